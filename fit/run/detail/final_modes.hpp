#pragma once
#include <optional>
#include <vector>

#include "fit/run/detail/material_fit.hpp"

namespace klang::fit::detail {

/// All elastic modes of a specimen in the band at the fitted parameters, by a full solve.
struct FinalModes {
  modal::ModalModel model;           ///< up to somewhat above the highest partial
  bool none_missing = false;         ///< proven by a Sturm count
  std::vector<double> frequency_hz;  ///< of all, ascending
  Eigen::VectorXd mesh_relative_error;
};

/// Stage 3: the modes of each specimen, in the problem's order; empty for those without partials.
std::vector<std::optional<FinalModes>> solve_final_modes(const MaterialFit& fit, const MeasuredData& data,
                                                         Monitor& monitor);

}  // namespace klang::fit::detail
