#pragma once
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/foundation/base/monitor.hpp"
#include "core/physics/bubble/bubble_ring.hpp"
#include "core/physics/bubble/time_series.hpp"
#include "core/sound/audio/signal.hpp"
#include "core/sound/stage/head_model.hpp"

namespace klang::bubble {

struct SceneBubble {
  double radius_m = 1e-3;
  double birth_s = 0.0;
  double strength = 1.0;  ///< times the excitation by the Laplace pressure
  std::shared_ptr<const BubbleMotion> motion;
  std::shared_ptr<const TransferSeries> transfer;  ///< none: the scene's own transfer
};

enum class SceneTransfer {
  kHalfSpace,  ///< closed form for a bubble below a wide plane surface: see half_space_transfer
  kUnit        ///< |P| = 1 for every bubble, also where it has a transfer of its own: for comparison
};

/// What a scene file says (docs/bubbles.md).
struct BubbleScene {
  std::string name;
  BubbleMedium medium;
  BubbleTheory theory = BubbleTheory::kLeighton;
  PitchModel pitch;
  bool printed_excitation = false;  ///< as the paper prints it
  bool soft_attack = true;
  SceneTransfer transfer = SceneTransfer::kHalfSpace;
  double air_density_kg_m3 = 1.2041, air_sound_speed_m_s = 343.0;
  HeadModel head;      ///< of the listener; its centre alone counts in mono
  HeadPath head_path;  ///< of a listener who moves
  bool stereo = true;
  bool propagation_delay = false;  ///< sound arrives distance / c later
  double sample_rate_hz = 48000.0;
  std::optional<double> duration_s;  ///< none: until the last bubble has ended
  double peak_db_re_full_scale = -3.0;
  std::vector<SceneBubble> bubbles;
};

/// Reads and checks a scene; times in its files are times of the scene, not ages. A seed makes its population.
BubbleScene read_bubble_scene(const std::filesystem::path& toml, std::uint64_t seed);
BubbleScene parse_bubble_scene(std::string_view toml, const std::string& name, const std::filesystem::path& base_folder,
                               std::uint64_t seed);

/// The keys of a scene as Markdown tables: part of docs/bubbles.md.
std::string bubble_scene_schema_markdown();

/// Pressure in the air for unit vibration amplitude of a bubble below a wide plane surface: the one-way (dual-domain)
/// solution in closed form. The source under the pressure-release plane moves the plane; the plane radiates as a piston
/// in a wall:
///   P = 2 rho_a r^2 lambda^2 / R * exp(-depth sqrt(k_a^2 sin^2 theta - k_f^2)), far from the bubble (k_a R > 1)
/// with lambda the complex rate of the oscillation (about i omega), theta the angle from the vertical. e^{-i k_a R} is
/// left out: sound takes its time by the scene's propagation_delay.
std::complex<double> half_space_transfer(const BubbleScene& scene, double radius_m, const Eigen::Vector3d& bubble_m,
                                         const Eigen::Vector3d& listener_m, std::complex<double> rate);

struct SoundedBubble {
  double frequency_start_hz = 0.0, frequency_end_hz = 0.0;  ///< heard, at birth and at 1/1000 of the amplitude
  double decay_start_per_s = 0.0;
  double amplitude_m = 0.0;
  double peak = 0.0;  ///< largest |gain Z| over the life and the channels [Pa], or [m] with unit transfer
};

enum class BubbleSoundStatus { kNotRun, kDone, kSilent };

struct BubbleSound {
  BubbleSoundStatus status = BubbleSoundStatus::kNotRun;
  audio::Signal sound;                 ///< [Pa], or [m] with unit transfer; 1 or 2 channels
  std::vector<SoundedBubble> bubbles;  ///< in the scene's order
  std::size_t n_too_high = 0;          ///< left out: their pitch reaches half of the sample rate
  double wall_time_s = 0.0;
};

/// Sum over bubbles of |P| Re Z (mono, eq. 11) or Re(H_ear P Z) (stereo, eq. 35), each ear with its own arrival time. A
/// bubble is heard from where it and the listener were at its birth as far as time goes, and from where they are as far
/// as level and phase go (which gives the Doppler shift with propagation_delay). Same scene, same bits on any number of
/// threads.
BubbleSound synthesise_bubbles(const BubbleScene& scene, Monitor& monitor = silent_monitor());

}  // namespace klang::bubble
