#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "core/foundation/config/fields.hpp"
#include "core/geometry/mesh/tet_mesh.hpp"

namespace klang::datasets {

/// What lies about after a breakage: a box, plates, and the shards of a slab.
struct DebrisOptions {
  Eigen::Vector3d box_m{0.12, 0.08, 0.05};  ///< lengths, 1e-4 to 10; 0 in all: no box
  double plate_length_m = 0.08, plate_width_m = 0.06;
  std::vector<double> plate_thicknesses_m{0.004, 0.006, 0.012};  ///< at most 50; empty: no plates
  Eigen::Vector3d slab_m{0.2, 0.2, 0.006};                       ///< the thickness last and smallest
  int n_shards = 10;
  double largest_tilt_deg = 10.0;  ///< of the cracks against the slab's normal, as a rule
  std::uint64_t seed = 1;
  void validate() const;  ///< InputError

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"plate_length_m", "Length of the plates", between(1e-3, 10.0)}, self.plate_length_m);
    visit({"plate_width_m", "Width of the plates", between(1e-3, 10.0)}, self.plate_width_m);
    visit({"plate_thicknesses_m", "Thickness of each plate", between(1e-4, 1.0)}, self.plate_thicknesses_m);
    visit({"slab_m", "Length, width and thickness of the slab", between(1e-4, 10.0)}, self.slab_m);
    visit({"n_shards", "Shards of the slab", between(0.0, 500.0)}, self.n_shards);
    visit({"largest_tilt_deg", "How far cracks lean, as a rule", between(0.0, 30.0)}, self.largest_tilt_deg);
  }
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
