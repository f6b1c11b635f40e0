#pragma once
#include <optional>
#include <string>
#include <vector>

#include "core/foundation/config/result_header.hpp"
#include "fit/ringdown/partial_table.hpp"
#include "fit/run/fit.hpp"

/// fit.json of `klang fit`. The files that it names lie beside it: recording-NAME.wav, resynthesis-NAME.wav, modes-NAME.vtu.
namespace klang::fit {

struct MaterialRecord {
  std::string preset;
  std::optional<double> youngs_modulus_pa, poissons_ratio, lame_lambda_pa, lame_mu_pa, density_kg_m3;
  std::optional<double> rayleigh_stiffness_s, rayleigh_mass_per_s;
  std::string source;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit(null_if_empty({"preset", "its name, if it is one"}), self.preset);
    visit({"youngs_modulus_pa", "E"}, self.youngs_modulus_pa);
    visit({"poissons_ratio", "nu"}, self.poissons_ratio);
    visit({"lame_lambda_pa", "lambda"}, self.lame_lambda_pa);
    visit({"lame_mu_pa", "mu"}, self.lame_mu_pa);
    visit({"density_kg_m3", "where masses are given: of the fitted specimens, mass over volume; of a start null then"},
          self.density_kg_m3);
    visit(absent_if_empty({"rayleigh_stiffness_s", "of the fitted Rayleigh damping, also where another law is better"}),
          self.rayleigh_stiffness_s);
    visit(absent_if_empty({"rayleigh_mass_per_s", "the same"}), self.rayleigh_mass_per_s);
    visit({"source", "where the numbers are from"}, self.source);
  }
};

struct CorrelationRecord {
  std::vector<std::string> names;
  std::vector<std::vector<double>> matrix;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"names", "of the identifiable parameters"}, self.names);
    visit({"matrix", "between them"}, self.matrix);
  }
};

struct CurveRecord {
  std::vector<double> frequency_hz, decay_per_s;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"frequency_hz", "of the curve's points"}, self.frequency_hz);
    visit({"decay_per_s", "at each of them"}, self.decay_per_s);
  }
};

struct DampingRecord {
  std::string model;
  std::vector<FitParameter> parameters;
  std::optional<double> aicc, aicc_weight, rms_relative_residual;
  CurveRecord curve;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit(
        {"model", "rayleigh, loss_factor, mass_only, stiffness_only or zener; _and_radiation, _and_mount beside these"},
        self.model);
    visit({"parameters", "of the model"}, self.parameters);
    visit({"aicc", "Akaike's criterion for few data; null with too few partials"}, self.aicc);
    visit({"aicc_weight", "its share of belief among the candidates"}, self.aicc_weight);
    visit({"rms_relative_residual", "of the decays"}, self.rms_relative_residual);
    visit({"curve", "what the material alone gives"}, self.curve);
  }
};

struct DampingRecords {
  std::string model;
  std::vector<DampingRecord> candidates;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"model", "the best one; empty where no decay was measured"}, self.model);
    visit({"candidates", "best first"}, self.candidates);
  }
};

struct MatchRecord {
  std::string specimen;
  int mode_index = -1;
  double frequency_hz = 0.0, model_frequency_hz = 0.0, deviation_cents = 0.0;
  std::optional<double> frequency_std_hz, decay_per_s, decay_std_per_s, model_decay_per_s, radiation_decay_per_s,
      mount_decay_per_kg, model_frequency_std_hz;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"specimen", "its name"}, self.specimen);
    visit({"mode_index", "elastic mode, from 0"}, self.mode_index);
    visit(needed({"frequency_hz", "measured"}), self.frequency_hz);
    visit({"frequency_std_hz", "its standard deviation"}, self.frequency_std_hz);
    visit(needed({"model_frequency_hz", "of the fitted model"}), self.model_frequency_hz);
    visit(needed({"deviation_cents", "measured over model"}), self.deviation_cents);
    visit({"decay_per_s", "measured"}, self.decay_per_s);
    visit({"decay_std_per_s", "its standard deviation"}, self.decay_std_per_s);
    visit({"model_decay_per_s", "by the best damping model"}, self.model_decay_per_s);
    visit({"radiation_decay_per_s", "by the mode's radiated power, where it was asked for"},
          self.radiation_decay_per_s);
    visit({"mount_decay_per_kg", "by a damper of 1 N s/m at each mount, where there are mounts"},
          self.mount_decay_per_kg);
    visit({"model_frequency_std_hz", "of a prediction: material, model scatter and mesh"}, self.model_frequency_std_hz);
  }
};

