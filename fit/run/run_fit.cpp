#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <map>
#include <memory>
#include <numeric>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/parallel.hpp"
#include "core/geometry/mesh/quality.hpp"
#include "core/sound/audio/sound_file.hpp"
#include "core/sound/transfer/radiate.hpp"
#include "fit/damping/damping.hpp"
#include "fit/elastic/elastic_blocks.hpp"
#include "fit/elastic/identifiability.hpp"
#include "fit/elastic/joint_match.hpp"
#include "fit/elastic/reduced_spectrum.hpp"
#include "fit/ringdown/merge_partials.hpp"
#include "fit/run/fit.hpp"

namespace klang::fit {
namespace {

constexpr double kCent = 5.776226504666211e-4;  // ln 2 / 1200
// Modes are wanted this far above the highest partial: a guess 30 % too soft in stiffness lies 20 % low in frequency.
constexpr double kModeMargin = 1.25;
constexpr double kRelinearise = 0.025;  // step of a dimension after which its meshes are made anew

class Stopwatch {
 public:
  double lap() {
    const auto now = std::chrono::steady_clock::now();
    const double seconds = std::chrono::duration<double>(now - last_).count();
    last_ = now;
    return seconds;
  }

 private:
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

/// One specimen on its way through the fit.
struct Work {
  std::vector<audio::Signal> signals;
  std::vector<RingdownResult> ringdowns;
  PartialTable partials;
  SpecimenBody body;
  std::shared_ptr<const ReducedSpectrum> spectrum;
};

PartialTable within(const PartialTable& table, const Band& band) {
  PartialTable kept{{}, table.origin};
  for (const Partial& partial : table.partials) {
    if (partial.frequency_hz >= band.low_hz && partial.frequency_hz <= band.high_hz) kept.partials.push_back(partial);
  }
  return kept;
}

void read_data(const Specimen& specimen, const Band& band, Work& work, Monitor& monitor) {
  if (specimen.partials) {
    work.partials = within(read_partial_table(*specimen.partials), band);
    return;
  }
  std::vector<PartialTable> tables;
  for (const auto& path : specimen.recordings) {
    work.signals.push_back(audio::read_sound(path));
    RingdownOptions options;
    options.band = band;
    work.ringdowns.push_back(identify_ringdown(work.signals.back(), options, monitor));
    if (work.ringdowns.back().usable()) tables.push_back(work.ringdowns.back().partials);
  }
  if (tables.size() == 1) work.partials = within(tables.front(), band);
  if (tables.size() > 1) work.partials = within(merge_partials(tables), band);
}

double highest_partial_hz(const PartialTable& table) {
  double highest = 0.0;
  for (const Partial& partial : table.partials) highest = std::max(highest, partial.frequency_hz);
  return highest;
}

void build_model(const FitProblem& problem, const ParameterSpace& space, std::size_t index, const FitOptions& options,
                 Work& work, Monitor& monitor) {
  const Specimen& specimen = problem.specimens[index];
  const double highest = kModeMargin * highest_partial_hz(work.partials);
  work.body = make_body(specimen, problem.material, highest);
  ReducedSpectrumOptions reduced;
  reduced.band = {problem.band.low_hz, highest};
  reduced.count = options.n_modes;
  reduced.vary_ratio = space.elastic_is_free();
  work.spectrum =
      std::make_shared<ReducedSpectrum>(specimen, work.body, space.free_dimensions(index), reduced, monitor);
}

/// The problem with its material and dimensions at x.
FitProblem at_solution(const FitProblem& problem, const ParameterSpace& space, const Eigen::VectorXd& x) {
  FitProblem moved = problem;
  moved.material.lame_lambda_pa = space.quantity("lame_lambda_pa", x).value;
  moved.material.lame_mu_pa = space.quantity("lame_mu_pa", x).value;
  moved.material.density_kg_m3 = space.quantity("density_kg_m3", x).value;
  for (std::size_t s = 0; s < problem.specimens.size(); ++s) {
    const auto local = space.local(s, x);
    const auto& names = space.free_dimensions(s);
    for (std::size_t d = 0; d < names.size(); ++d) {
      moved.specimens[s].shape->dims[names[d]] = local.point.dimensions[d];
    }
  }
  return moved;
}

double largest_dimension_step(const ParameterSpace& space, const Eigen::VectorXd& x) {
  double step = 0.0;
  for (Eigen::Index j = 0; j < space.size(); ++j) {
    if (space.coordinate_names()[static_cast<std::size_t>(j)].find('.') == std::string::npos) continue;
    step = std::max(step, std::abs(x[j] - space.start()[j]));
  }
  return step;
}

/// Modes whose shapes are kept: up to here above the highest partial. The list of frequencies goes on to the band's end.
constexpr double kShapeMargin = 1.25;
constexpr int kMostPredicted = 150;  // of tetrahedra

/// All modes of the band at the fitted parameters, by a full solve.
void solve_final(const FitProblem& fitted, std::size_t index, Work& work, SpecimenResult& result, Monitor& monitor) {
  const Specimen& specimen = fitted.specimens[index];
  if (specimen.shape && specimen.shape->dims != work.body.shape_dims)
    work.body = make_body_like(specimen, fitted.material, work.body);
  solid::Material material = fitted.material;
  if (specimen.mass_kg) material.density_kg_m3 = *specimen.mass_kg / work.body.volume_m3;
  work.body.material = material;
  work.body.mass_kg = material.density_kg_m3 * work.body.volume_m3;
  ReducedSpectrumOptions options;
  options.band = fitted.band;
  options.max_count = std::max(kMostPredicted, static_cast<int>(work.spectrum->n_modes()) + work.spectrum->n_skipped());
  auto modes = detail::elastic_blocks(specimen, work.body, 0, monitor)->lowest(material, options, true);
  result.model = std::move(modes.result.model);
  const Eigen::Index n_low = work.spectrum->n_skipped();
  const Eigen::Index n_kept = result.model.n_modes() - n_low;
  result.model.angular_frequency_rad_s = result.model.angular_frequency_rad_s.tail(n_kept).eval();
  result.model.shapes = result.model.shapes.rightCols(n_kept).eval();
  result.none_missing = modes.result.none_missing.value_or(false);
  result.mesh_relative_error = modes.relative_error.tail(n_kept);
  const Eigen::VectorXd frequency_hz = result.model.frequency_hz();
  const double highest = std::max(fitted.band.high_hz, 1.05 * highest_partial_hz(work.partials));
  for (Eigen::Index k = 0; k < n_kept && frequency_hz[k] <= highest; ++k)
    result.predicted_frequency_hz.push_back(frequency_hz[k]);
  const auto n_shown =
      std::max<Eigen::Index>(1, (frequency_hz.array() <= kShapeMargin * highest_partial_hz(work.partials)).count());
  result.model.angular_frequency_rad_s.conservativeResize(n_shown);
  result.model.shapes.conservativeResize(Eigen::NoChange, n_shown);
}

/// Where each of the reduced model's modes stands among all when they are sorted at x.
std::vector<int> ranks_at(const ParameterSpace& space, const SpectrumModels& models, std::size_t specimen,
                          const Eigen::VectorXd& x) {
  const Eigen::VectorXd frequency_hz = model_frequencies(space, models, specimen, x);
  std::vector<int> order(static_cast<std::size_t>(frequency_hz.size())), rank(order.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return frequency_hz[a] < frequency_hz[b]; });
  for (std::size_t k = 0; k < order.size(); ++k) rank[static_cast<std::size_t>(order[k])] = static_cast<int>(k);
  return rank;
}

/// Mode of each partial (-1: none). Of a line's modes the k-th lowest partial takes the k-th.
std::vector<int> mode_of_partial(const PartialTable& table, const TableMatch& match,
                                 const std::vector<ModelLine>& lines) {
  std::vector<int> modes(table.partials.size(), -1), taken(lines.size(), 0);
  for (std::size_t i = 0; i < table.partials.size(); ++i) {
    const int line = match.line_of_partial[i];
    if (line < 0) continue;
    const auto k = static_cast<std::size_t>(line);
    const auto place = std::min<std::size_t>(static_cast<std::size_t>(taken[k]++), lines[k].modes.size() - 1);
    modes[i] = lines[k].modes[place];
  }
  return modes;
}

/// Decay by radiated power of the given modes, by mode; empty where the surface cannot be solved for (said in a warning).
std::map<int, double> radiation_of(const SpecimenResult& specimen, const std::vector<int>& modes,
                                   std::vector<std::string>& warnings, Monitor& monitor) {
  std::map<int, double> decay_per_s;
  for (const int mode : modes) {
    if (mode >= 0 && mode < specimen.model.n_modes()) decay_per_s[mode] = 0.0;
  }
  if (decay_per_s.empty()) return {};
  modal::ModalModel matched = specimen.model;
  std::vector<Eigen::Index> columns, rows;
  for (const auto& [mode, value] : decay_per_s) columns.push_back(mode);
  matched.angular_frequency_rad_s = specimen.model.angular_frequency_rad_s(columns);
  matched.shapes = specimen.model.shapes(Eigen::all, columns);
  const acoustics::RadiateResult radiated = acoustics::radiate(matched, {}, monitor);
  if (!radiated.usable()) {
    warnings.push_back(specimen.name + ": no radiation: " + radiated.message);
    return {};
  }
  for (const acoustics::ModeTransfer& mode : radiated.transfer.modes)
    decay_per_s[static_cast<int>(columns[static_cast<std::size_t>(mode.mode)])] = mode.decay_radiation_per_s;
  return decay_per_s;
}

std::vector<DecayPoint> decay_points(const FitResult& result) {
  std::vector<DecayPoint> points;
  for (const PartialMatch& match : result.matches) {
    if (!match.decay_per_s) continue;
    if (result.specimens[static_cast<std::size_t>(match.specimen)].predicted) continue;
    points.push_back({match.frequency_hz, *match.decay_per_s, match.decay_std_per_s.value_or(0.0),
                      match.radiation_decay_per_s.value_or(0.0), match.mount_decay_per_kg.value_or(0.0)});
  }
  return points;
}

/// What the model says the first recording sounds like: measured amplitudes and phases on model frequencies and decays;
/// partials without a mode are left out.
audio::Signal fitted_sound(const Work& work, const SpecimenResult& result, const std::vector<int>& modes) {
  RingdownResult sound = work.ringdowns.front();
  const std::vector<Partial> measured = std::move(sound.partials.partials);
  sound.partials.partials.clear();
  std::vector<std::size_t> kept;
  for (std::size_t i = 0; i < measured.size(); ++i) {
    // The row of the merged table that this partial went into.
    int mode = -1;
    double nearest = 15.0;
    for (std::size_t j = 0; j < result.partials.partials.size(); ++j) {
      const double distance = std::abs(cents(measured[i].frequency_hz, result.partials.partials[j].frequency_hz));
      if (distance < nearest) nearest = distance, mode = modes[j];
    }
    if (mode < 0) continue;
    Partial partial = measured[i];
    partial.frequency_hz = result.predicted_frequency_hz[static_cast<std::size_t>(mode)];
    const double decay = result.predicted_decay_per_s[static_cast<std::size_t>(mode)];
    if (decay > 0.0) partial.decay_per_s = decay;
    sound.partials.partials.push_back(partial);
    kept.push_back(i);
  }
  for (auto& row : sound.strike_amplitudes) {
    std::vector<double> amplitudes;
    for (const std::size_t i : kept) amplitudes.push_back(i < row.size() ? row[i] : 0.0);
    row = std::move(amplitudes);
  }
  return resynthesise(sound, work.signals.front().n_frames());
}

/// The matches of a specimen, and how far they are off.
void add_matches(int index, const std::vector<int>& modes, FitResult& result) {
  SpecimenResult& specimen = result.specimens[static_cast<std::size_t>(index)];
  double sum = 0.0, n_matched = 0.0;
  for (std::size_t i = 0; i < modes.size(); ++i) {
    const Partial& partial = specimen.partials.partials[i];
    if (modes[i] < 0) {
      specimen.unmatched_partials.push_back(static_cast<int>(i));
      continue;
    }
    PartialMatch match;
    match.specimen = index;
    match.partial = static_cast<int>(i);
    match.mode = modes[i];
    match.frequency_hz = partial.frequency_hz;
    match.frequency_std_hz = partial.frequency_std_hz;
    match.model_frequency_hz = specimen.predicted_frequency_hz[static_cast<std::size_t>(modes[i])];
    match.deviation_cents = cents(match.frequency_hz, match.model_frequency_hz);
    match.decay_per_s = partial.decay_per_s;
    match.decay_std_per_s = partial.decay_std_per_s;
    sum += match.deviation_cents * match.deviation_cents;
    n_matched += 1.0;
    specimen.max_deviation_cents = std::max(specimen.max_deviation_cents, std::abs(match.deviation_cents));
    result.matches.push_back(match);
  }
  if (n_matched > 0.0) specimen.rms_deviation_cents = std::sqrt(sum / n_matched);
  if (n_matched == 0.0 && !modes.empty()) result.warnings.push_back(specimen.name + ": no partial matches a mode");
}

/// Partials of a specimen that took no part in the fit, on the modes that the fit predicts.
void match_prediction(const ParameterSpace& space, const SpectrumModels& models, std::size_t specimen,
                      const PartialTable& table, const FitOptions& options, JointMatch& joint) {
  constexpr double kToleranceCents = 10.0;  // scale of an honest prediction's errors; heavy tails beyond
  joint.lines[specimen] =
      model_lines(model_frequencies(space, models, specimen, joint.fit.x), models[specimen]->visibility());
  joint.matches[specimen] =
      match_partials(table, joint.lines[specimen], 0.0, {kToleranceCents, options.gate_cents, 40.0});
}

/// How far each prediction may be off, into its matches.
void add_prediction_std(const Eigen::VectorXd& relative_std, const std::vector<int>& rank, int specimen,
                        FitResult& result) {
  for (PartialMatch& match : result.matches) {
    if (match.specimen != specimen) continue;
    const auto column = std::find(rank.begin(), rank.end(), match.mode) - rank.begin();
    if (column < relative_std.size()) match.model_frequency_std_hz = relative_std[column] * match.model_frequency_hz;
  }
}

void add_rayleigh(const FitProblem& problem, FitResult& result) {
  const DampingCandidate* rayleigh = find_candidate(result.damping, DampingKind::kRayleigh);
  const DampingCandidate* alone_stiffness = find_candidate(result.damping, DampingKind::kStiffnessOnly);
  const DampingCandidate* alone_mass = find_candidate(result.damping, DampingKind::kMassOnly);
  const auto asked = [&](const char* name) {
    return std::count(problem.parameters.begin(), problem.parameters.end(), name) > 0;
  };
  const bool stiffness = asked("rayleigh_stiffness_s"), mass = asked("rayleigh_mass_per_s");
  const DampingCandidate* source = stiffness && mass ? rayleigh : stiffness ? alone_stiffness : alone_mass;
  for (const std::string& name : problem.parameters) {
    if (name.rfind("rayleigh_", 0) != 0) continue;
    FitParameter parameter;
    parameter.name = name;
    parameter.why = "no decay was measured";
    if (source) {
      for (const FitParameter& candidate : source->parameters) {
        if (candidate.name == name) parameter = candidate;
      }
    }
    // In the order they were asked for, before the derived ones.
    const auto place = std::find_if(result.parameters.begin(), result.parameters.end(),
                                    [](const FitParameter& p) { return p.derived; });
    result.parameters.insert(place, parameter);
  }
}

}  // namespace

std::string to_text(FitStatus status) {
  switch (status) {
    case FitStatus::kNotRun:
      return "not_run";
    case FitStatus::kConverged:
      return "converged";
    case FitStatus::kNotConverged:
      return "not_converged";
    case FitStatus::kNoPartials:
      return "no_partials";
    case FitStatus::kNoMatch:
      return "no_match";
  }
  return "";
}

void FitOptions::validate() const {
  checked("fit options", "n_modes", n_modes, 0, 2000);
  checked("fit options", "gate_cents", gate_cents, 1.0, 600.0);
  checked("fit options", "model_std_cents", model_std_cents, 1e-3, 100.0);
}

FitResult run_fit(const FitProblem& problem, const FitOptions& options, Monitor& monitor) {
  options.validate();
  FitResult result;
  Stopwatch watch;
  const std::size_t n = problem.specimens.size();
  for (const Specimen& specimen : problem.specimens) {
    if (specimen.recordings.empty() && !specimen.partials) {
      throw InputError("specimen " + specimen.name, "has neither recordings nor partials");
    }
  }
  std::vector<Work> work(n);
  for_each_job(
      n, [&](std::size_t s) { read_data(problem.specimens[s], problem.band, work[s], silent_monitor()); }, "partials",
      monitor);
  result.wall_time_s["partials"] = watch.lap();
  std::size_t n_partials = 0;
  for (std::size_t s = 0; s < n; ++s) {
    SpecimenResult specimen;
    specimen.name = problem.specimens[s].name;
    specimen.predicted = problem.specimens[s].predict;
    if (!work[s].ringdowns.empty()) specimen.ringdown = work[s].ringdowns.front();
    if (!work[s].signals.empty()) specimen.recorded = work[s].signals.front();
    specimen.partials = work[s].partials;
    for (const auto& ringdown : work[s].ringdowns) {
      for (const std::string& warning : ringdown.warnings) result.warnings.push_back(specimen.name + ": " + warning);
      if (!ringdown.usable()) result.warnings.push_back(specimen.name + ": " + ringdown.message);
    }
    if (!specimen.predicted) n_partials += specimen.partials.partials.size();
    if (specimen.partials.partials.empty()) result.warnings.push_back(specimen.name + ": no partials");
    result.specimens.push_back(std::move(specimen));
  }
  if (n_partials == 0) {
    result.status = FitStatus::kNoPartials;
    result.message = "no partial stands above the noise";
    for (const auto& warning : result.warnings) result.message += "; " + warning;
    return result;
  }

  FitProblem current = problem;
  std::vector<PartialTable> tables;
  for (std::size_t s = 0; s < n; ++s)
    tables.push_back(problem.specimens[s].predict ? PartialTable{} : work[s].partials);
  JointMatchOptions match_options;
  match_options.gate_cents = options.gate_cents;
  match_options.elastic.model_std = options.model_std_cents * kCent;
  match_options.elastic.robust = options.robust;
  match_options.elastic.priors = problem.priors;
  std::unique_ptr<ParameterSpace> space;
  SpectrumModels models;
  JointMatch joint;
  double seconds_models = 0.0, seconds_match = 0.0;
  for (int round = 0; round < 3; ++round) {
    space = std::make_unique<ParameterSpace>(current);
    for_each_job(
        n,
        [&](std::size_t s) {
          if (work[s].partials.partials.empty()) return;
          build_model(current, *space, s, options, work[s], silent_monitor());
        },
        "models", monitor);
    seconds_models += watch.lap();
    // A specimen without partials takes no part: an empty model would have no modes.
    models.clear();
    std::shared_ptr<const SpectrumModel> any;
    for (const Work& w : work) any = any ? any : std::static_pointer_cast<const SpectrumModel>(w.spectrum);
    for (const Work& w : work) models.push_back(w.spectrum ? w.spectrum : any);
    joint = match_and_fit(*space, models, tables, match_options, monitor);
    seconds_match += watch.lap();
    if (joint.n_matched == 0 || largest_dimension_step(*space, joint.fit.x) <= kRelinearise) break;
    current = at_solution(current, *space, joint.fit.x);
    match_options.search = false;
  }
  result.wall_time_s["models"] = seconds_models;
  result.wall_time_s["match"] = seconds_match;
  if (joint.n_matched == 0) {
    result.status = FitStatus::kNoMatch;
    result.message = "no partial lies near a mode of the model: check dimensions, material and support";
    return result;
  }

  for (std::size_t s = 0; s < n; ++s) {
    if (problem.specimens[s].predict && work[s].spectrum)
      match_prediction(*space, models, s, work[s].partials, options, joint);
  }
  const FitProblem fitted = at_solution(current, *space, joint.fit.x);
  ElasticReport report = elastic_report(*space, joint.fit, joint.leash, current);
  for (FitParameter& parameter : report.parameters) {
    parameter.start_value = ParameterSpace(problem).quantity(parameter.name, ParameterSpace(problem).start()).value;
  }
  result.parameters = std::move(report.parameters);
  result.correlation = std::move(report.correlation);
  result.cost_initial = joint.fit.cost_initial;
  result.cost_final = joint.fit.cost_final;
  result.n_iterations = joint.fit.n_iterations;
  watch.lap();

  for_each_job(
      n,
      [&](std::size_t s) {
        if (work[s].spectrum) solve_final(fitted, s, work[s], result.specimens[s], silent_monitor());
      },
      "final modes", monitor);
  result.wall_time_s["final_modes"] = watch.lap();
  std::vector<std::vector<int>> modes(n);
  for (std::size_t s = 0; s < n; ++s) {
    if (!work[s].spectrum) continue;
    modes[s] = mode_of_partial(result.specimens[s].partials, joint.matches[s], joint.lines[s]);
    const auto rank = ranks_at(*space, models, s, joint.fit.x);
    for (int& mode : modes[s]) {
      if (mode >= 0) mode = rank[static_cast<std::size_t>(mode)];
    }
    add_matches(static_cast<int>(s), modes[s], result);
    if (problem.specimens[s].predict)
      add_prediction_std(prediction_std(*space, models, s, joint.fit, joint.leash), rank, static_cast<int>(s), result);
  }
  std::vector<Eigen::VectorXd> mount_per_kg(n);
  for (std::size_t s = 0; s < n; ++s) {
    if (!work[s].spectrum || problem.specimens[s].mounts.empty()) continue;
    mount_per_kg[s] = mount_decay_per_kg(result.specimens[s].model, problem.specimens[s].mounts);
    for (PartialMatch& match : result.matches) {
      if (match.specimen == static_cast<int>(s) && match.mode < mount_per_kg[s].size())
        match.mount_decay_per_kg = mount_per_kg[s][match.mode];
    }
  }
  if (problem.radiation_damping) {
    for (std::size_t s = 0; s < n; ++s) {
      const auto decay_per_s = radiation_of(result.specimens[s], modes[s], result.warnings, monitor);
      for (PartialMatch& match : result.matches) {
        const auto found = decay_per_s.find(match.mode);
        if (match.specimen == static_cast<int>(s) && found != decay_per_s.end())
          match.radiation_decay_per_s = found->second;
      }
    }
    result.wall_time_s["radiation"] = watch.lap();
  }
  result.damping = fit_damping(decay_points(result), result.warnings);
  add_rayleigh(problem, result);
  const DampingCandidate* damping = result.damping.candidates.empty() ? nullptr : &result.damping.candidates.front();
  for (PartialMatch& match : result.matches) {
    if (damping)
      match.model_decay_per_s =
          damping->decay_per_s(2.0 * kPi * match.model_frequency_hz, match.radiation_decay_per_s.value_or(0.0),
                               match.mount_decay_per_kg.value_or(0.0));
  }
  for (std::size_t s = 0; s < n; ++s) {
    if (!work[s].spectrum) continue;
    SpecimenResult& specimen = result.specimens[s];
    for (std::size_t k = 0; k < specimen.predicted_frequency_hz.size(); ++k) {
      const auto mode = static_cast<Eigen::Index>(k);
      const double mount = mode < mount_per_kg[s].size() ? mount_per_kg[s][mode] : 0.0;
      specimen.predicted_decay_per_s.push_back(
          damping ? damping->decay_per_s(2.0 * kPi * specimen.predicted_frequency_hz[k], 0.0, mount) : 0.0);
    }
    for (const PartialMatch& match : result.matches) {
      if (match.specimen == static_cast<int>(s) && match.model_decay_per_s)
        specimen.predicted_decay_per_s[static_cast<std::size_t>(match.mode)] = *match.model_decay_per_s;
    }
    if (!work[s].ringdowns.empty() && work[s].ringdowns.front().usable()) {
      specimen.fitted = fitted_sound(work[s], specimen, modes[s]);
    }
  }
  result.wall_time_s["sound"] = watch.lap();
  result.status = joint.fit.converged && joint.settled ? FitStatus::kConverged : FitStatus::kNotConverged;
  const double scatter_cents = joint.fit.scatter / kCent;
  char text[160];
  std::snprintf(text, sizeof text, "%d of %zu partials matched; model scatter %.2g cents (estimated, in the intervals)",
                joint.n_matched, n_partials, scatter_cents);
  result.message = text;
  return result;
}

}  // namespace klang::fit
