#pragma once
#include <Eigen/Core>
#include <filesystem>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/foundation/base/errors.hpp"

namespace klang {

enum class TomlType { kText, kNumber, kBoolean, kVector, kTexts, kTable, kTables, kNumbers };

/// One key of a TOML file: drives the checks, the messages and the documentation.
struct TomlField {
  std::string_view
      table;  ///< "", "listener", "bubble", ...; of a table in a table "bubble.rise"; "fit.priors.*": of every
              ///< table in "fit.priors", whatever its name
  std::string_view key;
  TomlType type = TomlType::kText;
  std::string_view presence;                              ///< "required", or the default in words
  double low = -std::numeric_limits<double>::infinity();  ///< numbers and vectors: low <= value <= high
  double high = std::numeric_limits<double>::infinity();
  std::string_view meaning;
  bool open = false;      ///< low and high themselves are left out: low < value < high
  int length = 0;         ///< of a list of numbers; 0: any
  bool with_std = false;  ///< a number may be { value = .., std = .. }
};

/// A table of a TOML file, read by a schema. Unknown keys, wrong types and values out of range are InputErrors that
/// name file, line, key, value and what is allowed.
class TomlTable {
 public:
  /// @param schema  must outlive the table
  static TomlTable parse(std::string_view text, std::string name, std::span<const TomlField> schema);

  bool has(std::string_view key) const;
  /// "scene.toml:12: bubble[3].radius_m", for complaints.
  std::string place(std::string_view key) const;
  std::string place() const;                     ///< of the table itself: "scene.toml:12: bubble[3]"
  std::vector<std::string> keys() const;         ///< those given
  bool is_text(std::string_view key) const;      ///< given, and a text
  std::string text(std::string_view key) const;  ///< required
  std::string text(std::string_view key, std::string_view fallback) const;
  std::optional<std::string> optional_text(std::string_view key) const;
  /// One of a few words; the first is the default unless the key is required.
  std::string choice(std::string_view key, std::initializer_list<std::string_view> words) const;
  double number(std::string_view key) const;
  double number(std::string_view key, double fallback) const;
  std::optional<double> optional_number(std::string_view key) const;
  /// Of a number given as { value = .., std = .. } its std, > 0; empty for a plain number or none.
  std::optional<double> standard_deviation(std::string_view key) const;
  bool boolean(std::string_view key, bool fallback) const;
  Eigen::Vector3d vector(std::string_view key) const;
  Eigen::Vector3d vector(std::string_view key, const Eigen::Vector3d& fallback) const;
  std::vector<double> numbers(std::string_view key) const;     ///< required; of the field's length
  std::vector<std::string> texts(std::string_view key) const;  ///< none where the key is absent
  TomlTable table(std::string_view key) const;                 ///< an empty one where the key is absent
  /// Tables by names that no schema knows, in the file's order. A name that holds a point may be written without quotes,
  /// as a table in a table: the schema tells an entry by its keys.
  std::vector<std::pair<std::string, TomlTable>> named_tables(std::string_view key) const;
  std::vector<TomlTable> tables(std::string_view key, std::size_t most) const;  ///< none where the key is absent
  /// fewest to most of them, fewest > 0.
  std::vector<TomlTable> tables(std::string_view key, std::size_t fewest, std::size_t most) const;

 private:
  struct Document;
  TomlTable(std::shared_ptr<const Document> document, const void* node, std::string schema_table, std::string shown);
  const TomlField& field(std::string_view key) const;
  void add_named(const void* node, const std::string& prefix, const std::string& schema_table,
                 std::vector<std::pair<std::string, TomlTable>>& found) const;
  std::shared_ptr<const Document> document_;
  const void* node_;  // toml::table
  std::string schema_table_, shown_;
};

/// An ordinary file, named relative to a folder. @throws InputError with the place
std::filesystem::path existing_file(const std::string& text, const std::string& place,
                                    const std::filesystem::path& folder);

/// Calls a function that complains without knowing the file, and adds the place to its complaint.
template <class Function>
auto located(const std::string& place, Function&& function) {
  try {
    return function();
  } catch (const InputError& error) {
    throw InputError(place, error.what());
  }
}

/// The keys as Markdown tables.
std::string toml_schema_markdown(std::span<const TomlField> schema);

}  // namespace klang
