#include "fit/run/fit_json.hpp"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/json.hpp"
#include "core/geometry/mesh/quality.hpp"
#include "core/physics/modal/damping/damping_laws.hpp"

namespace klang::fit {
namespace {

using nlohmann::json;

json of(const FitParameter& parameter) {
  json value = {{"name", parameter.name},
                {"value", json_number(parameter.value)},
                {"std", json_number(parameter.std)},
                {"ci95", nullptr},
                {"identifiable", parameter.identifiable},
                {"why", parameter.why},
                {"start_value", json_number(parameter.start_value)},
                {"derived", parameter.derived}};
  if (parameter.ci95) value["ci95"] = {json_number((*parameter.ci95)[0]), json_number((*parameter.ci95)[1])};
  return value;
}

json of(const DampingCandidate& candidate, double low_hz, double high_hz) {
  json parameters = json::array(), frequency = json::array(), decay = json::array();
  for (const FitParameter& parameter : candidate.parameters) parameters.push_back(of(parameter));
  constexpr int kPoints = 100;
  for (int i = 0; i < kPoints && high_hz > low_hz; ++i) {
    const double f = low_hz * std::pow(high_hz / low_hz, i / (kPoints - 1.0));
    frequency.push_back(f);
    decay.push_back(json_number(candidate.decay_per_s(2.0 * kPi * f)));
  }
  return {{"model", candidate.model},
          {"parameters", parameters},
          {"aicc", json_number(candidate.aicc)},
          {"aicc_weight", json_number(candidate.aicc_weight)},
          {"rms_relative_residual", json_number(candidate.rms_relative_residual)},
          {"curve", {{"frequency_hz", frequency}, {"decay_per_s", decay}}}};
}

json of(const Partial& partial, int mode) {
  return {{"frequency_hz", json_number(partial.frequency_hz)},
          {"frequency_std_hz", json_number(partial.frequency_std_hz)},
          {"decay_per_s", json_number(partial.decay_per_s)},
          {"decay_std_per_s", json_number(partial.decay_std_per_s)},
          {"amplitude", json_number(partial.amplitude)},
          {"amplitude_std", json_number(partial.amplitude_std)},
          {"phase_rad", json_number(partial.phase_rad)},
          {"phase_std_rad", json_number(partial.phase_std_rad)},
          {"matched_mode", mode < 0 ? json(nullptr) : json(mode)}};
}

/// The dimensions after the fit: those given, with fitted ones replaced.
json shape_of(const Specimen& specimen, const std::vector<FitParameter>& parameters) {
  if (!specimen.shape) return {{"mesh", specimen.mesh_file ? specimen.mesh_file->filename().string() : ""}};
  json shape = {{"kind", specimen.shape->kind}};
  for (const auto& [name, value] : specimen.shape->dims) {
    shape[name] = value;
    for (const FitParameter& parameter : parameters) {
      if (parameter.name == specimen.name + "." + name) shape[name] = json_number(parameter.value);
    }
  }
  if (!specimen.shape->profile_csv.empty()) shape["profile_csv"] = specimen.shape->profile_csv.filename().string();
  return shape;
}

}  // namespace

std::string file_stem(const std::string& specimen_name) {
  std::string stem = specimen_name;
  for (char& c : stem) {
    const bool plain =
        (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' || c == '_';
    if (!plain) c = '_';
  }
  return stem;
}

json fit_json(const FitProblem& problem, const FitResult& result, const Provenance& provenance) {
  json root = {{"schema_version", 1},
               {"kind", "fit"},
               {"name", problem.name},
               {"material",
                {{"preset", problem.material.name.empty() ? json(nullptr) : json(problem.material.name)},
                 {"lame_lambda_pa", problem.material.lame_lambda_pa},
                 {"lame_mu_pa", problem.material.lame_mu_pa},
                 {"density_kg_m3", problem.material.density_kg_m3},
                 {"source", problem.material.source}}},
               {"status", to_text(result.status)},
               {"message", result.message},
               {"provenance", to_json(provenance)},
               {"warnings", result.warnings},
               {"wall_time_s", result.wall_time_s},
               {"cost_initial", json_number(result.cost_initial)},
               {"cost_final", json_number(result.cost_final)},
               {"n_iterations", result.n_iterations}};
  json& parameters = root["parameters"] = json::array();
  json names = json::array();
  for (const FitParameter& parameter : result.parameters) {
    parameters.push_back(of(parameter));
    const bool elastic = !damping::is_law_parameter(parameter.name);
    if (parameter.identifiable && !parameter.derived && elastic) names.push_back(parameter.name);
  }
  root["correlation"] = {{"names", names}, {"matrix", result.correlation}};

  double low_hz = 1e300, high_hz = 0.0;
  for (const PartialMatch& match : result.matches) {
    low_hz = std::min(low_hz, match.frequency_hz);
    high_hz = std::max(high_hz, match.frequency_hz);
  }
  json candidates = json::array();
  for (const DampingCandidate& candidate : result.damping.candidates) {
    candidates.push_back(of(candidate, 0.7 * low_hz, 1.4 * high_hz));
  }
  root["damping"] = {{"model", result.damping.model}, {"candidates", candidates}};

  json& matches = root["matches"] = json::array();
  for (const PartialMatch& match : result.matches) {
    matches.push_back({{"specimen", result.specimens[static_cast<std::size_t>(match.specimen)].name},
                       {"frequency_hz", json_number(match.frequency_hz)},
                       {"frequency_std_hz", json_number(match.frequency_std_hz)},
                       {"mode_index", match.mode},
                       {"model_frequency_hz", json_number(match.model_frequency_hz)},
                       {"deviation_cents", json_number(match.deviation_cents)},
                       {"decay_per_s", json_number(match.decay_per_s)},
                       {"decay_std_per_s", json_number(match.decay_std_per_s)},
                       {"radiation_decay_per_s", json_number(match.radiation_decay_per_s)},
                       {"mount_decay_per_kg", json_number(match.mount_decay_per_kg)},
                       {"model_frequency_std_hz", json_number(match.model_frequency_std_hz)},
                       {"model_decay_per_s", json_number(match.model_decay_per_s)}});
  }
  json& predicted = root["predicted"] = json::array();
  json& specimens = root["specimens"] = json::array();
  for (std::size_t s = 0; s < result.specimens.size(); ++s) {
    const SpecimenResult& specimen = result.specimens[s];
    for (std::size_t k = 0; k < specimen.predicted_frequency_hz.size(); ++k) {
      const double decay = k < specimen.predicted_decay_per_s.size() ? specimen.predicted_decay_per_s[k] : 0.0;
      predicted.push_back(
          {{"specimen", specimen.name},
           {"mode_index", k},
           {"frequency_hz", json_number(specimen.predicted_frequency_hz[k])},
           {"mesh_relative_error", json_number(specimen.mesh_relative_error[static_cast<Eigen::Index>(k)])},
           {"decay_per_s", decay > 0.0 ? json_number(decay) : json(nullptr)}});
    }
    std::vector<int> modes(specimen.partials.partials.size(), -1);
    for (const PartialMatch& match : result.matches) {
      if (match.specimen == static_cast<int>(s)) modes[static_cast<std::size_t>(match.partial)] = match.mode;
    }
    json partials = json::array();
    for (std::size_t i = 0; i < modes.size(); ++i) partials.push_back(of(specimen.partials.partials[i], modes[i]));
    const std::string stem = file_stem(specimen.name);
    const auto file = [&](bool there, const std::string& name) { return there ? json(name) : json(nullptr); };
    const mesh::TetMesh& mesh = specimen.model.mesh;
    const bool solved = mesh.n_elements() > 0;
    specimens.push_back(
        {{"name", specimen.name},
         {"predicted", specimen.predicted},
         {"shape", shape_of(problem.specimens[s], result.parameters)},
         {"mass_kg",
          solved ? json_number(mesh::mesh_volume_m3(mesh) * specimen.model.material.density_kg_m3) : json(nullptr)},
         {"n_nodes", mesh.n_nodes()},
         {"n_elements", mesh.n_elements()},
         {"none_missing", specimen.none_missing},
         {"rms_deviation_cents", json_number(specimen.rms_deviation_cents)},
         {"max_deviation_cents", json_number(specimen.max_deviation_cents)},
         {"partials", partials},
         {"strikes_s", specimen.ringdown.strikes_s},
         {"explained_energy", json_number(specimen.ringdown.explained_energy)},
         {"files",
          {{"recording", file(specimen.recorded.n_frames() > 0, "recording-" + stem + ".wav")},
           {"resynthesis", file(specimen.fitted.n_frames() > 0, "resynthesis-" + stem + ".wav")},
           {"modes", file(solved, "modes-" + stem + ".vtu")}}}});
  }
  return root;
}

json tune_json(const TuneResult& result, const Provenance& provenance) {
  json dimensions = json::array(), targets = json::array();
  for (const TunedDimension& dimension : result.dimensions) {
    dimensions.push_back({{"name", dimension.name},
                          {"start_m", json_number(dimension.start_m)},
                          {"value_m", json_number(dimension.value_m)},
                          {"low_m", json_number(dimension.low_m)},
                          {"high_m", json_number(dimension.high_m)},
                          {"at_bound", dimension.at_bound}});
  }
  for (const TunedTarget& target : result.targets) {
    json hz = json::object(), cents_per_tenth = json::object();
    for (std::size_t d = 0; d < result.dimensions.size(); ++d) {
      hz[result.dimensions[d].name] = json_number(target.hz_per_mm[d]);
      cents_per_tenth[result.dimensions[d].name] = json_number(target.cents_per_tenth_mm[d]);
    }
    targets.push_back({{"mode", target.mode},
                       {"mode_index", target.mode_index},
                       {"wanted_hz", json_number(target.wanted_hz)},
                       {"start_hz", json_number(target.start_hz)},
                       {"reached_hz", json_number(target.reached_hz)},
                       {"residual_cents", json_number(target.residual_cents)},
                       {"hz_per_mm", hz},
                       {"cents_per_tenth_mm", cents_per_tenth}});
  }
  return {{"schema_version", 1},
          {"kind", "tune"},
          {"status", to_text(result.status)},
          {"message", result.message},
          {"provenance", to_json(provenance)},
          {"warnings", json::array()},
          {"wall_time_s", result.wall_time_s},
          {"dimensions", dimensions},
          {"targets", targets},
          {"n_rounds", result.n_rounds}};
}

}  // namespace klang::fit
