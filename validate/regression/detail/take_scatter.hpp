#pragma once
#include <cstddef>
#include <vector>

namespace klang::validate::detail {

/// Values of one quantity over the takes in which it was found, with their own standard deviations.
struct Samples {
  std::vector<double> value, std;
  std::vector<std::size_t> take;  ///< of each value

  void add(double v, double s, std::size_t from_take);
  double mean() const;
  double variance() const;      ///< of the values; 0 below two
  double own_variance() const;  ///< mean of std^2: what the analyses explain
};

/// Scatter between takes of several quantities of one kind, beyond the analyses' own deviations.
struct Scatter {
  std::vector<double> std;  ///< of each quantity
  double dof = 0.0;         ///< behind each; 0: no quantity is in two takes
};

/// Variances that borrow strength from each other (empirical Bayes): with v_i the variance over the takes, o_i what the analyses
/// explain and E what all have in common beyond it (Paule and Mandel 1982: sum d v / (o + E) = sum d), the ratios v_i / (o_i + E) are drawn towards their prior s0^2 as d0 takes more would:
///   (d0 s0^2 + d_i ratio_i) / (d0 + d_i),  dof = d0 + d_i, never more than all quantities have together.
/// scatter^2 = max(s^2 E, s^2 (o_i + E) - o_i) with that moderated s^2. d0 and s0 follow from the spread of ln(ratio) (trigamma); where that is no wider than chance, d0 is infinite and all
/// quantities share one scatter. Below three quantities: each the larger of its own and the mean.
/// Source: Smyth 2004, Stat. Appl. Genet. Mol. Biol. 3(1), 3, section 6.2.
Scatter moderated_scatter(const std::vector<Samples>& quantities);

/// Standard deviation of the takes' common shift (mean over the quantities found in all takes of value - mean over the takes),
/// where an analysis of variance says that takes do shift as a whole (F of takes over residual above its 0.2 % point); else 0,
/// and the shift's scatter follows from the quantities'.
double common_scatter(const std::vector<Samples>& quantities, std::size_t n_takes);

}  // namespace klang::validate::detail
