#include "core/sound/scene/detail/sound_reader.hpp"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/errors.hpp"

namespace klang::scene::detail {
namespace {

using enum TomlType;
constexpr double kNoLimit = std::numeric_limits<double>::infinity();

}  // namespace

std::vector<TomlField> sound_fields() {
  return {
      {"sound", "band_hz", kNumbers, "[20, 20000]", 1, 1e5, "modes that are computed", false, 2},
      {"sound", "bank", kText, "none", -kNoLimit, kNoLimit,
       "a soundbank of `klang proxy build`, relative to the scene: ellipsoids that stand for bodies"},
      {"sound", "proxy_above_hz", kNumber, "none: no proxies", 0, 1e6,
       "bodies with sound = \"auto\" whose lowest frequency is above this are heard by an ellipsoid of the bank; 0: "
       "all"},
      {"sound", "sample_rate_hz", kNumber, "48000", 4000, 768000, "sample rate"},
      {"sound", "peak_db_re_full_scale", kNumber, "-3", -120, 0, "level of the highest peak in the file"},
      {"sound", "longest_tail_s", kNumber, "5", 0, 600,
       "without duration_s: how long it rings on after the motion at most"},
      {"sound", "elements_per_wavelength", kNumber, "6", 5, 40, "of the boundary elements for radiation"},
      {"sound", "radiation_damping", kBoolean, "false", -kNoLimit, kNoLimit, "adds each mode's decay by radiation"},
      {"sound", "listener", kTable, "the defaults below", -kNoLimit, kNoLimit, "where it is heard"},
      {"sound.listener", "position_m", kVector, "[0, -2, 1.6]", -1e4, 1e4, "centre of the head"},
      {"sound.listener", "facing", kVector, "[0, 1, 0]", -1e4, 1e4, "direction of the nose"},
      {"sound.listener", "path", kTables, "none: at rest", -kNoLimit, kNoLimit,
       "of one who walks, instead of position_m: places with their times, straight lines between, at rest before and "
       "after"},
      {"sound.listener", "mode", kText, "`mono`", -kNoLimit, kNoLimit,
       "`mono`, or `stereo`: two ears of a spherical head"},
      {"sound.listener.path", "time_s", kNumber, "required", 0, 3600, "rising"},
      {"sound.listener.path", "position_m", kVector, "required", -1e4, 1e4, "centre of the head then"},
      {"sound.listener.path", "facing", kVector, "as before", -1e4, 1e4, "direction of the nose then"},
      {"frames", "rate_hz", kNumber, "60", 1, 1000, "pictures per second of the motion"},
      {"frames", "formats", kTexts, "`[\"glb\", \"vtp\"]`", -kNoLimit, kNoLimit,
       "`glb`: scene.glb with keyframes; `vtp`: frames.pvd and a file for each picture"},
  };
}

std::vector<TomlField> floor_sound_fields() {
  return {
      {"world.floor.sound", "slab_m", kNumbers, "[9, 9, 0.9]", 1e-3, 1000, "length, width, thickness", false, 3},
      {"world.floor.sound", "low_hz", kNumber, "20", 1, 1e5, "lowest mode that is heard"},
      {"world.floor.sound", "high_hz", kNumber, "4000", 1, 1e5, "highest mode that is heard"},
      {"world.floor.sound", "n_modes", kNumber, "1000", 1, 20000,
       "most modes, from low_hz up (some 950 bending modes of the default slab lie in its band)"},
  };
}

namespace {

void read_listener(const TomlTable& table, SceneListener& listener) {
  constexpr std::size_t kMostKeys = 100000;
  listener.position_m = table.vector("position_m", listener.position_m);
  listener.facing = table.vector("facing", listener.facing);
  if (!(listener.facing.norm() > 0.0)) throw InputError(table.place("facing"), "has no direction", "0, 0, 0");
  listener.stereo = table.choice("mode", {"mono", "stereo"}) == "stereo";
  Eigen::Vector3d facing = listener.facing;
  for (const TomlTable& key : table.tables("path", kMostKeys)) {
    facing = key.vector("facing", facing);
    if (!(facing.norm() > 0.0)) throw InputError(key.place("facing"), "has no direction", "0, 0, 0");
    const double time_s = key.number("time_s");
    if (!listener.path.empty() && !(time_s > listener.path.back().time_s))
      throw InputError(key.place("time_s"), "does not rise", to_text(time_s),
                       "above " + to_text(listener.path.back().time_s));
    listener.path.push_back({time_s, key.vector("position_m"), facing});
  }
  if (listener.path.empty()) return;
  if (table.has("position_m")) throw InputError(table.place("position_m"), "stands beside a path", "", "one of both");
  listener.position_m = listener.path.front().position_m;
  listener.facing = listener.path.front().facing;
}

}  // namespace

void read_sound(const TomlTable& table, const std::filesystem::path& folder, SceneSoundOptions& sound) {
  if (table.has("band_hz")) {
    const std::vector<double> band = table.numbers("band_hz");
    if (!(band[0] < band[1]))
      throw InputError(table.place("band_hz"), "is no band", to_text(band[1]), "low, then high");
    sound.low_hz = band[0];
    sound.high_hz = band[1];
  }
  if (table.has("bank")) sound.bank = existing_file(table.text("bank"), table.place("bank"), folder);
  sound.proxy_above_hz = table.optional_number("proxy_above_hz");
  if (sound.proxy_above_hz && sound.bank.empty())
    throw InputError(table.place("proxy_above_hz"), "needs a soundbank", to_text(*sound.proxy_above_hz),
                     "bank = FILE of klang proxy build");
  sound.sample_rate_hz = table.number("sample_rate_hz", sound.sample_rate_hz);
  sound.peak_db_re_full_scale = table.number("peak_db_re_full_scale", sound.peak_db_re_full_scale);
  sound.longest_tail_s = table.number("longest_tail_s", sound.longest_tail_s);
  sound.elements_per_wavelength = table.number("elements_per_wavelength", sound.elements_per_wavelength);
  sound.radiation_damping = table.boolean("radiation_damping", false);
  read_listener(table.table("listener"), sound.listener);
}

FloorSound read_floor_sound(const TomlTable& table) {
  FloorSound sound;
  if (table.has("slab_m")) {
    const std::vector<double> slab = table.numbers("slab_m");
    sound.slab_m = {slab[0], slab[1], slab[2]};
    if (!(slab[2] <= 0.5 * std::min(slab[0], slab[1])))
      throw InputError(table.place("slab_m"), "is no slab: its thickness", to_text(slab[2]) + " m",
                       "length, width, thickness, up to half of the width");
  }
  sound.low_hz = table.number("low_hz", sound.low_hz);
  sound.high_hz = table.number("high_hz", sound.high_hz);
  if (!(sound.low_hz < sound.high_hz))
    throw InputError(table.place("high_hz"), "is no band with low_hz", to_text(sound.high_hz),
                     "above " + to_text(sound.low_hz));
  const double n = table.number("n_modes", sound.n_modes);
  if (n != std::floor(n)) throw InputError(table.place("n_modes"), "is no whole number", to_text(n));
  sound.n_modes = static_cast<int>(n);
  return sound;
}

SceneFrames read_frames(const TomlTable& table) {
  SceneFrames frames;
  frames.rate_hz = table.number("rate_hz", frames.rate_hz);
  if (!table.has("formats")) return frames;
  frames.glb = frames.vtp = false;
  for (const std::string& format : table.texts("formats")) {
    if (format != "glb" && format != "vtp")
      throw InputError(table.place("formats"), "unknown format", format, "glb, vtp");
    (format == "glb" ? frames.glb : frames.vtp) = true;
  }
  return frames;
}

}  // namespace klang::scene::detail
