#include "fit/run/detail/measured_data.hpp"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/parallel.hpp"
#include "core/sound/audio/sound_file.hpp"
#include "fit/frf/response_analysis.hpp"
#include "fit/ringdown/merge_partials.hpp"

namespace klang::fit::detail {
namespace {

PartialTable within(const PartialTable& table, const Band& band) {
  PartialTable kept{{}, table.origin, table.left_out_columns};
  for (const Partial& partial : table.partials) {
    if (!partial.is_ring()) continue;
    if (partial.frequency_hz >= band.low_hz && partial.frequency_hz <= band.high_hz) kept.partials.push_back(partial);
  }
  return kept;
}

/// Poles of responses at several places, within their own band and the fit's.
PartialTable read_poles(const std::filesystem::path& path, const Band& band, std::vector<std::string>& notes) {
  const ResponseSet set = read_responses(path);
  const Band whole = whole_band(set);
  ResponseOptions options;
  options.band = {std::max(whole.low_hz, band.low_hz), std::min(whole.high_hz, band.high_hz)};
  if (!(options.band.low_hz < options.band.high_hz))
    throw InputError(path.string(), "has no lines in the fit's band", "",
                     to_text(whole.low_hz) + " to " + to_text(whole.high_hz) + " Hz");
  const ResponseAnalysis analysis = analyse_responses(set, options, silent_monitor());
  notes = analysis.warnings;
  if (!analysis.usable()) notes.push_back(analysis.message);
  return {without_shapes(analysis.partials), path.string(), {}};
}

SpecimenData read_specimen_data(const Specimen& specimen, const Band& band) {
  SpecimenData data;
  if (specimen.partials && is_response_file(*specimen.partials)) {
    data.partials = within(read_poles(*specimen.partials, band, data.notes), band);
    return data;
  }
  if (specimen.partials) {
    data.partials = within(read_partial_table(*specimen.partials, specimen.name), band);
    return data;
  }
  std::vector<PartialTable> tables;
  for (const auto& path : specimen.recordings) {
    if (is_response_file(path))
      throw InputError("specimen " + specimen.name, "measured responses are no recording", path.filename().string(),
                       "partials = \"" + path.filename().string() + "\"");
    data.signals.push_back(audio::read_sound(path));
    RingdownOptions options;
    options.band = band;
    data.ringdowns.push_back(identify_ringdown(data.signals.back(), options, silent_monitor()));
    if (data.ringdowns.back().usable()) tables.push_back(data.ringdowns.back().partials);
  }
  data.n_takes = static_cast<int>(tables.size());
  if (tables.size() > 1) {
    const TakeAgreement agreement = take_agreement(tables);
    data.take_scatter_cents = agreement.scatter * 1200.0 / std::log(2.0);
    data.take_share = agreement.least_share;
  }
  if (tables.size() == 1) data.partials = within(tables.front(), band);
  if (tables.size() > 1) data.partials = within(merge_partials(tables), band);
  return data;
}

}  // namespace

double SpecimenData::highest_partial_hz() const {
  double highest = 0.0;
  for (const Partial& partial : partials.partials) highest = std::max(highest, partial.frequency_hz);
  return highest;
}

MeasuredData read_measured_data(const FitProblem& problem, Monitor& monitor) {
  const std::size_t n = problem.specimens.size();
  for (const Specimen& specimen : problem.specimens) {
    if (specimen.recordings.empty() && !specimen.partials)
      throw InputError("specimen " + specimen.name, "has neither recordings nor partials");
  }
  MeasuredData data;
  data.specimens.resize(n);
  for_each_job(
      n, [&](std::size_t s) { data.specimens[s] = read_specimen_data(problem.specimens[s], problem.band); }, "partials",
      monitor);
  for (std::size_t s = 0; s < n; ++s) {
    const std::string& name = problem.specimens[s].name;
    for (const std::string& column : data.specimens[s].partials.left_out_columns)
      data.warnings.push_back(name + ": the table's column " + column + " is left out: it means nothing here");
    for (const std::string& note : data.specimens[s].notes) data.warnings.push_back(name + ": " + note);
    for (const RingdownResult& ringdown : data.specimens[s].ringdowns) {
      for (const std::string& warning : ringdown.warnings) data.warnings.push_back(name + ": " + warning);
      if (!ringdown.usable()) data.warnings.push_back(name + ": " + ringdown.message);
    }
    const std::size_t n_partials = data.specimens[s].partials.partials.size();
    if (!problem.specimens[s].predict) data.n_fitted_partials += n_partials;
    if (n_partials == 0) data.warnings.push_back(name + ": no partials");
  }
  return data;
}

}  // namespace klang::fit::detail
