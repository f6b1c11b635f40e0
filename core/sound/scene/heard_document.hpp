#pragma once
#include <array>
#include <optional>
#include <string>
#include <vector>

/// Parts of scene.json about what is heard and seen.
namespace klang::scene {

struct HeardRecord {
  std::string file;
  double gain = 0.0, peak_pressure_pa = 0.0, duration_s = 0.0, sample_rate_hz = 0.0;
  int n_channels = 1;
  std::array<double, 3> listener_m{};

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"file", "beside scene.json"}, self.file);
    visit({"gain",
           "the file is the pressure in Pa times this [1/Pa]; a sound below 0 dB re 20 uPa is not raised to the peak "
           "asked for"},
          self.gain);
    visit({"peak_pressure_pa", "at the ear"}, self.peak_pressure_pa);
    visit({"duration_s", "of the sound"}, self.duration_s);
    visit({"sample_rate_hz", "of the sound"}, self.sample_rate_hz);
    visit({"n_channels", "1, or 2: left and right ear"}, self.n_channels);
    visit({"listener_m", "centre of the head; of one who walks at the start of the path"}, self.listener_m);
  }
};

/// A partial of a body over the draws.
struct DrawnPartial {
  std::string body;
  double frequency_hz = 0.0, low_hz = 0.0, high_hz = 0.0;
  double decay_per_s = 0.0, low_decay_per_s = 0.0, high_decay_per_s = 0.0;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"body", "whose partial"}, self.body);
    visit({"frequency_hz", "of the estimate"}, self.frequency_hz);
    visit({"low_hz", "5 % of the draws lie below"}, self.low_hz);
    visit({"high_hz", "5 % lie above"}, self.high_hz);
    visit({"decay_per_s", "of the estimate"}, self.decay_per_s);
    visit({"low_decay_per_s", "5 % of the draws lie below"}, self.low_decay_per_s);
    visit({"high_decay_per_s", "5 % lie above"}, self.high_decay_per_s);
  }
};

/// The sound again for draws from the covariance of fitted materials; the motion stays.
struct DrawsRecord {
  int n = 0;
  std::vector<std::string> materials;
  std::vector<double> peak_pressure_pa, level_db;
  double low_level_db = 0.0, high_level_db = 0.0, low_peak_pressure_pa = 0.0, high_peak_pressure_pa = 0.0;
  std::vector<DrawnPartial> partials;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"n", "draws"}, self.n);
    visit({"materials", "that come from a fit and were drawn"}, self.materials);
    visit({"peak_pressure_pa", "of each draw"}, self.peak_pressure_pa);
    visit({"level_db", "of each draw: its root mean square over that of the sound [dB]"}, self.level_db);
    visit({"low_level_db", "5 % of the draws lie below"}, self.low_level_db);
    visit({"high_level_db", "5 % lie above"}, self.high_level_db);
    visit({"low_peak_pressure_pa", "5 % of the draws lie below"}, self.low_peak_pressure_pa);
    visit({"high_peak_pressure_pa", "5 % lie above"}, self.high_peak_pressure_pa);
    visit({"partials", "of fitted bodies, the lowest ten of each, 100 in all"}, self.partials);
  }
};

struct FloorRecord {
  int n_modes = 0, n_places = 0;
  double low_hz = 0.0, high_hz = 0.0;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"n_modes", "of the slab that are heard"}, self.n_modes);
    visit({"n_places", "of contacts that it is heard from"}, self.n_places);
    visit({"low_hz", "band asked for"}, self.low_hz);
    visit({"high_hz", "band asked for"}, self.high_hz);
  }
};

struct FramesRecord {
  int n_frames = 0;
  double rate_hz = 0.0;
  std::optional<std::string> series, animation;
  std::array<double, 3> low_m{}, high_m{};

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"n_frames", "pictures of the motion"}, self.n_frames);
    visit({"rate_hz", "pictures per second"}, self.rate_hz);
    visit({"series", "VTK collection of them, frames/000000.vtp and on; null: not asked for"}, self.series);
    visit({"animation", "glTF with keyframes; null: not asked for"}, self.animation);
    visit({"low_m", "corner of the box that holds them all"}, self.low_m);
    visit({"high_m", "the corner across"}, self.high_m);
  }
};

}  // namespace klang::scene
