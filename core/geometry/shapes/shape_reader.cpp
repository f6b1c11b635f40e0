#include "core/geometry/shapes/shape_reader.hpp"

#include <algorithm>
#include <deque>
#include <limits>

#include "core/foundation/base/errors.hpp"
#include "core/geometry/shapes/shape_registry.hpp"

namespace klang::mesh {
namespace {

constexpr double kInf = std::numeric_limits<double>::infinity();
constexpr double kMaxLengthM = 1e3;  // nothing longer is struck and recorded
/// "tube, rod, ..., bowl or revolution"; lives as long as the program, as a field's meaning does.
const std::string& kinds_in_words() {
  static const std::string words = [] {
    std::string text;
    const auto& kinds = shape_kinds();
    for (std::size_t i = 0; i < kinds.size(); ++i)
      text += (i == 0 ? "" : i + 1 == kinds.size() ? " or " : ", ") + kinds[i];
    return text;
  }();
  return words;
}

/// Each dimension's name with "dimension of: " its kinds, in the order in which kinds name them first.
const std::deque<std::pair<std::string, std::string>>& dimensions() {
  static const std::deque<std::pair<std::string, std::string>> all = [] {
    std::deque<std::pair<std::string, std::string>> found;
    for (const std::string& kind : shape_kinds()) {
      for (const std::string& name : shape_dimensions(kind)) {
        const auto same =
            std::find_if(found.begin(), found.end(), [&](const auto& entry) { return entry.first == name; });
        if (same == found.end()) {
          found.emplace_back(name, "dimension of: " + kind);
        } else {
          same->second += ", " + kind;
        }
      }
    }
    return found;
  }();
  return all;
}

}  // namespace

std::vector<TomlField> shape_fields(std::string_view table) {
  std::vector<TomlField> fields = {{table, "kind", TomlType::kText, "required", -kInf, kInf, kinds_in_words()}};
  for (const auto& [name, meaning] : dimensions())
    fields.push_back({table, name, TomlType::kNumber, "by kind", 0, kMaxLengthM, meaning, true});
  fields.push_back({table, "profile_csv", TomlType::kText, "required for a revolution", -kInf, kInf,
                    "closed polygon with columns r_m, z_m"});
  return fields;
}

ShapeSpec read_shape(const TomlTable& table, const std::filesystem::path& folder) {
  ShapeSpec shape;
  const auto kind = table.optional_text("kind");
  if (!kind) throw InputError(table.place("kind"), "is missing", "", kinds_in_words());
  shape.kind = *kind;
  const auto& wanted = located(
      table.place("kind"), [&]() -> const auto& { return shape_dimensions(*kind); });
  const bool profiled = find_shape(*kind).facts().has_profile;
  std::string allowed = "kind";
  for (const std::string& name : wanted) allowed += ", " + name;
  if (profiled) allowed += ", profile_csv";
  for (const std::string& name : table.keys()) {
    if (name == "kind" || (name == "profile_csv" && profiled)) continue;
    if (std::find(wanted.begin(), wanted.end(), name) == wanted.end())
      throw InputError(table.place(name), "is no dimension of a " + *kind, "", allowed);
    shape.dims[name] = table.number(name);
  }
  for (const std::string& name : wanted) {
    if (!shape.dims.count(name)) throw InputError(table.place(name), "is missing", "", allowed);
  }
  if (profiled) {
    const auto profile = table.optional_text("profile_csv");
    if (!profile) throw InputError(table.place("profile_csv"), "is missing");
    shape.profile_csv = existing_file(*profile, table.place("profile_csv"), folder);
  }
  located(table.place("kind"), [&] { validate(shape); });
  return shape;
}

}  // namespace klang::mesh
