#include "fit/bubble/damped_filter.hpp"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/parallel.hpp"

namespace klang::fit::bubble {
namespace {

constexpr Eigen::Index kLanes = 16;  // atoms side by side: whole vector registers
using Lanes = Eigen::Array<float, kLanes, 1>;

}  // namespace

DampedFilterBank::DampedFilterBank(std::vector<Atom> atoms, double sample_rate_hz, Eigen::Index n_samples)
    : atoms_(std::move(atoms)),
      sample_rate_hz_(sample_rate_hz),
      n_samples_(n_samples),
      n_blocks_((n_samples + kBlock - 1) / kBlock),
      n_padded_((static_cast<Eigen::Index>(atoms_.size()) + kLanes - 1) / kLanes * kLanes) {
  pole_real_.setZero(n_padded_);
  pole_imag_.setZero(n_padded_);
  gain_.setZero(n_padded_);
  for (std::size_t i = 0; i < atoms_.size(); ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    const double fall = std::exp(-atoms_[i].decay_per_s / sample_rate_hz),
                 angle = 2.0 * kPi * atoms_[i].frequency_hz / sample_rate_hz;
    pole_real_[k] = static_cast<float>(fall * std::cos(angle));
    pole_imag_[k] = static_cast<float>(-fall * std::sin(angle));
    gain_[k] = static_cast<float>(1.0 - fall * fall);
    reach_.push_back(static_cast<Eigen::Index>(std::ceil(std::log(1e4) / atoms_[i].decay_per_s * sample_rate_hz)));
  }
  best_.setZero(n_padded_, n_blocks_);
  mask_.setZero(n_padded_, n_blocks_);
  best_at_.setZero(n_padded_, n_blocks_);
}

void DampedFilterBank::update(const Eigen::VectorXf& whitened, Eigen::Index first, Eigen::Index last) {
  parallel_for(static_cast<std::size_t>(n_padded_ / kLanes), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t group = begin; group < end; ++group) {
      const auto lane = static_cast<Eigen::Index>(group) * kLanes;
      Eigen::Index reach = 0;
      for (std::size_t i = static_cast<std::size_t>(lane);
           i < std::min(atoms_.size(), static_cast<std::size_t>(lane + kLanes)); ++i)
        reach = std::max(reach, reach_[i]);
      // A change at a sample reaches back to the atoms that begin before it; what comes after it is needed to begin.
      const Eigen::Index low = std::max<Eigen::Index>(0, first - reach) / kBlock;
      const Eigen::Index high = std::min(n_blocks_, (last + kBlock - 1) / kBlock);
      const Eigen::Index start = std::min(n_samples_, high * kBlock + reach);
      const Lanes pr = pole_real_.segment<kLanes>(lane), pi = pole_imag_.segment<kLanes>(lane),
                  gain = gain_.segment<kLanes>(lane);
      Lanes cr = Lanes::Zero(), ci = Lanes::Zero();
      for (Eigen::Index t = start - 1; t >= std::min(start, high * kBlock); --t) {
        const Lanes r = pr * cr - pi * ci + whitened[t];
        ci = pr * ci + pi * cr;
        cr = r;
      }
      for (Eigen::Index block = high - 1; block >= low; --block) {
        Lanes best = Lanes::Zero();
        Eigen::Array<int, kLanes, 1> at = Eigen::Array<int, kLanes, 1>::Zero();
        for (Eigen::Index t = std::min(n_samples_, (block + 1) * kBlock) - 1; t >= block * kBlock; --t) {
          const Lanes r = pr * cr - pi * ci + whitened[t];
          ci = pr * ci + pi * cr;
          cr = r;
          const Lanes score = (cr * cr + ci * ci) * gain;
          at = (score > best).select(static_cast<int>(t), at);
          best = best.max(score);
        }
        best_.col(block).segment<kLanes>(lane) = best;
        best_at_.col(block).segment<kLanes>(lane) = at;
      }
    }
  });
}

DampedFilterBank::Peak DampedFilterBank::highest(Eigen::Index first, Eigen::Index last) const {
  const Eigen::Index low = std::clamp<Eigen::Index>(first / kBlock, 0, n_blocks_),
                     high = std::min(n_blocks_, (last + kBlock - 1) / kBlock);
  const auto n = static_cast<Eigen::Index>(atoms_.size());
  Peak peak;
  for (Eigen::Index block = low; block < high; ++block) {
    Eigen::Index atom = 0;
    const auto scores = best_.col(block).head(n), masks = mask_.col(block).head(n);
    const float score = (scores > masks).select(scores, 0.0f).maxCoeff(&atom);
    if (score > peak.score) peak = {score, best_at_(atom, block), static_cast<std::size_t>(atom)};
  }
  return peak;
}

void DampedFilterBank::mask(Eigen::Index first, Eigen::Index last, double low_hz, double high_hz, double score) {
  const Eigen::Index low = std::clamp<Eigen::Index>(first / kBlock, 0, n_blocks_),
                     high = std::min(n_blocks_, (last + kBlock - 1) / kBlock);
  for (std::size_t i = 0; i < atoms_.size(); ++i) {
    if (atoms_[i].frequency_hz < low_hz || atoms_[i].frequency_hz > high_hz) continue;
    for (Eigen::Index block = low; block < high; ++block) {
      float& at = mask_(static_cast<Eigen::Index>(i), block);
      at = std::max(at, static_cast<float>(score));
    }
  }
}

}  // namespace klang::fit::bubble
