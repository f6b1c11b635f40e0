#include <algorithm>
#include <array>
#include <cmath>

#include "core/foundation/base/parallel.hpp"
#include "fit/ringdown/detail/partial_parts.hpp"

namespace klang::fit::detail {
namespace {

using Complex = std::complex<double>;

constexpr double kDisturbed = 4.0;     ///< residual over noise from which later starts are tried
constexpr double kForeseeable = 50.0;  ///< power over noise from which a partial must be seen later
constexpr double kLost = 0.7;          ///< part of its amplitude that may be missing there
constexpr double kSurer = 1.3;         ///< how much smaller the deviation must be to start later
constexpr double kReachCells = 8.0;    ///< from a change to what is fitted again, in 1 / window
constexpr double kMostGrowth = 3.0;    ///< nepers over the longest segment
constexpr double kSameStory = 2.5;     ///< residual with a later start's poles over the one without
constexpr double kCarriedShare = 0.6;  ///< of the energy in a sub-band, for its group to be what sounds there
constexpr double kDriftPart = 0.2;     ///< of the window: starts up to there tell whether a frequency drifts
constexpr double kLocalCells = 8.0;    ///< around a line: what the fit leaves there is its noise
constexpr double kFewestFree = 12.0;   ///< real numbers that must be left over there to say so
constexpr double kNotFarBelow = 0.01;  ///< of the strongest member's energy

/// Neighbours whose lines overlap and whose decays are alike are fitted together.
std::vector<std::vector<std::size_t>> groups_of(const RingData& data, const std::vector<FittedPartial>& partials) {
  std::vector<std::size_t> order(partials.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return partials[a].ring.pole.frequency_hz < partials[b].ring.pole.frequency_hz;
  });
  std::vector<std::vector<std::size_t>> groups;
  for (const std::size_t i : order) {
    const Pole& pole = partials[i].ring.pole;
    const double window = window_of(pole, data);
    bool placed = false;
    for (auto group = groups.rbegin(); group != groups.rend() && !placed; ++group) {
      if (std::distance(groups.rbegin(), group) > 8) break;
      const Pole& last = partials[group->back()].ring.pole;
      const double other = window_of(last, data);
      const double shorter = std::min(window, other), longer = std::max(window, other);
      if (group->size() < 8 && pole.frequency_hz - last.frequency_hz < 6 / shorter && longer < 5 * shorter) {
        group->push_back(i);
        placed = true;
      }
    }
    if (!placed) groups.push_back({i});
  }
  return groups;
}

struct GroupFit {
  bool ok = false;
  SubBand band;
  RefinedFit fit;
  FitCovariance spread;
  double variance = 0.0;
  double strongest_std_hz = 1e300;  ///< of the group's strongest partial
};

GroupFit fit_group(const RingData& data, const std::vector<Pole>& poles, const std::vector<RingPartial>& others,
                   double window, Eigen::Index offset) {
  GroupFit result;
  double low = 1e300, high = 0, fastest = 0;
  for (const Pole& pole : poles) {
    low = std::min(low, pole.frequency_hz);
    high = std::max(high, pole.frequency_hz);
    fastest = std::max(fastest, pole.decay_per_s);
  }
  const double half = std::max(kHalfBandCells / window, fastest);
  result.band = data.sub_band(low - half, high + half, window, others, offset);
  if (result.band.blocks.empty()) return result;
  result.fit = refine(result.band, poles);
  if (!result.fit.ok) return result;
  result.variance = residual_variance(result.band, result.fit);
  result.spread = covariance(result.band, result.fit.poles, result.fit.linear, result.variance);
  if (!result.spread.ok) return result;
  const auto n = static_cast<Eigen::Index>(2 * poles.size());
  double strongest = -1;
  for (std::size_t b = 0; b < result.band.blocks.size(); ++b) {
    const double loudest = data.peak(result.band.blocks[b].segment, result.band.blocks[b].channel);
    const Eigen::VectorXd& c = result.fit.linear.coefficients[b];
    if (!(c.head(n).cwiseAbs().maxCoeff() <= 3 * loudest)) return result;
    for (Eigen::Index i = 0; i < n; i += 2) {
      if (c.segment(i, 2).norm() <= strongest) continue;
      strongest = c.segment(i, 2).norm();
      result.strongest_std_hz = std::sqrt(result.spread.poles(i, i));
    }
  }
  result.ok = true;
  return result;
}

/// Power of a partial over the variance of its amplitude with the poles known, best block.
double signal_to_noise(const GroupFit& fit, std::size_t index) {
  const auto at = static_cast<Eigen::Index>(2 * index);
  double best = 0;
  for (std::size_t b = 0; b < fit.band.blocks.size(); ++b) {
    const double power = fit.fit.linear.coefficients[b].segment(at, 2).squaredNorm();
    best = std::max(best, power / fit.spread.amplitudes_held[b].block<2, 2>(at, at).trace());
  }
  return best;
}

/// What a fit leaves a bin within kLocalCells of each line, over what it leaves in the whole sub-band. Misfit is no white noise: it
/// stands where a strong line is no exponential or where lines are missing, and a line some cells away is as sure as its own bins are.
std::vector<double> local_levels(const GroupFit& fit) {
  std::vector<double> levels;
  const double reach = kLocalCells / fit.band.time_scale_s;
  for (const Pole& pole : fit.fit.poles) {
    double rest = 0, n_free = 0;
    for (std::size_t b = 0; b < fit.band.blocks.size(); ++b) {
      const BinBlock& block = fit.band.blocks[b];
      double n_bins = 0;
      for (Eigen::Index k = 0; k < block.y.size(); ++k) {
        if (std::abs(block.frequency_hz(k) - pole.frequency_hz) > reach) continue;
        rest += std::norm(fit.fit.linear.residuals[b][k]);
        ++n_bins;
      }
      n_free += 2 * n_bins * (1 - static_cast<double>(kBackgroundTerms) / static_cast<double>(block.y.size()));
    }
    for (const Pole& other : fit.fit.poles) {
      if (std::abs(other.frequency_hz - pole.frequency_hz) <= reach)
        n_free -= 2 + 2 * static_cast<double>(fit.band.blocks.size());
    }
    const bool known = n_free >= kFewestFree && fit.variance > 0;
    levels.push_back(known ? std::max(2 * rest / n_free / fit.variance, 1e-6) : 1.0);
  }
  return levels;
}

/// With the pole as it is: what is known of it when no refinement succeeds.
GroupFit hold_pole(const RingData& data, const Pole& pole, const std::vector<RingPartial>& others, double window) {
  GroupFit result;
  const double half = std::max(kHalfBandCells / window, pole.decay_per_s);
  result.band = data.sub_band(pole.frequency_hz - half, pole.frequency_hz + half, window, others);
  if (result.band.blocks.empty()) return result;
  result.fit.poles = {pole};
  result.fit.linear = linear_fit(result.band, result.fit.poles);
  result.variance = residual_variance(result.band, result.fit);
  result.spread = covariance(result.band, result.fit.poles, result.fit.linear, result.variance);
  result.ok = result.fit.ok = result.spread.ok;
  return result;
}

/// Of the two partials of a group that are told apart worst, in line widths, the weaker one: its place in the group.
std::size_t least_resolved(const std::vector<FittedPartial>& all, const std::vector<std::size_t>& group,
                           double window) {
  std::size_t weaker = 0;
  double closest = 1e300;
  for (std::size_t i = 0; i < group.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      const RingPartial& a = all[group[i]].ring;
      const RingPartial& b = all[group[j]].ring;
      const double width = std::max(a.pole.decay_per_s, b.pole.decay_per_s) / (2 * kPi) + 0.5 / window;
      const double apart =
          std::hypot(a.pole.frequency_hz - b.pole.frequency_hz, (a.pole.decay_per_s - b.pole.decay_per_s) / (2 * kPi)) /
          width;
      if (!(apart < closest)) continue;
      closest = apart;
      weaker = a.energy() < b.energy() ? i : j;
    }
  }
  return weaker;
}

