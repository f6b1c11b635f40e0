#pragma once
#include <Eigen/Core>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/physics/liquid/liquid_step.hpp"
#include "core/sound/stage/bubble_scene.hpp"

namespace klang::liquid_scene {

enum class RadiusKind { kDeaneStokes, kGaussian, kRecording };

/// Where markers are seeds whatever the flow does.
struct SeedPatch {
  Eigen::Vector3d low_m, high_m;
  double start_s = 0.0, end_s = 0.0;
};

/// What [entrainment] says, as given.
struct EntrainmentTable {
  bool given = false;
  double attempts_per_m2_s = 0.0, seed_life_s = 0.02, window_s = 0.008, threshold_m_s = -1.5, coverage = 0.6;
  bool consume = false;
  std::string criterion = "slope";    ///< slope | velocity
  std::string literature = "mended";  ///< mended | paper
  std::string drag = "contaminated";  ///< contaminated | clean (Tomiyama 1998) | paper
  RadiusKind radii = RadiusKind::kDeaneStokes;
  double smallest_m = 3e-4, largest_m = 5e-3;
  std::optional<double> mean_m, std_m;  ///< gaussian
  std::filesystem::path recording;
  std::vector<SeedPatch> patches;
};

/// A bubble that the scene itself puts there.
struct ScriptedBubble {
  double radius_m = 0.0, birth_s = 0.0;
  Eigen::Vector3d position_m;
};

enum class TransferMethod { kReciprocal, kForward, kHalfSpace, kUnit };
constexpr auto words_of(TransferMethod) {
  return std::array{Word{TransferMethod::kReciprocal, "reciprocal"}, Word{TransferMethod::kForward, "forward"},
                    Word{TransferMethod::kHalfSpace, "half_space"}, Word{TransferMethod::kUnit, "unit"}};
}

struct TransferTable {
  TransferMethod method = TransferMethod::kReciprocal;
  int bins_per_octave = 6;
  double liquid_loss_factor = 0.02;
  double wall_admittance = 0.0;  ///< bubble::DualDomainOptions
};

/// A scene with a [domain]: what moves, what bubbles it makes, where it is heard (docs/liquid.md).
struct LiquidScene {
  std::filesystem::path file;
  std::string name;
  double duration_s = 0.0, frame_rate_hz = 250.0;
  bool imported = false;                ///< its frames are another program's
  std::string flow_text, bubbles_text;  ///< of the file, what the stage flow, and this and the stage bubbles, depend on
  liquid::LiquidSetup setup;
  EntrainmentTable entrainment;
  std::vector<ScriptedBubble> bubbles;
  TransferTable transfer;
  std::filesystem::path pitch_from;  ///< drops.json of `klang bubble fit`
  stage::BubbleScene sound;          ///< medium, pitch, listener, rate, level; no bubbles
  std::vector<std::filesystem::path> key_files;

  std::vector<std::filesystem::path> inputs() const;  ///< the scene and every file that it names
  std::size_t n_frames() const;                       ///< k / frame_rate_hz from 0 to duration_s
  double frame_s(std::size_t frame) const { return static_cast<double>(frame) / frame_rate_hz; }
};

/// Whether a TOML text is a scene of a liquid: it has a table [domain].
bool is_liquid_scene(std::string_view toml);

/// @throws InputError in one line with file, line, key, value and what is allowed
LiquidScene read_liquid_scene(const std::filesystem::path& toml);
LiquidScene parse_liquid_scene(std::string_view toml, const std::string& name,
                               const std::filesystem::path& base_folder);

/// The keys as Markdown tables: part of docs/liquid.md.
std::string liquid_scene_schema_markdown();

}  // namespace klang::liquid_scene
