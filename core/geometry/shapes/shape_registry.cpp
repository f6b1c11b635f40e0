#include "core/geometry/shapes/shape_registry.hpp"

#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/nearest_word.hpp"
#include "core/geometry/shapes/detail/bowl_shape.hpp"
#include "core/geometry/shapes/detail/box_shape.hpp"
#include "core/geometry/shapes/detail/ellipsoid_shape.hpp"
#include "core/geometry/shapes/detail/revolution_shape.hpp"
#include "core/geometry/shapes/detail/rod_shape.hpp"
#include "core/geometry/shapes/detail/shell_box_shape.hpp"
#include "core/geometry/shapes/detail/sphere_shape.hpp"
#include "core/geometry/shapes/detail/tube_shape.hpp"
#include "core/geometry/shapes/detail/undercut_bar_shape.hpp"

namespace klang::mesh {

const std::vector<const ShapeKind*>& registered_shapes() {
  static const std::vector<const ShapeKind*> kinds{
      &detail::tube_shape(),      &detail::rod_shape(),        &detail::box_shape(),
      &detail::shell_box_shape(), &detail::ellipsoid_shape(),  &detail::sphere_shape(),
      &detail::bowl_shape(),      &detail::revolution_shape(), &detail::undercut_bar_shape(),
  };
  return kinds;
}

const ShapeKind& find_shape(std::string_view kind) {
  std::vector<std::string> known;
  for (const ShapeKind* shape : registered_shapes()) {
    if (shape->facts().name == kind) return *shape;
    known.push_back(shape->facts().name);
  }
  throw unknown_word("shape", "unknown kind", kind, kind, known);
}

std::string shapes_table() {
  std::string table = "| kind | body | dimension | range | meaning |\n|---|---|---|---|---|\n";
  for (const ShapeKind* shape : registered_shapes()) {
    const ShapeFacts& facts = shape->facts();
    std::string first = "| `" + facts.name + "` | " + facts.meaning + "; " + facts.placement;
    if (facts.has_profile)
      table +=
          first +
          " | `profile_csv` | a file | closed polygon with columns `r_m`, `z_m`, r_m at least 0; a third, `zone`, "
          "numbers the points of a wall |\n"
          "| |  | `size_m` | 0.001 to 1000 times the drawn | may be left out: longer side of the profile's bounding "
          "box; the body is scaled to it |\n"
          "| |  | `wall_N_m` | 0.2 to 3 times the drawn | may be left out: mean thickness of the wall of zone N, "
          "whose points move along their normals |\n";
    for (const ShapeDimension& dimension : facts.dimensions) {
      table += first + " | `" + dimension.name + "` | above " + to_text(dimension.low_m) + ", below " +
               to_text(dimension.high_m) + " | " + dimension.meaning + " |\n";
      first = "| | ";
    }
  }
  return table;
}

}  // namespace klang::mesh
