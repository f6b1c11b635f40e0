#include "core/foundation/config/result_docs.hpp"

namespace klang {
namespace {

/// A table of TOML is an object of JSON.
std::string table_of(std::vector<FieldRow> rows) {
  constexpr std::string_view kTable = "table", kObject = "object";
  for (FieldRow& row : rows) {
    const std::size_t at = row.type.find(kTable);
    if (at != std::string::npos) row.type.replace(at, kTable.size(), kObject);
  }
  return field_rows_markdown(rows, false);
}

}  // namespace

std::string result_kinds_markdown(const std::vector<ResultKind>& kinds) {
  std::string text = "## Every result\n" + table_of(field_rows<ResultHeader>());
  for (const ResultKind& kind : kinds) text += "\n## `" + kind.kind + "`: " + kind.where + "\n" + table_of(kind.fields);
  return text;
}

}  // namespace klang
