#include "fit/ringdown/ringdown.hpp"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/stopwatch.hpp"
#include "core/sound/audio/fft.hpp"
#include "core/sound/audio/sound_file.hpp"
#include "core/sound/audio/strikes.hpp"
#include "fit/ringdown/detail/partial_search.hpp"

namespace klang::fit {
namespace {

using detail::FittedPartial;
using detail::RingData;
using detail::Segment;
using Complex = std::complex<double>;

constexpr double kSureSnrDb = 14.0;      ///< below it noise alone makes partials
constexpr double kWeakestStrike = 0.01;  ///< energy a strike must add, against the strongest one
constexpr double kSilence = 1e-30;       ///< of full scale; the square of less may be no number
constexpr double kPi2 = 2 * kPi;

std::string short_hz(double frequency_hz) {
  const double rounded = std::round(frequency_hz * 10) / 10;
  return klang::to_text(rounded) + " Hz";
}

Complex advanced(const FittedPartial& partial, Complex amplitude, double time_s) {
  return amplitude * std::exp(Complex(-partial.ring.pole.decay_per_s, kPi2 * partial.ring.pole.frequency_hz) * time_s);
}

/// Energy that each strike adds to what rang already, summed over partials and channels.
std::vector<double> added_energy(const RingData& data, const std::vector<FittedPartial>& partials) {
  std::vector<double> energy(data.segments().size(), 0.0);
  for (const FittedPartial& partial : partials) {
    const double weight = 1 / (4 * (std::max(partial.ring.pole.decay_per_s, 0.0) + 1));
    for (std::size_t s = 0; s < energy.size(); ++s) {
      for (Eigen::Index c = 0; c < partial.ring.amplitude.cols(); ++c) {
        Complex added = partial.ring.amplitude(static_cast<Eigen::Index>(s), c);
        if (s > 0) {
          const double gap =
              static_cast<double>(data.segments()[s].begin - data.segments()[s - 1].begin) / data.sample_rate_hz();
          added -= advanced(partial, partial.ring.amplitude(static_cast<Eigen::Index>(s) - 1, c), gap);
        }
        energy[s] += weight * std::norm(added);
      }
    }
  }
  return energy;
}

/// Amplitude at frequency_hz in the part before the first strike (Hann window), or empty when that part is
/// too short.
std::optional<double> amplitude_before(const RingData& data, Eigen::Index channel, double frequency_hz) {
  const double rate = data.sample_rate_hz();
  const auto end = static_cast<Eigen::Index>((data.segments().front().strike_s - 0.005) * rate);
  const auto n = std::min<Eigen::Index>(end, static_cast<Eigen::Index>(2 * rate));
  if (n < 64 || static_cast<double>(n) / rate < std::max(0.05, 6 / frequency_hz)) return std::nullopt;
  const Eigen::VectorXd& x = data.channels()[static_cast<std::size_t>(channel)];
  Complex sum = 0;
  double weight = 0;
  for (Eigen::Index i = 0; i < n; ++i) {
    const double w = 0.5 - 0.5 * std::cos(kPi2 * (static_cast<double>(i) + 0.5) / static_cast<double>(n));
    sum += w * x[end - n + i] * std::polar(1.0, -kPi2 * frequency_hz / rate * static_cast<double>(i));
    weight += w;
  }
  return 2 * std::abs(sum) / weight;
}

/// Amplitude, phase and their deviations at the strike from those where the segment begins.
void extrapolate(Partial& out, const FittedPartial& partial, const Segment& segment, Complex a,
                 const Eigen::Matrix2d& amplitude_covariance, const Eigen::Matrix2d& cross) {
  const double t = segment.delay_s;
  const double size = std::abs(a);
  out.amplitude = size * std::exp(partial.ring.pole.decay_per_s * t);
  out.phase_rad = std::remainder(std::arg(a) - kPi2 * partial.ring.pole.frequency_hz * t, kPi2);
  // log amplitude = log|a| + decay t, phase = arg a - 2 pi f t, linear in (ar, ai, f, decay).
  const Eigen::Vector2d log_slope(a.real() / (size * size), a.imag() / (size * size));
  const Eigen::Vector2d arg_slope(-a.imag() / (size * size), a.real() / (size * size));
  const Eigen::Matrix2d& pole = partial.pole_covariance;
  const double log_variance =
      log_slope.dot(amplitude_covariance * log_slope) + 2 * t * log_slope.dot(cross.col(1)) + t * t * pole(1, 1);
  const double phase_variance = arg_slope.dot(amplitude_covariance * arg_slope) -
                                2 * kPi2 * t * arg_slope.dot(cross.col(0)) + std::pow(kPi2 * t, 2) * pole(0, 0);
  out.amplitude_std = *out.amplitude * std::sqrt(std::max(log_variance, 1e-32));
  out.phase_std_rad = std::sqrt(std::max(phase_variance, 1e-32));
}

enum class Verdict { kPartial, kSteady, kNoise };

/// Whether a fitted exponential is a partial of a struck body.
Verdict judged(const RingData& data, const FittedPartial& partial, const RingdownOptions& options) {
  const auto& pole = partial.ring.pole;
  if (partial.amplitude_covariance.empty()) return Verdict::kNoise;  // its last fit failed
  if (!(partial.snr_db >= std::max(options.min_snr_db, kSureSnrDb))) return Verdict::kNoise;
  const double frequency_std = std::sqrt(partial.pole_covariance(0, 0));
  const double decay_std = std::sqrt(partial.pole_covariance(1, 1));
  const double width = std::max(pole.decay_per_s / kPi2, 0.5 / partial.window_s);
  if (!(frequency_std <= 0.3 * width) || !(frequency_std > 0) || !(decay_std > 0)) return Verdict::kNoise;
  if (!(pole.frequency_hz >= data.band().low_hz) || !(pole.frequency_hz <= data.band().high_hz)) return Verdict::kNoise;
  if (!(pole.decay_per_s < 0.7 * kPi2 * pole.frequency_hz)) return Verdict::kNoise;  // over before it oscillates
  Eigen::Index segment = 0, channel = 0;
  partial.ring.amplitude.cwiseAbs().maxCoeff(&segment, &channel);
  const double loud = std::abs(partial.ring.amplitude(segment, channel));
  // Two exponentials that nearly cancel have amplitudes that nobody knows.
  const auto slot = static_cast<std::size_t>(segment * partial.ring.amplitude.cols() + channel);
  if (!(loud * loud >= 4 * partial.amplitude_covariance[slot].trace())) return Verdict::kNoise;
  Partial struck;
  extrapolate(struck, partial, data.segments()[static_cast<std::size_t>(segment)],
              partial.ring.amplitude(segment, channel), partial.amplitude_covariance[slot],
              partial.cross_covariance[slot]);
  if (!(*struck.amplitude_std <= 0.6 * *struck.amplitude)) return Verdict::kNoise;
  if (!(*struck.amplitude <= 10 * data.peak(segment, channel))) return Verdict::kNoise;
  const auto before = amplitude_before(data, channel, pole.frequency_hz);
  if (before && *before > 0.3 * loud) return Verdict::kSteady;
  const double mains =
      std::min(std::abs(std::remainder(pole.frequency_hz, 50.0)), std::abs(std::remainder(pole.frequency_hz, 60.0)));
  const double lost = pole.decay_per_s * partial.window_s;  // nepers within the window
  if (!before && mains < 0.3 && lost < 0.3 && pole.frequency_hz < 1000) return Verdict::kSteady;
  // Without a quiet part before the strike only a long look tells a steady tone from a slow decay.
  constexpr double kLongLookS = 1.5;
  if (!before && partial.window_s >= kLongLookS && (pole.decay_per_s + 2 * decay_std) * partial.window_s < 0.05)
    return Verdict::kSteady;
  if (!(pole.decay_per_s > -3 * decay_std) && lost < -0.3) return Verdict::kSteady;  // it grows
  return Verdict::kPartial;
}

/// Partials that only mend the shape of a stronger neighbour (a decay that is not quite exponential, a band
/// not quite fitted): within a fraction of the wider line's width and weaker.
std::vector<bool> shadows(const std::vector<FittedPartial>& partials) {
  std::vector<bool> shadow(partials.size(), false);
  for (std::size_t i = 0; i < partials.size(); ++i) {
    for (std::size_t j = 0; j < partials.size(); ++j) {
      if (i == j || shadow[j]) continue;
      const auto& a = partials[i].ring;
      const auto& b = partials[j].ring;
      const double apart = std::abs(a.pole.frequency_hz - b.pole.frequency_hz);
      const double weak = a.amplitude.norm(), strong = b.amplitude.norm();
      if (!(weak < strong)) continue;
      const double width = std::max(a.pole.decay_per_s, b.pole.decay_per_s) / kPi2;
      const double cell = 1 / std::max(partials[i].window_s, partials[j].window_s);
      const bool inside_line = apart < 0.1 * width;
      const bool under_skirt = apart < 0.7 * width + 2 * cell && weak < 0.01 * strong;
      const bool mends = partials[j].disturbance > 10 && apart < 2 * width + 4 * cell && weak < 0.2 * strong;
      if (inside_line || under_skirt || mends) shadow[i] = true;
    }
  }
  return shadow;
}

struct Search {
  std::vector<FittedPartial> partials, steady;
};

Search search(const RingData& data, const RingdownOptions& options, Monitor& monitor) {
  detail::SearchOptions search_options;
  search_options.min_snr_db = options.min_snr_db;
  search_options.max_partials = options.max_partials;
  std::vector<FittedPartial> all = detail::search_partials(data, search_options, monitor);
  Search result;
  detail::polish(data, all);
  for (int pass = 0; pass < 6; ++pass) {
    const std::size_t before = all.size();
    std::vector<FittedPartial> kept;
    for (FittedPartial& partial : all) {
      if (judged(data, partial, options) != Verdict::kNoise) kept.push_back(std::move(partial));
    }
    const std::vector<bool> shadow = shadows(kept);
    const std::vector<bool> lasts = detail::persistent(data, kept);
    all.clear();
    for (std::size_t i = 0; i < kept.size(); ++i) {
      if (!shadow[i] && lasts[i]) all.push_back(std::move(kept[i]));
    }
    if (all.size() == before) break;
    detail::polish(data, all);
  }
  for (FittedPartial& partial : all) {
    switch (judged(data, partial, options)) {
      case Verdict::kPartial:
        result.partials.push_back(std::move(partial));
        break;
      case Verdict::kSteady:
        result.steady.push_back(std::move(partial));
        break;
      case Verdict::kNoise:
        break;
    }
  }
  return result;
}

/// Energy of x in band, by its spectrum (Parseval).
double band_energy(const Eigen::VectorXd& x, double rate, const Band& band) {
  const Eigen::Index n = audio::good_fft_size(x.size());
  const Eigen::VectorXcd spectrum = audio::real_spectrum(x, n);
  double sum = 0;
  for (Eigen::Index k = 1; k < spectrum.size(); ++k) {
    const double f = static_cast<double>(k) * rate / static_cast<double>(n);
    if (f >= band.low_hz && f <= band.high_hz) sum += std::norm(spectrum[k]);
  }
  return 2 * sum / static_cast<double>(n);
}

void measure_fit(RingdownResult& result, const RingData& data, const Search& found) {
  std::vector<detail::RingPartial> struck;
  for (const FittedPartial& partial : found.partials) struck.push_back(partial.ring);
  double energy = 0, rest = 0, n_samples = 0;
  for (std::size_t s = 0; s < data.segments().size(); ++s) {
    const Segment& segment = data.segments()[s];
    const Eigen::Index n = segment.end - segment.begin;
    for (std::size_t c = 0; c < data.channels().size(); ++c) {
      const Eigen::VectorXd left = data.residual(static_cast<Eigen::Index>(s), static_cast<Eigen::Index>(c), n, struck);
      energy += band_energy(data.channels()[c].segment(segment.begin, n), data.sample_rate_hz(), data.band());
      rest += band_energy(left, data.sample_rate_hz(), data.band());
      n_samples += static_cast<double>(n);
    }
  }
  if (energy > 0) result.explained_energy = std::clamp(1 - rest / energy, 0.0, 1.0);
  if (n_samples > 0) result.noise_rms = std::sqrt(rest / n_samples);
}

void fill_table(RingdownResult& result, const RingData& data, Search& found, const RingdownOptions& options) {
  auto& partials = found.partials;
  if (partials.size() > static_cast<std::size_t>(options.max_partials)) {
    std::stable_sort(partials.begin(), partials.end(),
                     [](const FittedPartial& a, const FittedPartial& b) { return a.ring.energy() > b.ring.energy(); });
    result.warnings.push_back("the strongest " + std::to_string(options.max_partials) + " of " +
                              std::to_string(partials.size()) + " partials kept");
    partials.resize(static_cast<std::size_t>(options.max_partials));
  }
  std::stable_sort(partials.begin(), partials.end(), [](const FittedPartial& a, const FittedPartial& b) {
    return a.ring.pole.frequency_hz < b.ring.pole.frequency_hz;
  });
  const auto n_segments = static_cast<Eigen::Index>(data.segments().size());
  if (n_segments > 1) {
    result.strike_amplitudes.resize(static_cast<std::size_t>(n_segments));
    result.strike_phases_rad.resize(static_cast<std::size_t>(n_segments));
  }
  for (const FittedPartial& partial : partials) {
    Partial out;
    out.frequency_hz = partial.ring.pole.frequency_hz;
    out.frequency_std_hz = std::sqrt(partial.pole_covariance(0, 0));
    out.decay_std_per_s = std::sqrt(partial.pole_covariance(1, 1));
    // A recording too short to show the decay may estimate it below zero; no body does that.
    out.decay_per_s = std::max(partial.ring.pole.decay_per_s, 0.05 * *out.decay_std_per_s);
    // The channel that is loudest for this partial over all strikes.
    Eigen::Index channel = 0;
    partial.ring.amplitude.cwiseAbs().colwise().sum().maxCoeff(&channel);
    const auto slot = static_cast<std::size_t>(channel);
    extrapolate(out, partial, data.segments().front(), partial.ring.amplitude(0, channel),
                partial.amplitude_covariance[slot], partial.cross_covariance[slot]);
    for (Eigen::Index s = 0; n_segments > 1 && s < n_segments; ++s) {
      const double delay = data.segments()[static_cast<std::size_t>(s)].delay_s;
      const Complex struck = advanced(partial, partial.ring.amplitude(s, channel), -delay);
      result.strike_amplitudes[static_cast<std::size_t>(s)].push_back(std::abs(struck));
      result.strike_phases_rad[static_cast<std::size_t>(s)].push_back(std::arg(struck));
    }
    result.partials.partials.push_back(out);
  }
}

void warn_about(RingdownResult& result, const RingData& data, const Search& found) {
  for (const std::string& warning : data.warnings()) result.warnings.push_back(warning);
  if (data.n_clipped() > 0) {
    result.warnings.push_back("clipped: " + std::to_string(data.n_clipped()) + " samples left out");
  }
  for (const FittedPartial& partial : found.steady) {
    const double f = partial.ring.pole.frequency_hz;
    const double mains = std::min(std::abs(std::remainder(f, 50.0)), std::abs(std::remainder(f, 60.0)));
    result.warnings.push_back((mains < 0.5 && f < 2000 ? "mains hum at " : "steady tone at ") + short_hz(f) +
                              " ignored");
  }
}

}  // namespace

void RingdownOptions::validate() const {
  std::vector<Violation> violations = violations_of(*this);
  if (!(band.high_hz > band.low_hz))
    violations.push_back(out_of_range("band.high_hz", band.high_hz, inside(band.low_hz, 1e9)));
  throw_violations("ringdown", std::move(violations));
}

RingdownResult identify_ringdown(const audio::Signal& recording, const RingdownOptions& options, Monitor& monitor) {
  options.validate();
  const std::string place = recording.origin.empty() ? "recording" : recording.origin;
  checked_open(place, "sample_rate_hz", recording.sample_rate_hz, 0, 1e9);
  checked(place, "number of samples", static_cast<double>(recording.n_frames()), 16, 1e12);
  checked(place, "number of channels", static_cast<double>(recording.n_channels()), 1, kMaxChannels);
  if (!recording.samples.allFinite()) throw InputError(place, "has samples that are not finite numbers");
  checked(place, "largest sample", recording.samples.cwiseAbs().maxCoeff(), 0, audio::kLargestSample);
  const Stopwatch total;
  RingdownResult result;
  result.status = RingdownStatus::kNothingFound;
  result.sample_rate_hz = recording.sample_rate_hz;
  result.partials.origin = recording.origin;
  Band band = options.band;
  band.high_hz = std::min(band.high_hz, 0.48 * recording.sample_rate_hz);
  if (!(band.low_hz < band.high_hz)) {
    result.message = "the band lies above half the sample rate";
    return result;
  }
  const double spread = (recording.samples.colwise().maxCoeff() - recording.samples.colwise().minCoeff()).maxCoeff();
  if (!(spread > kSilence)) throw InputError(place, "the recording is silent");

  audio::StrikeOptions strike_options;
  strike_options.band = band;
  std::vector<audio::Strike> strikes = audio::detect_strikes(recording, strike_options);
  if (strikes.empty()) strikes.push_back({});
  result.wall_time_s["strikes"] = total.seconds();

  const Stopwatch search_watch;
  std::optional<RingData> data;
  Search found;
  for (int attempt = 0; attempt < 3; ++attempt) {
    data.emplace(recording, strikes, band);
    if (data->segments().empty()) break;
    found = search(*data, options, monitor);
    // Strikes that add next to nothing to the partials were bumps or beats: without them the windows are
    // longer.
    const std::vector<double> energy = added_energy(*data, found.partials);
    const double most = energy.empty() ? 0.0 : *std::max_element(energy.begin(), energy.end());
    std::vector<audio::Strike> kept;
    for (const audio::Strike& strike : strikes) {
      bool weak = false;
      for (std::size_t s = 0; s < energy.size(); ++s) {
        if (data->segments()[s].strike_s == strike.time_s) weak = !(energy[s] >= kWeakestStrike * most);
      }
      if (!weak || found.partials.empty()) kept.push_back(strike);
    }
    if (kept.size() == strikes.size() || kept.empty()) break;
    strikes = std::move(kept);
  }
  result.wall_time_s["partials"] = search_watch.seconds();
  if (data->segments().empty()) {
    result.message = data->n_clipped() > 0 ? "nothing is left after the clipped samples"
                                           : "the recording is too short after its strike";
    result.warnings = data->warnings();
    return result;
  }
  warn_about(result, *data, found);
  if (found.partials.empty()) {
    result.message = found.steady.empty() ? "no decaying partial stands above the noise"
                                          : "only steady tones stand above the noise, nothing that decays";
    measure_fit(result, *data, found);
    return result;
  }
  result.status = RingdownStatus::kOk;
  for (const Segment& segment : data->segments()) result.strikes_s.push_back(segment.strike_s);
  fill_table(result, *data, found, options);
  measure_fit(result, *data, found);
  result.wall_time_s["total"] = total.seconds();
  return result;
}

audio::Signal resynthesise(const RingdownResult& ringdown, Eigen::Index n_frames) {
  audio::Signal signal;
  signal.sample_rate_hz = ringdown.sample_rate_hz;
  signal.origin = "resynthesis of " + ringdown.partials.origin;
  signal.samples = Eigen::MatrixXd::Zero(n_frames, 1);
  if (!ringdown.usable()) return signal;
  const double rate = ringdown.sample_rate_hz;
  for (std::size_t s = 0; s < ringdown.strikes_s.size(); ++s) {
    const double strike_s = ringdown.strikes_s[s];
    const auto begin = static_cast<Eigen::Index>(std::ceil(strike_s * rate - 1e-9));
    const Eigen::Index end =
        s + 1 < ringdown.strikes_s.size()
            ? std::min(n_frames, static_cast<Eigen::Index>(std::ceil(ringdown.strikes_s[s + 1] * rate - 1e-9)))
            : n_frames;
    for (std::size_t i = 0; i < ringdown.partials.partials.size(); ++i) {
      const Partial& partial = ringdown.partials.partials[i];
      const double amplitude =
          ringdown.strike_amplitudes.empty() ? partial.amplitude.value_or(0) : ringdown.strike_amplitudes[s][i];
      const double phase =
          ringdown.strike_phases_rad.empty() ? partial.phase_rad.value_or(0) : ringdown.strike_phases_rad[s][i];
      const Complex sigma(-partial.decay_per_s.value_or(0), kPi2 * partial.frequency_hz);
      const Complex step = std::exp(sigma / rate);
      constexpr Eigen::Index kBlock = 512;
      for (Eigen::Index block = begin; block < end; block += kBlock) {
        Complex z = amplitude * std::exp(Complex(0, phase) + sigma * (static_cast<double>(block) / rate - strike_s));
        for (Eigen::Index k = block; k < std::min(block + kBlock, end); ++k) {
          signal.samples(k, 0) += z.real();
          z *= step;
        }
      }
    }
  }
  return signal;
}

}  // namespace klang::fit
