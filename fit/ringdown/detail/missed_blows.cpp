#include "fit/ringdown/detail/missed_blows.hpp"

#include <algorithm>

namespace klang::fit::detail {
namespace {

constexpr double kBlock_s = 0.01, kLeastShare = 0.25, kRise = 4.0, kQuiet = 1e-3;
constexpr Eigen::Index kBlocksBefore = 2, kBlocksOfBlow = 6;  // the block just before may hold the blow's begin

Eigen::VectorXd block_energies(const Eigen::VectorXd& x, Eigen::Index block) {
  Eigen::VectorXd energy(std::max<Eigen::Index>(0, (x.size() - 1) / block));
  for (Eigen::Index k = 0; k < energy.size(); ++k)
    energy[k] = (x.segment(k * block + 1, block) - x.segment(k * block, block)).squaredNorm();
  return energy;
}

}  // namespace

std::vector<double> missed_blows(const RingData& data, const std::vector<RingPartial>& rings) {
  const double rate = data.sample_rate_hz();
  const auto block = std::max<Eigen::Index>(8, static_cast<Eigen::Index>(kBlock_s * rate));
  double loudest = 0;
  for (const Segment& segment : data.segments())
    for (const double energy :
         block_energies(data.channels()[0].segment(segment.begin, segment.end - segment.begin), block))
      loudest = std::max(loudest, energy);
  std::vector<double> times;
  for (std::size_t s = 0; s < data.segments().size(); ++s) {
    const Segment& segment = data.segments()[s];
    const Eigen::Index n = segment.end - segment.begin;
    const Eigen::VectorXd heard = block_energies(data.channels()[0].segment(segment.begin, n), block);
    const Eigen::VectorXd rest = block_energies(data.residual(static_cast<Eigen::Index>(s), 0, n, rings), block);
    for (Eigen::Index k = kBlocksBefore + 1; k < rest.size(); ++k) {
      const double before = rest.segment(k - 1 - kBlocksBefore, kBlocksBefore).maxCoeff();
      if (!(rest[k] >= kRise * before && rest[k] >= rest[k - 1] && rest[k] >= kLeastShare * heard[k] &&
            heard[k] >= kQuiet * loudest))
        continue;
      times.push_back(static_cast<double>(segment.begin + k * block) / rate);
      k += kBlocksOfBlow;
    }
  }
  return times;
}

}  // namespace klang::fit::detail
