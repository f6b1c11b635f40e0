#pragma once
#include <complex>
#include <vector>

#include "core/foundation/base/conventions.hpp"
#include "fit/frf/response_set.hpp"

namespace klang::fit::detail {

using Pole = std::complex<double>;  ///< -decay + i omega [1/s], omega > 0

/// Poles of one order of a model.
struct OrderPoles {
  int order = 0;
  std::vector<Pole> poles;  ///< decaying, inside the band, ascending
};

/// Lines of a set within a band (of FRFs), on an even grid.
struct BandLines {
  double first_hz = 0, step_hz = 0;
  Eigen::MatrixXcd values;  ///< responses x lines
};
/// @throws InputError: fewer than 16 lines in band, lines that are not even
BandLines band_lines(const ResponseSet& set, const Band& band);

/// Least-squares complex frequency domain (Guillaume, Verboven, Vanlanduit 1998; Cauberghe et al. 2005), a common denominator for
/// all responses in z = exp(-i 2 pi (f - f1) / B) over the band; the coefficient of the highest power is 1, with which poles of
/// noise grow and only those of the body decay. One entry per order 2, 4 ... most.
std::vector<OrderPoles> lscf_poles(const BandLines& lines, int most);

/// Eigensystem realization (Juang and Pappa 1985) of pulse responses: of free decays as they are, of FRFs by the inverse transform of
/// the band. One entry per order as above.
std::vector<OrderPoles> era_poles(const Eigen::MatrixXcd& pulses, double step_s, double shift_rad_s, const Band& band,
                                  int most);
Eigen::MatrixXcd pulse_responses(const BandLines& lines, Eigen::Index most_samples);

}  // namespace klang::fit::detail
