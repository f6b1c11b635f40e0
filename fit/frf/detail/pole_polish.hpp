#pragma once
#include <optional>
#include <vector>

#include "fit/frf/detail/pole_estimators.hpp"

namespace klang::fit::detail {

/// Poles after least squares over all responses, their residues as linear unknowns (variable projection, Golub and Pereyra 1973).
struct PolishedPoles {
  std::vector<Pole> poles;
  Eigen::MatrixXd covariance;  ///< of decay and omega of pole 0, of pole 1, ... ; empty where the data leave no freedom
  Eigen::MatrixXcd residues;   ///< responses x poles
  double explained = 0;        ///< 1 - |misfit|^2 / |data|^2
  bool converged = false;
};

/// FRFs: (i omega)^k (sum_r A_r / (i omega - p_r) + conj(A_r) / (i omega - conj(p_r)) + U - L / omega^2), k the derivative of the displacement;
/// decays: sum_r Re 2 A_r exp(p_r t) + a constant. U, L complex. Responses count by the inverse of their size.
PolishedPoles polished(const ResponseSet& set, const Band& band, std::vector<Pole> start);

}  // namespace klang::fit::detail
