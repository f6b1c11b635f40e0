#include "core/sound/instrument/instrument_files.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/config/fields_csv.hpp"
#include "core/sound/audio/note.hpp"
#include "core/sound/audio/sound_file.hpp"

namespace klang::instrument {
namespace {

constexpr int kKeys = 128, kA4 = 69;

/// Nothing that a comment or a name in another language would trip over.
std::string plain(std::string text) {
  for (char& c : text) {
    if (!std::isalnum(static_cast<unsigned char>(c)) && c != '-') c = '_';
  }
  return text.empty() ? "bank" : text;
}

struct Region {
  const ModalBank* bank = nullptr;
  int key = 0, transpose = 0, tune = 0, low = 0, high = 0;
};

/// Key and tuning of the pitch.
Region region_of(const ModalBank& bank, double a4_hz) {
  const double semitones = kA4 + 12.0 * std::log2(pitch_hz(bank) / a4_hz);
  const int nearest = static_cast<int>(std::lround(semitones));
  Region region;
  region.bank = &bank;
  region.key = std::clamp(nearest, 0, kKeys - 1);
  region.transpose = region.key - nearest;
  region.tune = -static_cast<int>(std::lround(100.0 * (semitones - nearest)));
  return region;
}

/// Each key belongs to the region with the nearest centre, and to one only; every region has a key.
std::vector<Region> regions_of(const std::vector<ModalBank>& banks, double a4_hz) {
  std::vector<Region> regions;
  for (const ModalBank& bank : banks) regions.push_back(region_of(bank, a4_hz));
  std::stable_sort(regions.begin(), regions.end(), [](const Region& a, const Region& b) { return a.key < b.key; });
  const int n = static_cast<int>(regions.size());
  for (int i = 0; i < n; ++i) {
    Region& region = regions[static_cast<std::size_t>(i)];
    region.low = i == 0 ? 0 : regions[static_cast<std::size_t>(i - 1)].high + 1;
    const int middle = i + 1 < n ? (region.key + regions[static_cast<std::size_t>(i + 1)].key) / 2 : kKeys - 1;
    region.high = std::clamp(middle, region.low, kKeys - n + i);
  }
  return regions;
}

}  // namespace

std::string faust_text(const ModalBank& bank) {
  std::string text = "// Modal bank of " + plain(bank.name) +
                     ": a unit impulse gives the sum of a exp(-d t) cos(2 pi f t + phase).\n"
                     "// Compile with -double where low partials ring for seconds.\n"
                     "declare name \"" +
                     plain(bank.name) +
                     "\";\n"
                     "rate = min(768000.0, max(1.0, fconstant(int fSamplingFreq, <math.h>)));\n"
                     "partial(f, d, a, phase) = _ : turn : tap with {\n"
                     "  theta = 6.283185307179586 * f / rate;\n"
                     "  radius = exp(0.0 - d / rate);\n"
                     "  c = radius * cos(theta);\n"
                     "  s = radius * sin(theta);\n"
                     "  step(re, im, x) = c * re - s * im + x, s * re + c * im;\n"
                     "  turn = step ~ (_, _);\n"
                     "  tap(re, im) = a * (cos(phase) * re - sin(phase) * im);\n"
                     "};\n"
                     "process = _ <:\n";
  for (std::size_t i = 0; i < bank.partials.size(); ++i) {
    const BankPartial& p = bank.partials[i];
    text += "  partial(" + to_text(p.frequency_hz) + ", " + to_text(p.decay_per_s) + ", " + to_text(p.amplitude) +
            ", " + to_text(p.phase_rad) + ")" + (i + 1 < bank.partials.size() ? ",\n" : "\n");
  }
  return text + "  :> _;\n";
}

std::string pure_data_text(const ModalBank& bank) {
  std::string text = "#N canvas 60 60 900 600 12;\n";
  int n_objects = 0;
  std::string wires;
  const auto object = [&](const std::string& what, int x, int y) {
    text += "#X " + what.substr(0, what.find(' ')) + " " + std::to_string(x) + " " + std::to_string(y) + " " +
            what.substr(what.find(' ') + 1) + ";\n";
    return n_objects++;
  };
  const auto wire = [&](int from, int outlet, int to, int inlet) {
    wires += "#X connect " + std::to_string(from) + " " + std::to_string(outlet) + " " + std::to_string(to) + " " +
             std::to_string(inlet) + ";\n";
  };
  object("text Modal bank of " + plain(bank.name) + ": each bang is a strike", 20, 10);
  const int strike = object("obj bng 25 250 50 0 empty empty empty 17 7 0 10 -1 -1 -1", 20, 40);
  const int load = object("obj loadbang", 200, 40);
  const int rate = object("obj samplerate~", 200, 70);
  const int out = object("obj dac~", 20, 560);
  wire(load, 0, rate, 0);
  for (std::size_t i = 0; i < bank.partials.size(); ++i) {
    const BankPartial& p = bank.partials[i];
    const int x = 20 + 60 * static_cast<int>(i), y = 140;
    const std::string radius = "exp(-" + to_text(p.decay_per_s) + " / \\$f1)";
    const std::string angle = "(" + to_text(2.0 * kPi * p.frequency_hz) + " / \\$f1)";
    const int c = object("obj expr " + radius + " * cos(" + angle + ")", x, y);
    const int s = object("obj expr " + radius + " * sin(" + angle + ")", x, y + 40);
    const int start = object(
        "msg set " + to_text(p.amplitude * std::cos(p.phase_rad)) + " " + to_text(p.amplitude * std::sin(p.phase_rad)),
        x, y + 80);
    const int pole = object("obj cpole~", x, y + 120);
    wire(rate, 0, c, 0);
    wire(rate, 0, s, 0);
    wire(strike, 0, start, 0);
    wire(start, 0, pole, 0);
    wire(c, 0, pole, 2);
    wire(s, 0, pole, 3);
    for (const int channel : {0, 1}) wire(pole, 0, out, channel);
  }
  return text + wires;
}

std::string scala_text(const std::vector<ModalBank>& banks, const std::string& name) {
  constexpr double kSame = 1e-3;
  std::vector<double> frequencies;
  if (banks.size() > 1) {
    for (const ModalBank& bank : banks) frequencies.push_back(pitch_hz(bank));
  } else {
    for (const BankPartial& partial : banks.front().partials) {
      if (!partial.is_weak) frequencies.push_back(partial.frequency_hz);
    }
    if (frequencies.empty()) frequencies.push_back(pitch_hz(banks.front()));
  }
  std::sort(frequencies.begin(), frequencies.end());
  std::vector<double> degrees;
  for (const double frequency : frequencies) {
    const double above = cents(frequency, frequencies.front());
    if (above - (degrees.empty() ? 0.0 : degrees.back()) > kSame) degrees.push_back(above);
  }
  if (degrees.empty()) degrees.push_back(1200.0);
  std::string text = "! " + plain(name) + ".scl\n!\n" + plain(name) + ", over " + to_text(frequencies.front()) +
                     " Hz\n " + std::to_string(degrees.size()) + "\n!\n";
  for (const double degree : degrees) {
    char line[40];
    std::snprintf(line, sizeof line, " %.6f\n", degree);  // the point makes it cents
    text += line;
  }
  return text;
}

std::string bank_csv(const std::vector<ModalBank>& banks) {
  std::string text = "specimen,frequency_hz,decay_per_s,amplitude,phase_rad\n";
  for (const ModalBank& bank : banks) {
    for (const BankPartial& p : bank.partials)
      text += csv_cell(bank.name) + "," + csv_cell(p.frequency_hz) + "," + csv_cell(p.decay_per_s) + "," +
              csv_cell(p.amplitude) + "," + csv_cell(p.phase_rad) + "\n";
  }
  return text;
}

std::vector<std::string> write_sfz(const OutputDirectory& folder, const std::vector<ModalBank>& banks,
                                   const std::string& name, double a4_hz, double sample_rate_hz) {
  if (banks.size() > kKeys)
    throw InputError(name, "has more things than there are keys", std::to_string(banks.size()), "up to 128");
  std::string text = "// " + plain(name) + ", by Klangprobe\n";
  std::vector<std::string> cut_off;
  std::map<const ModalBank*, double> peaks;
  double loudest = 0.0;
  for (const ModalBank& bank : banks) {
    const auto n = static_cast<Eigen::Index>(std::ceil(kPeakWithinS * sample_rate_hz));
    const double peak = peaks[&bank] = bank_sound(bank, sample_rate_hz, n).cwiseAbs().maxCoeff();
    if (!(peak > 0.0)) throw InputError(bank.name, "is silent: no partial rings below half the sample rate");
    loudest = std::max(loudest, peak);
  }
  int number = 0;
  for (const Region& region : regions_of(banks, a4_hz)) {
    // The partials' envelopes add up to more than the sound's own peak, whose phases differ.
    const double end = peaks[region.bank] * std::pow(10.0, kSampleEndDb / 20.0);
    double length_s = time_to_amplitude_s(*region.bank, end, sample_rate_hz);
    if (!(length_s <= kLongestSampleS)) {
      length_s = kLongestSampleS;
      cut_off.push_back(region.bank->name + " rings longer than " + to_text(kLongestSampleS) +
                        " s, where its sample ends before it is " + to_text(-kSampleEndDb) + " dB down");
    }
    audio::Signal sound;
    sound.sample_rate_hz = sample_rate_hz;
    sound.samples =
        kPeak / loudest *
        bank_sound(*region.bank, sample_rate_hz, static_cast<Eigen::Index>(std::ceil(length_s * sample_rate_hz)) + 1);
    const std::string file = std::to_string(++number) + "-" + plain(region.bank->name) + ".wav";
    audio::write_sound(folder.staging() / file, sound);
    text += "\n<region>\nsample=" + file + "\nlokey=" + std::to_string(region.low) +
            "\nhikey=" + std::to_string(region.high) + "\npitch_keycenter=" + std::to_string(region.key) +
            "\ntranspose=" + std::to_string(region.transpose) + "\ntune=" + std::to_string(region.tune) +
            "\nloop_mode=one_shot\n";
  }
  write_file(folder.staging() / (plain(name) + ".sfz"), text);
  return cut_off;
}

}  // namespace klang::instrument
