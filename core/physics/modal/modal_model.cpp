#include "core/physics/modal/modal_model.hpp"

#include <cmath>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/errors.hpp"

namespace klang::modal {

Eigen::VectorXd ModalModel::frequency_hz() const { return angular_frequency_rad_s / (2 * kPi); }

ModalModel with_density(const ModalModel& model, double density_kg_m3) {
  checked_open("modal model", "density_kg_m3", density_kg_m3, 0, HUGE_VAL);
  const double factor = std::sqrt(model.material.density_kg_m3 / density_kg_m3);
  ModalModel result = model;
  result.material.density_kg_m3 = density_kg_m3;
  result.angular_frequency_rad_s *= factor;
  result.shapes *= factor;
  return result;
}

ModalModel with_stiffness_factor(const ModalModel& model, double factor) {
  checked_open("modal model", "stiffness factor", factor, 0, HUGE_VAL);
  ModalModel result = model;
  result.material.lame_lambda_pa *= factor;
  result.material.lame_mu_pa *= factor;
  result.angular_frequency_rad_s *= std::sqrt(factor);
  return result;
}

ModalModel with_size_factor(const ModalModel& model, double factor) {
  checked_open("modal model", "size factor", factor, 0, HUGE_VAL);
  ModalModel result = model;
  result.mesh.nodes_m *= factor;
  result.angular_frequency_rad_s /= factor;
  result.shapes *= std::pow(factor, -1.5);
  return result;
}

}  // namespace klang::modal