/// Marks a partial as none: nothing of it is subtracted where others are fitted.
void leave_out(FittedPartial& partial) {
  partial.unresolved = true;
  partial.ring.amplitude.setZero();
}

/// Which members of the group carry their neighbourhood (FittedPartial::carries): where the group explains most of its
/// sub-band and no other partial near it is stronger, the strongest and those not far below it.
std::vector<char> carrying_members(const RingData& data, const GroupFit& fit, const std::vector<std::size_t>& group,
                                   const std::vector<FittedPartial>& all) {
  std::vector<char> carries(group.size(), 0);
  const double background = linear_fit(fit.band, {}).residual_sum_sq;
  if (!(fit.fit.linear.residual_sum_sq <= (1.0 - kCarriedShare) * background)) return carries;
  std::vector<double> energy;
  for (std::size_t g = 0; g < group.size(); ++g)
    energy.push_back(RingPartial{fit.fit.poles[g], amplitudes_of(data, fit.band, fit.fit.linear, g)}.energy());
  const auto strongest = static_cast<std::size_t>(std::max_element(energy.begin(), energy.end()) - energy.begin());
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (std::find(group.begin(), group.end(), i) != group.end()) continue;
    const double apart = std::abs(all[i].ring.pole.frequency_hz - fit.fit.poles[strongest].frequency_hz);
    if (apart < kHalfBandCells / fit.band.time_scale_s && all[i].ring.energy() > energy[strongest]) return carries;
  }
  for (std::size_t g = 0; g < group.size(); ++g) carries[g] = energy[g] >= kNotFarBelow * energy[strongest];
  return carries;
}

