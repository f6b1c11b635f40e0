#include "datasets-synthetic/detail/recipe_recording.hpp"

#include <algorithm>
#include <cmath>
#include <complex>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/json.hpp"
#include "core/foundation/base/random.hpp"
#include "core/sound/stage/oscillator_bank.hpp"
#include "datasets-synthetic/body_modes.hpp"
#include "datasets-synthetic/disturbances.hpp"

namespace klang::datasets::detail {
namespace {

using nlohmann::json;

constexpr double kHighestOfSampleRate = 0.499;
constexpr double kSilent = 1e-9;  // of the loudest partial: a mode struck or heard on a node line
enum class Purpose : std::uint64_t { kNoise, kRoom, kMains };

// One mode as each channel records it after the first strike: amplitude exp(-decay t) cos(omega_d t + phase),
// written as Re(amplitude exp(p t)).
struct RecordedMode {
  double undamped_rad_s = 0.0, damped_rad_s = 0.0, decay_per_s = 0.0;
  std::vector<std::complex<double>> amplitude;  // one per channel
  std::string label;
};

// The body's modes with what every strike gives to each and how each decays.
struct StruckBody {
  double highest_hz = 0.0;
  BodyModes modes;
  std::size_t n_strikes = 0, n_channels = 0;
  std::vector<modal::Oscillator> oscillators;
  std::vector<modal::ModalImpulse> impulses;
  std::vector<RecordedMode> under_damped;  // amplitudes without the pickups' gain
};

// What the channels record before anything disturbs it.
struct CleanSound {
  Eigen::MatrixXd samples;  // one column per channel
  std::vector<RecordedMode> partials;
};

struct DisturbedSound {
  Eigen::MatrixXd samples;
  json channels;
  long n_clipped = 0;
};

RandomStream stream(std::uint64_t seed, std::size_t specimen, std::size_t channel, Purpose purpose) {
  return {seed, (specimen << 16) | (channel << 4) | static_cast<std::uint64_t>(purpose)};
}

json vector_json(const Eigen::Vector3d& v) { return {json_number(v[0]), json_number(v[1]), json_number(v[2])}; }

// Modes with equal frequencies (closer than a thousandth of their width) are one partial.
std::vector<RecordedMode> partials_of(std::vector<RecordedMode> modes) {
  std::sort(modes.begin(), modes.end(),
            [](const RecordedMode& a, const RecordedMode& b) { return a.damped_rad_s < b.damped_rad_s; });
  std::vector<RecordedMode> partials;
  for (RecordedMode& mode : modes) {
    if (!partials.empty() && mode.damped_rad_s - partials.back().damped_rad_s <= 1e-3 * mode.decay_per_s) {
      for (std::size_t c = 0; c < mode.amplitude.size(); ++c) partials.back().amplitude[c] += mode.amplitude[c];
    } else {
      partials.push_back(std::move(mode));
    }
  }
  double loudest = 0.0;
  const auto loudness = [](const RecordedMode& m) {
    double top = 0.0;
    for (const auto& a : m.amplitude) top = std::max(top, std::abs(a));
    return top;
  };
  for (const RecordedMode& partial : partials) loudest = std::max(loudest, loudness(partial));
  std::erase_if(partials, [&](const RecordedMode& m) { return !(loudness(m) > kSilent * loudest); });
  return partials;
}

json shape_json(const mesh::ShapeSpec& shape) {
  json value = {{"kind", shape.kind}};
  for (const auto& [name, metres] : shape.dims) value[name] = metres;
  if (!shape.profile_csv.empty()) value["profile_csv"] = shape.profile_csv.filename().string();
  return value;
}

StruckBody strike_body(const Recipe& recipe, const RecipeSpecimen& specimen, Monitor& monitor) {
  StruckBody body;
  body.n_strikes = specimen.strikes.size();
  body.n_channels = specimen.pickups.size();
  std::vector<Eigen::Vector3d> places;
  for (const RecipeStrike& strike : specimen.strikes) places.push_back(strike.at);
  for (const RecipePickup& pickup : specimen.pickups) places.push_back(pickup.at);
  for (const RecipeMount& mount : specimen.mounts) places.push_back(mount.at);
  body.highest_hz = std::min(recipe.highest_hz, kHighestOfSampleRate * recipe.sample_rate_hz);
  body.modes = body_modes(specimen.shape, recipe.material, specimen.support, body.highest_hz, places, monitor);
  BodyModes& modes = body.modes;
  split_pairs(modes, recipe.split_detuning, recipe.split_detuning > 0.0 ? recipe.split_angle_rad : 0.0);
  const Eigen::Index n_modes = modes.angular_frequency_rad_s.size();

  for (const RecipeStrike& strike : specimen.strikes) {
    body.impulses.push_back({strike.time_s, Eigen::VectorXd(n_modes), strike.contact_s});
  }
  for (Eigen::Index m = 0; m < n_modes; ++m) {
    const double omega = modes.angular_frequency_rad_s[m];
    double decay = recipe.decay_per_s(omega);
    for (std::size_t k = 0; k < specimen.mounts.size(); ++k) {
      const RecipeMount& mount = specimen.mounts[k];
      const Eigen::Vector3d shape = modes.shapes[body.n_strikes + body.n_channels + k].col(m);
      const double seen = mount.direction ? shape.dot(mount.direction->normalized()) : shape.norm();
      decay += 0.5 * mount.damping_n_s_per_m * seen * seen;
    }
    body.oscillators.push_back({omega, decay, 1.0});
    for (std::size_t s = 0; s < body.n_strikes; ++s) {
      body.impulses[s].impulse[m] = modes.shapes[s].col(m).dot(specimen.strikes[s].impulse_n_s);
    }
    if (!(decay < omega)) continue;  // over-damped: a thud, no partial
    RecordedMode mode{
        omega, std::sqrt((omega - decay) * (omega + decay)), decay, {}, modes.labels[static_cast<std::size_t>(m)]};
    const std::complex<double> pole(-decay, mode.damped_rad_s);
    const double contact = specimen.strikes[0].contact_s;
    const std::complex<double> start = body.impulses[0].impulse[m] / mode.damped_rad_s *
                                       std::exp(0.5 * contact * contact * pole * pole) * std::complex<double>(0, -1);
    mode.amplitude.assign(body.n_channels, start);
    body.under_damped.push_back(std::move(mode));
  }
  return body;
}

// The pickups' velocities, the loudest channel scaled to the recipe's peak.
CleanSound clean_sound(const Recipe& recipe, const RecipeSpecimen& specimen, StruckBody body) {
  const auto n_frames = static_cast<Eigen::Index>(std::llround(recipe.duration_s * recipe.sample_rate_hz));
  const Eigen::Index n_modes = body.modes.angular_frequency_rad_s.size();
  Eigen::MatrixXd clean(n_frames, static_cast<Eigen::Index>(body.n_channels));
  for (std::size_t c = 0; c < body.n_channels; ++c) {
    const Eigen::Vector3d direction = specimen.pickups[c].direction.normalized();
    std::size_t at = 0;
    for (Eigen::Index m = 0; m < n_modes; ++m) {
      auto& oscillator = body.oscillators[static_cast<std::size_t>(m)];
      oscillator.output_gain = body.modes.shapes[body.n_strikes + c].col(m).dot(direction) *
                               oscillator.angular_frequency_rad_s / (2.0 * kPi);
      if (oscillator.decay_per_s < oscillator.angular_frequency_rad_s)
        body.under_damped[at++].amplitude[c] *= oscillator.output_gain;
    }
    clean.col(static_cast<Eigen::Index>(c)) =
        modal::render(body.oscillators, body.impulses, recipe.sample_rate_hz, n_frames);
  }
  const double top = clean.size() > 0 ? clean.cwiseAbs().maxCoeff() : 0.0;
  if (!(top > 0.0)) {
    throw InputError(recipe.name + ", " + specimen.name, "is silent: nothing is struck or heard in the band",
                     std::to_string(n_modes) + " modes up to " + to_text(body.highest_hz) + " Hz");
  }
  const double scale = recipe.peak / top;
  clean *= scale;
  for (RecordedMode& mode : body.under_damped) {
    for (auto& a : mode.amplitude) a *= scale;
  }
  return {std::move(clean), partials_of(std::move(body.under_damped))};
}

// Random numbers of one recording.
struct RecordingSeed {
  std::uint64_t seed = 0;
  std::size_t specimen = 0;
};

struct DisturbedChannel {
  Eigen::VectorXd samples;
  double sound_rms = 0.0, noise_rms = 0.0;
};

DisturbedChannel disturbed_channel(const Recipe& recipe, const Eigen::VectorXd& clean, const RecordingSeed& seed,
                                   std::size_t c) {
  const Eigen::Index n_frames = clean.size();
  DisturbedChannel channel;
  channel.samples = clean;
  if (recipe.room_rt60_s) {
    RandomStream random = stream(seed.seed, seed.specimen, c, Purpose::kRoom);
    channel.samples += room_tail(clean, recipe.sample_rate_hz, *recipe.room_rt60_s, recipe.room_level_db, random);
  }
  channel.sound_rms = std::sqrt(channel.samples.squaredNorm() / static_cast<double>(n_frames));
  Eigen::VectorXd added = Eigen::VectorXd::Constant(n_frames, recipe.dc_offset);
  if (recipe.snr_db) {
    channel.noise_rms = channel.sound_rms * std::pow(10.0, -*recipe.snr_db / 20.0);
    RandomStream random = stream(seed.seed, seed.specimen, c, Purpose::kNoise);
    added += channel.noise_rms *
             (recipe.pink ? pink_noise(n_frames, recipe.sample_rate_hz, random) : white_noise(n_frames, random));
  }
  if (recipe.mains_amplitude > 0.0) {
    RandomStream random = stream(seed.seed, seed.specimen, 0, Purpose::kMains);  // the same in every channel
    added += mains_hum(n_frames, recipe.sample_rate_hz, recipe.mains_frequency_hz, recipe.mains_amplitude,
                       recipe.mains_harmonics, random);
  }
  channel.samples += added;
  return channel;
}

DisturbedSound disturbed_sound(const Recipe& recipe, const RecipeSpecimen& specimen, const StruckBody& body,
                               const CleanSound& clean, const RecordingSeed& seed) {
  DisturbedSound sound{clean.samples, json::array(), 0};
  for (std::size_t c = 0; c < body.n_channels; ++c) {
    const auto column = static_cast<Eigen::Index>(c);
    const DisturbedChannel channel = disturbed_channel(recipe, clean.samples.col(column), seed, c);
    sound.samples.col(column) = channel.samples;
    json list = json::array();
    for (const RecordedMode& p : clean.partials) {
      list.push_back(
          {{"amplitude", json_number(std::abs(p.amplitude[c]))}, {"phase_rad", json_number(std::arg(p.amplitude[c]))}});
    }
    sound.channels.push_back({{"at_m", vector_json(body.modes.places_m[body.n_strikes + c])},
                              {"direction", vector_json(specimen.pickups[c].direction.normalized())},
                              {"sound_rms", json_number(channel.sound_rms)},
                              {"noise_rms", json_number(channel.noise_rms)},
                              {"partials", std::move(list)}});
  }
  if (recipe.clip_level) {
    sound.n_clipped = (sound.samples.array().abs() > *recipe.clip_level).count();
    sound.samples = sound.samples.cwiseMax(-*recipe.clip_level).cwiseMin(*recipe.clip_level);
  }
  return sound;
}

json partials_json(const std::vector<RecordedMode>& partials) {
  json list = json::array();
  for (const RecordedMode& p : partials) {
    list.push_back({{"frequency_hz", json_number(p.damped_rad_s / (2.0 * kPi))},
                    {"undamped_frequency_hz", json_number(p.undamped_rad_s / (2.0 * kPi))},
                    {"decay_per_s", json_number(p.decay_per_s)},
                    {"amplitude", json_number(std::abs(p.amplitude[0]))},
                    {"phase_rad", json_number(std::arg(p.amplitude[0]))},
                    {"mode", p.label}});
  }
  return list;
}

json strikes_json(const RecipeSpecimen& specimen, const BodyModes& modes) {
  json list = json::array();
  for (std::size_t s = 0; s < specimen.strikes.size(); ++s) {
    const RecipeStrike& strike = specimen.strikes[s];
    list.push_back({{"time_s", strike.time_s},
                    {"at_m", vector_json(modes.places_m[s])},
                    {"impulse_n_s", vector_json(strike.impulse_n_s)},
                    {"contact_s", strike.contact_s}});
  }
  return list;
}

json modes_json(const BodyModes& modes) {
  json list = json::array();
  for (Eigen::Index m = 0; m < modes.angular_frequency_rad_s.size(); ++m) {
    list.push_back({{"undamped_frequency_hz", json_number(modes.angular_frequency_rad_s[m] / (2.0 * kPi))},
                    {"mode", modes.labels[static_cast<std::size_t>(m)]}});
  }
  return list;
}

json mounts_json(const RecipeSpecimen& specimen, const std::vector<Eigen::Vector3d>& mounts_m) {
  json list = json::array();
  for (std::size_t k = 0; k < specimen.mounts.size(); ++k) {
    list.push_back(
        {{"at_m", vector_json(mounts_m[k])},
         {"direction", specimen.mounts[k].direction ? vector_json(*specimen.mounts[k].direction) : json(nullptr)},
         {"damping_n_s_per_m", specimen.mounts[k].damping_n_s_per_m}});
  }
  return list;
}

}  // namespace

RecipeRecording make_recording(const Recipe& recipe, std::size_t index, std::uint64_t seed, Monitor& monitor) {
  const RecipeSpecimen& specimen = recipe.specimens[index];
  const StruckBody body = strike_body(recipe, specimen, monitor);
  const CleanSound clean = clean_sound(recipe, specimen, body);
  DisturbedSound sound = disturbed_sound(recipe, specimen, body, clean, {seed, index});

  RecipeRecording result;
  result.recording.name = specimen.name;
  result.recording.signal = {std::move(sound.samples), recipe.sample_rate_hz, recipe.name + ", " + specimen.name};
  for (const RecordedMode& p : clean.partials) {
    result.recording.frequency_hz.push_back(p.damped_rad_s / (2.0 * kPi));
    result.recording.decay_per_s.push_back(p.decay_per_s);
    result.recording.amplitude.push_back(std::abs(p.amplitude[0]));
    result.recording.phase_rad.push_back(std::arg(p.amplitude[0]));
  }
  for (const RecipeStrike& strike : specimen.strikes) result.recording.strikes_s.push_back(strike.time_s);
  const std::size_t first_mount = body.n_strikes + body.n_channels;
  for (std::size_t k = 0; k < specimen.mounts.size(); ++k)
    result.mounts_m.push_back(body.modes.places_m[first_mount + k]);
  json mass = nullptr;
  if (specimen.shape.kind != "revolution") mass = mesh::shape_volume_m3(specimen.shape) * recipe.material.density_kg_m3;
  result.truth = {{"name", specimen.name},
                  {"recording", specimen.name + ".wav"},
                  {"shape", shape_json(specimen.shape)},
                  {"mass_kg", mass},
                  {"method", body.modes.method},
                  {"strikes", strikes_json(specimen, body.modes)},
                  {"mounts", mounts_json(specimen, result.mounts_m)},
                  {"partials", partials_json(clean.partials)},
                  {"channels", std::move(sound.channels)},
                  {"modes", modes_json(body.modes)},
                  {"n_clipped_samples", sound.n_clipped}};
  return result;
}

}  // namespace klang::datasets::detail
