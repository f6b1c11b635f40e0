#include "datasets-synthetic/drops.hpp"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/json.hpp"
#include "core/foundation/base/parallel.hpp"
#include "core/foundation/config/fields_json.hpp"
#include "core/foundation/config/result_header.hpp"
#include "core/physics/bubble/bubble_physics.hpp"
#include "core/physics/bubble/ringdown_formulas.hpp"
#include "datasets-synthetic/disturbances.hpp"
#include "datasets-synthetic/oscillator_ode.hpp"

namespace klang::datasets {
namespace {

using nlohmann::json;

constexpr double kAudibleFall = 6.907755278982137;  // ln 1000
constexpr double kSilentFall = 13.815510557964274;  // ln 1e6
constexpr double kLongestLifeS = 20.0;
constexpr double kTrackStepS = 1e-3;
constexpr double kHighestOfSampleRate = 0.499;
enum class DropPurpose : std::uint64_t { kNoise = 1, kRoom = 2 };

RandomStream stream(std::uint64_t seed, std::size_t recording, DropPurpose purpose) {
  return {seed, (std::uint64_t{0xd70a} << 32) | (recording << 4) | static_cast<std::uint64_t>(purpose)};
}

// omega0 and beta of a drop's bubble at an age.
class DropCoefficients {
 public:
  DropCoefficients(const Drop& drop, const DropRecipe& recipe)
      : drop_(drop),
        recipe_(recipe),
        motion_(bubble::analytic_rise({0, 0, -drop.depth_m}, drop.radius_m, drop.rise, recipe.medium)),
        omega_inf_(bubble::undamped_angular_frequency_rad_s(recipe.medium, recipe.theory, drop.radius_m)) {}
  bubble::RingRate<double> rate(double age_s) const {
    const double factor = bubble::pitch_factor(drop_.pitch, drop_.radius_m, motion_->phi_m(age_s).v, -drop_.depth_m);
    return bubble::ring_rate(recipe_.medium, recipe_.theory, drop_.radius_m, omega_inf_, factor);
  }
  OscillatorCoefficients operator()(double age_s) const {
    const bubble::RingRate<double> at = rate(age_s);
    return {at.omega0_rad_s, at.decay_per_s};
  }
  double phi_m(double age_s) const { return motion_->phi_m(age_s).v; }
  std::vector<double> corners_s() const { return motion_->breaks_s(); }

