#include "fit/bubble/recording_verdict.hpp"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/json.hpp"

namespace klang::fit::bubble {
namespace {

// Limits of the verdict, between what real drops and what other sounds show (docs/bubbles.md).
constexpr double kLeastExplained = 0.15, kLeastBubbles = 0.5;
constexpr double kMostStruck = 0.5, kMostGliding = 0.7, kMostFalling = 0.65, kMostDriven = 0.7;

constexpr double kTogetherS = 0.003, kSteady = 0.05, kPartnerEnergy = 0.003;
constexpr std::size_t kStruckRings = 3;
constexpr double kNextS = 0.002, kGapS = 0.005, kGapShare = 0.5, kSamePitch = 0.06, kLikeEnergy = 0.03;

double energy(const FoundBubble& ring) { return std::pow(10.0, 0.1 * ring.snr_db); }

/// ln of the pitch at a time of the recording; before the onset and after the end as there.
double log_pitch(const FoundBubble& ring, double time_s) {
  const double since =
      std::clamp(time_s, ring.chirp.onset_s, std::max(ring.end_s, ring.chirp.onset_s)) - ring.chirp.onset_s;
  return ring.chirp.log_frequency + ring.law.pitch_at(since, ring.chirp.pitch).log_ratio;
}

double rise(const FoundBubble& ring) { return log_pitch(ring, ring.end_s) - ring.chirp.log_frequency; }

bool is_clear(const FoundBubble& ring) { return ring.verdict != BubbleVerdict::kUnclear; }

/// Whether b begins while a rings or just after it, at a's pitch there: pieces of one gliding tone.
bool goes_on(const FoundBubble& a, const FoundBubble& b) {
  const double after = b.chirp.onset_s - a.chirp.onset_s, life = a.end_s - a.chirp.onset_s;
  if (!(after >= kNextS && b.chirp.onset_s <= a.end_s + kGapS + kGapShare * life)) return false;
  if (!(energy(b) > kLikeEnergy * energy(a) && energy(a) > kLikeEnergy * energy(b))) return false;
  return std::abs(b.chirp.log_frequency - log_pitch(a, b.chirp.onset_s)) < kSamePitch;
}

std::string per_cent(double share) { return to_text(std::round(100.0 * share)) + " %"; }

}  // namespace

RecordingEvidence evidence_of(const BubbleSearchResult& found) {
  RecordingEvidence e;
  const std::vector<FoundBubble>& rings = found.found;
  double all = 0.0, clear = 0.0;
  std::vector<bool> struck(rings.size(), false), gliding(rings.size(), false);
  for (std::size_t i = 0; i < rings.size(); ++i) {
    all += energy(rings[i]);
    if (is_clear(rings[i])) clear += energy(rings[i]);
    std::vector<std::size_t> together;
    for (std::size_t j = 0; j < rings.size(); ++j) {
      const bool steady = std::abs(rise(rings[i])) < kSteady && std::abs(rise(rings[j])) < kSteady;
      if (steady && std::abs(rings[j].chirp.onset_s - rings[i].chirp.onset_s) < kTogetherS &&
          energy(rings[j]) > kPartnerEnergy * energy(rings[i]))
        together.push_back(j);
      if (i != j && is_clear(rings[i]) && is_clear(rings[j]) && goes_on(rings[i], rings[j]))
        gliding[i] = gliding[j] = true;
    }
    if (together.size() < kStruckRings) continue;
    for (const std::size_t j : together) struck[j] = true;
  }
  if (!(all > 0.0)) return e;
  for (std::size_t i = 0; i < rings.size(); ++i) {
    const FoundBubble& ring = rings[i];
    if (struck[i]) e.struck += energy(ring) / all;
    if (ring.is_bubble()) e.explained += found.explained_above_noise.value_or(0.0) * energy(ring) / all;
    if (!is_clear(ring)) continue;
    const double share = energy(ring) / clear;
    if (ring.is_bubble()) e.bubbles += share;
    if (gliding[i]) e.gliding += share;
    if (rise(ring) < -kSteady) e.falling += share;
    if (ring.verdict == BubbleVerdict::kDriven) e.driven += share;
  }
  return e;
}

std::string refusal_of(const BubbleSearchResult& found, const RecordingEvidence& e) {
  const bool any =
      std::any_of(found.found.begin(), found.found.end(), [](const FoundBubble& b) { return b.is_bubble(); });
  if (!any) return found.found.empty() ? "no decaying chirp stands above the noise" : "no ring in it is a bubble's";
  if (e.struck > kMostStruck)
    return per_cent(e.struck) + " of the rings' energy begins as three or more of steady pitch at once: a struck body";
  if (e.gliding > kMostGliding)
    return per_cent(e.gliding) + " of the rings' energy goes on where another ring ends, at its pitch: a gliding tone";
  if (e.falling > kMostFalling)
    return "the pitch falls in " + per_cent(e.falling) + " of the rings' energy; a bubble's keeps or rises";
  if (e.driven > kMostDriven)
    return "the amplitude does not fall as a free bubble's in " + per_cent(e.driven) + " of the rings' energy";
  if (e.bubbles < kLeastBubbles)
    return "bubbles hold " + per_cent(e.bubbles) +
           " of the rings' energy; the rest rings longer or shorter than one can";
  if (e.explained < kLeastExplained)
    return "bubbles explain " + per_cent(e.explained) + " of the energy above the noise";
  return "";
}

}  // namespace klang::fit::bubble
