#include "core/geometry/shapes/detail/block_shape.hpp"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/errors.hpp"

namespace klang::mesh::detail {

TetMesh BlockShape::mesh(const ShapeSpec& spec, const ShapeDivisions& divisions, int order) const {
  std::array<int, 3> n;
  for (std::size_t i = 0; i < 3; ++i) {
    const int count = divisions.counts[i];
    if (count < 0 || count > 1000000)
      throw InputError("shape " + spec.kind, "divisions", std::to_string(count), "1 to 1000000");
    n[i] = std::max(1, count);
  }
  double largest_m = 0.0;
  for (const auto& [name, value] : spec.dims) largest_m = std::max(largest_m, value);
  // Blocks agree to rounding (1e-15 of the size); the thinnest admissible cell is 1e-5 of it over its divisions.
  return mesh_blocks(blocks(spec, n), order, 1e-12 * largest_m);
}

double dimension(const ShapeSpec& spec, const char* name) { return spec.dims.at(name); }

void check_below(const ShapeSpec& spec, const char* name, double limit_m, const std::string& rule) {
  if (!(dimension(spec, name) < limit_m * (1.0 - kThinnest)))
    throw InputError("shape " + spec.kind, std::string(name) + " is too large", to_text(dimension(spec, name)), rule);
}

int divided(double length_m, double edge_m, int at_least) {
  const double count = std::ceil(length_m / edge_m * (1.0 - 1e-12));
  if (!(count <= 1e6))
    throw InputError("shape mesh options", "edge length too small", to_text(edge_m), "up to 1e6 divisions");
  return std::max(at_least, static_cast<int>(count));
}

int rounded(double count, int low, int high) {
  return static_cast<int>(std::clamp(std::round(count), static_cast<double>(low), static_cast<double>(high)));
}

}  // namespace klang::mesh::detail
