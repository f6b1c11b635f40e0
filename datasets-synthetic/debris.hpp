#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "core/geometry/mesh/tet_mesh.hpp"

namespace klang::datasets {

/// What lies about after a breakage: a box, plates, and the shards of a slab.
struct DebrisOptions {
  Eigen::Vector3d box_m{0.12, 0.08, 0.05};                       ///< lengths; 0 in all: no box
  double plate_length_m = 0.08, plate_width_m = 0.06;            ///< 1e-3 to 10
  std::vector<double> plate_thicknesses_m{0.004, 0.006, 0.012};  ///< 1e-4 to 1 each, at most 50; empty: no plates
  Eigen::Vector3d slab_m{0.2, 0.2, 0.006};                       ///< 1e-4 to 10 each, the thickness last and smallest
  int n_shards = 10;                                             ///< 0 to 500: pieces of the slab
  double largest_tilt_deg = 10.0;  ///< of the cracks against the slab's normal, as a rule; 0 to 30
  std::uint64_t seed = 1;
  void validate() const;  ///< InputError
};

/// One body: a closed convex surface of triangles, normals outward, in the frame of what it was cut from.
struct DebrisPiece {
  std::string name;  ///< "box", "plate_1" ..., "shard_01" ...
  mesh::SurfaceMesh surface;
  double volume_m3 = 0.0;
};

/// The shards of the slab: Voronoi cells of seeded points that keep a distance of 0.4 of the mean spacing. The points lie a little
/// above and below the middle plane, so cracks lean and no piece is quite a prism, yet all are convex and fill the slab without gap. Of 64
/// draws the one whose shortest edge is longest is taken: tiny edges would say more about meshing than about sound.
/// The same bits for the same options.
/// @throws InputError
std::vector<DebrisPiece> slab_shards(const DebrisOptions& options = {});

/// Box, plates by their order, shards.
std::vector<DebrisPiece> debris(const DebrisOptions& options = {});

}  // namespace klang::datasets
