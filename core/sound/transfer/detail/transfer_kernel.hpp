#pragma once
#include "core/sound/transfer/transfer_layout.hpp"

namespace klang::acoustics::detail {

/// Listeners that share each load of the coefficients.
inline constexpr int kListeners = 4;

/// Real harmonics of width directions at once, width 1 or kListeners: with Y_n^m = q_n^m (s_x + i s_y)^m,
///   out[n (n + 1) + m] = Re Y_n^m (m >= 0),  out[n (n + 1) - m] = Im Y_n^m (m > 0),  width values each.
/// directions: x of all of them, then y, then z. rows: scratch of 4 (order + 1) width. Tables: SphericalHarmonics.
void real_harmonics(int order, int width, const double* diagonal, const double* by_z, const double* by_previous,
                    const double* directions, double* rows, double* out);

/// Pressure of one group of kModeLanes modes at n_listeners <= kListeners listeners,
///   p = sum_n h_n(x) sum_j c_nj y_nj,  h_{n+1} = (2 n + 1) / x h_n - h_{n-1} upward (it loses nothing for h).
/// coefficients: (order + 1)^2 pairs of real and imaginary parts, for the real harmonics; harmonics: of width 1 where
/// n_listeners is 1, else kListeners.
/// start: for each listener 1/x, Re h_0, Im h_0 of each mode. out: for each listener Re p, Im p of each mode.
void group_pressures(int order, int n_listeners, const ModeLanes* coefficients, const double* harmonics,
                     const double* start, double* out);

}  // namespace klang::acoustics::detail
