#pragma once
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "core/foundation/config/fields.hpp"

namespace klang::validate {

/// How errors should fall.
///   kAlgebraic: error ~ C h^p;        the order is p
///   kGeometric: error ~ C e^(-q n);   the "order" is the rate q in nepers per step of n
///   kRoundOff:  no trend; every level is at the last digits
enum class Convergence { kAlgebraic, kGeometric, kRoundOff };
constexpr auto words_of(Convergence) {
  return std::array{Word{Convergence::kAlgebraic, "algebraic"}, Word{Convergence::kGeometric, "geometric"},
                    Word{Convergence::kRoundOff, "round_off"}};
}

enum class OrderStatus { kNotRun, kEstimated, kTooFewLevels };

struct OrderEstimate {
  OrderStatus status = OrderStatus::kNotRun;
  std::optional<double> observed_order;  ///< slope of the least-squares line
  std::optional<std::array<double, 2>>
      ci95;  ///< of the slope, Student's t with n_used - 2 degrees of freedom; needs 3 levels
  std::vector<std::optional<double>>
      pairwise;                       ///< n_levels; slope from the level before to this one, empty for the first
  std::vector<std::string> excluded;  ///< n_levels; why a level is not in the fit, empty where it is
  int n_used = 0;
  std::optional<bool> asymptotic;  ///< the last two pairwise orders agree within 15 % of the fitted one
};

/// Observed order of errors over step sizes.
///   algebraic: least squares of ln(error) over ln(h);  geometric: of ln(error) over -n
/// Two rules leave levels out, neither of which looks at the order that is expected:
///   floor            error <= error_floor (round-off, or the accuracy of the reference), and every finer level after it
///   pre-asymptotic   as long as more than four levels are left: the coarsest, where its pairwise order lies further than a
///                    quarter from the median of the others
/// @param step   h (coarse to fine, falling) or n (rising); n_levels, > 0
/// @param error  n_levels, >= 0; a level whose error is not finite or is 0 is left out ("no error")
OrderEstimate estimate_order(const std::vector<double>& step, const std::vector<double>& error, Convergence kind,
                             double error_floor = 0.0);

/// Richardson extrapolation and grid convergence index of three levels, finest first.
///   p from |ln|e32/e21| + q(p)| / ln r21,  q(p) = ln((r21^p - s) / (r32^p - s)),  s = sign(e32/e21)
///   extrapolated = (r21^p f1 - f2) / (r21^p - 1)
///   gci_fine = safety |(f1 - f2) / f1| / (r21^p - 1),  gci_coarse the same one level up
/// Source: Celik et al. 2008, J. Fluids Eng. 130, 078001; safety factor 1.25 for three levels after Roache 1998.
struct GridConvergence {
  double order = 0.0;
  double extrapolated = 0.0;
  double gci_fine = 0.0;          ///< relative to f1
  double gci_coarse = 0.0;        ///< relative to f2
  double asymptotic_ratio = 0.0;  ///< gci_coarse / (r21^p gci_fine); near 1 in the asymptotic range
  bool oscillating = false;
};

/// @param h      finest first, rising, > 0
/// @param value  the same levels
/// @return empty where two values agree or no order solves the equation
std::optional<GridConvergence> grid_convergence(const std::array<double, 3>& h, const std::array<double, 3>& value,
                                                double safety = 1.25);

/// Reference for a study without an exact one: value ~ limit + C h^p by least squares over all levels (p by a search
/// between 0.2 and 12, limit and C linear). @return limit and p; empty below three levels or without a trend
struct RichardsonLimit {
  double limit = 0.0, order = 0.0;
};
std::optional<RichardsonLimit> richardson_limit(const std::vector<double>& h, const std::vector<double>& value);

}  // namespace klang::validate