/// One group's joint fit; the others stay as they are. Where no joint fit succeeds the least resolved member is left
/// out (and marked) and the rest is fitted again: one that cannot be told from its neighbour takes nobody along.
void polish_group(const RingData& data, const std::vector<FittedPartial>& all, std::vector<std::size_t> group,
                  const Polishing& how, std::vector<FittedPartial>& result) {
  double window = 0, centre = 0;
  std::vector<RingPartial> others;
  std::vector<Pole> poles;
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (std::find(group.begin(), group.end(), i) == group.end()) others.push_back(all[i].ring);
  }
  for (const std::size_t i : group) {
    poles.push_back(all[i].ring.pole);
    window = std::max(window, window_of(poles.back(), data));
    centre += poles.back().frequency_hz / static_cast<double>(group.size());
  }
  GroupFit best = fit_group(data, poles, others, window, 0);
  while (!best.ok && group.size() > 1) {
    const std::size_t left_out = least_resolved(all, group, window);
    leave_out(result[group[left_out]]);
    group.erase(group.begin() + static_cast<std::ptrdiff_t>(left_out));
    poles.erase(poles.begin() + static_cast<std::ptrdiff_t>(left_out));
    best = fit_group(data, poles, others, window, 0);
  }
  if (!best.ok) best = hold_pole(data, poles.front(), others, window);
  const GroupFit early = best;
  Eigen::Index best_offset = 0;
  std::vector<double> drift_hz(group.size(), 0.0);
  if (how.later_starts && (!best.ok || best.variance > kDisturbed * how.noise->at(centre))) {
    // Something other than free ringing in the first part (a second touch, a rattle)? A later start that is
    // much surer of the strongest partial says so.
    for (const double part : {0.08, 0.16, 0.3, 0.45}) {
      const auto later = static_cast<Eigen::Index>(part * window * data.sample_rate_hz());
      GroupFit late = fit_group(data, poles, others, window, later);
      const bool complete = late.ok && (!best.ok || late.band.blocks.size() >= best.band.blocks.size());
      for (std::size_t g = 0; early.ok && complete && part < kDriftPart && g < group.size(); ++g) {
        const auto at = static_cast<Eigen::Index>(2 * g);
        const double moved = std::abs(late.fit.poles[g].frequency_hz - early.fit.poles[g].frequency_hz);
        const double width = early.fit.poles[g].decay_per_s / (2 * kPi) + 0.5 / window;
        const bool beyond_noise = moved * moved > 9.0 * late.spread.poles(at, at);
        if (beyond_noise && moved < 0.3 * width) drift_hz[g] = std::max(drift_hz[g], moved);
      }
      if (!complete || !(late.strongest_std_hz < best.strongest_std_hz / (best_offset == 0 ? kSurer : 1.0))) continue;
      // Its poles must tell the whole story nearly as well: a pitch that glides is not a disturbance.
      const SubBand whole =
          data.sub_band(late.band.blocks.front().frequency_hz(0),
                        late.band.blocks.front().frequency_hz(late.band.blocks.front().y.size() - 1), window, others);
      RefinedFit held;
      held.poles = late.fit.poles;
      held.linear = linear_fit(whole, held.poles);
      if (early.ok && !(residual_variance(whole, held) <= kSameStory * early.variance)) continue;
      best = std::move(late);
      best_offset = later;
    }
  }
  if (!best.ok) return;  // the last good fit stays
  const bool misfit = how.noise != nullptr && best.variance > kDisturbed * how.noise->at(centre);
  const std::vector<double> level = misfit ? local_levels(best) : std::vector<double>(group.size(), 1.0);
  std::vector<double> late_snr;
  if (best_offset > 0) {
    // Poles from the undisturbed part, amplitudes from all of it: what rang is what the recording holds.
    for (std::size_t g = 0; g < group.size(); ++g) late_snr.push_back(signal_to_noise(best, g));
    best.band =
        data.sub_band(best.band.blocks.front().frequency_hz(0),
                      best.band.blocks.front().frequency_hz(best.band.blocks.front().y.size() - 1), window, others);
    best.fit.linear = linear_fit(best.band, best.fit.poles);
    const Eigen::MatrixXd poles_from_late = best.spread.poles;
    best.spread = covariance(best.band, best.fit.poles, best.fit.linear, residual_variance(best.band, best.fit));
    if (!best.spread.ok) return;
    best.spread.poles = poles_from_late;
  }
  const auto n_channels = data.channels().size();
  const std::vector<char> carries = carrying_members(data, best, group, all);
  for (std::size_t g = 0; g < group.size(); ++g) {
    FittedPartial& partial = result[group[g]];
    partial.carries = carries[g] != 0;
    if (how.later_starts) partial.drift_hz = drift_hz[g];
    partial.ring.pole = best.fit.poles[g];
    partial.ring.amplitude = amplitudes_of(data, best.band, best.fit.linear, g);
    partial.window_s = best.band.time_scale_s;
    partial.lasts.reset();
    // What grows in a short window would explode in a longer one; it rings nowhere.
    if (partial.ring.pole.decay_per_s * data.longest_segment_s() < -kMostGrowth) leave_out(partial);
    if (how.noise != nullptr)
      partial.disturbance = level[g] * (early.ok ? early.variance : best.variance) / (how.noise->at(centre) + 1e-300);
    // A bias that comes from misfit far away leaves nothing near the line: less rest makes it only half as much surer.
    const double own = level[g] < 1 ? std::sqrt(level[g]) : level[g];
    const double spread = own * (how.noise != nullptr ? how.noise->repeats() : 1.0);
    const auto at = static_cast<Eigen::Index>(2 * g);
    partial.pole_covariance = spread * best.spread.poles.block<2, 2>(at, at);
    const std::size_t n_blocks = data.segments().size() * n_channels;
    partial.amplitude_covariance.assign(n_blocks, Eigen::Matrix2d::Zero());
    partial.cross_covariance.assign(n_blocks, Eigen::Matrix2d::Zero());
    for (std::size_t b = 0; b < best.band.blocks.size(); ++b) {
      const auto slot = static_cast<std::size_t>(best.band.blocks[b].segment) * n_channels +
                        static_cast<std::size_t>(best.band.blocks[b].channel);
      partial.amplitude_covariance[slot] = spread * best.spread.amplitudes[b].block<2, 2>(at, at);
      partial.cross_covariance[slot] = spread * best.spread.cross[b].block<2, 2>(at, at);
    }
    const double snr = (late_snr.empty() ? signal_to_noise(best, g) : late_snr[g]) / level[g];
    partial.snr_db = 10 * std::log10(std::max(snr, 1e-30));
  }
}

