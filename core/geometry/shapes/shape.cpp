#include "core/geometry/shapes/shape.hpp"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/nearest_word.hpp"
#include "core/geometry/shapes/detail/block_shape.hpp"
#include "core/geometry/shapes/round_surfaces.hpp"
#include "core/geometry/shapes/shape_registry.hpp"

namespace klang::mesh {
namespace {

std::string kinds_with_profile() {
  std::vector<std::string> names;
  for (const ShapeKind* kind : registered_shapes())
    if (kind->facts().has_profile) names.push_back(kind->facts().name);
  return word_list(names);
}

void check_options(const ShapeMeshOptions& options) {
  const std::string place = "shape mesh options";
  if (options.order != 1 && options.order != 2)
    throw InputError(place, "order", std::to_string(options.order), "1 or 2");
  checked(place, "max_edge_m", options.max_edge_m, 0.0, 1e6);
  checked(place, "wavelength_m", options.wavelength_m, 0.0, 1e6);
  checked(place, "elements_per_wavelength", options.elements_per_wavelength, 0.5, 1000.0);
  if (options.refinement < 0 || options.refinement > 8)
    throw InputError(place, "refinement", std::to_string(options.refinement), "0 to 8");
}

/// The longest edge asked for, 0 where none was.
double wanted_edge_m(const ShapeMeshOptions& options) {
  double edge_m = options.max_edge_m;
  if (options.wavelength_m > 0.0) {
    const double from_wavelength =
        options.wavelength_m / (options.elements_per_wavelength * (options.order == 1 ? 2.0 : 1.0));
    edge_m = edge_m > 0.0 ? std::min(edge_m, from_wavelength) : from_wavelength;
  }
  return edge_m;
}

/// Every dimension is there, in its range, and none is unknown or lost beside the others.
void check_ranges(const ShapeSpec& spec, const ShapeKind& kind, const std::string& place) {
  if (kind.facts().has_profile) return;  // each may be left out, and the profile says which there are
  const std::vector<std::string>& names = kind.dimension_names();
  for (const auto& [name, value] : spec.dims)
    if (std::find(names.begin(), names.end(), name) == names.end())
      throw unknown_word(place, "unknown dimension", name, name, names);
  for (const ShapeDimension& dimension : kind.facts().dimensions) {
    const auto it = spec.dims.find(dimension.name);
    if (it == spec.dims.end()) throw InputError(place, "missing dimension", dimension.name, word_list(names));
    checked_open(place, dimension.name, it->second, dimension.low_m, dimension.high_m);
  }
}

const ShapeKind& validated(const ShapeSpec& spec) {
  validate(spec);
  return find_shape(spec.kind);
}

}  // namespace

const std::vector<std::string>& shape_dimensions(std::string_view kind) { return find_shape(kind).dimension_names(); }

const std::vector<std::string>& shape_kinds() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> result;
    for (const ShapeKind* kind : registered_shapes()) result.push_back(kind->facts().name);
    return result;
  }();
  return names;
}

void validate(const ShapeSpec& spec) {
  const ShapeKind& kind = find_shape(spec.kind);
  const std::string place = "shape " + spec.kind;
  check_ranges(spec, kind, place);
  if (kind.facts().has_profile) {
    if (spec.profile_csv.empty()) throw InputError(place, "missing profile_csv", "", "a file with columns r_m, z_m");
    if (!spec.dims.empty()) kind.check_relations(spec);
    return;  // without changes the profile itself is checked when it is read
  }
  if (!spec.profile_csv.empty())
    throw InputError(place, "profile_csv is for kind " + kinds_with_profile(), spec.profile_csv.string());
  kind.check_relations(spec);
  double smallest = HUGE_VAL, largest = 0.0;
  for (const auto& [name, value] : spec.dims) {
    smallest = std::min(smallest, value);
    largest = std::max(largest, value);
  }
  if (!(smallest >= detail::kThinnest * largest))
    throw InputError(place, "dimensions too different", to_text(smallest) + " beside " + to_text(largest),
                     "smallest at least 1e-5 of the largest");
}

std::vector<Eigen::Matrix3Xd> convex_parts(const ShapeSpec& spec) { return validated(spec).convex_parts(spec); }
std::vector<RoundSurface> round_surfaces(const ShapeSpec& spec) { return validated(spec).round_surfaces(spec); }

double shape_volume_m3(const ShapeSpec& spec) { return validated(spec).volume_m3(spec); }

double shape_area_m2(const ShapeSpec& spec) { return validated(spec).area_m2(spec); }

ShapeDivisions shape_divisions(const ShapeSpec& spec, const ShapeMeshOptions& options) {
  const ShapeKind& kind = validated(spec);
  check_options(options);
  return kind.refined(kind.counts(spec, wanted_edge_m(options)), options.refinement);
}

ShapeDivisions resonance_divisions(const ShapeSpec& spec, double bar_speed_m_s, double highest_hz) {
  return validated(spec).resonance_divisions(spec, bar_speed_m_s, highest_hz);
}

ShapeDivisions reference_divisions(const ShapeSpec& spec) { return validated(spec).reference_divisions(spec); }

TetMesh mesh_shape(const ShapeSpec& spec, const ShapeDivisions& divisions, int order) {
  const ShapeKind& kind = validated(spec);
  if (order != 1 && order != 2) throw InputError("shape", "element order", std::to_string(order), "1 or 2");
  return kind.mesh(spec, divisions, order);
}

TetMesh mesh_shape(const ShapeSpec& spec, const ShapeMeshOptions& options) {
  return mesh_shape(spec, shape_divisions(spec, options), options.order);
}

}  // namespace klang::mesh
