#pragma once
#include <Eigen/Core>

#include "core/physics/modal/detail/eigen_problem.hpp"
#include "core/physics/modal/modal_model.hpp"
#include "core/physics/solid/assembly.hpp"

namespace klang::modal::detail {

/// modal/mesh_error.hpp with the factor that `problem` holds.
Eigen::VectorXd hierarchical_frequency_error(const ModalModel& model, const solid::AssembledSolid& assembled,
                                             EigenProblem& problem);

}  // namespace klang::modal::detail
