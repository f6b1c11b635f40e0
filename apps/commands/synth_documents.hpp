#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/foundation/config/result_header.hpp"

/// Results of `klang synth` and `klang bubble synth`.
namespace klang::apps {

struct EarRecord {
  std::string file, device;
  bool delay = false, unit_transfer = false;
  int n_ears = 1;
  bool listener_moves = false;
  std::array<double, 3> listener_at_start_m{};
  int n_modes_heard = 0, n_modes_without_transfer = 0, n_modes_too_high = 0;
  std::optional<double> peak_pressure_pa;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"file", "the transfer model"}, self.file);
    visit({"device", "that computed the sound; empty: the processor without OpenCL"}, self.device);
    visit({"delay", "whether sound takes its time to the ear"}, self.delay);
    visit({"unit_transfer", "whether every mode was given the same transfer"}, self.unit_transfer);
    visit({"n_ears", "1 or 2"}, self.n_ears);
    visit({"listener_moves", "whether the listener was given a path"}, self.listener_moves);
    visit({"listener_at_start_m", "middle of the head"}, self.listener_at_start_m);
    visit({"n_modes_heard", "modes in the sound"}, self.n_modes_heard);
    visit({"n_modes_without_transfer", "silent for want of a transfer"}, self.n_modes_without_transfer);
    visit({"n_modes_too_high", "silent: half of the sample rate and above"}, self.n_modes_too_high);
    visit(absent_if_empty({"peak_pressure_pa", "largest at the ears, before the gain"}), self.peak_pressure_pa);
  }
};

struct StruckModeRecord {
  int index = 0;
  double frequency_hz = 0.0, decay_per_s = 0.0;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"index", "of the mode in the model"}, self.index);
    visit({"frequency_hz", "undamped"}, self.frequency_hz);
    visit({"decay_per_s", "of the amplitude"}, self.decay_per_s);
  }
};

struct SynthDocument {
  ResultHeader header;
  double gain = 0.0;
  std::optional<EarRecord> transfer;
  std::vector<StruckModeRecord> modes;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    ResultHeader::describe(self.header, visit);
    visit({"gain",
           "samples of the file over what was computed: displacement weighted by the area that moves, with --transfer "
           "Pa"},
          self.gain);
    visit(absent_if_empty({"transfer", "with --transfer: how it is heard"}), self.transfer);
    visit(absent_if_empty({"modes", "of the model; an analysis has none"}), self.modes);
  }
};

struct HeardBubbleRecord {
  double radius_m = 0.0, birth_s = 0.0, frequency_start_hz = 0.0, frequency_end_hz = 0.0, decay_per_s = 0.0,
         amplitude_m = 0.0;
  std::optional<double> peak_pressure_pa, peak_displacement_m;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"radius_m", "at birth"}, self.radius_m);
    visit({"birth_s", "in the scene"}, self.birth_s);
    visit({"frequency_start_hz", "at birth"}, self.frequency_start_hz);
    visit({"frequency_end_hz", "at its end"}, self.frequency_end_hz);
    visit({"decay_per_s", "of the amplitude, at birth"}, self.decay_per_s);
    visit({"amplitude_m", "of the wall at birth"}, self.amplitude_m);
    visit(absent_if_empty({"peak_pressure_pa", "at the ears; none with a unit transfer"}), self.peak_pressure_pa);
    visit(absent_if_empty({"peak_displacement_m", "of the wall; with a unit transfer"}), self.peak_displacement_m);
  }
};

struct BubbleSynthDocument {
  ResultHeader header;
  std::int64_t n_bubbles = 0, n_bubbles_listed = 0;
  int n_too_high = 0, n_channels = 0;
  double duration_s = 0.0, sample_rate_hz = 0.0, gain = 0.0;
  std::optional<double> peak_pressure_pa, peak_displacement_m, peak_level_db_re_20upa;
  std::vector<HeardBubbleRecord> bubbles;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    ResultHeader::describe(self.header, visit);
    visit({"n_bubbles", "of the scene"}, self.n_bubbles);
    visit({"n_bubbles_listed", "of these in bubbles"}, self.n_bubbles_listed);
    visit({"n_too_high", "left out: half of the sample rate and above"}, self.n_too_high);
    visit({"n_channels", "of the file"}, self.n_channels);
    visit({"duration_s", "of the file"}, self.duration_s);
    visit({"sample_rate_hz", "of the file"}, self.sample_rate_hz);
    visit({"gain", "samples of the file per Pa (per m with a unit transfer)"}, self.gain);
    visit(absent_if_empty({"peak_pressure_pa", "at the ears"}), self.peak_pressure_pa);
    visit(absent_if_empty({"peak_displacement_m", "with a unit transfer"}), self.peak_displacement_m);
    visit(absent_if_empty({"peak_level_db_re_20upa", "of a sine with that peak"}), self.peak_level_db_re_20upa);
    visit({"bubbles", "the first of them"}, self.bubbles);
  }
};

}  // namespace klang::apps
