#pragma once
#include <Eigen/SparseCore>
#include <cmath>
#include <vector>

#include "core/geometry/mesh/tet_mesh.hpp"

namespace klang::mesh {

/// Some elements of a mesh, cut smaller towards a place, with the rest of the mesh left as it is: what functions that are zero on the faces shared with
/// the rest need, whatever new nodes lie on those.
struct GradedPatch {
  TetMesh mesh;  ///< quadratic; nodes on the coarse elements, curved ones too
  /// Values at its nodes of a nodal field of the coarse mesh: rows of the coarse elements' functions.
  Eigen::SparseMatrix<double, Eigen::RowMajor> from_coarse;
  std::vector<char> is_shared;  ///< nodes on faces that other elements of the coarse mesh have too
};

struct Grading {
  Eigen::Vector3d place_m = Eigen::Vector3d::Zero();
  double smallest_m = 0.0;      ///< longest edge at the place
  double growth = 0.5;          ///< longest edge per distance from the place, where that is more
  double largest_m = HUGE_VAL;  ///< longest edge anywhere
  int most_elements = 100000;
};

/// Longest edges are halved in all elements around them (Rivara's path to an edge that is the longest of all of them), so that elements do not get flatter
/// than a bound that the coarse ones set. Stops at most_elements.
/// @param elements  of the coarse mesh, at least one
GradedPatch graded_patch(const TetMesh& coarse, const std::vector<int>& elements, const Grading& grading);

}  // namespace klang::mesh
