#include "validate/regression/detail/common_reason.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/json.hpp"

namespace klang::validate::detail {
namespace {

constexpr double kStrong = 0.0316;       // of the loudest amplitude, 30 dB
constexpr double kTogetherCents = 12.0;  // of one ratio
constexpr double kMostCents = 2400.0, kLeastCents = 30.0;
constexpr std::size_t kLeastPartials = 4;

std::vector<double> strong_hz(const std::vector<fit::Partial>& partials) {
  double loudest = 0.0;
  for (const fit::Partial& p : partials) loudest = std::max(loudest, p.amplitude.value_or(0.0));
  std::vector<double> hz;
  for (const fit::Partial& p : partials)
    if (p.amplitude.value_or(0.0) >= kStrong * loudest) hz.push_back(p.frequency_hz);
  return hz;
}

/// How many of a, moved by a number of cents, are in b; their mean distance from there is added to shift.
std::size_t count_at(const std::vector<double>& a, const std::vector<double>& b, double& shift_cents) {
  std::size_t n = 0;
  double sum = 0.0;
  for (const double f : a) {
    double nearest = 1e9;
    for (const double g : b) {
      const double apart = cents(g, f) - shift_cents;
      if (std::abs(apart) < std::abs(nearest)) nearest = apart;
    }
    if (!(std::abs(nearest) <= kTogetherCents)) continue;
    ++n;
    sum += nearest;
  }
  if (n > 0) shift_cents += sum / static_cast<double>(n);
  return n;
}

std::string rates_of(double shift_cents) {
  constexpr std::array kRates = {48000.0, 44100.0, 32000.0, 96000.0, 88200.0,
                                 16000.0, 22050.0, 24000.0, 8000.0,  11025.0};
  for (const double a : kRates) {
    for (const double b : kRates) {
      if (a != b && std::abs(cents(a, b) - shift_cents) < 2.0)
        return ", the ratio of " + to_text(a) + " to " + to_text(b) +
               " Hz: the sample rate in one of the files is wrong";
    }
  }
  return "";
}

}  // namespace

std::string common_reason(const std::vector<fit::Partial>& expected, const std::vector<fit::Partial>& found,
                          std::size_t n_pairs) {
  const std::vector<double> a = strong_hz(expected), b = strong_hz(found);
  const std::size_t fewer = std::min(a.size(), b.size());
  double unmoved = 0.0, best_cents = 0.0;
  const std::size_t at_unity = count_at(a, b, unmoved);
  std::size_t best = 0;
  for (const double f : a) {
    for (const double g : b) {
      double shift = cents(g, f);
      if (!(std::abs(shift) <= kMostCents)) continue;
      const std::size_t n = count_at(a, b, shift);
      if (n > best) best = n, best_cents = shift;
    }
  }
  if (best >= kLeastPartials && 10 * best >= 7 * fewer && best >= 2 * at_unity && std::abs(best_cents) > kLeastCents) {
    const double ratio = std::exp2(best_cents / 1200.0);
    return std::to_string(best) + " of " + std::to_string(a.size()) + " strong partials lie " +
           to_text(std::round(10.0 * std::abs(best_cents)) / 10.0) + " cents " + (best_cents > 0 ? "higher" : "lower") +
           ", frequencies times " + to_text(std::round(1e4 * ratio) / 1e4) + rates_of(best_cents);
  }
  if (expected.size() >= kLeastPartials && 10 * n_pairs < 3 * expected.size())
    return "of the reference's " + std::to_string(expected.size()) + " partials the sound has " +
           std::to_string(n_pairs) + ": another object";
  return "";
}

}  // namespace klang::validate::detail
