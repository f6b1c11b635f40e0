#pragma once
#include <optional>
#include <string>
#include <vector>

#include "core/foundation/base/monitor.hpp"
#include "fit/ringdown/ringdown.hpp"
#include "fit/specimen/specimen.hpp"

namespace klang::fit::detail {

/// What was measured of one specimen.
struct SpecimenData {
  std::vector<audio::Signal> signals;        ///< one per recording; none where the partials were measured elsewhere
  std::vector<RingdownResult> ringdowns;     ///< one per signal
  PartialTable partials;                     ///< of all recordings together, within the band
  int n_takes = 0;                           ///< recordings that have partials; 0: a table made elsewhere
  std::optional<double> take_scatter_cents;  ///< typical deviation of a partial from take to take; empty: one take
  std::optional<double> take_share;          ///< least share of a take's strong partials that other takes have too
  std::vector<std::string> notes;            ///< of measured responses
  double highest_partial_hz() const;         ///< 0 without partials
};

struct MeasuredData {
  std::vector<SpecimenData> specimens;  ///< in the problem's order
  std::size_t n_fitted_partials = 0;    ///< of the specimens that take part in the fit
  std::vector<std::string> warnings;    ///< "NAME: ..."
};

/// Stage 1: recordings and tables of partials.
/// @throws InputError for a specimen with neither, and as read_sound and read_partial_table
MeasuredData read_measured_data(const FitProblem& problem, Monitor& monitor);

}  // namespace klang::fit::detail
