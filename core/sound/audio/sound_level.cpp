#include "core/sound/audio/sound_level.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numbers>

#include "core/foundation/base/errors.hpp"
#include "core/sound/audio/fft.hpp"

namespace klang::audio {
namespace {

constexpr double kQuietestPeakPa = kReferencePressurePa * std::numbers::sqrt2;
constexpr double kLowestWeightedHz = 10.0;
// A band of 20 Hz is 4.6 Hz wide: bins this wide leave no band of the audible range without a bin of its own.
constexpr double kWidestBinHz = 0.25;

double third_octave_power(double thirds) { return 1000.0 * std::pow(10.0, 0.1 * thirds); }

double a_weight_gain(double frequency_hz) {
  constexpr double f1 = 20.598997, f2 = 107.65265, f3 = 737.86223, f4 = 12194.217;
  const double f_sq = frequency_hz * frequency_hz;
  return f4 * f4 * f_sq * f_sq / ((f_sq + f1 * f1) * std::sqrt((f_sq + f2 * f2) * (f_sq + f3 * f3)) * (f_sq + f4 * f4));
}

}  // namespace

double a_weighting_db(double frequency_hz) {
  return 20.0 * std::log10(a_weight_gain(frequency_hz) / a_weight_gain(1000.0));
}

double ThirdOctave::centre_hz() const { return third_octave_power(index); }
double ThirdOctave::low_hz() const { return third_octave_power(index - 0.5); }
double ThirdOctave::high_hz() const { return third_octave_power(index + 0.5); }

std::vector<ThirdOctave> third_octaves(const Band& band) {
  checked_open("third octaves", "low_hz", band.low_hz, 0.0, 1e9);
  checked_open("third octaves", "high_hz", band.high_hz, band.low_hz, 1e9);
  constexpr double kRounding = 1e-9;  // an edge that was computed counts as its own band's
  std::vector<ThirdOctave> bands;
  ThirdOctave band_x{static_cast<int>(std::floor(10.0 * std::log10(band.low_hz / 1000.0))) - 1};
  for (; band_x.high_hz() <= band.high_hz * (1.0 + kRounding); ++band_x.index) {
    if (band_x.low_hz() >= band.low_hz * (1.0 - kRounding)) bands.push_back(band_x);
  }
  return bands;
}

EnergySpectrum::EnergySpectrum(const Signal& signal) {
  checked_open("energy spectrum", "sample_rate_hz", signal.sample_rate_hz, 0.0, 1e9);
  if (signal.n_frames() == 0 || signal.n_channels() == 0)
    throw InputError("energy spectrum", "the signal has no samples");
  if (!signal.samples.allFinite()) throw InputError("energy spectrum", "a sample is not finite");
  const double rate = signal.sample_rate_hz;
  const auto wanted = static_cast<Eigen::Index>(std::ceil(std::min(rate / kWidestBinHz, 1e8)));
  const Eigen::Index n_fft =
      good_fft_size(std::max(signal.n_frames(), wanted) / 2 + 1) * 2;  // even: half the rate is a bin
  energy_ = Eigen::VectorXd::Zero(n_fft / 2 + 1);
  for (Eigen::Index channel = 0; channel < signal.n_channels(); ++channel) {
    energy_ += real_spectrum(signal.samples.col(channel), n_fft).cwiseAbs2();
  }
  energy_.segment(1, n_fft / 2 - 1) *= 2.0;  // a bin and its mirror image
  energy_ /= static_cast<double>(n_fft) * rate * static_cast<double>(signal.n_channels());
  bin_hz_ = rate / static_cast<double>(n_fft);
  duration_s_ = signal.duration_s();
}

Eigen::Index EnergySpectrum::first_bin(double frequency_hz) const {
  const double bin = std::ceil(frequency_hz / bin_hz_ - 1e-9);
  return static_cast<Eigen::Index>(std::clamp(bin, 0.0, static_cast<double>(energy_.size())));
}

double EnergySpectrum::within(double low_hz, double high_hz) const {
  const Eigen::Index first = first_bin(low_hz), end = first_bin(high_hz);
  return end > first ? energy_.segment(first, end - first).sum() : 0.0;
}

double EnergySpectrum::a_weighted(double low_hz, double high_hz) const {
  const double at_1000 = a_weight_gain(1000.0);
  double sum = 0.0;
  for (Eigen::Index k = first_bin(low_hz); k < first_bin(high_hz); ++k) {
    const double gain = a_weight_gain(static_cast<double>(k) * bin_hz_) / at_1000;
    sum += gain * gain * energy_[k];
  }
  return sum;
}

double EnergySpectrum::total() const { return energy_.sum(); }

double level_db(double energy, double duration_s) {
  return energy > 0.0 ? 10.0 * std::log10(2.0 * energy / duration_s) : -std::numeric_limits<double>::infinity();
}

std::vector<double> third_octave_levels_db(const Signal& signal, const std::vector<ThirdOctave>& bands) {
  const EnergySpectrum spectrum(signal);
  std::vector<double> levels;
  for (const ThirdOctave& band : bands) levels.push_back(level_db(spectrum.within(band), spectrum.duration_s()));
  return levels;
}

double a_weighted_level_db(const Signal& signal) {
  const EnergySpectrum spectrum(signal);
  return level_db(spectrum.a_weighted(kLowestWeightedHz, spectrum.highest_hz() * (1.0 + 1e-12)), spectrum.duration_s());
}

double file_gain(double peak_pressure_pa, double level_db_re_full_scale) {
  return std::pow(10.0, level_db_re_full_scale / 20.0) / std::max(peak_pressure_pa, kQuietestPeakPa);
}

bool is_inaudible(double peak_pressure_pa) { return peak_pressure_pa > 0.0 && peak_pressure_pa < kQuietestPeakPa; }

std::string inaudible_note(double peak_pressure_pa) {
  char text[120];
  std::snprintf(text, sizeof text,
                "what is heard is below 0 dB re 20 uPa (peak %.3g Pa), which nobody hears: the file is left as quiet",
                peak_pressure_pa);
  return text;
}

}  // namespace klang::audio
