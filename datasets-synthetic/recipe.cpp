#include "datasets-synthetic/recipe.hpp"

#include <algorithm>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/json.hpp"
#include "core/foundation/base/output_file.hpp"
#include "core/foundation/base/parallel.hpp"
#include "core/foundation/base/provenance.hpp"
#include "datasets-synthetic/detail/recipe_recording.hpp"
#include "datasets-synthetic/drops.hpp"
#include "datasets-synthetic/recipe_spec.hpp"

namespace klang::datasets {
namespace {

using nlohmann::json;

json truth_header(const Recipe& recipe, std::string_view toml, std::uint64_t seed) {
  const solid::Material& m = recipe.material;
  Provenance provenance;
  provenance.command = "dataset " + recipe.name;
  provenance.seed = seed;
  provenance.options_json = json{{"recipe_toml", toml}}.dump();
  json damping = {{"model", recipe.damping->name()}};
  const auto parameters = recipe.damping->parameters();
  for (std::size_t i = 0; i < parameters.size(); ++i)
    damping[std::string(parameters[i].name)] = recipe.damping_parameters[i];
  return {{"schema_version", 1},
          {"kind", "dataset"},
          {"status", "made"},
          {"name", recipe.name},
          {"provenance", to_json(provenance)},
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
    if (!specimen.shape.profile_csv.empty()) text += ", profile_csv = '" + specimen.shape.profile_csv.string() + "'";
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
  std::vector<detail::RecipeRecording> made(recipe.specimens.size());
  for_each_job(
      made.size(), [&](std::size_t i) { made[i] = detail::make_recording(recipe, i, seed, monitor); },
      "synthetic recordings", monitor);
  Dataset dataset;
  json truth = truth_header(recipe, toml, seed);
  truth["specimens"] = json::array();
  std::vector<std::vector<Eigen::Vector3d>> mounts_m;
  for (detail::RecipeRecording& one : made) {
    mounts_m.push_back(std::move(one.mounts_m));
    dataset.recordings.push_back(std::move(one.recording));
    truth["specimens"].push_back(std::move(one.truth));
  }
  dataset.truth_json = json_text(truth);
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