/// Groups in two rounds: neighbours see each other's newest state (all at once, overlapping lines can chase
/// each other). Only groups for which wanted(group) holds.
template <typename Wanted>
void polish_groups(const RingData& data, std::vector<FittedPartial>& partials, const Polishing& how, Wanted wanted) {
  const auto groups = groups_of(data, partials);
  std::array<std::vector<std::size_t>, 2> rounds;
  for (std::size_t g = 0; g < groups.size(); ++g) {
    if (wanted(groups[g])) rounds[g % 2].push_back(g);
  }
  for (const std::vector<std::size_t>& chosen : rounds) {
    const std::vector<FittedPartial> before = partials;
    for_each_job(chosen.size(),
                 [&](std::size_t job) { polish_group(data, before, groups[chosen[job]], how, partials); });
  }
}

}  // namespace

double window_of(const Pole& pole, const RingData& data) {
  const double shortest = std::max(kShortestWindowS, 64 / data.sample_rate_hz());
  const double wanted = pole.decay_per_s > 0 ? kDecaysPerWindow / pole.decay_per_s : 1e9;
  // A grid of lengths, so that fits share spectra.
  const double longest = data.longest_segment_s();
  const double steps = std::max(0.0, std::floor(2 * std::log2(longest / std::max(wanted, shortest))));
  return longest * std::exp2(-0.5 * steps);
}

double residual_variance(const SubBand& band, const RefinedFit& fit) {
  const auto order = static_cast<double>(fit.poles.size());
  const double used = 2 * order + static_cast<double>(band.blocks.size()) * (2 * order + 2 * kBackgroundTerms);
  return 2 * fit.linear.residual_sum_sq / std::max(1.0, static_cast<double>(band.n_real_data()) - used);
}

