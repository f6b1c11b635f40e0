#include "fit/ringdown/ringdown.hpp"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/stopwatch.hpp"
#include "core/foundation/config/fields.hpp"
#include "core/sound/audio/fft.hpp"
#include "core/sound/audio/sound_file.hpp"
#include "core/sound/audio/stretch.hpp"
#include "core/sound/audio/strikes.hpp"
#include "fit/ringdown/detail/missed_blows.hpp"
#include "fit/ringdown/detail/partial_judge.hpp"
#include "fit/ringdown/detail/tail_noise.hpp"

namespace klang::fit {
namespace {

using detail::FittedPartial;
using detail::JudgedPartials;
using detail::RingData;
using detail::Segment;
using Complex = std::complex<double>;

constexpr double kWeakestStrike = 0.01;  ///< energy a strike must add, against the strongest one
constexpr double kWeakPart = 1e-3;  ///< of the loudest amplitude at the strike (-60 dB): below it a partial is weak
constexpr double kHopeless = 0.25 * kLeastExplained;  ///< best_explained()
constexpr double kBeyondBand = 0.03;                  ///< of its ends: so far the search looks beyond the band
constexpr double kLeastOnLines =
    0.3;  ///< of the energy: from there on lines that are no exponentials are a ring all the same
constexpr Eigen::Index kFewestFrames = 16;
constexpr double kSilence = 1e-30;  ///< of full scale; the square of less may be no number
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

/// Energy in band of the first frames of all segments and what the rings leave of it.
struct Explained {
  double energy = 0.0, rest = 0.0, n_samples = 0.0;
  double share() const { return energy > 0 ? std::clamp(1 - rest / energy, 0.0, 1.0) : 0.0; }
};

Explained explained_by(const RingData& data, const std::vector<detail::RingPartial>& rings, const Band& band,
                       double longest_s) {
  Explained sum;
  for (std::size_t s = 0; s < data.segments().size(); ++s) {
    const Segment& segment = data.segments()[s];
    const auto n = static_cast<Eigen::Index>(
        std::min(static_cast<double>(segment.end - segment.begin), longest_s * data.sample_rate_hz() + 1));
    for (std::size_t c = 0; c < data.channels().size(); ++c) {
      const Eigen::VectorXd left = data.residual(static_cast<Eigen::Index>(s), static_cast<Eigen::Index>(c), n, rings);
      sum.energy += band_energy(data.channels()[c].segment(segment.begin, n), data.sample_rate_hz(), band);
      sum.rest += band_energy(left, data.sample_rate_hz(), band);
      sum.n_samples += static_cast<double>(n);
    }
  }
  return sum;
}

std::vector<detail::RingPartial> rings_of(const JudgedPartials& found) {
  std::vector<detail::RingPartial> rings;
  for (const FittedPartial& partial : found.partials) rings.push_back(partial.ring);
  for (const FittedPartial& partial : found.too_short) rings.push_back(partial.ring);
  return rings;
}

/// The share that the partials explain where they explain most: of the first 30, 100, 300 ms after the strikes and of all
/// (a ring that dies in noise explains little of a long recording, and what is hardly begun little of the first).
double best_explained(const RingData& data, const std::vector<detail::RingPartial>& rings, const Band& band) {
  double best = 0;
  for (const double longest_s : {0.03, 0.1, 0.3, 1e9})
    best = std::max(best, explained_by(data, rings, band, longest_s).share());
  return best;
}

/// The share of the energy in band that lies on the partials' lines, within their widths and 3 cells, where it is far more than as
/// many cells of noise hold: a ring whose lines waver or beat is no sum of exponentials, but its lines stand (0 else).
double share_on_lines(const RingData& data, const std::vector<detail::RingPartial>& rings, const Band& band) {
  constexpr double kFarMore = 10.0, kWidestLineHz = 20.0;
  const Segment& segment = data.segments()[static_cast<std::size_t>(data.longest_segment())];
  const Eigen::Index n = audio::good_fft_size_below(segment.end - segment.begin);
  const Eigen::VectorXd x = data.channels().front().segment(segment.begin, n).cwiseProduct(detail::blackman_harris(n));
  const Eigen::VectorXd power = audio::real_spectrum(x, n).cwiseAbs2();
  const double cell_hz = data.sample_rate_hz() / static_cast<double>(n);
  std::vector<char> on_line(static_cast<std::size_t>(power.size()), 0);
  for (const detail::RingPartial& ring : rings) {
    const double width_hz = std::max(3 * cell_hz, ring.pole.decay_per_s / kPi);
    if (width_hz > kWidestLineHz) continue;
    const auto from = static_cast<Eigen::Index>(std::max(0.0, (ring.pole.frequency_hz - width_hz) / cell_hz));
    const auto to = static_cast<Eigen::Index>((ring.pole.frequency_hz + width_hz) / cell_hz) + 1;
    for (Eigen::Index k = from; k <= std::min(to, power.size() - 1); ++k) on_line[static_cast<std::size_t>(k)] = 1;
  }
  double all = 0, lines = 0, n_all = 0, n_lines = 0;
  for (Eigen::Index k = 0; k < power.size(); ++k) {
    const double f = static_cast<double>(k) * cell_hz;
    if (f < band.low_hz || f > band.high_hz) continue;
    all += power[k];
    ++n_all;
    if (on_line[static_cast<std::size_t>(k)] == 0) continue;
    lines += power[k];
    ++n_lines;
  }
  return lines * n_all > kFarMore * n_lines * all ? lines / all : 0.0;
}

/// Whether several strikes sound so unlike that one body struck alike does not explain them: the least likeness (cosine of the
/// partials' amplitudes) of two of at least three.
bool strikes_unlike(const RingdownResult& result) {
  constexpr double kUnlike = 0.6;
  const auto& rows = result.strike_amplitudes;
  if (rows.size() < 3) return false;
  double least = 1;
  for (std::size_t a = 0; a < rows.size(); ++a) {
    for (std::size_t b = 0; b < a; ++b) {
      double both = 0, first = 0, second = 0;
      for (std::size_t i = 0; i < rows[a].size(); ++i) {
        both += rows[a][i] * rows[b][i];
        first += rows[a][i] * rows[a][i];
        second += rows[b][i] * rows[b][i];
      }
      if (first > 0 && second > 0) least = std::min(least, both / std::sqrt(first * second));
    }
  }
  return least < kUnlike;
}

/// Without what lies outside the band, which the search sees beyond: a line at the band's edge rings in both.
void keep_band(JudgedPartials& found, const Band& band) {
  const auto outside = [&](const FittedPartial& partial) {
    return partial.ring.pole.frequency_hz < band.low_hz || partial.ring.pole.frequency_hz > band.high_hz;
  };
  std::erase_if(found.partials, outside);
  std::erase_if(found.too_short, outside);
  std::erase_if(found.steady, outside);
}

std::string percent(double share) { return klang::to_text(std::round(1000 * share) / 10) + " %"; }

void measure_fit(RingdownResult& result, const RingData& data, const std::vector<detail::RingPartial>& rings,
                 const Band& band) {
  const Explained whole = explained_by(data, rings, band, 1e9);
  if (whole.energy > 0) result.explained_energy = whole.share();
  if (whole.n_samples > 0) result.noise_rms = std::sqrt(whole.rest / whole.n_samples);
}

/// One line of the table, as it is at a strike in the channel that is loudest for it over all strikes.
Partial table_row(const RingData& data, const FittedPartial& partial, Eigen::Index strike, Eigen::Index channel) {
  Partial out;
  out.frequency_hz = partial.ring.pole.frequency_hz;
  out.frequency_std_hz = std::hypot(std::sqrt(partial.pole_covariance(0, 0)), partial.drift_hz);
  const detail::StruckAmplitude struck = detail::at_strike(data, partial, strike, channel);
  out.amplitude = struck.amplitude;
  out.amplitude_std = struck.amplitude_std;
  out.phase_rad = struck.phase_rad;
  out.phase_std_rad = struck.phase_std_rad;
  return out;
}

Eigen::Index loudest_channel(const FittedPartial& partial) {
  Eigen::Index channel = 0;
  partial.ring.amplitude.cwiseAbs().colwise().sum().maxCoeff(&channel);
  return channel;
}

/// At the strike that excites it most.
double loudness(const FittedPartial& partial) { return partial.ring.amplitude.rowwise().norm().maxCoeff(); }

double size_at(const RingData& data, const FittedPartial& partial, Eigen::Index strike, Eigen::Index channel) {
  return std::abs(advanced(partial, partial.ring.amplitude(strike, channel),
                           -data.segments()[static_cast<std::size_t>(strike)].delay_s));
}

/// The first of the strikes that ring with at least half the energy of the one that rings with most.
Eigen::Index reference_strike(const RingData& data, const std::vector<FittedPartial>& partials) {
  Eigen::VectorXd energy = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(data.segments().size()));
  for (const FittedPartial& partial : partials) {
    const Eigen::Index channel = loudest_channel(partial);
    for (Eigen::Index s = 0; s < energy.size(); ++s)
      energy[s] += std::pow(size_at(data, partial, s, channel), 2) / std::max(partial.ring.pole.decay_per_s, 1e-3);
  }
  Eigen::Index s = 0;
  while (s + 1 < energy.size() && !(energy[s] >= 0.5 * energy.maxCoeff())) ++s;
  return s;
}

/// That strike for each partial, or, where it leaves the partial 30 dB below what another makes of it, the one that excites it most.
Eigen::Index told_strike(const RingData& data, const FittedPartial& partial, Eigen::Index reference,
                         Eigen::Index channel) {
  constexpr double kNotStruck = 0.0316;
  Eigen::VectorXd size(partial.ring.amplitude.rows());
  for (Eigen::Index s = 0; s < size.size(); ++s) size[s] = size_at(data, partial, s, channel);
  Eigen::Index loudest = 0;
  size.maxCoeff(&loudest);
  return size[reference] >= kNotStruck * size[loudest] ? reference : loudest;
}

void fill_table(RingdownResult& result, const RingData& data, const JudgedPartials& found,
                const RingdownOptions& options) {
  struct Listed {
    const FittedPartial* partial;
    PartialKind kind;
  };
  std::vector<Listed> listed;
  for (const FittedPartial& partial : found.partials) listed.push_back({&partial, PartialKind::kDecaying});
  for (const FittedPartial& partial : found.too_short) listed.push_back({&partial, PartialKind::kTooShort});
  if (listed.size() > static_cast<std::size_t>(options.max_partials)) {
    std::stable_sort(listed.begin(), listed.end(),
                     [](const Listed& a, const Listed& b) { return loudness(*a.partial) > loudness(*b.partial); });
    result.warnings.push_back("the strongest " + std::to_string(options.max_partials) + " of " +
                              std::to_string(listed.size()) +
                              " partials kept (by amplitude at the strike that excites each most)");
    listed.resize(static_cast<std::size_t>(options.max_partials));
  }
  std::stable_sort(listed.begin(), listed.end(), [](const Listed& a, const Listed& b) {
    return a.partial->ring.pole.frequency_hz < b.partial->ring.pole.frequency_hz;
  });
  const auto n_segments = static_cast<Eigen::Index>(data.segments().size());
  if (n_segments > 1) {
    result.strike_amplitudes.resize(static_cast<std::size_t>(n_segments));
    result.strike_phases_rad.resize(static_cast<std::size_t>(n_segments));
  }
  const Eigen::Index reference = reference_strike(data, found.partials);
  if (n_segments > 1) result.amplitude_strike = static_cast<int>(reference);
  int n_elsewhere = 0;
  double loudest = 0;
  std::vector<double> largest;  // of each, at the strike that excites it most
  for (const auto& [partial, kind] : listed) {
    const Eigen::Index channel = loudest_channel(*partial);
    const Eigen::Index strike = told_strike(data, *partial, reference, channel);
    if (strike != reference && kind == PartialKind::kDecaying) ++n_elsewhere;
    Partial out = table_row(data, *partial, strike, channel);
    out.kind = kind;
    if (kind == PartialKind::kDecaying) {
      out.decay_per_s = partial->ring.pole.decay_per_s;
      out.decay_std_per_s = std::sqrt(partial->pole_covariance(1, 1));
    }
    largest.push_back(*out.amplitude);
    for (Eigen::Index s = 0; n_segments > 1 && s < n_segments; ++s) {
      const double delay = data.segments()[static_cast<std::size_t>(s)].delay_s;
      const Complex struck = advanced(*partial, partial->ring.amplitude(s, channel), -delay);
      result.strike_amplitudes[static_cast<std::size_t>(s)].push_back(std::abs(struck));
      largest.back() = std::max(largest.back(), std::abs(struck));
      result.strike_phases_rad[static_cast<std::size_t>(s)].push_back(std::arg(struck));
    }
    loudest = std::max(loudest, largest.back());
    result.partials.partials.push_back(out);
  }
  if (n_elsewhere > 0)
    result.warnings.push_back(std::to_string(n_elsewhere) + " of " + std::to_string(listed.size()) +
                              " partials are not struck at strike " + std::to_string(reference + 1) +
                              ", whose amplitudes are told: theirs are of the strike that excites each most");
  for (std::size_t i = 0; i < largest.size(); ++i) {
    Partial& partial = result.partials.partials[i];
    if (partial.kind == PartialKind::kDecaying && largest[i] < kWeakPart * loudest) partial.kind = PartialKind::kWeak;
  }
}

bool is_mains(double frequency_hz) {
  const double away =
      std::min(std::abs(std::remainder(frequency_hz, 50.0)), std::abs(std::remainder(frequency_hz, 60.0)));
  return away < 0.5 && frequency_hz < 2000;
}

/// One sentence for all tones of a sort, the loudest named.
void warn_of_tones(RingdownResult& result, const std::string& one, const std::string& several, bool mains) {
  constexpr std::size_t kNamed = 6;
  std::vector<const Partial*> tones;
  for (const Partial& tone : result.steady_tones) {
    if (is_mains(tone.frequency_hz) == mains) tones.push_back(&tone);
  }
  if (tones.empty()) return;
  const std::size_t n = tones.size();
  std::stable_sort(tones.begin(), tones.end(),
                   [](const Partial* a, const Partial* b) { return *a->amplitude > *b->amplitude; });
  tones.resize(std::min(n, kNamed));
  std::string names;
  for (const Partial* tone : tones) names += (names.empty() ? "" : ", ") + short_hz(tone->frequency_hz);
  if (n > kNamed) names += " and " + std::to_string(n - kNamed) + " more";
  result.warnings.push_back((n == 1 ? one : several) + " at " + names + " ignored");
}

constexpr double kRepeated = 1.2;  ///< TailNoise::repeats above which it is said

void warn_about(RingdownResult& result, const RingData& data, const JudgedPartials& found) {
  for (const std::string& warning : data.warnings()) result.warnings.push_back(warning);
  if (data.n_clipped() > 0) {
    result.warnings.push_back("clipped: " + std::to_string(data.n_clipped()) + " samples left out");
  }
  if (found.repeats > kRepeated) {
    result.warnings.push_back(
        "the noise of several strikes is the same: one take pasted again, whose copies add nothing (the "
        "deviations are those of one)");
  }
  if (data.n_cut_off() > 0) {
    const auto n = data.segments().size();
    result.warnings.push_back((n == 1 ? std::string("the ring ends")
                                      : std::to_string(data.n_cut_off()) + " of " + std::to_string(n) + " rings end") +
                              " suddenly (a hand, a gate or a fade): what follows is left out");
  }
  for (const FittedPartial& tone : found.steady) {
    Partial row = table_row(data, tone, 0, loudest_channel(tone));
    row.kind = PartialKind::kSteady;
    result.steady_tones.push_back(row);
  }
  std::stable_sort(result.steady_tones.begin(), result.steady_tones.end(),
                   [](const Partial& a, const Partial& b) { return a.frequency_hz < b.frequency_hz; });
  warn_of_tones(result, "mains hum", "mains hum", true);
  warn_of_tones(result, "steady tone", "steady tones", false);
  if (data.coded_s() > 0) result.n_coder_images = found.n_images;
  if (found.n_images > 0) {
    result.warnings.push_back(std::to_string(found.n_images) + (found.n_images == 1 ? " image" : " images") +
                              " that the coder made of louder lines left out");
  }
  if (!found.too_short.empty()) {
    result.warnings.push_back(std::to_string(found.too_short.size()) +
                              (found.too_short.size() == 1 ? " partial" : " partials") +
                              " without a decay: the recording is too short to tell whether they fall");
  }
}

/// Refuses, or warns at the top, where the partials say little of what is heard.
void judge_explained(RingdownResult& result, const RingData& data, const std::vector<detail::RingPartial>& rings,
                     const Band& band, const RingdownOptions& options) {
  if (strikes_unlike(result)) {
    result.warnings.insert(result.warnings.begin(),
                           "the strikes sound unlike one another: blows at different places, or several bodies, whose "
                           "sound the partials of one do not explain");
  }
  const double share = result.explained_energy.value_or(0);
  if (share >= kMostlyExplained) return;
  const double best = best_explained(data, rings, band);
  const std::string told = "the partials explain " + percent(share) + " of the energy in band";
  const bool on_lines = best < kLeastExplained && share_on_lines(data, rings, band) >= kLeastOnLines;
  if (best < kLeastExplained && !on_lines && !options.accept_unexplained) {
    result.status = RingdownStatus::kUnexplained;
    result.message = told + ", nowhere after a strike " + percent(kLeastExplained) + ": this is no ring of one body";
    return;
  }
  result.warnings.insert(result.warnings.begin(),
                         best < kLeastExplained
                             ? told + ": most of what is heard is not theirs, and they may not be real"
                             : told + "; the rest is noise, other sounds, or no free ringing");
}

RingdownResult identify_sounding(const audio::Signal& recording, const RingdownOptions& options, Monitor& monitor) {
  options.validate();
  const std::string place = recording.origin.empty() ? "recording" : recording.origin;
  checked_open(place, "sample_rate_hz", recording.sample_rate_hz, 0, 1e9);
  checked(place, "number of samples", static_cast<double>(recording.n_frames()), kFewestFrames, 1e12);
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
  const Band searched{(1 - kBeyondBand) * band.low_hz,
                      std::min((1 + kBeyondBand) * band.high_hz, 0.48 * recording.sample_rate_hz)};
  std::vector<audio::Strike> strikes = audio::detect_strikes(recording, strike_options);
  if (strikes.empty()) strikes.push_back({});
  result.wall_time_s["strikes"] = total.seconds();

  const Stopwatch search_watch;
  std::optional<RingData> data;
  JudgedPartials found;
  for (int attempt = 0; attempt < 3; ++attempt) {
    data.emplace(recording, strikes, searched);
    if (data->segments().empty()) break;
    found = detail::find_partials(*data, {options.min_snr_db, options.max_partials}, monitor);
    // Strikes that add next to nothing to the partials were bumps or beats: without them the windows are
    // longer.
    std::vector<FittedPartial> ringing = found.partials;
    ringing.insert(ringing.end(), found.too_short.begin(), found.too_short.end());
    const std::vector<double> energy = added_energy(*data, ringing);
    const double most = energy.empty() ? 0.0 : *std::max_element(energy.begin(), energy.end());
    std::vector<audio::Strike> kept;
    for (const audio::Strike& strike : strikes) {
      bool weak = false;
      for (std::size_t s = 0; s < energy.size(); ++s) {
        if (data->segments()[s].strike_s == strike.time_s) weak = !(energy[s] >= kWeakestStrike * most);
      }
      if (!weak || ringing.empty()) kept.push_back(strike);
    }
    if (kept.size() == strikes.size() || kept.empty()) break;
    // Other windows do not make a ring of what explains next to nothing of the loudest moments: music is refused sooner.
    const std::vector<detail::RingPartial> so_far = rings_of(found);
    if (!options.accept_unexplained && best_explained(*data, so_far, band) < kHopeless &&
        share_on_lines(*data, so_far, band) < kLeastOnLines)
      break;
    strikes = std::move(kept);
  }
  result.wall_time_s["partials"] = search_watch.seconds();
  if (data->segments().empty()) {
    result.message = data->n_clipped() > 0 ? "nothing is left after the clipped samples"
                                           : "the recording is too short after its strike";
    result.warnings = data->warnings();
    return result;
  }
  const std::vector<detail::RingPartial> rings = rings_of(found);
  keep_band(found, band);
  warn_about(result, *data, found);
  if (found.empty()) {
    result.message = found.steady.empty() ? "no decaying partial stands above the noise"
                                          : "only steady tones stand above the noise, nothing that decays";
    measure_fit(result, *data, rings, band);
    return result;
  }
  result.status = RingdownStatus::kOk;
  for (const Segment& segment : data->segments()) result.strikes_s.push_back(segment.strike_s);
  fill_table(result, *data, found, options);
  measure_fit(result, *data, rings, band);
  if (const std::size_t n_missed = detail::missed_blows(*data, rings).size(); n_missed > 0) {
    result.warnings.insert(
        result.warnings.begin(),
        "what the partials leave begins anew " + std::to_string(n_missed) + (n_missed == 1 ? " time" : " times") +
            ": blows that were not found (a body that bounces?), which bend the decays by more than their deviations");
  }
  judge_explained(result, *data, rings, band, options);
  result.wall_time_s["total"] = total.seconds();
  return result;
}

}  // namespace

void RingdownOptions::validate() const {
  std::vector<Violation> violations = violations_of(*this);
  if (!(band.high_hz > band.low_hz))
    violations.push_back(out_of_range("band.high_hz", band.high_hz, inside(band.low_hz, 1e9)));
  throw_violations("ringdown", std::move(violations));
}

RingdownResult identify_ringdown(const audio::Signal& recording, const RingdownOptions& options, Monitor& monitor) {
  // Digital silence at the ends says nothing of the body, but would move every frame, the mean and the end of the windows.
  const audio::Stretch sound = audio::sounding_stretch(recording);
  if (sound.size() == recording.n_frames() || sound.size() < kFewestFrames)
    return identify_sounding(recording, options, monitor);
  audio::Signal part = recording;
  part.samples = recording.samples.middleRows(sound.begin, sound.size());
  RingdownResult result = identify_sounding(part, options, monitor);
  for (double& strike_s : result.strikes_s) strike_s += static_cast<double>(sound.begin) / recording.sample_rate_hz;
  return result;
}

}  // namespace klang::fit
