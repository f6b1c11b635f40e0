#include "core/physics/fracture/quasistatic/breaking_stress.hpp"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/check.hpp"
#include "core/foundation/base/conventions.hpp"
#include "core/physics/fracture/quasistatic/detail/corner_fit.hpp"

namespace klang::fracture {
namespace {

constexpr double kRoundOff = 1e-9;

double own_tension_pa(const PointForce& force, const Eigen::Vector3d& x) {
  const Eigen::Vector3d way = x - force.place_m;
  const double size_n = force.force_n.norm(), r_sq = way.squaredNorm();
  if (!(size_n > 0.0)) return 0.0;
  if (!(r_sq > 0.0)) return HUGE_VAL;
  const double cosine = way.dot(force.force_n) / (size_n * std::sqrt(r_sq));
  return BreakingStress::kOwnTension * size_n * (1.0 - std::min(1.0, cosine)) / (2.0 * kPi * r_sq);
}

}  // namespace

BreakingStress::BreakingStress(const mesh::TetMesh& mesh)
    : mesh_(mesh), volume_m3_(mesh.n_elements()), node_volume_m3_(Eigen::VectorXd::Zero(mesh.n_nodes())) {
  Eigen::VectorXd norm_sq = Eigen::VectorXd::Zero(mesh.n_nodes());  // sum of V_e^2 (M_e^-1)_cc
  for (int e = 0; e < mesh.n_elements(); ++e) {
    const detail::CornerGram gram = detail::corner_gram(mesh, e);
    volume_m3_[e] = gram.volume_m3;
    for (int c = 0; c < 4; ++c) {
      node_volume_m3_[mesh.elements(e, c)] += volume_m3_[e];
      norm_sq[mesh.elements(e, c)] += volume_m3_[e] * volume_m3_[e] * gram.inverse(c, c);
    }
  }
  for (int i = 0; i < mesh.n_nodes(); ++i)
    if (node_volume_m3_[i] > 0.0)
      largest_norm_sq_1_m3_ = std::max(largest_norm_sq_1_m3_, norm_sq[i] / (node_volume_m3_[i] * node_volume_m3_[i]));
}

Eigen::VectorXd BreakingStress::at_nodes_pa(const StressField& field, const std::vector<PointForce>& forces,
                                            const std::vector<NodeForce>& pushed) const {
  KLANG_CHECK(field.n_elements() == mesh_.n_elements(), "a field of this mesh");
  Eigen::Matrix<double, 6, Eigen::Dynamic> sum =
      Eigen::Matrix<double, 6, Eigen::Dynamic>::Zero(6, static_cast<Eigen::Index>(mesh_.n_nodes()));
  for (int e = 0; e < mesh_.n_elements(); ++e)
    for (int c = 0; c < 4; ++c)
      sum.col(mesh_.elements(e, c)) += volume_m3_[e] * field.corner(e, field.n_corners() == 4 ? c : 0);
  Eigen::VectorXd tension_pa = Eigen::VectorXd::Zero(mesh_.n_nodes());
  for (int i = 0; i < mesh_.n_nodes(); ++i) {
    if (!(node_volume_m3_[i] > 0.0)) continue;
    tension_pa[i] = principal_stresses_pa(sum.col(i) / node_volume_m3_[i])[0];
    for (const PointForce& force : forces) tension_pa[i] -= own_tension_pa(force, mesh_.nodes_m.row(i).transpose());
  }
  for (const NodeForce& force : pushed)
    if (!force.force_n.isZero(0.0)) tension_pa[force.node] = 0.0;
  return tension_pa;
}

Eigen::VectorXd BreakingStress::by_element_pa(const StressField& field, const std::vector<PointForce>& forces,
                                              const std::vector<NodeForce>& pushed) const {
  const Eigen::VectorXd at_nodes = at_nodes_pa(field, forces, pushed);
  Eigen::VectorXd tension_pa(mesh_.n_elements());
  for (int e = 0; e < mesh_.n_elements(); ++e) {
    tension_pa[e] = at_nodes[mesh_.elements(e, 0)];
    for (int c = 1; c < 4; ++c) tension_pa[e] = std::max(tension_pa[e], at_nodes[mesh_.elements(e, c)]);
  }
  return tension_pa;
}

double BreakingStress::least_energy_j(const solid::Material& material, double strength_pa) const {
  KLANG_CHECK(strength_pa > 0.0 && largest_norm_sq_1_m3_ > 0.0, "a mesh with elements and a strength");
  const double modulus_pa = material.lame_lambda_pa + 2.0 * material.lame_mu_pa;
  return (1.0 - kRoundOff) * strength_pa * strength_pa / (2.0 * modulus_pa * largest_norm_sq_1_m3_);
}

}  // namespace klang::fracture
