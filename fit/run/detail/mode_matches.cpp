#include "fit/run/detail/mode_matches.hpp"

#include <algorithm>

#include "core/foundation/base/checked_index.hpp"
#include "core/foundation/base/conventions.hpp"

namespace klang::fit::detail {
namespace {

/// Mode of each partial (-1: none). Of a line's modes the k-th lowest partial takes the k-th.
std::vector<int> modes_of_partials(const PartialTable& table, const TableMatch& match,
                                   const std::vector<ModelLine>& lines) {
  std::vector<int> modes(table.partials.size(), -1), taken(lines.size(), 0);
  for (std::size_t i = 0; i < table.partials.size(); ++i) {
    const int line = match.line_of_partial[i];
    if (line < 0) continue;
    const std::vector<int>& own = item(lines, line).modes;
    modes[i] = own[std::min<std::size_t>(static_cast<std::size_t>(item(taken, line)++), own.size() - 1)];
  }
  return modes;
}

PartialMatch match_of(const Partial& partial, int mode, double model_frequency_hz) {
  PartialMatch match;
  match.mode = mode;
  match.frequency_hz = partial.frequency_hz;
  match.frequency_std_hz = partial.frequency_std_hz;
  match.model_frequency_hz = model_frequency_hz;
  match.deviation_cents = cents(match.frequency_hz, match.model_frequency_hz);
  match.decay_per_s = partial.decay_per_s;
  match.decay_std_per_s = partial.decay_std_per_s;
  return match;
}

/// How far each prediction may be off, into its match.
void add_prediction_std(const Eigen::VectorXd& relative_std, const std::vector<int>& rank,
                        std::vector<PartialMatch>& matches) {
  for (PartialMatch& match : matches) {
    const auto column = std::find(rank.begin(), rank.end(), match.mode) - rank.begin();
    if (column < relative_std.size()) match.model_frequency_std_hz = relative_std[column] * match.model_frequency_hz;
  }
}

}  // namespace

ModeMatches match_modes(const MaterialFit& fit, const std::vector<SpecimenResult>& specimens) {
  ModeMatches result;
  result.mode_of_partial.resize(specimens.size());
  for (std::size_t s = 0; s < specimens.size(); ++s) {
    if (!fit.specimens[s].spectrum) continue;
    const SpecimenResult& specimen = specimens[s];
    std::vector<int>& modes = result.mode_of_partial[s];
    modes = modes_of_partials(specimen.partials, fit.joint.matches[s], fit.joint.lines[s]);
    const std::vector<int> rank = fit.ranks_at_solution(s);
    std::vector<PartialMatch> matches;
    for (std::size_t i = 0; i < modes.size(); ++i) {
      if (modes[i] < 0) continue;
      modes[i] = item(rank, modes[i]);
      matches.push_back(
          match_of(specimen.partials.partials[i], modes[i], item(specimen.predicted_frequency_hz, modes[i])));
      matches.back().specimen = static_cast<int>(s);
      matches.back().partial = static_cast<int>(i);
    }
    if (specimen.predicted) {
      add_prediction_std(prediction_std(*fit.space, fit.spectra, s, fit.joint.fit, fit.joint.regularisation), rank,
                         matches);
    }
    if (matches.empty() && !modes.empty()) result.warnings.push_back(specimen.name + ": no partial matches a mode");
    result.matches.insert(result.matches.end(), matches.begin(), matches.end());
  }
  return result;
}

}  // namespace klang::fit::detail
