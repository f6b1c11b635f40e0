#include "core/physics/modal/mesh_error.hpp"

#include "core/foundation/base/errors.hpp"
#include "core/physics/modal/detail/eigen_problem.hpp"
#include "core/physics/modal/detail/hierarchical_error.hpp"

namespace klang::modal {

Eigen::VectorXd estimate_frequency_error(const ModalModel& model, const solid::AssembledSolid& assembled) {
  if (assembled.n_mesh_nodes != model.mesh.n_nodes()) {
    throw InputError("mesh error", "the matrices belong to another mesh",
                     std::to_string(assembled.n_mesh_nodes) + " nodes", std::to_string(model.mesh.n_nodes()));
  }
  if (model.n_modes() == 0) return {};
  detail::EigenProblem problem(model.mesh, assembled, model.material);
  std::string message;
  if (!problem.factor(message)) throw NumericalError("mesh error: " + message);
  return detail::hierarchical_frequency_error(model, assembled, problem);
}

}  // namespace klang::modal
