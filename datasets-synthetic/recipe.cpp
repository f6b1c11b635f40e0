#include "datasets-synthetic/recipe.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <memory>

#include "core/foundation/base/check.hpp"
#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/json.hpp"
#include "core/foundation/base/output_file.hpp"
#include "core/foundation/base/parallel.hpp"
#include "core/foundation/config/fields_json.hpp"
#include "core/foundation/config/result_header.hpp"
#include "core/geometry/shapes/shape_registry.hpp"
#include "core/sound/audio/nyquist.hpp"
#include "core/sound/stage/modal_voice.hpp"
#include "datasets-synthetic/body_modes.hpp"
#include "datasets-synthetic/disturbances.hpp"
#include "datasets-synthetic/drops.hpp"
#include "datasets-synthetic/recipe_spec.hpp"

namespace klang::datasets {
namespace {

using nlohmann::json;

constexpr double kSilent = 1e-9;  // of the loudest partial: a mode struck or heard on a node line
enum class Purpose : std::uint64_t { kNoise, kRoom, kMains };

// One mode as each channel hears it after the first strike: amplitude exp(-decay t) cos(omega_d t + phase),
// written as Re(amplitude exp(p t)).
struct RingingMode {
  double undamped_rad_s = 0.0, damped_rad_s = 0.0, decay_per_s = 0.0;
  std::vector<std::complex<double>> amplitude;  // a channel each
  std::string label;
};

struct SpecimenRecording {
  SyntheticRecording recording;
  std::vector<Eigen::Vector3d> mounts_m;  // the points that were taken
  json truth;
};

RandomStream stream(std::uint64_t seed, std::size_t specimen, std::size_t channel, Purpose purpose) {
  return {seed, (specimen << 16) | (channel << 4) | static_cast<std::uint64_t>(purpose)};
}

json vector_json(const Eigen::Vector3d& v) { return {json_number(v[0]), json_number(v[1]), json_number(v[2])}; }

// Modes with equal frequencies (closer than a thousandth of their width) are one partial.
std::vector<RingingMode> partials_of(std::vector<RingingMode> modes) {
  std::sort(modes.begin(), modes.end(),
            [](const RingingMode& a, const RingingMode& b) { return a.damped_rad_s < b.damped_rad_s; });
  std::vector<RingingMode> partials;
  for (RingingMode& mode : modes) {
    if (!partials.empty() && mode.damped_rad_s - partials.back().damped_rad_s <= 1e-3 * mode.decay_per_s) {
      for (std::size_t c = 0; c < mode.amplitude.size(); ++c) partials.back().amplitude[c] += mode.amplitude[c];
    } else {
      partials.push_back(std::move(mode));
    }
  }
  double loudest = 0.0;
  const auto loudness = [](const RingingMode& m) {
    double top = 0.0;
    for (const auto& a : m.amplitude) top = std::max(top, std::abs(a));
    return top;
  };
  for (const RingingMode& partial : partials) loudest = std::max(loudest, loudness(partial));
  std::erase_if(partials, [&](const RingingMode& m) { return !(loudness(m) > kSilent * loudest); });
  return partials;
}

json shape_json(const mesh::ShapeSpec& shape) {
  json value = {{"kind", shape.kind}};
  for (const auto& [name, metres] : shape.dims) value[name] = metres;
  if (!shape.profile_csv.empty()) value["profile_csv"] = shape.profile_csv.filename().string();
  return value;
}

// A specimen that is struck and heard. It refers to itself and does not move.
struct SpecimenSound {
  BodyModes modes;
  stage::RingingBody ringing;
  events::EventLog log;
  double highest_hz = 0.0;
};

// Mass-normalised: decay by the material and by the mounts, c |u|^2 / 2 each.
double decay_of(const Recipe& recipe, const RecipeSpecimen& specimen, const BodyModes& modes, Eigen::Index m) {
  double decay = recipe.decay_per_s(modes.angular_frequency_rad_s[m]);
  for (std::size_t k = 0; k < specimen.mounts.size(); ++k) {
    const RecipeMount& mount = specimen.mounts[k];
    const Eigen::Vector3d shape = modes.shapes[specimen.strikes.size() + specimen.pickups.size() + k].col(m);
    const double seen = mount.direction ? shape.dot(mount.direction->normalized()) : shape.norm();
    decay += 0.5 * mount.damping_n_s_per_m * seen * seen;
  }
  return decay;
}

// A body that is known at the places of its recipe only.
stage::ModalPush push_at_known_places(const BodyModes& modes) {
  return [&modes](const Eigen::Vector3d& point_m, const Eigen::Vector3d& impulse_n_s) {
    const auto place = std::find(modes.places_m.begin(), modes.places_m.end(), point_m);
    KLANG_CHECK(place != modes.places_m.end(), "a strike at a place of the recipe");
    const Eigen::MatrixXd& shapes = modes.shapes[static_cast<std::size_t>(place - modes.places_m.begin())];
    Eigen::VectorXd push(shapes.cols());
    for (Eigen::Index m = 0; m < push.size(); ++m) push[m] = shapes.col(m).dot(impulse_n_s);
    return push;
  };
}

// Modes, how the pickups hear them (the velocity of a point: displacement times frequency), and the strikes.
std::unique_ptr<SpecimenSound> specimen_sound(const Recipe& recipe, const RecipeSpecimen& specimen, Monitor& monitor) {
  auto sound = std::make_unique<SpecimenSound>();
  std::vector<Eigen::Vector3d> places;
  for (const RecipeStrike& strike : specimen.strikes) places.push_back(strike.at);
  for (const RecipePickup& pickup : specimen.pickups) places.push_back(pickup.at);
  for (const RecipeMount& mount : specimen.mounts) places.push_back(mount.at);
  sound->highest_hz = std::min(recipe.highest_hz, audio::highest_rendered_hz(recipe.sample_rate_hz));
  BodyModes& modes = sound->modes;
  modes = body_modes(specimen.shape, recipe.material, specimen.support, sound->highest_hz, places, monitor);
  split_pairs(modes, recipe.split_detuning, recipe.split_detuning > 0.0 ? recipe.split_angle_rad : 0.0);

  const Eigen::Index n_modes = modes.angular_frequency_rad_s.size();
  const std::size_t n_channels = specimen.pickups.size();
  stage::RingingBody& ringing = sound->ringing;
  ringing.heard = stage::Heard::kMotion;  // exactly exponentials once the blow is over
  ringing.angular_frequency_rad_s = modes.angular_frequency_rad_s;
  ringing.decay_per_s.resize(n_modes);
  for (Eigen::Index m = 0; m < n_modes; ++m) ringing.decay_per_s[m] = decay_of(recipe, specimen, modes, m);
  ringing.gain.resize(n_modes, static_cast<Eigen::Index>(n_channels));
  for (std::size_t c = 0; c < n_channels; ++c) {
    const Eigen::Vector3d direction = specimen.pickups[c].direction.normalized();
    for (Eigen::Index m = 0; m < n_modes; ++m) {
      ringing.gain(m, static_cast<Eigen::Index>(c)) = modes.shapes[specimen.strikes.size() + c].col(m).dot(direction) *
                                                      modes.angular_frequency_rad_s[m] / (2.0 * kPi);
    }
  }
  ringing.push = push_at_known_places(modes);
  std::vector<events::Strike> strikes;
  for (std::size_t s = 0; s < specimen.strikes.size(); ++s) {
    events::Strike strike;
    strike.time_s = specimen.strikes[s].time_s;
    strike.duration_s = specimen.strikes[s].contact_s;
    strike.shape = events::PulseShape::kGaussian;
    strike.point_m = modes.places_m[s];
    strike.impulse_n_s = specimen.strikes[s].impulse_n_s;
    strikes.push_back(strike);
  }
  sound->log = stage::log_of(std::move(strikes));
  return sound;
}

// The modes that ring (an over-damped one is a thud, no partial) after the first strike.
std::vector<RingingMode> ringing_modes(const SpecimenSound& sound) {
  const stage::RingingBody& ringing = sound.ringing;
  const events::Impulse& first = sound.log.impulses.front();
  const Eigen::VectorXd push = ringing.push(first.point_m, first.impulse_n_s);
  std::vector<RingingMode> modes;
  for (Eigen::Index m = 0; m < push.size(); ++m) {
    const double omega = ringing.angular_frequency_rad_s[m], decay = ringing.decay_per_s[m];
    if (!(decay < omega)) continue;
    RingingMode mode{omega,
                     std::sqrt((omega - decay) * (omega + decay)),
                     decay,
                     {},
                     sound.modes.labels[static_cast<std::size_t>(m)]};
    const std::complex<double> pole(-decay, mode.damped_rad_s);
    const double contact = first.duration_s;
    const std::complex<double> start =
        push[m] / mode.damped_rad_s * std::exp(0.5 * contact * contact * pole * pole) * std::complex<double>(0, -1);
    mode.amplitude.assign(static_cast<std::size_t>(ringing.gain.cols()), start);
    for (std::size_t c = 0; c < mode.amplitude.size(); ++c)
      mode.amplitude[c] *= ringing.gain(m, static_cast<Eigen::Index>(c));
    modes.push_back(std::move(mode));
  }
  return modes;
}

// Adds the room's tail, noise, hum and offset to a channel. @return what truth.json says of the channel's levels
json disturb(const Recipe& recipe, std::size_t specimen, std::size_t c, std::uint64_t seed,
             const Eigen::MatrixXd& clean, Eigen::Ref<Eigen::VectorXd> channel) {
  const Eigen::Index n_frames = channel.size();
  if (recipe.room_rt60_s) {
    RandomStream random = stream(seed, specimen, c, Purpose::kRoom);
    channel += room_tail(clean.col(static_cast<Eigen::Index>(c)), recipe.sample_rate_hz, *recipe.room_rt60_s,
                         recipe.room_level_db, random);
  }
  const double rms = std::sqrt(channel.squaredNorm() / static_cast<double>(n_frames));
  double noise_rms = 0.0;
  Eigen::VectorXd added = Eigen::VectorXd::Constant(n_frames, recipe.dc_offset);
  if (recipe.snr_db) {
    noise_rms = rms * std::pow(10.0, -*recipe.snr_db / 20.0);
    RandomStream random = stream(seed, specimen, c, Purpose::kNoise);
    added +=
        noise_rms * (recipe.pink ? pink_noise(n_frames, recipe.sample_rate_hz, random) : white_noise(n_frames, random));
  }
  if (recipe.mains_amplitude > 0.0) {
    RandomStream random = stream(seed, specimen, 0, Purpose::kMains);  // the same in every channel
    added += mains_hum(n_frames, recipe.sample_rate_hz, recipe.mains_frequency_hz, recipe.mains_amplitude,
                       recipe.mains_harmonics, random);
  }
  channel += added;
  return {{"sound_rms", json_number(rms)}, {"noise_rms", json_number(noise_rms)}};
}

// Partials, strikes, mounts and modes as truth.json and the recording know them.
void add_truth(const Recipe& recipe, const RecipeSpecimen& specimen, const BodyModes& modes,
               const std::vector<RingingMode>& partials, SpecimenRecording& result) {
  const std::size_t n_strikes = specimen.strikes.size(), n_channels = specimen.pickups.size();
  const Eigen::Index n_modes = modes.angular_frequency_rad_s.size();
  json partial_list = json::array(), strikes = json::array(), mode_list = json::array();
  for (const RingingMode& p : partials) {
    result.recording.frequency_hz.push_back(p.damped_rad_s / (2.0 * kPi));
    result.recording.decay_per_s.push_back(p.decay_per_s);
    result.recording.amplitude.push_back(std::abs(p.amplitude[0]));
    result.recording.phase_rad.push_back(std::arg(p.amplitude[0]));
    partial_list.push_back({{"frequency_hz", json_number(p.damped_rad_s / (2.0 * kPi))},
                            {"undamped_frequency_hz", json_number(p.undamped_rad_s / (2.0 * kPi))},
                            {"decay_per_s", json_number(p.decay_per_s)},
                            {"amplitude", json_number(std::abs(p.amplitude[0]))},
                            {"phase_rad", json_number(std::arg(p.amplitude[0]))},
                            {"mode", p.label}});
  }
  for (std::size_t s = 0; s < n_strikes; ++s) {
    const RecipeStrike& strike = specimen.strikes[s];
    result.recording.strikes_s.push_back(strike.time_s);
    strikes.push_back({{"time_s", strike.time_s},
                       {"at_m", vector_json(modes.places_m[s])},
                       {"impulse_n_s", vector_json(strike.impulse_n_s)},
                       {"contact_s", strike.contact_s}});
  }
  for (Eigen::Index m = 0; m < n_modes; ++m) {
    mode_list.push_back({{"undamped_frequency_hz", json_number(modes.angular_frequency_rad_s[m] / (2.0 * kPi))},
                         {"mode", modes.labels[static_cast<std::size_t>(m)]}});
  }
  json mounts = json::array();
  for (std::size_t k = 0; k < specimen.mounts.size(); ++k) {
    result.mounts_m.push_back(modes.places_m[n_strikes + n_channels + k]);
    mounts.push_back(
        {{"at_m", vector_json(result.mounts_m.back())},
         {"direction", specimen.mounts[k].direction ? vector_json(*specimen.mounts[k].direction) : json(nullptr)},
         {"damping_n_s_per_m", specimen.mounts[k].damping_n_s_per_m}});
  }
  json mass = nullptr;
  if (!mesh::find_shape(specimen.shape.kind).facts().has_profile)
    mass = mesh::shape_volume_m3(specimen.shape) * recipe.material.density_kg_m3;
  result.truth = {{"name", specimen.name},
                  {"recording", specimen.name + ".wav"},
                  {"shape", shape_json(specimen.shape)},
                  {"mass_kg", mass},
                  {"method", modes.method},
                  {"strikes", std::move(strikes)},
                  {"mounts", std::move(mounts)},
                  {"partials", std::move(partial_list)},
                  {"modes", std::move(mode_list)}};
}

SpecimenRecording make_recording(const Recipe& recipe, std::size_t index, std::uint64_t seed, Monitor& monitor) {
  const RecipeSpecimen& specimen = recipe.specimens[index];
  const std::size_t n_channels = specimen.pickups.size(), n_strikes = specimen.strikes.size();
  const std::unique_ptr<const SpecimenSound> body = specimen_sound(recipe, specimen, monitor);
  stage::ModalVoice voice(0, body->ringing);
  stage::Voice* const voices[] = {&voice};
  Eigen::MatrixXd clean = stage::render(body->log, voices, stage::Listener::without_place(static_cast<int>(n_channels)),
                                        {recipe.sample_rate_hz, recipe.duration_s}, monitor)
                              .samples;
  const double top = clean.size() > 0 ? clean.cwiseAbs().maxCoeff() : 0.0;
  if (!(top > 0.0)) {
    throw InputError(recipe.name + ", " + specimen.name, "is silent: nothing is struck or heard in the band",
                     std::to_string(body->modes.angular_frequency_rad_s.size()) + " modes up to " +
                         to_text(body->highest_hz) + " Hz");
  }
  const double scale = recipe.peak / top;
  clean *= scale;
  std::vector<RingingMode> ringing = ringing_modes(*body);
  for (RingingMode& mode : ringing) {
    for (auto& a : mode.amplitude) a *= scale;
  }
  const std::vector<RingingMode> partials = partials_of(std::move(ringing));

  SpecimenRecording result;
  Eigen::MatrixXd sound = clean;
  json channels = json::array();
  for (std::size_t c = 0; c < n_channels; ++c) {
    json channel = disturb(recipe, index, c, seed, clean, sound.col(static_cast<Eigen::Index>(c)));
    json list = json::array();
    for (const RingingMode& p : partials) {
      list.push_back(
          {{"amplitude", json_number(std::abs(p.amplitude[c]))}, {"phase_rad", json_number(std::arg(p.amplitude[c]))}});
    }
    channel["at_m"] = vector_json(body->modes.places_m[n_strikes + c]);
    channel["direction"] = vector_json(specimen.pickups[c].direction.normalized());
    channel["partials"] = std::move(list);
    channels.push_back(std::move(channel));
  }
  long n_clipped = 0;
  if (recipe.clip_level) {
    n_clipped = (sound.array().abs() > *recipe.clip_level).count();
    sound = sound.cwiseMax(-*recipe.clip_level).cwiseMin(*recipe.clip_level);
  }
  result.recording.name = specimen.name;
  result.recording.signal = {std::move(sound), recipe.sample_rate_hz, recipe.name + ", " + specimen.name};
  add_truth(recipe, specimen, body->modes, partials, result);
  result.truth["channels"] = std::move(channels);
  result.truth["n_clipped_samples"] = n_clipped;
  return result;
}

json truth_header(const Recipe& recipe, std::string_view toml, std::uint64_t seed) {
  const solid::Material& m = recipe.material;
  const Provenance provenance = make_provenance("dataset " + recipe.name, seed, {{"recipe_toml", toml}}, {});
  json damping = {{"model", recipe.damping->name()}};
  const auto parameters = recipe.damping->parameters();
  for (std::size_t i = 0; i < parameters.size(); ++i)
    damping[std::string(parameters[i].name)] = recipe.damping_parameters[i];
  return {{"schema_version", 1},
          {"kind", "dataset"},
          {"status", "made"},
          {"name", recipe.name},
          {"provenance", json_of(provenance)},
          {"material",
           {{"lame_lambda_pa", m.lame_lambda_pa},
            {"lame_mu_pa", m.lame_mu_pa},
            {"youngs_modulus_pa", m.youngs_modulus_pa()},
            {"poissons_ratio", m.poissons_ratio()},
            {"density_kg_m3", m.density_kg_m3}}},
          {"damping", std::move(damping)},
          {"sample_rate_hz", recipe.sample_rate_hz},
          {"duration_s", recipe.duration_s},
          {"snr_db", json_number(recipe.snr_db)},
          {"noise_colour", recipe.pink ? "pink" : "white"},
          {"mains",
           {{"frequency_hz", recipe.mains_frequency_hz},
            {"amplitude", recipe.mains_amplitude},
            {"harmonics", recipe.mains_harmonics}}},
          {"room", {{"rt60_s", json_number(recipe.room_rt60_s)}, {"level_db", recipe.room_level_db}}},
          {"split_pairs", {{"relative_detuning", recipe.split_detuning}, {"angle_rad", recipe.split_angle_rad}}},
          {"dc_offset", recipe.dc_offset},
          {"clip_level", json_number(recipe.clip_level)}};
}

// A number that TOML reads as one with a fraction.
std::string toml_number(double value) {
  std::string text = to_text(value);
  if (text.find_first_of(".e") == std::string::npos) text += ".0";
  return text;
}

/// The profile goes with the recordings, so that the specimen made of them reads it.
std::string profile_copy_of(const RecipeSpecimen& specimen) { return specimen.name + "-profile.csv"; }

std::string specimen_toml_of(const Recipe& recipe, const std::vector<std::vector<Eigen::Vector3d>>& mounts_m) {
  const solid::Material& m = recipe.material;
  const double poisson = recipe.start_poissons_ratio.value_or(m.poissons_ratio());
  std::string quoted;
  for (char c : recipe.name) {
    if (static_cast<unsigned char>(c) >= 0x20 && c != '"' && c != '\\' && c != 0x7f) quoted += c;
  }
  std::string text =
      "# Made with the recordings beside it; the material is a starting guess.\nname = \"" + quoted + "\"\n\n";
  text += "[material]\nyoungs_modulus_pa = " + toml_number(m.youngs_modulus_pa() * recipe.start_youngs_factor) + "\n";
  text += "poissons_ratio = " + toml_number(poisson) + "\ndensity_kg_m3 = " + toml_number(m.density_kg_m3) + "\n";
  for (std::size_t s = 0; s < recipe.specimens.size(); ++s) {
    const RecipeSpecimen& specimen = recipe.specimens[s];
    text += "\n[[specimen]]\nname = \"" + specimen.name + "\"\nshape = { kind = \"" + specimen.shape.kind + "\"";
    for (const auto& [name, metres] : specimen.shape.dims) text += ", " + name + " = " + toml_number(metres);
    if (!specimen.shape.profile_csv.empty()) text += ", profile_csv = '" + profile_copy_of(specimen) + "'";
    text += " }\n";
    if (specimen.support.kind != solid::SupportKind::kFree) {
      text += "support = { kind = \"";
      text += specimen.support.kind == solid::SupportKind::kClamped ? "clamped" : "pinned";
      text += "\", where = '" + specimen.support.where + "' }\n";
    }
    text += "recording = \"" + specimen.name + ".wav\"\n";
    if (specimen.predict) text += "predict = true\n";
    for (std::size_t k = 0; k < specimen.mounts.size(); ++k) {
      const auto list = [](const Eigen::Vector3d& v) {
        return "[" + toml_number(v[0]) + ", " + toml_number(v[1]) + ", " + toml_number(v[2]) + "]";
      };
      const RecipeMount& mount = specimen.mounts[k];
      text += (k > 0 ? ", { at_m = " : "mount = [{ at_m = ") + list(mounts_m[s][k]);
      if (mount.direction) text += ", direction = " + list(*mount.direction);
      text += k + 1 < specimen.mounts.size() ? " }" : " }]\n";
    }
  }
  if (!recipe.fit_parameters.empty()) {
    text += "\n[fit]\nparameters = [";
    for (std::size_t i = 0; i < recipe.fit_parameters.size(); ++i) {
      text += (i > 0 ? ", \"" : "\"") + recipe.fit_parameters[i] + "\"";
    }
    text += "]\n";
  }
  return text;
}

Dataset made_dataset(std::string_view toml, const std::string& name, const std::filesystem::path& base,
                     std::uint64_t seed, Monitor& monitor) {
  if (is_drop_recipe(toml)) return make_drops(toml, name, seed, monitor);
  const Recipe recipe = parse_recipe(toml, name, base);
  std::vector<SpecimenRecording> recordings(recipe.specimens.size());
  for_each_job(
      recordings.size(), [&](std::size_t i) { recordings[i] = make_recording(recipe, i, seed, monitor); },
      "synthetic recordings", monitor);
  Dataset dataset;
  json truth = truth_header(recipe, toml, seed);
  truth["specimens"] = json::array();
  std::vector<std::vector<Eigen::Vector3d>> mounts_m;
  for (SpecimenRecording& one : recordings) {
    mounts_m.push_back(std::move(one.mounts_m));
    dataset.recordings.push_back(std::move(one.recording));
    truth["specimens"].push_back(std::move(one.truth));
  }
  dataset.truth_json = json_text(truth);
  for (const RecipeSpecimen& specimen : recipe.specimens)
    if (!specimen.shape.profile_csv.empty())
      dataset.files.emplace_back(profile_copy_of(specimen),
                                 read_file(specimen.shape.profile_csv, std::size_t{1} << 24));
  dataset.specimen_toml = specimen_toml_of(recipe, mounts_m);
  return dataset;
}

}  // namespace

Dataset make_dataset(const std::filesystem::path& recipe_toml, std::uint64_t seed, Monitor& monitor) {
  const std::string text = read_file(recipe_toml, std::size_t{1} << 20);
  return made_dataset(text, recipe_toml.filename().string(), recipe_toml.parent_path(), seed, monitor);
}

Dataset make_dataset_from_text(std::string_view toml, const std::string& name, std::uint64_t seed, Monitor& monitor) {
  return made_dataset(toml, name, {}, seed, monitor);
}

}  // namespace klang::datasets
