#pragma once
#include <Eigen/Core>
#include <map>
#include <vector>

#include "core/physics/fracture/pattern/region_cut.hpp"
#include "core/physics/fracture/pattern/seeds.hpp"

namespace klang::fracture {

/// SB's regions: k_i dist(x, p_i) least, k_i = density_i^alpha, dist the length of the shortest path along edges of the mesh
/// (Dijkstra; from the seed, the centre of an element, straight to its corners), linear within tetrahedra. Paths along edges are longer
/// than straight ones, by up to about a third on coarse meshes; on a body that is not convex they go around its corners. Every seed's
/// distances reach the whole body; what of a region is not joined by faces becomes a body of its own (fragments_of).
class GeodesicRegions {
 public:
  GeodesicRegions(const mesh::TetMesh& mesh, double alpha);
  /// Distances of a seed are computed once, when it first comes: calls take more or fewer of the same seeds.
  RegionFields fields(const std::vector<Seed>& seeds);

 private:
  Eigen::VectorXd distances_m(const Seed& seed) const;

  const mesh::TetMesh& mesh_;
  double alpha_;
  std::vector<int> first_, neighbour_;  // of node n: first_[n] to first_[n + 1]
  std::vector<double> length_m_;
  std::map<int, Eigen::VectorXd> known_;  // by the seed's element
};

}  // namespace klang::fracture
