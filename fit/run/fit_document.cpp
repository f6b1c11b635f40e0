#include "fit/run/fit_document.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "core/foundation/base/checked_index.hpp"
#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/json.hpp"
#include "core/geometry/mesh/quality.hpp"
#include "core/physics/modal/damping/damping_laws.hpp"
#include "core/sound/audio/note.hpp"
#include "fit/ringdown/partial_pairs.hpp"

namespace klang::fit {
namespace {

using nlohmann::json;

constexpr int kCurvePoints = 100;

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

/// Of the material alone, from a little below the lowest matched partial to a little above the highest.
CurveRecord curve_of(const DampingCandidate& candidate, double low_hz, double high_hz) {
  CurveRecord curve;
  for (int i = 0; i < kCurvePoints && high_hz > low_hz; ++i) {
    curve.frequency_hz.push_back(low_hz * std::pow(high_hz / low_hz, i / (kCurvePoints - 1.0)));
    curve.decay_per_s.push_back(candidate.decay_per_s(2.0 * kPi * curve.frequency_hz.back()));
  }
  return curve;
}

DampingRecords damping_records(const FitResult& result) {
  double low_hz = 1e300, high_hz = 0.0;
  for (const PartialMatch& match : result.matches) {
    low_hz = std::min(low_hz, match.frequency_hz);
    high_hz = std::max(high_hz, match.frequency_hz);
  }
  DampingRecords records{result.damping.model, {}};
  for (const DampingCandidate& c : result.damping.candidates)
    records.candidates.push_back({c.model, c.parameters, c.aicc, c.aicc_weight, c.rms_relative_residual,
                                  curve_of(c, 0.7 * low_hz, 1.4 * high_hz)});
  return records;
}

MatchRecord match_record(const PartialMatch& match, const std::string& specimen) {
  MatchRecord record;
  record.specimen = specimen;
  record.mode_index = match.mode;
  record.frequency_hz = match.frequency_hz;
  record.frequency_std_hz = match.frequency_std_hz;
  record.model_frequency_hz = match.model_frequency_hz;
  record.deviation_cents = match.deviation_cents;
  record.decay_per_s = match.decay_per_s;
  record.decay_std_per_s = match.decay_std_per_s;
  record.model_decay_per_s = match.model_decay_per_s;
  record.radiation_decay_per_s = match.radiation_decay_per_s;
  record.mount_decay_per_kg = match.mount_decay_per_kg;
  record.model_frequency_std_hz = match.model_frequency_std_hz;
  return record;
}

void add_predicted(const SpecimenResult& specimen, std::vector<PredictedRecord>& records) {
  for (std::size_t k = 0; k < specimen.predicted_frequency_hz.size(); ++k) {
    const double decay = k < specimen.predicted_decay_per_s.size() ? specimen.predicted_decay_per_s[k] : 0.0;
    records.push_back({specimen.name, static_cast<int>(k), specimen.predicted_frequency_hz[k],
                       specimen.mesh_relative_error[static_cast<Eigen::Index>(k)],
                       decay > 0.0 ? std::optional(decay) : std::nullopt});
  }
}

std::vector<PartialRecord> partial_records(const FitResult& result, std::size_t s) {
  std::vector<PartialRecord> records;
  std::vector<Partial> partials = result.specimens[s].partials.partials;
  name_notes(partials, audio::kConcertPitchHz);
  name_pairs(partials);
  for (const Partial& partial : partials) records.push_back({partial, {}});
  for (const PartialMatch& match : result.matches) {
    if (match.specimen == static_cast<int>(s) && match.mode >= 0)
      item(records, match.partial).matched_mode = match.mode;
  }
  return records;
}

SpecimenFiles files_of(const SpecimenResult& specimen) {
  const std::string stem = file_stem(specimen.name);
  SpecimenFiles files;
  if (specimen.recorded.n_frames() > 0) files.recording = "recording-" + stem + ".wav";
  if (specimen.fitted.n_frames() > 0) files.resynthesis = "resynthesis-" + stem + ".wav";
  if (specimen.model.mesh.n_elements() > 0) files.modes = "modes-" + stem + ".vtu";
  return files;
}

SpecimenRecord specimen_record(const FitProblem& problem, const FitResult& result, std::size_t s) {
  const SpecimenResult& specimen = result.specimens[s];
  const mesh::TetMesh& mesh = specimen.model.mesh;
  SpecimenRecord record;
  record.name = specimen.name;
  record.predicted = specimen.predicted;
  record.shape.text = shape_of(problem.specimens[s], result.parameters).dump();
  if (mesh.n_elements() > 0) record.mass_kg = mesh::mesh_volume_m3(mesh) * specimen.model.material.density_kg_m3;
  record.n_nodes = mesh.n_nodes();
  record.n_elements = mesh.n_elements();
  record.none_missing = specimen.none_missing;
  record.rms_deviation_cents = specimen.rms_deviation_cents;
  record.max_deviation_cents = specimen.max_deviation_cents;
  record.partials = partial_records(result, s);
  record.strikes_s = specimen.ringdown.strikes_s;
  record.amplitude_strike = specimen.ringdown.amplitude_strike;
  record.explained_energy = specimen.ringdown.explained_energy;
  record.files = files_of(specimen);
  return record;
}

MaterialRecord material_record(const solid::Material& material) {
  MaterialRecord record;
  record.preset = material.name;
  record.youngs_modulus_pa = material.youngs_modulus_pa();
  record.poissons_ratio = material.poissons_ratio();
  record.lame_lambda_pa = material.lame_lambda_pa;
  record.lame_mu_pa = material.lame_mu_pa;
  if (material.density_kg_m3 > 0.0) record.density_kg_m3 = material.density_kg_m3;
  record.source = material.source;
  return record;
}

/// What was found of the material beside its elasticity: a density from the masses, Rayleigh's two numbers.
void complete_material(const FitProblem& problem, const FitResult& result, MaterialRecord& record) {
  double mass_kg = 0.0, volume_m3 = 0.0;
  for (std::size_t s = 0; s < result.specimens.size(); ++s) {
    const SpecimenResult& specimen = result.specimens[s];
    if (specimen.predicted || !problem.specimens[s].mass_kg || specimen.model.mesh.n_elements() == 0) continue;
    mass_kg += *problem.specimens[s].mass_kg;
    volume_m3 += *problem.specimens[s].mass_kg / specimen.model.material.density_kg_m3;
  }
  if (volume_m3 > 0.0) record.density_kg_m3 = mass_kg / volume_m3;
  for (const DampingCandidate& candidate : result.damping.candidates) {
    if (candidate.model.substr(0, candidate.model.find("_and_")) != "rayleigh") continue;
    for (const FitParameter& parameter : candidate.parameters) {
      if (parameter.name == "rayleigh_stiffness_s") record.rayleigh_stiffness_s = parameter.value;
      if (parameter.name == "rayleigh_mass_per_s") record.rayleigh_mass_per_s = parameter.value;
    }
    return;  // the best of those that hold it
  }
}

CorrelationRecord correlation_record(const FitResult& result) {
  CorrelationRecord record{{}, result.correlation};
  for (const FitParameter& parameter : result.parameters) {
    const bool elastic = !damping::is_law_parameter(parameter.name);
    if (parameter.identifiable && !parameter.derived && elastic) record.names.push_back(parameter.name);
  }
  return record;
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

void FitDocument::check(const std::string& place) const {
  for (std::size_t i = 0; i < damping.candidates.size(); ++i) {
    const CurveRecord& curve = damping.candidates[i].curve;
    if (curve.frequency_hz.size() != curve.decay_per_s.size())
      throw InputError(place + ".damping.candidates[" + std::to_string(i) + "].curve", "lists differ in length");
  }
}

FitDocument fit_document(const FitProblem& problem, const FitResult& result, Provenance provenance) {
  FitDocument document;
  document.header.kind = "fit";
  document.header.status = to_text(result.status);
  document.header.message = result.message;
  document.header.provenance = std::move(provenance);
  document.header.warnings = result.warnings;
  document.header.wall_time_s = result.wall_time_s;
  document.name = problem.name;
  document.material = material_record(result.material.value_or(problem.material));
  complete_material(problem, result, document.material);
  document.material_start = material_record(problem.material);
  document.parameters = result.parameters;
  document.correlation = correlation_record(result);
  document.budget = result.budget;
  document.damping = damping_records(result);
  for (const PartialMatch& match : result.matches)
    document.matches.push_back(match_record(match, item(result.specimens, match.specimen).name));
  for (std::size_t s = 0; s < result.specimens.size(); ++s) {
    add_predicted(result.specimens[s], document.predicted);
    document.specimens.push_back(specimen_record(problem, result, s));
  }
  document.judgement = result.judgement;
  document.cost_initial = result.cost_initial;
  document.cost_final = result.cost_final;
  document.n_iterations = result.n_iterations;
  return document;
}

}  // namespace klang::fit
