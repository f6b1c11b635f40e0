#pragma once
#include <array>

#include "core/geometry/shapes/shape.hpp"

namespace klang::mesh {

/// The half-plane section (r >= 0, z) of a body that is turned about the z axis, cut into curved quadrilaterals of high
/// degree. Row of an element: node (i, j) of its reference square at column j (degree + 1) + i, Gauss-Lobatto points in
/// both directions, positive orientation.
struct Section {
  int degree = 4;
  Eigen::Matrix<double, Eigen::Dynamic, 2, Eigen::RowMajor> nodes_m;  ///< n_nodes x 2: r, z
  IndexRows elements;                                                 ///< n_elements x (degree + 1)^2, 0-based

  int n_nodes() const { return static_cast<int>(nodes_m.rows()); }
  int n_elements() const { return static_cast<int>(elements.rows()); }
};

/// True for tube, rod, sphere, ellipsoid with a_m = b_m, bowl and revolution.
bool is_axisymmetric(const ShapeSpec& spec);

/// How often the section is divided; kept apart from the dimensions for the same reason as ShapeDivisions.
struct SectionDivisions {
  /// By kind (detail/NAME_shape.cpp), e.g. tube: axial, radial, layers at an end. Layers double in length from the free
  /// end on, the first as long as the body is thick.
  std::array<int, 3> counts{};
  int degree = 4;  ///< 1 to 12
};

/// Divisions with elements no longer than edge_m. @throws InputError for a body that is not one of revolution
SectionDivisions section_divisions(const ShapeSpec& spec, double edge_m);

/// Smallest thickness that bends: wall, diameter, or twice area over perimeter of a profile.
/// @throws InputError for a body that is not one of revolution
double section_thickness_m(const ShapeSpec& spec);

Section mesh_section(const ShapeSpec& spec, const SectionDivisions& divisions);

/// Where a point lies in a section: weights of an element's nodes. Points outside by round-off or by the curvature that
/// the elements leave out belong to the nearest element.
class SectionLocator {
 public:
  explicit SectionLocator(const Section& section);
  struct Place {
    int element = -1;
    Eigen::VectorXd weight;  ///< (degree + 1)^2
  };
  Place find(double r_m, double z_m) const;

 private:
  const Section& section_;
  Eigen::VectorXd nodes_;  // Gauss-Lobatto
  std::vector<Eigen::Vector2d> low_, high_;
};

}  // namespace klang::mesh
