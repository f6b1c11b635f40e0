#pragma once
#include <Eigen/Core>
#include <array>
#include <functional>
#include <string>
#include <vector>

#include "core/geometry/mesh/tet_mesh.hpp"

namespace klang::mesh::detail {

/// A curved brick: the image of the unit cube under map, divided counts[0] x counts[1] x counts[2] times.
/// Two blocks may meet only along whole faces with the same divisions, both running the same way along the
/// face (increasing parameters of one are increasing parameters of the other): then the cuts agree.
struct Block {
  std::array<int, 3> counts{};
  std::function<Eigen::Vector3d(double u, double v, double w)> map;
  std::array<std::string, 6> faces;  ///< node set of u = 0, u = 1, v = 0, v = 1, w = 0, w = 1; empty: none
};

/// Cuts every cell into the six tetrahedra around its diagonal from the lowest to the highest corner, and
/// glues the blocks (also a block to itself: a ring) where boundary points agree within glue_m. With order 2
/// the mid-node of every edge, also inside, is the map's image of the edge's parameter midpoint, so it lies
/// on the true surface.
/// @throws InputError when a cell is turned inside out (divisions too coarse for the curvature) or the mesh
/// is too big
TetMesh mesh_blocks(const std::vector<Block>& blocks, int order, double glue_m);

/// One direction of a body that is symmetric about 0: two halves from the middle outwards where n is even
/// (the mesh is then a mirror image of itself), one piece where it is odd. Halves may be graded towards the
/// ends, cell borders at s + grading sin(pi s) / pi for even steps of s; mid-points stay half-way between the
/// borders of their cell.
struct Segment {
  int n = 1;
  double from = 0.0, to = 0.0;
  std::string from_face, to_face;
  double grading = 0.0;
  double at(double u) const;
};
std::vector<Segment> mirrored_segments(int n, double half_length_m, const std::string& low_face,
                                       const std::string& high_face, double grading = 0.0);

/// Throws InputError where a mesh of so many elements would not fit 32-bit indices or memory.
void check_element_count(double n_elements);

}  // namespace klang::mesh::detail
