#include "fit/ringdown/bell.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace klang::fit {
namespace {

/// A partial that stands at a ratio to the nominal.
struct Degree {
  double ratio, gate_cents;
  bool named;  ///< of the four below the nominal; the two above support it only
};
constexpr std::array<Degree, 6> kDegrees{{{0.25, 250.0, true},
                                          {0.5, 150.0, true},
                                          {0.6, 150.0, true},
                                          {0.75, 150.0, true},
                                          {1.5, 150.0, false},
                                          {2.0, 150.0, false}}};
constexpr double kDoubletCents = 25.0;
constexpr int kFewestNamed = 3;

double cents_between(double a, double b) { return 1200.0 * std::log2(a / b); }

/// The nearest partial to a frequency within a gate, or the loudest of its doublet; null: none.
const Partial* partial_near(const std::vector<Partial>& partials, double frequency_hz, double gate_cents) {
  const Partial* nearest = nullptr;
  double least = gate_cents;
  for (const Partial& partial : partials) {
    const double off = std::abs(cents_between(partial.frequency_hz, frequency_hz));
    if (off > least) continue;
    least = off;
    nearest = &partial;
  }
  if (nearest == nullptr) return nullptr;
  const Partial* loudest = nearest;
  for (const Partial& partial : partials) {
    const bool doublet = std::abs(cents_between(partial.frequency_hz, nearest->frequency_hz)) <= kDoubletCents;
    if (doublet && partial.amplitude.value_or(0.0) > loudest->amplitude.value_or(0.0)) loudest = &partial;
  }
  return loudest;
}

struct Reading {
  std::array<const Partial*, 6> at{};
  double score = 0.0;
  int n_named = 0;
};

Reading reading_about(const std::vector<Partial>& partials, const Partial& nominal) {
  Reading reading;
  for (std::size_t i = 0; i < kDegrees.size(); ++i) {
    const Degree& degree = kDegrees[i];
    const double wanted = degree.ratio * nominal.frequency_hz;
    reading.at[i] = partial_near(partials, wanted, degree.gate_cents);
    if (reading.at[i] == nullptr) continue;
    const double off = cents_between(reading.at[i]->frequency_hz, wanted) / degree.gate_cents;
    reading.score += (degree.named ? 1.0 : 0.5) * std::exp(-0.5 * std::pow(2.0 * off, 2));
    reading.n_named += degree.named ? 1 : 0;
  }
  return reading;
}

double energy_of(const Partial& partial) {
  return std::pow(partial.amplitude.value_or(1.0), 2) / std::max(partial.decay_per_s.value_or(1.0), 1e-3);
}

/// Whether something rings below the hum, by its energy: then this is no bell, or another partial is the nominal. A clapper's thud does not
/// last.
bool sounds_below(const std::vector<Partial>& partials, const Reading& reading, const Partial& nominal) {
  constexpr double kBeside = 3e-4;  // -35 dB
  const Degree& hum = kDegrees[0];
  const double lowest_hz = hum.ratio * nominal.frequency_hz * std::exp2(-hum.gate_cents / 1200.0);
  double named = energy_of(nominal);
  for (std::size_t i = 0; i < kDegrees.size(); ++i)
    if (kDegrees[i].named && reading.at[i] != nullptr) named = std::max(named, energy_of(*reading.at[i]));
  return std::any_of(partials.begin(), partials.end(), [&](const Partial& partial) {
    return partial.frequency_hz < lowest_hz && energy_of(partial) > kBeside * named;
  });
}

/// Whether the ring with the most energy, or one of its doublet, is among what a reading names.
bool holds_strongest(const std::vector<Partial>& partials, const Reading& reading, const Partial& nominal) {
  const auto strongest = std::max_element(
      partials.begin(), partials.end(), [](const Partial& a, const Partial& b) { return energy_of(a) < energy_of(b); });
  const auto is_it = [&](const Partial* partial) {
    return partial != nullptr &&
           std::abs(cents_between(partial->frequency_hz, strongest->frequency_hz)) <= kDoubletCents;
  };
  bool any = is_it(&nominal);
  for (std::size_t i = 0; i < kDegrees.size(); ++i) any = any || (kDegrees[i].named && is_it(reading.at[i]));
  return any;
}

std::optional<double> frequency_of(const Partial* partial) {
  if (partial == nullptr) return std::nullopt;
  return partial->frequency_hz;
}

}  // namespace

Bell name_bell(const std::vector<Partial>& partials, double a4_hz) {
  std::vector<Partial> rings;
  for (const Partial& partial : partials)
    if (partial.is_ring()) rings.push_back(partial);
  Reading best;
  const Partial* nominal = nullptr;
  for (const Partial& candidate : rings) {
    const Reading reading = reading_about(rings, candidate);
    if (reading.n_named < kFewestNamed || reading.score <= best.score) continue;
    if (sounds_below(rings, reading, candidate) || !holds_strongest(rings, reading, candidate)) continue;
    best = reading;
    nominal = &candidate;
  }
  Bell bell;
  if (nominal == nullptr) return bell;
  nominal = partial_near(rings, nominal->frequency_hz, 0.0);  // the louder of its doublet
  bell.hum_hz = frequency_of(best.at[0]);
  bell.prime_hz = frequency_of(best.at[1]);
  bell.tierce_hz = frequency_of(best.at[2]);
  bell.quint_hz = frequency_of(best.at[3]);
  bell.nominal_hz = nominal->frequency_hz;
  bell.strike_note_hz = 0.5 * nominal->frequency_hz;
  bell.strike_note = audio::nearest_note(*bell.strike_note_hz, a4_hz).name;
  return bell;
}

}  // namespace klang::fit
