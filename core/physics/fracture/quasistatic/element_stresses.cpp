#include "core/physics/fracture/quasistatic/element_stresses.hpp"

#include <Eigen/LU>
#include <array>
#include <cmath>

#include "core/foundation/base/check.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/parallel.hpp"
#include "core/foundation/math/tet_rule.hpp"
#include "core/physics/fracture/quasistatic/detail/corner_fit.hpp"
#include "core/physics/fracture/quasistatic/detail/quadratic_tet.hpp"

namespace klang::fracture {
namespace {

constexpr std::size_t kGrain = 512;  // elements

using detail::quadratic_derivative;
using detail::QuadraticDerivative;

struct Rules {
  std::array<QuadraticDerivative, 4> corner;
  std::array<QuadraticDerivative, TetRule::kPoints> inner;
  std::array<double, TetRule::kPoints> weight;
  std::array<Eigen::Vector4d, TetRule::kPoints> coordinates;  ///< barycentric
};

const Rules& rules() {
  static const Rules made = [] {
    Rules r;
    for (int c = 0; c < 4; ++c) {
      std::array<double, 4> l{};
      l[c] = 1.0;
      r.corner[c] = quadratic_derivative(l);
    }
    const TetRule rule = make_tet_rule();
    for (int q = 0; q < TetRule::kPoints; ++q) {
      r.inner[q] = quadratic_derivative(rule.point[q]);
      r.coordinates[q] = Eigen::Map<const Eigen::Vector4d>(rule.point[q].data());
    }
    r.weight = rule.weight;
    return r;
  }();
  return made;
}

}  // namespace

ElementStresses::ElementStresses(const mesh::TetMesh& mesh, const solid::Material& material)
    : mesh_(mesh), lambda_pa_(material.lame_lambda_pa), mu_pa_(material.lame_mu_pa), volume_m3_(mesh.n_elements()) {
  solid::validate(material);
  const auto n = static_cast<std::size_t>(mesh.n_elements());
  inverse_jacobian_.resize(n);
  is_curved_.assign(n, 0);
  for (int e = 0; e < mesh.n_elements(); ++e) {
    Eigen::Matrix3d jacobian;
    for (int b = 0; b < 3; ++b)
      jacobian.col(b) = (mesh.nodes_m.row(mesh.elements(e, b + 1)) - mesh.nodes_m.row(mesh.elements(e, 0))).transpose();
    double six_volumes = jacobian.determinant();
    inverse_jacobian_[static_cast<std::size_t>(e)] = jacobian.inverse();
    if (mesh.order() == 2 && detail::has_curved_edge(mesh, e)) {
      is_curved_[static_cast<std::size_t>(e)] = 1;
      const detail::TetNodes nodes = detail::nodes_of(mesh, e);
      six_volumes = 0.0;
      for (int q = 0; q < TetRule::kPoints; ++q)
        six_volumes += 6.0 * rules().weight[q] * (nodes * rules().inner[q]).determinant();
    }
    if (!(six_volumes > 0.0) || !std::isfinite(six_volumes))
      throw InputError("mesh", "element " + std::to_string(e) + " is flat, inside out or not finite");
    volume_m3_[e] = six_volumes / 6.0;
  }
}

StressTensor ElementStresses::stress_pa(const Eigen::Matrix3d& h) const {
  const double pressure = lambda_pa_ * h.trace();
  StressTensor s;
  s << pressure + 2.0 * mu_pa_ * h(0, 0), pressure + 2.0 * mu_pa_ * h(1, 1), pressure + 2.0 * mu_pa_ * h(2, 2),
      mu_pa_ * (h(0, 1) + h(1, 0)), mu_pa_ * (h(1, 2) + h(2, 1)), mu_pa_ * (h(2, 0) + h(0, 2));
  return s;
}

double ElementStresses::energy_density(const StressTensor& s, const Eigen::Matrix3d& h) const {
  return 0.5 * (s[0] * h(0, 0) + s[1] * h(1, 1) + s[2] * h(2, 2) + s[3] * (h(0, 1) + h(1, 0)) +
                s[4] * (h(1, 2) + h(2, 1)) + s[5] * (h(2, 0) + h(0, 2)));
}

void ElementStresses::linear(int e, const double* u, StressField& field) const {
  using Vector = Eigen::Map<const Eigen::Vector3d>;
  const Vector u0(u + 3 * mesh_.elements(e, 0));
  Eigen::Matrix3d difference;
  for (int b = 0; b < 3; ++b) difference.col(b) = Vector(u + 3 * mesh_.elements(e, b + 1)) - u0;
  const Eigen::Matrix3d gradient = difference * inverse_jacobian_[static_cast<std::size_t>(e)];
  field.stress_pa.col(e) = stress_pa(gradient);
  field.energy_density_j_m3[e] = energy_density(field.stress_pa.col(e), gradient);
}

void ElementStresses::quadratic(int e, const double* u, StressField& field) const {
  detail::TetNodes displacement;
  for (int c = 0; c < 10; ++c) displacement.col(c) = Eigen::Map<const Eigen::Vector3d>(u + 3 * mesh_.elements(e, c));
  const Rules& rule = rules();
  if (is_curved_[static_cast<std::size_t>(e)] == 0) {
    // Strain and stress are linear: for two linear functions int f g = V/20 (sum f_c g_c + sum f_c sum g_c).
    Eigen::Matrix3d all = Eigen::Matrix3d::Zero();
    double products = 0.0;
    for (int c = 0; c < 4; ++c) {
      const Eigen::Matrix3d gradient = displacement * rule.corner[c] * inverse_jacobian_[static_cast<std::size_t>(e)];
      const StressTensor stress = stress_pa(gradient);
      field.corner_stress_pa.col(4 * static_cast<Eigen::Index>(e) + c) = stress;
      products += energy_density(stress, gradient);
      all += gradient;
    }
    const StressTensor sum = stress_pa(all);
    field.stress_pa.col(e) = 0.25 * sum;
    field.energy_density_j_m3[e] = (products + energy_density(sum, all)) / 20.0;
    return;
  }
  const detail::TetNodes nodes = detail::nodes_of(mesh_, e);
  Eigen::Matrix<double, 6, 4> moments = Eigen::Matrix<double, 6, 4>::Zero();  // int l_c stress
  StressTensor sum = StressTensor::Zero();
  double energy = 0.0;
  for (int q = 0; q < TetRule::kPoints; ++q) {
    const Eigen::Matrix3d jacobian = nodes * rule.inner[q];
    const double weight = rule.weight[q] * jacobian.determinant();
    const Eigen::Matrix3d gradient = displacement * rule.inner[q] * jacobian.inverse();
    const StressTensor stress = stress_pa(gradient);
    sum += weight * stress;
    moments += weight * stress * rule.coordinates[q].transpose();
    energy += weight * energy_density(stress, gradient);
  }
  field.corner_stress_pa.middleCols<4>(4 * static_cast<Eigen::Index>(e)) =
      moments * detail::corner_gram(mesh_, e).inverse;
  field.stress_pa.col(e) = sum / volume_m3_[e];
  field.energy_density_j_m3[e] = energy / volume_m3_[e];
}

StressField ElementStresses::field(const Eigen::Ref<const Eigen::VectorXd>& displacement_m) const {
  KLANG_CHECK(displacement_m.size() == 3 * mesh_.n_nodes(), "three displacements per node");
  StressField field;
  const Eigen::Index n = mesh_.n_elements();
  field.stress_pa.resize(6, n);
  if (mesh_.order() == 2) field.corner_stress_pa.resize(6, 4 * n);
  field.energy_density_j_m3.resize(n);
  field.volume_m3 = volume_m3_;
  const double* u = displacement_m.data();
  parallel_for(static_cast<std::size_t>(n), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t e = begin; e < end; ++e) {
      if (mesh_.order() == 2)
        quadratic(static_cast<int>(e), u, field);
      else
        linear(static_cast<int>(e), u, field);
    }
  });
  field.strain_energy_j = field.energy_density_j_m3.dot(field.volume_m3);
  return field;
}

}  // namespace klang::fracture
