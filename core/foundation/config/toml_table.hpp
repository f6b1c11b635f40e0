#pragma once
#include <Eigen/Core>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace klang {

enum class TomlType { kText, kNumber, kBoolean, kVector, kTexts, kTable, kTables };

/// One key of a TOML file: drives the checks, the messages and the documentation.
struct TomlField {
  std::string_view table;  ///< "", "listener", "bubble", ...; of a table in a table "bubble.rise"
  std::string_view key;
  TomlType type = TomlType::kText;
  std::string_view presence;                              ///< "required", or the default in words
  double low = -std::numeric_limits<double>::infinity();  ///< numbers and vectors: low <= value <= high
  double high = std::numeric_limits<double>::infinity();
  std::string_view meaning;
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
  std::string text(std::string_view key) const;  ///< required
  std::string text(std::string_view key, std::string_view fallback) const;
  /// One of a few words; the first is the default unless the key is required.
  std::string choice(std::string_view key, std::initializer_list<std::string_view> words) const;
  double number(std::string_view key) const;
  double number(std::string_view key, double fallback) const;
  std::optional<double> optional_number(std::string_view key) const;
  bool boolean(std::string_view key, bool fallback) const;
  Eigen::Vector3d vector(std::string_view key) const;
  Eigen::Vector3d vector(std::string_view key, const Eigen::Vector3d& fallback) const;
  std::vector<std::string> texts(std::string_view key) const;  ///< none where the key is absent
  TomlTable table(std::string_view key) const;                 ///< an empty one where the key is absent
  /// A table whose keys no schema knows, of finite numbers and texts.
  struct FreeTable {
    std::map<std::string, double> numbers;
    std::map<std::string, std::string> texts;
  };
  FreeTable free_table(std::string_view key) const;                             ///< required
  std::vector<TomlTable> tables(std::string_view key, std::size_t most) const;  ///< none where the key is absent

 private:
  struct Document;
  TomlTable(std::shared_ptr<const Document> document, const void* node, std::string schema_table, std::string shown);
  const TomlField& field(std::string_view key) const;
  std::shared_ptr<const Document> document_;
  const void* node_;  // toml::table
  std::string schema_table_, shown_;
};

/// The keys as Markdown tables.
std::string toml_schema_markdown(std::span<const TomlField> schema);

}  // namespace klang
