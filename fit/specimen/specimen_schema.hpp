#pragma once
#include <limits>
#include <string>
#include <string_view>
#include <vector>

namespace klang::fit {

enum class FieldType { kText, kNumber, kBoolean, kTextList, kNumberList, kTable, kTableList };

/// One key of specimen.toml. The table of these drives the reader's checks, its error messages and docs/specimen.md.
struct SchemaField {
  std::string_view table;  ///< "", "material", "specimen", "specimen.shape", "specimen.support", "fit", "fit.priors.*"
  std::string_view key;
  FieldType type = FieldType::kText;
  std::string_view presence;                              ///< "required", or the default in words
  double low = -std::numeric_limits<double>::infinity();  ///< numbers: low < value < high
  double high = std::numeric_limits<double>::infinity();
  std::string_view meaning;
  int list_length = 0;  ///< of a number list; 0: any
};

const std::vector<SchemaField>& specimen_schema();

/// The field, or nullptr for an unknown key. Dimensions of every shape kind are known keys of "specimen.shape".
const SchemaField* find_field(std::string_view table, std::string_view key);

/// "a number", "a list of texts", ...
std::string_view type_text(FieldType type);

/// "above 0, below 0.5" or "above 0"; "" without limits.
std::string range_text(const SchemaField& field);

/// The known keys of a table, comma separated, for messages.
std::string known_keys(std::string_view table);

/// Names a fit accepts beside dimensions "SPECIMEN.length_m".
const std::vector<std::string>& material_parameter_names();

}  // namespace klang::fit
