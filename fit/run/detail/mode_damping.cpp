#include "fit/run/detail/mode_damping.hpp"

#include <algorithm>
#include <iterator>
#include <map>

#include "core/foundation/base/checked_index.hpp"
#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/stopwatch.hpp"
#include "core/physics/modal/damping/damping_laws.hpp"
#include "core/sound/transfer/radiate.hpp"

namespace klang::fit::detail {
namespace {

/// Decay by dampers of 1 N s/m at the mounts of each mode of each specimen, into the matches too.
std::vector<Eigen::VectorXd> mount_decays(const FitProblem& problem, const std::vector<SpecimenResult>& specimens,
                                          std::vector<PartialMatch>& matches) {
  std::vector<Eigen::VectorXd> per_kg(specimens.size());
  for (std::size_t s = 0; s < specimens.size(); ++s) {
    if (specimens[s].predicted_frequency_hz.empty() || problem.specimens[s].mounts.empty()) continue;
    per_kg[s] = mount_decay_per_kg(specimens[s].model, problem.specimens[s].mounts);
    for (PartialMatch& match : matches) {
      if (match.specimen == static_cast<int>(s) && match.mode < per_kg[s].size())
        match.mount_decay_per_kg = per_kg[s][match.mode];
    }
  }
  return per_kg;
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
  std::vector<Eigen::Index> columns;
  for (const auto& [mode, value] : decay_per_s) columns.push_back(mode);
  matched.angular_frequency_rad_s = specimen.model.angular_frequency_rad_s(columns);
  matched.shapes = specimen.model.shapes(Eigen::all, columns);
  const acoustics::RadiateResult radiated = acoustics::radiate(matched, {}, monitor);
  if (!radiated.usable()) {
    warnings.push_back(specimen.name + ": no radiation: " + radiated.message);
    return {};
  }
  for (const acoustics::ModeTransfer& mode : radiated.transfer.modes)
    decay_per_s[static_cast<int>(item(columns, mode.mode))] = mode.decay_radiation_per_s;
  return decay_per_s;
}

void add_radiation(const std::vector<SpecimenResult>& specimens, ModeMatches& matches,
                   std::vector<std::string>& warnings, Monitor& monitor) {
  for (std::size_t s = 0; s < specimens.size(); ++s) {
    const auto decay_per_s = radiation_of(specimens[s], matches.mode_of_partial[s], warnings, monitor);
    for (PartialMatch& match : matches.matches) {
      const auto found = decay_per_s.find(match.mode);
      if (match.specimen == static_cast<int>(s) && found != decay_per_s.end())
        match.radiation_decay_per_s = found->second;
    }
  }
}

std::vector<DecayPoint> decay_points(const std::vector<SpecimenResult>& specimens,
                                     const std::vector<PartialMatch>& matches) {
  std::vector<DecayPoint> points;
  for (const PartialMatch& match : matches) {
    if (!match.decay_per_s || item(specimens, match.specimen).predicted) continue;
    points.push_back({match.frequency_hz, *match.decay_per_s, match.decay_std_per_s.value_or(0.0),
                      match.radiation_decay_per_s.value_or(0.0), match.mount_decay_per_kg.value_or(0.0)});
  }
  return points;
}

/// The asked numbers of a damping law, by the law that has just these.
std::vector<FitParameter> law_parameters(const std::vector<std::string>& asked, const DampingResult& damping) {
  std::vector<std::string> names;
  std::copy_if(asked.begin(), asked.end(), std::back_inserter(names), damping::is_law_parameter);
  const damping::DampingLaw* law = damping::law_of_parameters(names);
  const DampingCandidate* source = law ? find_candidate(damping, *law) : nullptr;
  std::vector<FitParameter> parameters;
  for (const std::string& name : names) {
    FitParameter& parameter = parameters.emplace_back();
    parameter.name = name;
    parameter.why = "no decay was measured";
    if (source) {
      for (const FitParameter& candidate : source->parameters) {
        if (candidate.name == name) parameter = candidate;
      }
    }
  }
  return parameters;
}

std::vector<double> predicted_decays(const SpecimenResult& specimen, const DampingCandidate* damping,
                                     const Eigen::VectorXd& mount_per_kg) {
  std::vector<double> decay_per_s;
  for (std::size_t k = 0; k < specimen.predicted_frequency_hz.size(); ++k) {
    const auto mode = static_cast<Eigen::Index>(k);
    const double mount = mode < mount_per_kg.size() ? mount_per_kg[mode] : 0.0;
    decay_per_s.push_back(damping ? damping->decay_per_s(2.0 * kPi * specimen.predicted_frequency_hz[k], 0.0, mount)
                                  : 0.0);
  }
  return decay_per_s;
}

}  // namespace

ModeDamping fit_mode_damping(const FitProblem& problem, const std::vector<SpecimenResult>& specimens,
                             ModeMatches& matches, Monitor& monitor) {
  ModeDamping result;
  const std::vector<Eigen::VectorXd> mount_per_kg = mount_decays(problem, specimens, matches.matches);
  if (problem.radiation_damping) {
    const Stopwatch watch;
    add_radiation(specimens, matches, result.warnings, monitor);
    result.radiation_wall_time_s = watch.seconds();
  }
  result.damping = fit_damping(decay_points(specimens, matches.matches), result.warnings);
  result.law_parameters = law_parameters(problem.parameters, result.damping);
  const DampingCandidate* best = result.damping.candidates.empty() ? nullptr : &result.damping.candidates.front();
  for (std::size_t s = 0; s < specimens.size(); ++s)
    result.predicted_decay_per_s.push_back(predicted_decays(specimens[s], best, mount_per_kg[s]));
  for (PartialMatch& match : matches.matches) {
    if (!best) continue;
    match.model_decay_per_s =
        best->decay_per_s(2.0 * kPi * match.model_frequency_hz, match.radiation_decay_per_s.value_or(0.0),
                          match.mount_decay_per_kg.value_or(0.0));
    item(item(result.predicted_decay_per_s, match.specimen), match.mode) = *match.model_decay_per_s;
  }
  return result;
}

}  // namespace klang::fit::detail
