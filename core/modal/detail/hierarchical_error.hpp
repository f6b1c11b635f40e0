#pragma once
#include <Eigen/Core>

#include "core/modal/detail/eigen_problem.hpp"
#include "core/modal/modal_model.hpp"
#include "core/solid/assembly.hpp"

namespace klang::modal::detail {

/// modal/mesh_error.hpp with the factor that `problem` holds.
Eigen::VectorXd hierarchical_frequency_error(const ModalModel& model, const solid::AssembledSolid& assembled,
                                             EigenProblem& problem);

}  // namespace klang::modal::detail