Eigen::MatrixXcd amplitudes_of(const RingData& data, const SubBand& band, const LinearFit& linear, std::size_t index) {
  Eigen::MatrixXcd amplitude = Eigen::MatrixXcd::Zero(static_cast<Eigen::Index>(data.segments().size()),
                                                      static_cast<Eigen::Index>(data.channels().size()));
  for (std::size_t b = 0; b < band.blocks.size(); ++b) {
    const auto i = static_cast<Eigen::Index>(2 * index);
    amplitude(band.blocks[b].segment, band.blocks[b].channel) =
        Complex(linear.coefficients[b][i], linear.coefficients[b][i + 1]);
  }
  return amplitude;
}

void polish_near(const RingData& data, std::vector<FittedPartial>& partials, const Polishing& how,
                 const std::vector<double>& changed_hz) {
  const std::vector<FittedPartial> snapshot = partials;
  polish_groups(data, partials, how, [&](const std::vector<std::size_t>& group) {
    for (const std::size_t i : group) {
      const Pole& pole = snapshot[i].ring.pole;
      const double reach = kReachCells / window_of(pole, data);
      for (const double f : changed_hz) {
        if (std::abs(f - pole.frequency_hz) < reach) return true;
      }
    }
    return false;
  });
}

void polish(const RingData& data, std::vector<FittedPartial>& partials, const TailNoise& noise) {
  polish_groups(data, partials, {&noise, true}, [](const std::vector<std::size_t>&) { return true; });
}

void check_persistence(const RingData& data, std::vector<FittedPartial>& partials) {
  const std::vector<FittedPartial>& all = partials;
  const auto groups = groups_of(data, partials);
  std::vector<std::size_t> chosen;
  for (std::size_t g = 0; g < groups.size(); ++g) {
    if (std::any_of(groups[g].begin(), groups[g].end(), [&](std::size_t i) { return !all[i].lasts.has_value(); }))
      chosen.push_back(g);
  }
  for_each_job(chosen.size(), [&](std::size_t job) {
    const auto& group = groups[chosen[job]];
    std::vector<RingPartial> others;
    std::vector<Pole> poles;
    double low = 1e300, high = 0, window = 0;
    for (std::size_t i = 0; i < all.size(); ++i) {
      if (std::find(group.begin(), group.end(), i) == group.end()) others.push_back(all[i].ring);
    }
    for (const std::size_t i : group) {
      poles.push_back(all[i].ring.pole);
      low = std::min(low, poles.back().frequency_hz);
      high = std::max(high, poles.back().frequency_hz);
      window = std::max(window, window_of(poles.back(), data));
    }
    const double half = kHalfBandCells / window;
    std::vector<char> lasts(group.size(), 1);
    for (std::size_t member = 0; member < group.size(); ++member) {
      const RingPartial& ring = all[group[member]].ring;
      const bool strongest = std::all_of(group.begin(), group.end(), [&](std::size_t i) {
        return all[i].ring.amplitude.norm() <= ring.amplitude.norm();
      });
      if (strongest) continue;
      const double later_s = std::min(1 / std::max(ring.pole.decay_per_s, 1e-9), 0.4 * data.longest_segment_s());
      const auto offset = static_cast<Eigen::Index>(later_s * data.sample_rate_hz());
      const SubBand band = data.sub_band(low - half, high + half, window, others, offset);
      if (band.blocks.empty()) continue;
      RefinedFit held;
      held.poles = poles;
      held.linear = linear_fit(band, poles);
      const double variance = residual_variance(band, held);
      const FitCovariance spread = covariance(band, poles, held.linear, variance);
      if (!spread.ok) continue;
      const Complex step = std::exp(Complex(-ring.pole.decay_per_s, 2 * kPi * ring.pole.frequency_hz) *
                                    (static_cast<double>(offset) / data.sample_rate_hz()));
      const auto at = static_cast<Eigen::Index>(2 * member);
      double expected = 0, missed = 0, noise = 0;
      for (std::size_t b = 0; b < band.blocks.size(); ++b) {
        const Complex predicted = ring.amplitude(band.blocks[b].segment, band.blocks[b].channel) * step;
        const Complex seen(held.linear.coefficients[b][at], held.linear.coefficients[b][at + 1]);
        expected += std::norm(predicted);
        missed += std::norm(seen - predicted);
        noise += spread.amplitudes_held[b].block<2, 2>(at, at).trace();
      }
      if (expected > kForeseeable * noise && missed > kLost * kLost * expected) lasts[member] = 0;
    }
    for (std::size_t member = 0; member < group.size(); ++member) partials[group[member]].lasts = lasts[member] != 0;
  });
}

}  // namespace klang::fit::detail
