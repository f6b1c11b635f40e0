#include "fit/instrument/chime.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/parallel.hpp"
#include "core/foundation/config/fields.hpp"
#include "core/geometry/shapes/shape_registry.hpp"
#include "core/physics/modal/modes_of.hpp"
#include "core/sound/instrument/modal_bank.hpp"
#include "fit/elastic/reduced_spectrum.hpp"
#include "fit/instrument/banks.hpp"
#include "fit/tune/tune.hpp"

namespace klang::fit {
namespace {

constexpr double kStrikeEveryS = 0.7, kLastRingsS = 4.0;
/// A free slender bar's outer nodes in its first bending mode: cos kl cosh kl = 1, u(x) = 0.
constexpr double kNodeRule = 0.22416;

/// A body of the fit that has a length.
struct Stock {
  std::string name;
  mesh::ShapeSpec shape;
  solid::Material material;
  double first_hz = 0.0;
};

Specimen specimen_at(const Stock& stock, double length_m) {
  Specimen specimen;
  specimen.name = stock.name;
  specimen.shape = stock.shape;
  specimen.shape->dims["length_m"] = length_m;
  return specimen;
}

modal::ModalModel modes_up_to(const Specimen& specimen, const solid::Material& material, double highest_hz,
                              Monitor& monitor) {
  const SpecimenBody body = make_body(specimen, material, highest_hz);
  modal::ModesOptions options;
  options.eigen.band = {0.0, highest_hz};
  options.eigen.most = 200;
  options.eigen.prove_none_missing = false;
  modal::EigenResult modes =
      modal::modes_of({specimen.shape, specimen.support, 2}, body.mesh, material, options, monitor);
  if (!modes.usable()) throw NumericalError("chime: " + modes.message);
  return std::move(modes.model);
}

double first_bending_hz(const Stock& stock, Monitor& monitor) {
  const double length = stock.shape.dims.at("length_m");
  const double speed = std::sqrt(stock.material.youngs_modulus_pa() / stock.material.density_kg_m3);
  for (double highest_hz = 0.2 * speed / length; highest_hz < 10.0 * speed / length; highest_hz *= 2.0) {
    const modal::ModalModel model = modes_up_to(specimen_at(stock, length), stock.material, highest_hz, monitor);
    if (model.n_modes() == 0) continue;
    const auto families = bending_modes(stock.shape, model);
    if (!families.empty() && !families.front().empty()) return model.frequency_hz()[families.front().front()];
  }
  throw NumericalError("chime: " + stock.name + " has no bending mode");
}

std::vector<Stock> stocks_of(const FitDocument& fit, const std::filesystem::path& path, const std::string& only,
                             Monitor& monitor) {
  std::vector<Stock> stocks;
  if (!only.empty()) specimen_of(fit, only, path);
  for (const SpecimenRecord& record : fit.specimens) {
    if (only.empty() ? record.predicted : record.name != only) continue;
    Stock stock;
    stock.name = record.name;
    stock.shape = fitted_shape(fit, record, path);
    if (!stock.shape.dims.contains("length_m") || !mesh::find_shape(stock.shape.kind).long_axis(stock.shape))
      throw InputError(path.string() + ": specimen " + record.name, "has no length to cut", stock.shape.kind,
                       "a tube, rod, box or undercut bar");
    stock.material = stock_material(fit, record, stock.shape, path);
    stocks.push_back(std::move(stock));
  }
  if (stocks.empty()) throw InputError(path.string(), "has no specimen to cut from");
  if (stocks.size() > 1) {
    for_each_job(
        stocks.size(), [&](std::size_t i) { stocks[i].first_hz = first_bending_hz(stocks[i], silent_monitor()); },
        "stock", monitor);
  } else {
    stocks.front().first_hz = first_bending_hz(stocks.front(), monitor);
  }
  return stocks;
}

/// Of a predicted frequency.
struct FrequencyDoubt {
  double relative_std = 0.0;
  std::string caveat;  ///< what that leaves out
};

/// Half of E's standard deviation, and how far the struck bodies lie from the model (rms); empty where E's is not known.
std::optional<FrequencyDoubt> frequency_doubt(const FitDocument& fit) {
  double sum_sq = 0.0, n = 0.0;
  for (const MatchRecord& match : fit.matches) {
    sum_sq += std::pow(match.deviation_cents * std::log(2.0) / 1200.0, 2);
    n += 1.0;
  }
  for (const FitParameter& parameter : fit.parameters) {
    if (parameter.name != "youngs_modulus_pa" || !parameter.std || !(n > 0.0)) continue;
    return FrequencyDoubt{std::hypot(0.5 * *parameter.std / parameter.value, std::sqrt(sum_sq / n)), parameter.caveat};
  }
  return std::nullopt;
}

/// Where the first bending mode's sideways motion of whole sections vanishes, from an end: the mean of both ends.
double node_m(const modal::ModalModel& model, int mode, int axis) {
  std::map<long, std::pair<Eigen::Vector3d, int>>
      sections;  // by place in nm: the mesh has the same places along it everywhere
  const auto along = model.mesh.nodes_m.col(axis);
  const double low = along.minCoeff(), length = along.maxCoeff() - low;
  for (Eigen::Index node = 0; node < along.size(); ++node) {
    auto& [sum, count] = sections[std::lround((along[node] - low) * 1e9)];
    if (count == 0) sum.setZero();
    sum += model.shapes.block<3, 1>(3 * node, mode);
    ++count;
  }
  Eigen::Vector3d direction = sections.begin()->second.first / sections.begin()->second.second;
  direction[axis] = 0.0;
  direction.normalize();
  std::vector<double> crossings;
  double before_at = 0.0, before = 0.0;
  bool is_first = true;
  for (const auto& [place, section] : sections) {
    if (section.second < 4) continue;
    const double at = 1e-9 * static_cast<double>(place), now = section.first.dot(direction) / section.second;
    if (!is_first && before * now < 0.0) crossings.push_back(before_at + (at - before_at) * before / (before - now));
    is_first = false;
    before_at = at;
    before = now;
  }
  if (crossings.size() < 2) throw NumericalError("chime: the first bending mode has no two nodes");
  return 0.5 * (crossings.front() + length - crossings.back());
}

struct Cut {
  ChimeNote note;
  instrument::ModalBank bank;
};

Cut cut_of(const Stock& stock, const std::string& name, double frequency_hz, const std::optional<FrequencyDoubt>& doubt,
           const std::optional<damping::LawValue>& law) {
  // Bending goes with 1 / length^2, nearly.
  Specimen start = specimen_at(stock, stock.shape.dims.at("length_m") * std::sqrt(stock.first_hz / frequency_hz));
  mesh::validate(*start.shape);
  TuneOptions tune;
  tune.dimensions = {"length_m"};
  tune.targets = {{"bending 1", frequency_hz}};
  const TuneResult tuned = tune_dimensions(start, stock.material, tune, silent_monitor());
  if (!tuned.usable()) throw NumericalError("chime: " + name + ": " + tuned.message);
  Cut cut;
  ChimeNote& note = cut.note;
  note.note = name;
  note.frequency_hz = frequency_hz;
  note.length_m = tuned.shape.dims.at("length_m");
  note.cents_per_tenth_mm = tuned.targets.front().cents_per_tenth_mm.front();
  note.residual_cents = tuned.targets.front().residual_cents;
  note.node_rule_m = kNodeRule * note.length_m;
  note.specimen = stock.name;
  const double log_slope_per_m = note.cents_per_tenth_mm * 1e4 * std::log(2.0) / 1200.0;
  if (doubt) {
    note.length_std_m = doubt->relative_std / std::abs(log_slope_per_m);
    note.length_caveat = doubt->caveat;
  }
  const Specimen finished = specimen_at(stock, note.length_m);
  const modal::ModalModel model =
      modes_up_to(finished, stock.material, std::min(18000.0, 20.0 * frequency_hz), silent_monitor());
  const auto families = bending_modes(*finished.shape, model);
  if (families.empty() || families.front().empty()) throw NumericalError("chime: " + name + " has no bending mode");
  note.node_m =
      node_m(model, families.front().front(), mesh::find_shape(stock.shape.kind).long_axis(*finished.shape)->axis);
  const Eigen::VectorXd& omega = model.angular_frequency_rad_s;
  const Eigen::VectorXd decays =
      law ? law->law->decay_per_s(omega, law->parameters.data()) : assumed_decay_per_s(model);
  cut.bank = instrument::struck_bank(model, decays, default_strike(model));
  cut.bank.name = name;
  return cut;
}

audio::Signal sound_of(std::vector<Cut>& cuts, double sample_rate_hz) {
  audio::Signal sound;
  sound.sample_rate_hz = sample_rate_hz;
  const auto frames = [&](double s) { return static_cast<Eigen::Index>(std::llround(s * sample_rate_hz)); };
  const Eigen::Index n = frames(kStrikeEveryS * (static_cast<double>(cuts.size()) - 1.0) + kLastRingsS);
  sound.samples = Eigen::MatrixXd::Zero(n, 1);
  for (std::size_t i = 0; i < cuts.size(); ++i) {
    instrument::normalise(cuts[i].bank, 1.0, sample_rate_hz, 0.2);
    const Eigen::Index first = frames(kStrikeEveryS * static_cast<double>(i));
    sound.samples.col(0).tail(n - first) += instrument::bank_sound(cuts[i].bank, sample_rate_hz, n - first);
  }
  sound.samples *= instrument::kPeak / sound.samples.cwiseAbs().maxCoeff();
  return sound;
}

}  // namespace

ChimeSet chime_set(const FitDocument& fit, const std::filesystem::path& path, const ChimeOptions& options,
                   Monitor& monitor) {
  std::vector<int> keys;
  std::set<int> seen;
  if (options.notes.empty()) throw option_error("notes", "names no note", "", "\"D5 E5 G5\"");
  for (const std::string& note : options.notes) {
    keys.push_back(audio::key_of_note(note));
    if (!seen.insert(keys.back()).second) throw option_error("notes", "has a note twice", note);
  }
  const std::vector<Stock> stocks = stocks_of(fit, path, options.specimen, monitor);
  const std::optional<FrequencyDoubt> doubt = frequency_doubt(fit);
  const std::optional<damping::LawValue> law = fitted_law(fit);
  std::vector<Cut> cuts(keys.size());
  for_each_job(
      keys.size(),
      [&](std::size_t i) {
        const double frequency_hz = options.temperament.frequency_hz(keys[i], options.a4_hz);
        const Stock* nearest = &stocks.front();
        for (const Stock& stock : stocks) {
          if (std::abs(cents(stock.first_hz, frequency_hz)) < std::abs(cents(nearest->first_hz, frequency_hz)))
            nearest = &stock;
        }
        cuts[i] = cut_of(*nearest, options.notes[i], frequency_hz, doubt, law);
      },
      "notes", monitor);
  ChimeSet set;
  set.damping_is_assumed = !law;
  for (const Cut& cut : cuts) set.notes.push_back(cut.note);
  set.sound = sound_of(cuts, options.sample_rate_hz);
  return set;
}

}  // namespace klang::fit
