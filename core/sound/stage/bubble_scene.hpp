#pragma once
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/foundation/base/monitor.hpp"
#include "core/sound/audio/signal.hpp"
#include "core/sound/stage/bubble_voice.hpp"

namespace klang {
class TomlTable;
struct TomlField;
}  // namespace klang

namespace klang::stage {

struct SceneBubble {
  double radius_m = 1e-3;
  double birth_s = 0.0;
  double strength = 1.0;  ///< times the excitation by the Laplace pressure
  std::shared_ptr<const bubble::BubbleMotion> motion;
  std::shared_ptr<const bubble::TransferSeries> transfer;  ///< none: the scene's own transfer
};

/// What a scene file says (docs/bubbles.md).
struct BubbleScene : BubbleSettings {
  Listener listener;
  double sample_rate_hz = 48000.0;
  std::optional<double> duration_s;  ///< none: until the last bubble has ended
  double peak_db_re_full_scale = -3.0;
  std::vector<SceneBubble> bubbles;
};

/// Reads and checks a scene; times in its files are times of the scene, not ages. A seed makes its population.
BubbleScene read_bubble_scene(const std::filesystem::path& toml, std::uint64_t seed);
BubbleScene parse_bubble_scene(std::string_view toml, const std::string& name, const std::filesystem::path& base_folder,
                               std::uint64_t seed);

/// For scenes of other kinds that have the tables liquid, gas, air, sound (without
/// transfer), pitch and listener, too: their keys, and what they say.
std::vector<TomlField> bubble_settings_fields();
void read_bubble_settings(const TomlTable& root, const std::filesystem::path& base_folder, BubbleScene& scene);

/// The keys of a scene as Markdown tables: part of docs/bubbles.md.
std::string bubble_scene_schema_markdown();

enum class BubbleSoundStatus { kNotRun, kDone, kSilent };

struct BubbleSound {
  BubbleSoundStatus status = BubbleSoundStatus::kNotRun;
  audio::Signal sound;                 ///< [Pa], or [m] with unit transfer; 1 or 2 channels
  std::vector<SoundedBubble> bubbles;  ///< in the scene's order
  std::size_t n_too_high = 0;          ///< left out: their pitch reaches half of the sample rate
  double wall_time_s = 0.0;
};

/// The sound of a scene: render() with one BubbleVoice. Same scene, same bits on any number of threads.
BubbleSound synthesise_bubbles(const BubbleScene& scene, Monitor& monitor = silent_monitor());

}  // namespace klang::stage
