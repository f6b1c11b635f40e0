#include "core/foundation/config/result_schema.hpp"

#include <nlohmann/json.hpp>

#include "core/foundation/base/json.hpp"

namespace klang {
namespace {

using nlohmann::json;

/// A type of FieldRow ("list of number or null", "one of a, b") as a schema.
json schema_of_type(std::string type) {
  constexpr std::string_view kOrNull = " or null", kListOf = "list of ", kOneOf = "one of ";
  if (type.ends_with(kOrNull)) type.resize(type.size() - kOrNull.size());
  if (type.starts_with(kListOf))
    return {{"type", {"array", "null"}}, {"items", schema_of_type(type.substr(kListOf.size()))}};
  if (type.starts_with(kOneOf)) {
    json words = json::array();
    for (std::size_t at = kOneOf.size(); at < type.size();) {
      const std::size_t end = std::min(type.find(", ", at), type.size());
      words.push_back(type.substr(at, end - at));
      at = end + 2;
    }
    words.push_back(nullptr);
    return {{"enum", words}};
  }
  if (type == "table") return {{"type", {"object", "null"}}};
  if (type == "text") return {{"type", {"string", "null"}}};
  if (type == "number" || type == "integer" || type == "boolean") return {{"type", {type, "null"}}};
  return json::object();  // any
}

/// The schema of the object that holds a field: "a[].b.c" is c in b in the items of a.
json& place_of(json& root, std::string_view path, std::string& key) {
  json* at = &root;
  for (;;) {
    const std::size_t dot = path.find('.');
    if (dot == std::string_view::npos) break;
    std::string step(path.substr(0, dot));
    path.remove_prefix(dot + 1);
    int n_lists = 0;
    for (; step.ends_with("[]"); step.resize(step.size() - 2)) ++n_lists;
    at = &(*at)["properties"][step];
    for (; n_lists > 0; --n_lists) at = &(*at)["items"];
  }
  key = path;
  return *at;
}

void add_rows(const std::vector<FieldRow>& rows, json& schema) {
  for (const FieldRow& row : rows) {
    std::string key;
    json& place = place_of(schema, row.name, key);
    json field = schema_of_type(row.type);
    field["description"] = row.meaning + (row.range.empty() ? "" : " (" + row.range + ")");
    place["properties"][key].update(field);
    if (row.required) place["required"].push_back(key);
  }
}

}  // namespace

std::string result_schema(const ResultKind& kind) {
  json schema = {{"$schema", "https://json-schema.org/draft/2020-12/schema"},
                 {"title", kind.kind},
                 {"description", kind.where},
                 {"type", "object"},
                 {"required", {"kind", "schema_version"}}};
  add_rows(field_rows<ResultHeader>(), schema);
  add_rows(kind.fields, schema);
  schema["properties"]["kind"] = {{"const", kind.kind}, {"description", "of result"}};
  schema["properties"]["schema_version"] = {{"const", 1}, {"description", "of these files"}};
  return json_text(schema);
}

}  // namespace klang
