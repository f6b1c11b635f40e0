#include "core/physics/entrainment/radii.hpp"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/errors.hpp"
#include "core/physics/bubble/bubble_medium.hpp"

namespace klang::entrainment {
namespace {

constexpr double kHinze_m = 1e-3, kBelow = -1.5, kAbove = -10.0 / 3.0;
constexpr double kSmear = 0.1;  // standard deviation in ln r
constexpr int kMostTurns = 100'000;

/// Integral of (r / Hinze)^slope from a to b.
double power_integral(double slope, double a, double b) {
  const double n = slope + 1.0;
  return kHinze_m / n * (std::pow(b / kHinze_m, n) - std::pow(a / kHinze_m, n));
}
/// The b at which that is `integral`.
double power_end(double slope, double a, double integral) {
  const double n = slope + 1.0;
  return kHinze_m * std::pow(std::pow(a / kHinze_m, n) + n * integral / kHinze_m, 1.0 / n);
}

double deane_stokes(double share, double smallest_m, double largest_m) {
  const double middle = std::clamp(kHinze_m, smallest_m, largest_m);
  const double below = middle > smallest_m ? power_integral(kBelow, smallest_m, middle) : 0.0;
  const double above = largest_m > middle ? power_integral(kAbove, middle, largest_m) : 0.0;
  const double wanted = share * (below + above);
  const double r = wanted < below ? power_end(kBelow, smallest_m, wanted) : power_end(kAbove, middle, wanted - below);
  return std::clamp(r, smallest_m, largest_m);
}

}  // namespace

void RadiusDistribution::validate() const {
  checked("radii", "smallest_m", smallest_m, bubble::kSmallestRadiusM, bubble::kLargestRadiusM);
  checked("radii", "largest_m", largest_m, smallest_m, bubble::kLargestRadiusM);
  if (kind == Kind::kGaussian) {
    checked("radii", "mean_m", mean_m, smallest_m, largest_m);
    checked("radii", "std_m", std_m, 0.0, 1.0);
  }
  if (kind != Kind::kRecorded) return;
  const bool any =
      std::any_of(recorded_m.begin(), recorded_m.end(), [&](double r) { return r >= smallest_m && r <= largest_m; });
  if (!any)
    throw InputError("radii", "the recording has no radius within the limits",
                     std::to_string(recorded_m.size()) + " radii",
                     to_text(smallest_m) + " to " + to_text(largest_m) + " m");
}

double RadiusDistribution::draw(RandomStream& random) const {
  switch (kind) {
    case Kind::kDeaneStokes:
      return deane_stokes(random.uniform(), smallest_m, largest_m);
    case Kind::kGaussian:
      for (int turn = 0; turn < kMostTurns; ++turn) {
        const double r = mean_m + std_m * random.normal();
        if (r >= smallest_m && r <= largest_m) return r;
      }
      return mean_m;
    case Kind::kRecorded:
      for (int turn = 0; turn < kMostTurns; ++turn) {
        const double seen = recorded_m[random.below(static_cast<std::uint32_t>(recorded_m.size()))];
        const double r = seen * std::exp(kSmear * random.normal());
        if (r >= smallest_m && r <= largest_m) return r;
      }
      return smallest_m;
  }
  return smallest_m;
}

}  // namespace klang::entrainment
