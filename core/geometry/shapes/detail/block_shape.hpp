#pragma once
#include <string>

#include "core/geometry/shapes/detail/block_mesh.hpp"
#include "core/geometry/shapes/shape_kind.hpp"

namespace klang::mesh::detail {

/// A kind that is made of curved bricks.
class BlockShape : public ShapeKind {
 public:
  using ShapeKind::ShapeKind;
  TetMesh mesh(const ShapeSpec& spec, const ShapeDivisions& divisions, int order) const final;

  /// The bricks for counts n >= 1, which the kind may raise to what it needs.
  virtual std::vector<Block> blocks(const ShapeSpec& spec, std::array<int, 3> n) const = 0;
};

/// Below this part of the largest dimension a body is a typing error, and its elements lose all digits.
constexpr double kThinnest = 1e-5;

double dimension(const ShapeSpec& spec, const char* name);

/// Throws InputError unless the dimension is below limit_m by more than kThinnest of it.
/// The rule is what the message allows: "below depth_m".
void check_below(const ShapeSpec& spec, const char* name, double limit_m, const std::string& rule);

/// Divisions of a length by an edge length; checked before it becomes an int. @throws InputError above 1e6
int divided(double length_m, double edge_m, int at_least = 1);

/// count rounded to the nearest whole number within low to high.
int rounded(double count, int low, int high);

}  // namespace klang::mesh::detail
