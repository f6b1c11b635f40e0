#pragma once
#include <array>
#include <string>
#include <vector>

#include "core/geometry/mesh/tet_mesh.hpp"

namespace klang::mesh {

/// More parts than these are refused.
inline constexpr int kMostSurfaceParts = 1000;

/// Whether a triangle is thinner than the rounding of its coordinates. size_m: of the surface that it belongs to.
bool is_flat_triangle(const std::array<Eigen::Vector3d, 3>& p, double size_m);

/// What a closed surface consists of: its connected parts, and which of them bound hollows.
struct SurfaceParts {
  int n_parts = 0;
  std::vector<int> part_of_triangle;
  std::vector<bool> is_hollow;                   ///< by part: lies inside the solid of another, faces into it
  std::vector<Eigen::Vector3d> point_in_hollow;  ///< one for each hollow part, in order
  double volume_m3 = 0.0;                        ///< enclosed by all of them
};

/// Accepts a surface that bounds a solid: in this order every vertex finite, every index in range, no
/// triangle without area, every edge shared by exactly two triangles that run it in opposite directions, no
/// triangle cutting or touching another, normals out of the solid (parts inside others alternate between
/// hollow and solid).
/// @param name  the file, for the message
/// @throws InputError naming the first bad face (0-based triangle number); of an open surface the number of open edges and
/// where the first one runs
SurfaceParts check_closed_surface(const SurfaceMesh& surface, const std::string& name);

}  // namespace klang::mesh
