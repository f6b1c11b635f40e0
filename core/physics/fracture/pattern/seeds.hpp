#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "core/foundation/base/random.hpp"
#include "core/geometry/mesh/tet_mesh.hpp"

namespace klang::fracture {

/// Where cracks' cells have their centres.
struct Seed {
  int element = 0;
  Eigen::Vector3d at_m = Eigen::Vector3d::Zero();  ///< the element's centre
  double density = 0.0;                            ///< strain energy there over the body's largest, above 0 to 1
};

/// Seeds one at a time: an element is drawn with a probability proportional to the strain energy in it (density times volume; SB
/// 3.2 "proportional to strain energy density" of points in space), anew where a seed lies nearer than the least distance. The
/// first n seeds are the same however many are drawn; the same (seed, stream) gives the same bits. Densities are taken relative to
/// the largest, so that a body of another size with the same field has the same seeds.
class SeedSampler {
 public:
  /// @param energy_density  [J/m^3] by element, >= 0
  /// @throws InputError for a density that is negative or not finite, or none above 0
  SeedSampler(const mesh::TetMesh& mesh, const Eigen::VectorXd& energy_density, double least_distance_m,
              std::uint64_t seed, std::uint64_t stream = 0);

  /// The first n, or fewer where no more keep their distance: 1000 draws in a row found no place.
  const std::vector<Seed>& first(int n);

 private:
  Eigen::Matrix3Xd centres_m_;
  Eigen::VectorXd density_, cumulative_;
  double least_distance_m_;
  RandomStream random_;
  std::vector<Seed> seeds_;
  bool exhausted_ = false;
};

}  // namespace klang::fracture
