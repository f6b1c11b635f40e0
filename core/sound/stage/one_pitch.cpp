#include "core/sound/stage/one_pitch.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace klang::stage {
namespace {

constexpr double kRelativeDistance = 2e-3;

}  // namespace

std::vector<std::vector<std::size_t>> modes_of_one_pitch(const Eigen::VectorXd& omega_rad_s,
                                                         const Eigen::VectorXd& decay_per_s) {
  const auto omega = [&](std::size_t k) { return omega_rad_s[static_cast<Eigen::Index>(k)]; };
  const auto decay = [&](std::size_t k) { return decay_per_s[static_cast<Eigen::Index>(k)]; };
  std::vector<std::size_t> order(static_cast<std::size_t>(omega_rad_s.size()));
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return omega(a) < omega(b); });
  std::vector<std::vector<std::size_t>> groups;
  for (std::size_t k = 0; k < order.size(); ++k) {
    const bool follows =
        k > 0 && omega(order[k]) - omega(order[k - 1]) <=
                     std::max(kRelativeDistance * omega(order[k]), decay(order[k]) + decay(order[k - 1]));
    if (!follows) groups.emplace_back();
    groups.back().push_back(order[k]);
  }
  std::erase_if(groups, [](const auto& group) { return group.size() < 2; });
  return groups;
}

std::complex<double> common_phase(std::span<const std::complex<double>> pressures) {
  std::complex<double> squares = 0.0, loudest = 0.0;
  for (const std::complex<double>& p : pressures) {
    squares += p * p;
    if (std::norm(p) > std::norm(loudest)) loudest = p;
  }
  if (!(std::norm(loudest) > 0.0)) return 1.0;
  // p of equal parts in both axes has no axis: the loudest one's.
  const bool no_axis = !(std::abs(squares) > 1e-12 * std::norm(loudest));
  const std::complex<double> u = no_axis ? loudest / std::abs(loudest) : std::sqrt(squares / std::abs(squares));
  return (loudest * std::conj(u)).real() < 0.0 ? -u : u;
}

}  // namespace klang::stage
