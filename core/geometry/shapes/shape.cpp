#include "core/geometry/shapes/shape.hpp"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/check.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/geometry/shapes/detail/block_mesh.hpp"
#include "core/geometry/shapes/detail/profile.hpp"
#include "core/geometry/shapes/detail/revolution.hpp"
#include "core/geometry/shapes/detail/shape_blocks.hpp"

namespace klang::mesh {
namespace {

struct Kind {
  std::string name;
  std::vector<std::string> dimensions;
};

const std::vector<Kind>& kinds() {
  static const std::vector<Kind> table{
      {"tube", {"length_m", "outer_radius_m", "wall_m"}},
      {"rod", {"length_m", "radius_m"}},
      {"box", {"length_m", "width_m", "height_m"}},
      {"shell_box", {"edge_m", "wall_m"}},
      {"ellipsoid", {"a_m", "b_m", "c_m"}},
      {"sphere", {"radius_m"}},
      {"bowl", {"outer_radius_m", "wall_m", "depth_m"}},
      {"revolution", {}},
  };
  return table;
}

std::string joined(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : ", ") + word;
  return text;
}

/// Below this part of the other dimension a wall is a typing error, and its elements lose all digits.
constexpr double kThinnest = 1e-5;

}  // namespace

const std::vector<std::string>& shape_dimensions(std::string_view kind) {
  for (const Kind& known : kinds())
    if (known.name == kind) return known.dimensions;
  throw InputError("shape", "unknown kind", kind, joined(shape_kinds()));
}

const std::vector<std::string>& shape_kinds() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> result;
    for (const Kind& kind : kinds()) result.push_back(kind.name);
    return result;
  }();
  return names;
}

void validate(const ShapeSpec& spec) {
  const std::vector<std::string>& names = shape_dimensions(spec.kind);
  const std::string place = "shape " + spec.kind;
  for (const auto& [name, value] : spec.dims)
    if (std::find(names.begin(), names.end(), name) == names.end())
      throw InputError(place, "unknown dimension", name,
                       names.empty() ? "none, profile_csv gives the shape" : joined(names));
  double smallest = HUGE_VAL, largest = 0.0;
  for (const std::string& name : names) {
    const auto it = spec.dims.find(name);
    if (it == spec.dims.end()) throw InputError(place, "missing dimension", name, joined(names));
    checked_open(place, name, it->second, 0.0, 1e6);
    smallest = std::min(smallest, it->second);
    largest = std::max(largest, it->second);
  }
  if (spec.kind == "revolution") {
    if (spec.profile_csv.empty()) throw InputError(place, "missing profile_csv", "", "a file with columns r_m, z_m");
    return;  // the profile itself is checked when it is read
  }
  if (!spec.profile_csv.empty())
    throw InputError(place, "profile_csv is for kind revolution", spec.profile_csv.string());
  const auto dim = [&](const char* name) { return spec.dims.at(name); };
  const auto below = [&](const char* name, double limit, const std::string& rule) {
    if (!(dim(name) < limit * (1.0 - kThinnest)))
      throw InputError(place, std::string(name) + " is too large", to_text(dim(name)), rule);
  };
  if (spec.kind == "tube")
    below("wall_m", dim("outer_radius_m"), "below outer_radius_m = " + to_text(dim("outer_radius_m")));
  if (spec.kind == "shell_box")
    below("wall_m", 0.5 * dim("edge_m"), "below edge_m / 2 = " + to_text(0.5 * dim("edge_m")));
  if (spec.kind == "bowl") {
    below("wall_m", dim("outer_radius_m"), "below outer_radius_m = " + to_text(dim("outer_radius_m")));
    below("wall_m", dim("depth_m"), "below depth_m = " + to_text(dim("depth_m")));
    const double limit = 2.0 * dim("outer_radius_m") - dim("wall_m");
    below("depth_m", limit, "below 2 outer_radius_m - wall_m = " + to_text(limit));
  }
  if (!(smallest >= kThinnest * largest))
    throw InputError(place, "dimensions too different", to_text(smallest) + " beside " + to_text(largest),
                     "smallest at least 1e-5 of the largest");
}

TetMesh mesh_shape(const ShapeSpec& spec, const ShapeDivisions& divisions, int order) {
  validate(spec);
  if (order != 1 && order != 2) throw InputError("shape", "element order", std::to_string(order), "1 or 2");
  if (spec.kind == "revolution")
    return detail::mesh_revolution(detail::read_profile(spec.profile_csv), divisions.counts, order);
  for (const int count : divisions.counts)
    if (count < 0 || count > 1000000)
      throw InputError("shape " + spec.kind, "divisions", std::to_string(count), "1 to 1000000");
  const detail::BlockLayout layout = detail::shape_blocks(spec, divisions.counts);
  return detail::mesh_blocks(layout.blocks, order, layout.glue_m);
}

TetMesh mesh_shape(const ShapeSpec& spec, const ShapeMeshOptions& options) {
  return mesh_shape(spec, shape_divisions(spec, options), options.order);
}

}  // namespace klang::mesh
