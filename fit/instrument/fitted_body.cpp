#include "fit/instrument/fitted_body.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/nearest_word.hpp"
#include "core/foundation/base/output_file.hpp"
#include "core/foundation/base/parse_json.hpp"
#include "core/foundation/base/provenance.hpp"
#include "core/foundation/config/fields.hpp"
#include "core/foundation/config/fields_json.hpp"
#include "core/physics/modal/damping/assumed_damping.hpp"
#include "core/physics/modal/modes_of.hpp"
#include "core/physics/solid/fitted_material.hpp"
#include "core/sound/instrument/modal_bank.hpp"
#include "fit/elastic/reduced_spectrum.hpp"

namespace klang::fit {
namespace {

constexpr double kWidestBand = 64.0;  ///< of a changed body, over the fitted one's

/// The decays that the fit predicts for the modes of a model; empty where it has none for one of them.
std::optional<Eigen::VectorXd> predicted_decays(const FitDocument& fit, const std::string& specimen,
                                                const modal::ModalModel& model) {
  Eigen::VectorXd decays = Eigen::VectorXd::Constant(model.n_modes(), -1.0);
  for (const PredictedRecord& mode : fit.predicted) {
    if (mode.specimen == specimen && mode.mode_index >= 0 && mode.mode_index < decays.size() && mode.decay_per_s)
      decays[mode.mode_index] = *mode.decay_per_s;
  }
  if (decays.size() == 0 || !(decays.minCoeff() >= 0.0)) return std::nullopt;
  return decays;
}

std::optional<Eigen::VectorXd> decays_by_law(const FitDocument& fit, const modal::ModalModel& model) {
  const auto law = fitted_law(fit);
  if (!law) return std::nullopt;
  return law->law->decay_per_s(model.angular_frequency_rad_s, law->parameters.data());
}

/// The profile as the fit read it: where it lay then, or beside the fit.
std::filesystem::path profile_of_fit(const FitDocument& fit, const std::filesystem::path& name,
                                     const std::string& place, const std::filesystem::path& folder) {
  for (const InputFile& input : fit.header.provenance.inputs) {
    if (std::filesystem::path(input.path).filename() != name.filename()) continue;
    bool is_there = false;
    for (const std::filesystem::path& file : {std::filesystem::path(input.path), folder / name.filename()}) {
      std::error_code error;
      if (!std::filesystem::is_regular_file(file, error)) continue;
      is_there = true;
      if (sha256(read_file(file)) == input.sha256) return file;
    }
    throw InputError(place, is_there ? "its profile is not what it was when it was fitted" : "its profile is gone",
                     input.path, "the file that klang fit read, there or beside fit.json");
  }
  throw InputError(place, "its profile is not among what the fit read", name.string());
}

}  // namespace

FitDocument read_fit_document(const std::filesystem::path& path) {
  const nlohmann::json json = solid::read_fit_json(path);
  FitDocument document = read_fields<FitDocument>(json, path.string());
  document.check(path.string());
  return document;
}

const SpecimenRecord& specimen_of(const FitDocument& fit, const std::string& name, const std::filesystem::path& path) {
  std::vector<std::string> names;
  for (const SpecimenRecord& specimen : fit.specimens) {
    if (specimen.name == name) return specimen;
    names.push_back(specimen.name);
  }
  if (name.empty() && names.size() == 1) return fit.specimens.front();
  if (name.empty()) throw InputError(path.string(), "which specimen? --specimen says it", "", word_list(names));
  throw unknown_word(path.string(), "no such specimen", name, name, names);
}

mesh::ShapeSpec fitted_shape(const FitDocument& fit, const SpecimenRecord& specimen,
                             const std::filesystem::path& path) {
  const std::string place = path.string() + ": specimen " + specimen.name;
  const nlohmann::json shape = parse_json(specimen.shape.text, place);
  if (!shape.is_object() || shape.contains("mesh"))
    throw InputError(place, "has no dimensions that could be changed", "", "a body given by shape and dimensions");
  mesh::ShapeSpec spec;
  for (const auto& [key, value] : shape.items()) {
    if (key == "kind" && value.is_string()) spec.kind = value.get<std::string>();
    if (value.is_number()) spec.dims[key] = value.get<double>();
    if (key == "profile_csv" && value.is_string())
      spec.profile_csv = profile_of_fit(fit, value.get<std::string>(), place, path.parent_path());
  }
  mesh::validate(spec);
  return spec;
}

solid::Material stock_material(const FitDocument& fit, const SpecimenRecord& specimen, const mesh::ShapeSpec& shape,
                               const std::filesystem::path& path) {
  solid::Material material;
  material.lame_lambda_pa = fit.material.lame_lambda_pa.value_or(0.0);
  material.lame_mu_pa = fit.material.lame_mu_pa.value_or(0.0);
  material.density_kg_m3 =
      specimen.mass_kg ? *specimen.mass_kg / mesh::shape_volume_m3(shape) : fit.material.density_kg_m3.value_or(0.0);
  material.source = "fitted: " + path.filename().string();
  solid::validate(material);
  return material;
}

std::optional<damping::LawValue> fitted_law(const FitDocument& fit) {
  if (fit.damping.candidates.empty()) return std::nullopt;
  const DampingRecord& best = fit.damping.candidates.front();
  damping::LawValue value;
  value.law = damping::find_law(best.model.substr(0, best.model.find("_and_")));
  if (value.law == nullptr) return std::nullopt;
  for (const damping::LawParameter& parameter : value.law->parameters()) {
    const auto found = std::find_if(best.parameters.begin(), best.parameters.end(),
                                    [&](const FitParameter& p) { return p.name == parameter.name; });
    value.parameters.push_back(found == best.parameters.end() ? 0.0 : found->value);
  }
  return value;
}

FittedBody fitted_body(const FitDocument& fit, const std::filesystem::path& path, const std::string& name,
                       const BodyChange& change, Monitor& monitor) {
  const SpecimenRecord& specimen = specimen_of(fit, name, path);
  const std::filesystem::path file = path.parent_path() / specimen.files.modes.value_or("");
  if (!specimen.files.modes || !std::filesystem::is_regular_file(file))
    throw InputError(path.string(), "the modes of " + specimen.name + " are not beside it",
                     specimen.files.modes.value_or(""), "the folder that klang fit wrote");
  FittedBody body;
  body.model = modal::read_modal_model(file);
  if (!change.any()) {
    body.decay_per_s = predicted_decays(fit, specimen.name, body.model);
    if (!body.decay_per_s) body.decay_per_s = decays_by_law(fit, body.model);
    return body;
  }
  Specimen changed;
  changed.name = specimen.name;
  changed.shape = fitted_shape(fit, specimen, path);
  changed.support = body.model.support;
  for (const auto& [dimension, value] : change.dims) {
    if (!changed.shape->dims.contains(dimension)) {
      std::vector<std::string> known;
      for (const auto& [known_name, known_value] : changed.shape->dims) known.push_back(known_name);
      throw option_error("dims", "names an unknown dimension", dimension,
                         word_list(known) + did_you_mean(dimension, known));
    }
    changed.shape->dims[dimension] = value;
  }
  mesh::validate(*changed.shape);
  const solid::Material material = change.material.value_or(body.model.material);
  const Eigen::Index n_modes = body.model.n_modes();
  const double fitted_hz = n_modes > 0 ? body.model.frequency_hz().maxCoeff() : 20000.0;
  // A smaller body has its modes higher.
  for (double highest_hz = fitted_hz; highest_hz <= kWidestBand * fitted_hz; highest_hz *= 2.0) {
    const SpecimenBody mesh = make_body(changed, material, highest_hz);
    modal::ModesOptions options;
    options.eigen.band = {0.0, highest_hz};
    options.eigen.most = static_cast<int>(std::max<Eigen::Index>(500, n_modes));
    modal::EigenResult modes =
        modal::modes_of({changed.shape, changed.support, 2}, mesh.mesh, material, options, monitor);
    if (!modes.usable()) throw NumericalError("modes of the changed body: " + modes.message);
    body.model = std::move(modes.model);
    if (body.model.n_modes() >= std::max<Eigen::Index>(1, n_modes)) break;
  }
  body.decay_per_s = decays_by_law(fit, body.model);
  return body;
}

Eigen::VectorXd assumed_decay_per_s(const modal::ModalModel& model) {
  return 0.5 * damping::kAssumedLossFactor * model.angular_frequency_rad_s;
}

std::optional<FitBeside> fit_beside(const std::filesystem::path& modes_file) {
  const std::filesystem::path path = modes_file.parent_path() / "fit.json";
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) return std::nullopt;
  try {
    const FitDocument fit = read_fit_document(path);
    for (const SpecimenRecord& specimen : fit.specimens) {
      if (specimen.files.modes == modes_file.filename().string()) return FitBeside{path, specimen.name};
    }
  } catch (const InputError&) {  // some other program's file of that name
  }
  return std::nullopt;
}

}  // namespace klang::fit
