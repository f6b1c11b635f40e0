#pragma once
#include <string>
#include <vector>

#include "core/foundation/config/result_header.hpp"

namespace klang {

/// A kind of result for docs/result-json.md: where it is written, and its keys beside those that every result has.
struct ResultKind {
  std::string kind;   ///< "fit"
  std::string where;  ///< "fit.json of `klang fit`"
  std::vector<FieldRow> fields;
};

template <Described Document>
ResultKind result_kind(std::string kind, std::string where) {
  std::vector<FieldRow> fields = field_rows<Document>();
  fields.erase(fields.begin(), fields.begin() + static_cast<std::ptrdiff_t>(field_rows<ResultHeader>().size()));
  return {std::move(kind), std::move(where), std::move(fields)};
}

/// A section with a table for each kind, after one of the keys that all have.
std::string result_kinds_markdown(const std::vector<ResultKind>& kinds);

}  // namespace klang
