#include "fit/bubble/bubble_document.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>
#include <string>

#include "core/foundation/base/errors.hpp"
#include "core/physics/bubble/bubble_physics.hpp"

namespace klang::fit::bubble {
namespace {

constexpr int kTrackSteps = 24;
constexpr double kLeastTheoryRadius_m = 2e-4, kLargestTheoryRadius_m = 0.016, kTheoryRatio = 1.12;

BubbleRecord bubble_record(const FoundBubble& b) {
  BubbleRecord record;
  const double f = std::exp(b.chirp.log_frequency), beta = std::exp(b.chirp.log_decay);
  const double life_s = b.end_s - b.chirp.onset_s;
  std::vector<double> times;
  for (int i = 0; i <= kTrackSteps; ++i) times.push_back(life_s * i / static_cast<double>(kTrackSteps));
  record.frequency_end_hz = f;
  for (const ChirpPoint& point : chirp_track(b.law, b.chirp, times)) {
    record.track.time_s.push_back(b.chirp.onset_s + point.time_s);
    record.track.frequency_hz.push_back(point.frequency_hz);
    record.frequency_end_hz = point.frequency_hz;
  }
  const auto spread = [&](int i, double unit = 1.0) {
    return b.covariance ? std::optional(unit * std::sqrt((*b.covariance)(i, i))) : std::nullopt;
  };
  record.onset_s = b.chirp.onset_s;
  record.onset_std_s = spread(2);
  record.end_s = b.end_s;
  if (b.law.rest_s) record.rest_s = b.chirp.onset_s + *b.law.rest_s;
  record.frequency_start_hz = f;
  record.frequency_start_std_hz = spread(3, f);
  record.chirp_rate_per_s = b.chirp.pitch[0];
  record.chirp_rate_std_per_s = spread(0);
  record.chirp_growth_per_s = b.chirp.pitch[1];
  record.chirp_growth_std_per_s = spread(1);
  record.decay_per_s = beta;
  record.decay_std_per_s = spread(4, beta);
  record.theory_decay_per_s = b.theory_decay_per_s;
  record.radius_m = b.radius_m;
  record.radius_std_m = b.radius_std_m;
  record.amplitude = std::hypot(b.chirp.cosine, b.chirp.sine);
  record.snr_db = b.snr_db;
  record.attack = b.law.soft_attack() ? "soft" : "quick";
  record.verdict = words(b.verdict);
  return record;
}

PitchRecord pitch_record(const PitchNumber& n) {
  PitchRecord record;
  record.value = n.value;
  record.std = n.standard_deviation;
  record.identifiable = n.determined;
  if (n.low95) record.ci95 = {*n.low95, *n.high95};
  return record;
}

PitchFitRecord pitch_fit_record(const PitchFitResult& pitch) {
  PitchFitRecord record;
  record.status = pitch.status == PitchStatus::kNotRun ? PitchStatus::kFailed : pitch.status;
  record.message = pitch.message;
  record.n_bubbles = static_cast<int>(pitch.n_bubbles);
  record.chi_square_per_datum = pitch.chi_square_per_datum;
  for (const PitchNumber& n : pitch.parameters) {
    record.parameters.push_back(pitch_record(n));
    record.parameters.back().name = n.name;
  }
  for (const PitchNumber& n : pitch.identifiable) {
    record.identifiable.push_back(pitch_record(n));
    record.identifiable.back().combination = n.name;
  }
  return record;
}

TheoryRecord theory_record(const BubbleSearchOptions& search) {
  TheoryRecord record;
  for (double radius_m = kLeastTheoryRadius_m; radius_m < kLargestTheoryRadius_m; radius_m *= kTheoryRatio) {
    const auto at = klang::bubble::bubble_oscillation(radius_m, search.medium, search.theory);
    record.frequency_hz.push_back(at.damped_frequency_hz);
    record.decay_per_s.push_back(at.decay_per_s);
  }
  return record;
}

/// Real gas is neither adiabatic nor the formula's: what the other theory of heat would make of the same pitches.
std::optional<std::string> heat_warning(const std::vector<BubbleRecord>& bubbles, const BubbleSearchOptions& search) {
  using klang::bubble::BubbleTheory;
  if (search.theory != BubbleTheory::kLeighton || bubbles.empty()) return std::nullopt;
  double least = 1e300, most = 0.0;
  bool matters = false;
  for (const BubbleRecord& bubble : bubbles) {
    const double smaller =
        1.0 -
        radius_of_frequency_m(bubble.frequency_start_hz, search.medium, BubbleTheory::kProsperetti) / bubble.radius_m;
    least = std::min(least, smaller);
    most = std::max(most, smaller);
    matters = matters || smaller * bubble.radius_m > 2.0 * bubble.radius_std_m.value_or(0.0);
  }
  if (!matters) return std::nullopt;
  char text[200];
  std::snprintf(text, sizeof text,
                "radii are those of the adiabatic pitch; the exact theory of heat (--thermal prosperetti) makes them "
                "%.1f to %.1f %% "
                "smaller, which their deviations do not hold",
                100.0 * least, 100.0 * most);
  return text;
}

}  // namespace

void BubblesDocument::check(const std::string& place) const {
  for (const auto& [list, rings] : {std::pair{"bubbles", &bubbles}, {"rejected", &rejected}}) {
    for (std::size_t i = 0; i < rings->size(); ++i) {
      const TrackRecord& track = (*rings)[i].track;
      if (track.time_s.size() != track.frequency_hz.size())
        throw InputError(place + "." + list + "[" + std::to_string(i) + "].track", "lists differ in length");
    }
  }
  if (theory.frequency_hz.size() != theory.decay_per_s.size())
    throw InputError(place + ".theory", "lists differ in length");
}

BubblesDocument bubbles_document(ResultHeader header, const BubbleSearchResult& found, const PitchFitResult& pitch,
                                 const BubbleSearchOptions& search) {
  BubblesDocument document;
  document.header = std::move(header);
  for (const FoundBubble& b : found.found)
    (b.is_bubble() ? document.bubbles : document.rejected).push_back(bubble_record(b));
  document.evidence = evidence_of(found);
  const std::string refusal = refusal_of(found, *document.evidence);
  document.header.status = document.bubbles.empty() ? "nothing_found" : refusal.empty() ? "ok" : "not_bubbles";
  if (!refusal.empty()) document.header.message = refusal;
  if (found.stopped_early)
    document.header.warnings.push_back(
        "the search ended at its limit of work: weaker rings were not searched for; --max-work raises it");
  if (auto warning = heat_warning(document.bubbles, search)) document.header.warnings.push_back(*warning);
  document.explained_energy = found.explained_energy;
  document.theory = theory_record(search);
  document.pitch = pitch_fit_record(pitch);
  return document;
}

}  // namespace klang::fit::bubble