struct PredictedRecord {
  std::string specimen;
  int mode_index = -1;
  double frequency_hz = 0.0;
  std::optional<double> mesh_relative_error, decay_per_s;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"specimen", "its name"}, self.specimen);
    visit({"mode_index", "elastic mode, from 0"}, self.mode_index);
    visit(needed({"frequency_hz", "of the fitted model"}), self.frequency_hz);
    visit({"mesh_relative_error", "estimated"}, self.mesh_relative_error);
    visit({"decay_per_s", "by the best damping model"}, self.decay_per_s);
  }
};

struct PartialRecord : Partial {
  std::optional<int> matched_mode;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    Partial::describe(self, visit);
    visit({"matched_mode", "elastic mode, from 0; null: none"}, self.matched_mode);
  }
};

struct SpecimenFiles {
  std::optional<std::string> recording, resynthesis, modes;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"recording", "recording-NAME.wav"}, self.recording);
    visit({"resynthesis", "resynthesis-NAME.wav, by the fitted model"}, self.resynthesis);
    visit({"modes", "modes-NAME.vtu, at the fitted parameters"}, self.modes);
  }
};

struct SpecimenRecord {
  std::string name;
  bool predicted = false;
  JsonText shape;
  std::optional<double> mass_kg;
  std::optional<int> n_nodes, n_elements;
  std::optional<bool> none_missing;
  std::optional<double> rms_deviation_cents, max_deviation_cents;
  std::vector<PartialRecord> partials;
  std::vector<double> strikes_s;
  std::optional<int> amplitude_strike;
  std::optional<double> explained_energy;
  SpecimenFiles files;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"name", "of the specimen"}, self.name);
    visit({"predicted", "took no part in the fit: a test of it"}, self.predicted);
    visit({"shape", "kind and dimensions after the fit, or mesh file"}, self.shape);
    visit({"mass_kg", "of the mesh"}, self.mass_kg);
    visit({"n_nodes", "of the mesh"}, self.n_nodes);
    visit({"n_elements", "of the mesh"}, self.n_elements);
    visit({"none_missing", "a Sturm count proves that no mode in the band is missing"}, self.none_missing);
    visit({"rms_deviation_cents", "of its matches"}, self.rms_deviation_cents);
    visit({"max_deviation_cents", "the largest, absolute"}, self.max_deviation_cents);
    visit({"partials", "that were measured"}, self.partials);
    visit({"strikes_s", "from the recording's start"}, self.strikes_s);
    visit(absent_if_empty(
              {"amplitude_strike", "place in strikes_s of the strike at which the partials' amplitudes are told"}),
          self.amplitude_strike);
    visit({"explained_energy", "by the partials, 0 to 1"}, self.explained_energy);
    visit({"files", "beside the result"}, self.files);
  }
};

struct FitDocument {
  ResultHeader header;
  std::string name;
  MaterialRecord material, material_start;
  std::vector<FitParameter> parameters;
  CorrelationRecord correlation;
  std::vector<BudgetEntry> budget;
  DampingRecords damping;
  std::vector<MatchRecord> matches;
  std::vector<PredictedRecord> predicted;
  std::vector<SpecimenRecord> specimens;
  std::optional<double> cost_initial, cost_final;
  std::optional<int> n_iterations;
  Judgement judgement;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    ResultHeader::describe(self.header, visit);
    visit({"name", "of the problem"}, self.name);
    visit({"judgement", "whether the numbers may be believed, and why"}, self.judgement);
    visit({"material", "that the fit found; what no partial determines stayed where it began"}, self.material);
    visit({"material_start", "where the fit began: as given"}, self.material_start);
    visit({"parameters", "asked ones first, then derived ones"}, self.parameters);
    visit({"correlation", "of the estimates"}, self.correlation);
    visit({"budget", "where each parameter's standard deviation comes from"}, self.budget);
    visit({"damping", "models that explain the decays"}, self.damping);
    visit({"matches", "partials and their modes"}, self.matches);
    visit({"predicted", "all modes of the model in the band"}, self.predicted);
    visit({"specimens", "as in the problem"}, self.specimens);
    visit({"cost_initial", "of the solver"}, self.cost_initial);
    visit({"cost_final", "of the solver"}, self.cost_final);
    visit({"n_iterations", "of the solver"}, self.n_iterations);
  }
  /// @throws InputError naming a list that does not go with its neighbour
  void check(const std::string& place) const;
};

/// The document of a fit; the files that it names are the caller's to write.
FitDocument fit_document(const FitProblem& problem, const FitResult& result, Provenance provenance);

/// NAME as it appears in file names: everything but letters, digits, - and _ becomes _.
std::string file_stem(const std::string& specimen_name);

}  // namespace klang::fit
