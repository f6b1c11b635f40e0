#include "core/physics/fracture/pattern/seeds.hpp"

#include <Eigen/Geometry>
#include <algorithm>

#include "core/foundation/base/check.hpp"
#include "core/foundation/base/errors.hpp"

namespace klang::fracture {
namespace {
constexpr int kMostDraws = 1000;
}

SeedSampler::SeedSampler(const mesh::TetMesh& mesh, const Eigen::VectorXd& energy_density, double least_distance_m,
                         std::uint64_t seed, std::uint64_t stream)
    : least_distance_m_(least_distance_m), random_(seed, stream) {
  const int n = mesh.n_elements();
  KLANG_CHECK(energy_density.size() == n && n > 0, "a density for each element");
  if (!energy_density.allFinite() || !(energy_density.minCoeff() >= 0.0) || !(energy_density.maxCoeff() > 0.0))
    throw InputError("fracture", "the strain energy density is negative, not finite or zero everywhere");
  density_ = energy_density / energy_density.maxCoeff();
  centres_m_.resize(3, n);
  cumulative_.resize(n);
  double sum = 0.0;
  for (int e = 0; e < n; ++e) {
    std::array<Eigen::Vector3d, 4> p;
    for (int c = 0; c < 4; ++c) p[c] = mesh.nodes_m.row(mesh.elements(e, c)).transpose();
    centres_m_.col(e) = 0.25 * (p[0] + p[1] + p[2] + p[3]);
    sum += density_[e] * (p[1] - p[0]).dot((p[2] - p[0]).cross(p[3] - p[0])) / 6.0;
    cumulative_[e] = sum;
  }
}

const std::vector<Seed>& SeedSampler::first(int n) {
  const double total = cumulative_[cumulative_.size() - 1];
  for (int draws = 0; !exhausted_ && static_cast<int>(seeds_.size()) < n;) {
    const double place = total * random_.uniform();
    const auto e =
        static_cast<int>(std::upper_bound(cumulative_.begin(), cumulative_.end(), place) - cumulative_.begin());
    const bool fits =
        e < cumulative_.size() && density_[e] > 0.0 && std::all_of(seeds_.begin(), seeds_.end(), [&](const Seed& s) {
          return s.element != e && (s.at_m - centres_m_.col(e)).norm() >= least_distance_m_;
        });
    if (fits) {
      seeds_.push_back({e, centres_m_.col(e), density_[e]});
      draws = 0;
    } else if (++draws >= kMostDraws) {
      exhausted_ = true;
    }
  }
  return seeds_;
}

}  // namespace klang::fracture