 private:
  const Drop& drop_;
  const DropRecipe& recipe_;
  std::shared_ptr<const bubble::BubbleMotion> motion_;
  double omega_inf_;
};

json drop_json(const Drop& drop, const DropSound& sound, double scale, double noise_rms) {
  const bool has_noise = noise_rms > 0.0;
  const auto last = sound.frequency_hz.size() - 1;
  return {{"onset_s", drop.onset_s},
          {"radius_m", drop.radius_m},
          {"depth_m", drop.depth_m},
          {"strength", drop.strength},
          {"rise", drop.rise.kind == bubble::RiseKind::kFixed           ? "fixed"
                   : drop.rise.kind == bubble::RiseKind::kConstantSpeed ? "constant"
                                                                        : "terminal"},
          {"rise_speed_m_s", drop.rise.speed_m_s},
          {"k_delta_per_m", drop.pitch.k_delta_per_m},
          {"eta", drop.pitch.eta},
          {"phi0_m", drop.pitch.phi0_m},
          {"frequency_start_hz", sound.frequency_hz.front()},
          {"frequency_end_hz", sound.frequency_hz[last]},
          {"decay_per_s", sound.decay_per_s.front()},
          {"amplitude", scale * sound.amplitude},
          {"life_s", sound.life_s},
          {"snr_db", has_noise ? json(10.0 * std::log10(sound.ring_mean_square) + 20.0 * std::log10(scale / noise_rms))
                               : json(nullptr)},
          {"track",
           {{"time_s", sound.time_s},
            {"frequency_hz", sound.frequency_hz},
            {"decay_per_s", sound.decay_per_s},
            {"phi_m", sound.phi_m}}}};
}

// How each bubble of a recording rose, as klang bubble fit reads it.
std::string rise_csv(const DropRecording& recording, const std::vector<DropSound>& sounds) {
  std::string text = "onset_s,time_s,phi_m\n";
  for (std::size_t i = 0; i < sounds.size(); ++i) {
    for (std::size_t k = 0; k < sounds[i].time_s.size(); ++k) {
      text += to_text(recording.drops[i].onset_s) + "," + to_text(sounds[i].time_s[k]) + "," +
              to_text(sounds[i].phi_m[k]) + "\n";
    }
  }
  return text;
}

struct RecordedDrops {
  SyntheticRecording recording;
  json truth;
  std::string rise;
};

RecordedDrops make_recording(const DropRecipe& recipe, std::size_t index, std::uint64_t seed) {
  const DropRecording& wanted = recipe.recordings[index];
  const auto n_frames = static_cast<Eigen::Index>(std::llround(recipe.duration_s * recipe.sample_rate_hz));
  Eigen::VectorXd clean = Eigen::VectorXd::Zero(n_frames);
  std::vector<DropSound> sounds;
  double loudest = 0.0;
  for (const Drop& drop : wanted.drops) {
    sounds.push_back(drop_sound(drop, recipe));
    const DropSound& sound = sounds.back();
    const Eigen::Index n = std::min(sound.samples.size(), n_frames - sound.first_frame);
    if (n > 0) clean.segment(sound.first_frame, n) += sound.samples.head(n);
    loudest = std::max(loudest, sound.ring_mean_square);
  }
  const double top = clean.cwiseAbs().maxCoeff();
  if (!(top > 0.0)) throw InputError(recipe.name + ", " + wanted.name, "is silent");
  const double scale = recipe.peak / top;
  clean *= scale;
  Eigen::VectorXd sound = clean;
  if (recipe.room_rt60_s) {
    RandomStream random = stream(seed, index, DropPurpose::kRoom);
    sound += room_tail(clean, recipe.sample_rate_hz, *recipe.room_rt60_s, recipe.room_level_db, random);
  }
  double noise_rms = 0.0;
  if (recipe.snr_db) {
    const double mean_square =
        recipe.snr_of == DropSnr::kDrop ? scale * scale * loudest : sound.squaredNorm() / static_cast<double>(n_frames);
    noise_rms = std::sqrt(mean_square) * std::pow(10.0, -*recipe.snr_db / 20.0);
    RandomStream random = stream(seed, index, DropPurpose::kNoise);
    sound +=
        noise_rms * (recipe.pink ? pink_noise(n_frames, recipe.sample_rate_hz, random) : white_noise(n_frames, random));
  }
  RecordedDrops made;
  made.recording.name = wanted.name;
  made.recording.signal.samples = sound;
  made.recording.signal.sample_rate_hz = recipe.sample_rate_hz;
  made.recording.signal.origin = recipe.name + ", " + wanted.name;
  json bubbles = json::array();
  for (std::size_t i = 0; i < sounds.size(); ++i) {
    made.recording.strikes_s.push_back(wanted.drops[i].onset_s);
    bubbles.push_back(drop_json(wanted.drops[i], sounds[i], scale, noise_rms));
  }
  made.rise = rise_csv(wanted, sounds);
  made.truth = {{"name", wanted.name},
                {"recording", wanted.name + ".wav"},
                {"rise", wanted.name + "-rise.csv"},
                {"noise_rms", noise_rms},
                {"bubbles", std::move(bubbles)}};
  return made;
}

}  // namespace

DropSound drop_sound(const Drop& drop, const DropRecipe& recipe) {
  const DropCoefficients coefficients(drop, recipe);
  DropSound sound;
  // The life by the rates alone: amplitude of q ~ exp(-int beta) / sqrt(omega_d).
  const bubble::RingRate<double> onset = coefficients.rate(0.0);
  double fall = 0.0, age = 0.0, silent_s = kLongestLifeS, tenth_s = 0.0;
  const auto note = [&](double at_s) {
    const bubble::RingRate<double> at = coefficients.rate(at_s);
    sound.time_s.push_back(at_s);
    sound.frequency_hz.push_back(at.omega_d_rad_s / (2 * kPi));
    sound.decay_per_s.push_back(at.decay_per_s);
    sound.phi_m.push_back(coefficients.phi_m(at_s));
  };
  for (; age < kLongestLifeS; age += kTrackStepS) {
    const bubble::RingRate<double> at = coefficients.rate(age);
    const double level = fall + 0.5 * std::log(at.omega_d_rad_s / onset.omega_d_rad_s);
    if (!(at.omega_d_rad_s < 2 * kPi * kHighestOfSampleRate * recipe.sample_rate_hz)) {
      throw InputError(recipe.name, "has a drop whose pitch reaches half of the sample rate",
                       "radius " + to_text(drop.radius_m) + " m, " + to_text(at.omega_d_rad_s / (2 * kPi)) + " Hz");
    }
    if (level <= kAudibleFall) {
      note(age);
      // A bubble that comes to rest does so between two points: the track's corner is one of its points.
      for (const double corner_s : coefficients.corners_s())
        if (corner_s > age && corner_s < age + kTrackStepS) note(corner_s);
      sound.life_s = age;
    }
    const double pressure_level = level - 2.0 * std::log(at.omega0_rad_s / onset.omega0_rad_s);
    if (pressure_level <= std::log(10.0)) tenth_s = age + kTrackStepS;
    if (level > kSilentFall) {
      silent_s = age;
      break;
    }
    fall += kTrackStepS * coefficients.rate(age + 0.5 * kTrackStepS).decay_per_s;
  }
  const double h = 1.0 / recipe.sample_rate_hz;
  sound.first_frame = static_cast<Eigen::Index>(std::ceil(drop.onset_s * recipe.sample_rate_hz));
  const double first_s = std::max(0.0, static_cast<double>(sound.first_frame) * h - drop.onset_s);
  const double shown_s = std::min(silent_s, recipe.duration_s - drop.onset_s);
  const auto n = static_cast<Eigen::Index>(std::max(1.0, std::ceil(shown_s * recipe.sample_rate_hz)));
  const double gain = drop.strength * drop.radius_m * drop.radius_m *
                      bubble::entrainment_velocity_m_s(drop.radius_m, recipe.medium, recipe.theory);
  const Eigen::MatrixXd rows =
      integrate_oscillator([&](double t) { return coefficients(t); }, 1.0, first_s, h, n, coefficients.corners_s());
  sound.samples = gain * rows.col(2);
  if (recipe.soft_attack) {
    for (Eigen::Index i = 0; i < n; ++i)
      sound.samples[i] *= bubble::attack_window(onset.decay_per_s, first_s + static_cast<double>(i) * h);
  }
  sound.amplitude = gain * onset.omega0_rad_s * onset.omega0_rad_s / onset.omega_d_rad_s;
  const auto n_ring = std::clamp<Eigen::Index>(static_cast<Eigen::Index>(tenth_s * recipe.sample_rate_hz), 1, n);
  sound.ring_mean_square = sound.samples.head(n_ring).squaredNorm() / static_cast<double>(n_ring);
  return sound;
}

Dataset make_drops(std::string_view toml, const std::string& name, std::uint64_t seed, Monitor& monitor) {
  const DropRecipe recipe = parse_drop_recipe(toml, name, seed);
  std::vector<RecordedDrops> made(recipe.recordings.size());
  for_each_job(
      made.size(), [&](std::size_t i) { made[i] = make_recording(recipe, i, seed); }, "synthetic drops", monitor);
  const Provenance provenance = make_provenance("dataset " + recipe.name, seed, {{"recipe_toml", toml}}, {});
  const bubble::PitchModel pitch = recipe.recordings.front().drops.front().pitch;
  json truth = {
      {"schema_version", 1},
      {"kind", "drops"},
      {"status", "made"},
      {"name", recipe.name},
      {"provenance", json_of(provenance)},
      {"method", "implicit Gauss-Legendre, order 8, of q'' + 2 beta q' + omega0^2 q = 0; pressure ~ r^2 q''"},
      {"sample_rate_hz", recipe.sample_rate_hz},
      {"duration_s", recipe.duration_s},
      {"snr_db", json_number(recipe.snr_db)},
      {"noise_colour", recipe.pink ? "pink" : "white"},
      {"room", {{"rt60_s", json_number(recipe.room_rt60_s)}, {"level_db", recipe.room_level_db}}},
      {"pitch", {{"k_delta_per_m", pitch.k_delta_per_m}, {"eta", pitch.eta}, {"largest_factor", pitch.largest_factor}}},
      {"recordings", json::array()}};
  Dataset dataset;
  for (RecordedDrops& one : made) {
    dataset.files.emplace_back(one.recording.name + "-rise.csv", std::move(one.rise));
    dataset.recordings.push_back(std::move(one.recording));
    truth["recordings"].push_back(std::move(one.truth));
  }
  dataset.truth_json = json_text(truth);
  return dataset;
}

}  // namespace klang::datasets
