#include "fit/run/detail/fitted_sound.hpp"

#include <cmath>

#include "core/foundation/base/checked_index.hpp"
#include "core/foundation/base/conventions.hpp"

namespace klang::fit::detail {
namespace {

/// Mode of the row of the merged table that a partial went into; -1: none.
int mode_near(double frequency_hz, const PartialTable& merged, const std::vector<int>& mode_of_partial) {
  int mode = -1;
  double nearest = 15.0;
  for (std::size_t j = 0; j < merged.partials.size(); ++j) {
    const double distance = std::abs(cents(frequency_hz, merged.partials[j].frequency_hz));
    if (distance < nearest) nearest = distance, mode = mode_of_partial[j];
  }
  return mode;
}

}  // namespace

audio::Signal fitted_sound(const SpecimenData& data, const SpecimenResult& specimen,
                           const std::vector<int>& mode_of_partial) {
  if (data.ringdowns.empty() || !data.ringdowns.front().usable()) return {};
  RingdownResult sound = data.ringdowns.front();
  const std::vector<Partial> measured = std::move(sound.partials.partials);
  sound.partials.partials.clear();
  std::vector<std::size_t> kept;
  for (std::size_t i = 0; i < measured.size(); ++i) {
    const int mode = mode_near(measured[i].frequency_hz, specimen.partials, mode_of_partial);
    if (mode < 0) continue;
    Partial partial = measured[i];
    partial.frequency_hz = item(specimen.predicted_frequency_hz, mode);
    const double decay = item(specimen.predicted_decay_per_s, mode);
    if (decay > 0.0) partial.decay_per_s = decay;
    sound.partials.partials.push_back(partial);
    kept.push_back(i);
  }
  for (auto* rows : {&sound.strike_amplitudes, &sound.strike_phases_rad})
    for (std::vector<double>& row : *rows) {
      std::vector<double> own;
      for (const std::size_t i : kept) own.push_back(i < row.size() ? row[i] : 0.0);
      row = std::move(own);
    }
  return resynthesise(sound, data.signals.front().n_frames());
}

}  // namespace klang::fit::detail
