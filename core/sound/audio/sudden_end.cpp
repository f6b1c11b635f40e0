#include "core/sound/audio/sudden_end.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/sound/audio/fft.hpp"

namespace klang::audio {
namespace {

constexpr double kShortestBlockS = 0.0025;
constexpr double kLongestBlockS = 0.02;
constexpr double kPeriodsPerBlock = 1.5;  ///< of what is low in the sound, so that a period does not show in the level
constexpr double kLowShare = 0.1;         ///< of the energy lies below what is called low
constexpr double kShortestRingS = 0.1;
constexpr double kDropDb = 15, kBeforeShare = 0.2;
constexpr double kLongestDropS = 0.35;
constexpr double kUnprovenDropS =
    0.05;  ///< a longer drop must be followed by kRestS: a slow beat falls into its null so
constexpr double kRestS = 0.1;
constexpr double kBendDb = 0.5;
constexpr double kRestFallsDb = 4;  ///< of what is left after the drop, at most

/// Frequency below which kLowShare of the energy lies, over the first 2^15 frames at most.
double low_frequency_hz(const Eigen::Ref<const Eigen::MatrixXd>& stretch, double rate) {
  const Eigen::Index n = good_fft_size_below(std::min<Eigen::Index>(stretch.rows(), Eigen::Index{1} << 15));
  Eigen::VectorXd power = Eigen::VectorXd::Zero(n / 2 + 1);
  for (Eigen::Index c = 0; c < stretch.cols(); ++c) power += real_spectrum(stretch.col(c).head(n), n).cwiseAbs2();
  power[0] = 0;
  const double wanted = kLowShare * power.sum();
  double sum = 0;
  for (Eigen::Index k = 0; k < power.size(); ++k) {
    sum += power[k];
    if (sum >= wanted) return std::max(0.5, static_cast<double>(k)) * rate / static_cast<double>(n);
  }
  return 0.5 * rate;
}

/// Level in dB of the loudest block from each block on: falls, and only once for all that comes back.
std::vector<double> levels_to_come_db(const Eigen::Ref<const Eigen::MatrixXd>& stretch, Eigen::Index block,
                                      std::size_t n_blocks) {
  const Eigen::RowVectorXd mean = stretch.colwise().mean();
  std::vector<double> level(n_blocks);
  double loudest = 0;
  for (std::size_t k = n_blocks; k-- > 0;) {
    const auto part = stretch.middleRows(static_cast<Eigen::Index>(k) * block, block);
    loudest = std::max(loudest, (part.rowwise() - mean).squaredNorm());
    level[k] = 10 * std::log10(loudest / static_cast<double>(block) + 1e-30);
  }
  return level;
}

/// Last block of [k, k + span] up to which the level falls as it did over the span before, within kBendDb.
std::size_t last_before(const std::vector<double>& level, std::size_t k, std::size_t span) {
  const double per_block = (level[k - span] - level[k]) / static_cast<double>(span);
  std::size_t last = k;
  while (last < k + span && level[k] - level[last + 1] <= kBendDb + per_block * static_cast<double>(last + 1 - k))
    ++last;
  return last;
}

}  // namespace

std::optional<Eigen::Index> sudden_end(const Eigen::Ref<const Eigen::MatrixXd>& stretch, double sample_rate_hz) {
  if (static_cast<double>(stretch.rows()) < 2 * kShortestRingS * sample_rate_hz || stretch.cols() == 0)
    return std::nullopt;
  const double block_s = std::max(kShortestBlockS, kPeriodsPerBlock / low_frequency_hz(stretch, sample_rate_hz));
  const auto block = static_cast<Eigen::Index>(std::llround(block_s * sample_rate_hz));
  if (block_s > kLongestBlockS || block < 4) return std::nullopt;
  const auto n = static_cast<std::size_t>(stretch.rows() / block);
  const Eigen::Index skipped =
      stretch.rows() - static_cast<Eigen::Index>(n) * block;  // the blocks end with the stretch
  const std::vector<double> level = levels_to_come_db(stretch.bottomRows(stretch.rows() - skipped), block, n);
  const auto first = static_cast<std::size_t>(std::ceil(kShortestRingS / block_s));
  for (std::size_t span = 4; static_cast<double>(span) * block_s <= kLongestDropS; span *= 2) {
    for (std::size_t k = std::max(first, span); k + span < n; ++k) {
      const double drop = level[k] - level[k + span];
      if (!(drop >= kDropDb) || !(level[k - span] - level[k] <= kBeforeShare * drop)) continue;
      if (level[k + span] - level[n - 1 - (n - 1 - k - span) / 4] > kRestFallsDb) continue;
      const double rest_s = static_cast<double>(n - 1 - k - span) * block_s;
      if (static_cast<double>(span) * block_s > kUnprovenDropS && rest_s < kRestS) continue;
      return skipped + static_cast<Eigen::Index>(last_before(level, k, span) - 1) * block;
    }
  }
  return std::nullopt;
}

}  // namespace klang::audio
