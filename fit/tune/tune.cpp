#include "fit/tune/tune.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <memory>

#include "core/foundation/base/checked_index.hpp"
#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/nearest_word.hpp"
#include "core/foundation/base/stopwatch.hpp"
#include "core/geometry/shapes/profile_dimensions.hpp"
#include "fit/elastic/parameter_space.hpp"
#include "fit/elastic/reduced_spectrum.hpp"
#include "fit/tune/mode_names.hpp"

namespace klang::fit {
namespace {

constexpr const char* kPlace = "tune";
constexpr double kLongestStep = 0.1;  // of ln(dimension) in a round

/// Those it is given by, and those that a drawn profile has besides.
std::map<std::string, double> changeable_dimensions_m(const mesh::ShapeSpec& shape) {
  std::map<std::string, double> dims = shape.dims;
  dims.merge(mesh::drawn_dimensions_m(shape));
  return dims;
}

/// How often sound crosses a body in a second: above a few times this it has modes by the thousand.
double crossing_hz(const Specimen& specimen, const solid::Material& material) {
  double longest_m = 0.0;
  for (const auto& [name, value] : changeable_dimensions_m(*specimen.shape)) longest_m = std::max(longest_m, value);
  return std::sqrt(material.youngs_modulus_pa() / material.density_kg_m3) / longest_m;
}

/// The lowest one of a body, as a scale for its meshes.
double first_frequency_hz(const Specimen& specimen, const solid::Material& material) {
  const double highest_hz = crossing_hz(specimen, material);
  const SpecimenBody body = make_body(specimen, material, highest_hz);
  ReducedSpectrumOptions options;
  options.count = 1;
  options.band = {0.0, highest_hz};
  options.vary_ratio = false;
  const ReducedSpectrum spectrum(specimen, body, {}, options);
  return spectrum.nominal().model.frequency_hz()[0];
}

/// A ratio counts from a target of its base, else from the body's lowest frequency: its base is not known yet.
double highest_target_hz(const Specimen& specimen, const solid::Material& material, const TuneOptions& options) {
  double highest_hz = 0.0, highest_ratio = 1.0;
  for (const TuneTarget& target : options.targets) {
    highest_hz = std::max(highest_hz, target.frequency_hz);
    highest_ratio = std::max(highest_ratio, target.ratio);
  }
  constexpr double kMostCrossings = 4.0;
  const double allowed_hz = kMostCrossings * crossing_hz(specimen, material);
  if (!(highest_hz <= allowed_hz))
    throw InputError(kPlace, "a target lies among so many modes of this body that none can be told",
                     to_text(std::round(highest_hz)) + " Hz",
                     "up to " + to_text(std::floor(allowed_hz)) + " Hz for this size; are its dimensions in metres?");
  return highest_ratio * (highest_hz > 0.0 ? highest_hz : first_frequency_hz(specimen, material));
}

FitProblem problem_at(const Specimen& specimen, const solid::Material& material, const TuneOptions& options) {
  FitProblem problem;
  problem.material = material;
  problem.specimens = {specimen};
  for (const std::string& name : options.dimensions) problem.parameters.push_back(specimen.name + "." + name);
  return problem;
}

/// Beyond a tenth the tangents no longer hold: no dimension goes farther in a round, and the direction stays.
/// @param wanted  in the order of the names. @return whether anything moved
bool step_towards(const std::vector<double>& wanted, const std::vector<std::string>& order,
                  std::vector<TunedDimension>& dimensions) {
  const auto log_step = [&](const TunedDimension& dimension) {
    const auto place = static_cast<std::size_t>(std::find(order.begin(), order.end(), dimension.name) - order.begin());
    return std::log(wanted[place] / dimension.value_m);
  };
  double longest = 0.0;
  for (const TunedDimension& dimension : dimensions) longest = std::max(longest, std::abs(log_step(dimension)));
  const double shorter = longest > kLongestStep ? kLongestStep / longest : 1.0;
  bool moved = false;
  for (TunedDimension& dimension : dimensions) {
    const double next =
        std::clamp(std::exp(shorter * log_step(dimension)) * dimension.value_m, dimension.low_m, dimension.high_m);
    moved = moved || std::abs(next / dimension.value_m - 1.0) >= 1e-9;
    dimension.at_bound = next == dimension.low_m || next == dimension.high_m;
    dimension.value_m = next;
  }
  return moved;
}

/// The dimensions at which the tangents meet the targets, in least squares where they cannot, by the smallest change where there are
/// dimensions to spare. Tangents, not the parabolas of the reduced spectrum: these hold where a dimension only stretches the body, and
/// each round has its own solve. A dimension at a bound that would go beyond it stays.
std::vector<double> linear_step(const Eigen::MatrixXd& slopes, const Eigen::VectorXd& missing,
                                const std::vector<std::string>& order, const std::vector<TunedDimension>& dimensions) {
  Eigen::MatrixXd free = slopes;
  Eigen::VectorXd step = Eigen::VectorXd::Zero(slopes.cols());
  std::vector<double> wanted(order.size());
  for (std::size_t pass = 0; pass <= order.size(); ++pass) {
    step = free.completeOrthogonalDecomposition().solve(missing);
    bool fixed = false;
    for (const TunedDimension& dimension : dimensions) {
      const auto place = std::find(order.begin(), order.end(), dimension.name) - order.begin();
      const bool beyond = (dimension.value_m >= dimension.high_m && step[place] > 0.0) ||
                          (dimension.value_m <= dimension.low_m && step[place] < 0.0);
      if (beyond) free.col(place).setZero(), fixed = true;
      item(wanted, place) = dimension.value_m * std::exp(step[place]);
    }
    if (!fixed) break;
  }
  return wanted;
}

/// A body on the way to its targets, with its modes.
struct Stage {
  Specimen specimen;
  SpecimenBody body;
  std::shared_ptr<const ReducedSpectrum> spectrum = {};
};

/// Tangents alone are used. A mode carried to a body whose dimension does more than stretch it is strained by h^2 of its stiffest
/// motion, which leaves h^2 in a central difference: at 0.01 half of a slender bar's slope.
ReducedSpectrumOptions tangents(double highest_hz) {
  ReducedSpectrumOptions reduced;
  reduced.band = {0.0, 1.5 * highest_hz};
  reduced.vary_ratio = false;
  reduced.relative_step = 1e-3;
  return reduced;
}

/// Goes from a stage to the dimensions given, or part of the way where a profile folds before that (walls that change by much, beside
/// others that do not, cross). @param dimensions  become those that were reached. @return whether it got anywhere
bool advance(Stage& stage, const solid::Material& material, const std::vector<std::string>& order,
             const ReducedSpectrumOptions& reduced, std::vector<TunedDimension>& dimensions, Monitor& monitor) {
  constexpr int kMostHalvings = 3;
  const std::map<std::string, double> from = stage.specimen.shape->dims;
  for (int halving = 0; halving <= kMostHalvings; ++halving) {
    Stage next{stage.specimen, {}};
    for (TunedDimension& dimension : dimensions) {
      if (halving > 0) dimension.value_m = std::sqrt(dimension.value_m * from.at(dimension.name));
      next.specimen.shape->dims[dimension.name] = dimension.value_m;
      dimension.at_bound = dimension.value_m == dimension.low_m || dimension.value_m == dimension.high_m;
    }
    try {
      mesh::validate(*next.specimen.shape);
      next.body = make_body_like(next.specimen, material, stage.body);
      next.spectrum = std::make_shared<ReducedSpectrum>(next.specimen, next.body, order, reduced, monitor);
      stage = std::move(next);
      return true;
    } catch (const InputError&) {  // folded
    }
  }
  for (TunedDimension& dimension : dimensions) dimension.value_m = from.at(dimension.name);
  return false;
}

}  // namespace

void TuneOptions::validate(const Specimen& specimen) const {
  if (!specimen.shape) throw InputError(kPlace, "only a body given by shape and dimensions can be tuned");
  if (dimensions.empty()) throw InputError(kPlace, "no dimension is free");
  if (targets.empty()) throw InputError(kPlace, "no target frequency is given");
  std::vector<std::string> known;
  const std::map<std::string, double> own = changeable_dimensions_m(*specimen.shape);
  for (const auto& [name, value] : own) known.push_back(name);
  for (const std::string& name : dimensions) {
    if (!own.count(name)) throw unknown_word(kPlace, "unknown dimension", name, name, known);
    if (std::count(dimensions.begin(), dimensions.end(), name) > 1)
      throw InputError(kPlace, "dimension named twice", name);
  }
  for (const TuneTarget& target : targets) {
    const double wanted = target.over.empty() ? target.frequency_hz : target.ratio;
    if (!(wanted > 0.0)) throw InputError(kPlace, "a target is not above 0", to_text(wanted));
    if (target.over == target.mode) throw InputError(kPlace, "a mode over itself", target.mode);
  }
  validate_fields(kPlace, *this);
}

TuneResult tune_dimensions(const Specimen& specimen, const solid::Material& material, const TuneOptions& options,
                           Monitor& monitor) {
  options.validate(specimen);
  const Stopwatch watch;
  TuneResult result;
  const double highest_hz = highest_target_hz(specimen, material, options);
  Specimen current = specimen;
  current.name = specimen.name.empty() ? "body" : specimen.name;
  // Of a drawn profile those alone that vary: walls that are not named go with the size.
  const std::map<std::string, double> own = changeable_dimensions_m(*specimen.shape);
  for (const std::string& name : options.dimensions) current.shape->dims[name] = own.at(name);
  for (const std::string& name : options.dimensions) {
    const double start = own.at(name);
    result.dimensions.push_back(
        {name, start, start, start * (1.0 - options.widest_change), start * (1.0 + options.widest_change), false});
  }
  const ReducedSpectrumOptions reduced = tangents(highest_hz);
  // The space orders dimensions by name.
  const std::vector<std::string> order = ParameterSpace(problem_at(current, material, options)).free_dimensions(0);
  Stage stage{current, make_body(current, material, 1.5 * highest_hz)};
  stage.spectrum = std::make_shared<ReducedSpectrum>(stage.specimen, stage.body, order, reduced, monitor);
  bool folded = false;
  for (int round = 0; round < options.max_rounds; ++round) {
    monitor.progress("tune", static_cast<double>(round) / options.max_rounds);
    monitor.throw_if_stopped();
    result.n_rounds = round + 1;
    const mesh::ShapeSpec& shape = *stage.specimen.shape;
    const ParameterSpace space(problem_at(stage.specimen, material, options));
    const modal::ModalModel& model = stage.spectrum->nominal().model;
    const Eigen::VectorXd frequency = model.frequency_hz();
    const Spectrum here = stage.spectrum->spectrum(space.local(0, space.start()).point);

    const auto n_dimensions = static_cast<Eigen::Index>(order.size());
    // d ln(frequency or ratio) / d ln(dimension), and what is missing to the target.
    Eigen::MatrixXd slopes(static_cast<Eigen::Index>(options.targets.size()), n_dimensions);
    Eigen::VectorXd missing(slopes.rows());
    const auto log_slope_of = [&](int mode, Eigen::Index place) {
      return 0.5 * here.derivative(mode, 3 + place) * shape.dims.at(item(order, place));
    };
    result.targets.resize(options.targets.size());
    double worst = 0.0;
    for (std::size_t t = 0; t < options.targets.size(); ++t) {
      TunedTarget& target = result.targets[t];
      target.mode = options.targets[t].mode;
      target.mode_index = named_mode(target.mode, shape, model);
      target.reached_hz = frequency[target.mode_index];
      const bool is_ratio = !options.targets[t].over.empty();
      const int base = is_ratio ? named_mode(options.targets[t].over, shape, model) : -1;
      target.wanted_hz = is_ratio ? options.targets[t].ratio * frequency[base] : options.targets[t].frequency_hz;
      if (round == 0) target.start_hz = target.reached_hz;
      target.residual_cents = cents(target.reached_hz, target.wanted_hz);
      worst = std::max(worst, std::abs(target.residual_cents));
      target.hz_per_mm.assign(options.dimensions.size(), 0.0);
      target.cents_per_tenth_mm = target.hz_per_mm;
      for (std::size_t d = 0; d < options.dimensions.size(); ++d) {
        const auto place = std::find(order.begin(), order.end(), options.dimensions[d]) - order.begin();
        const double log_slope = 0.5 * here.derivative(target.mode_index, 3 + place);  // d ln f / d m
        target.hz_per_mm[d] = 1e-3 * target.reached_hz * log_slope;
        target.cents_per_tenth_mm[d] = 1e-4 * log_slope * 1200.0 / std::log(2.0);
      }
      const auto row = static_cast<Eigen::Index>(t);
      missing[row] = std::log(target.wanted_hz / target.reached_hz);
      for (Eigen::Index d = 0; d < n_dimensions; ++d)
        slopes(row, d) = log_slope_of(target.mode_index, d) - (is_ratio ? log_slope_of(base, d) : 0.0);
      if (is_ratio) target.mode += "/" + options.targets[t].over;
    }
    if (worst <= options.tolerance_cents) {
      result.status = TuneStatus::kReached;
      break;
    }
    if (round + 1 == options.max_rounds) break;
    if (!step_towards(linear_step(slopes, missing, order, result.dimensions), order, result.dimensions)) break;
    folded = !advance(stage, material, order, reduced, result.dimensions, monitor);
    if (folded) break;
  }
  result.shape = *stage.specimen.shape;
  if (result.status != TuneStatus::kReached) {
    result.status = TuneStatus::kNotReached;
    result.message = "the targets cannot all be met within the allowed change of the dimensions";
    if (folded) result.message = "the targets cannot all be met: beyond these dimensions the body's section folds";
  }
  result.wall_time_s["total"] = watch.seconds();
  return result;
}

}  // namespace klang::fit
