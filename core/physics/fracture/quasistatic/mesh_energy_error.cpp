#include "core/physics/fracture/quasistatic/mesh_energy_error.hpp"

namespace klang::fracture {
namespace {

/// s : C^-1 s / 2 [J/m^3].
double complementary_density(const StressTensor& s, double youngs_modulus_pa, double poissons_ratio) {
  const double trace = s[0] + s[1] + s[2];
  const double square = s.head<3>().squaredNorm() + 2.0 * s.tail<3>().squaredNorm();
  return 0.5 * ((1.0 + poissons_ratio) * square - poissons_ratio * trace * trace) / youngs_modulus_pa;
}

}  // namespace

double energy_share_missing(const mesh::TetMesh& mesh, const StressField& field, const solid::Material& material) {
  Eigen::Matrix<double, 6, Eigen::Dynamic> nodal(6, mesh.n_nodes());
  Eigen::VectorXd weight = Eigen::VectorXd::Zero(mesh.n_nodes());
  nodal.setZero();
  const auto corner = [&](int e, int c) { return field.corner(e, field.n_corners() == 4 ? c : 0); };
  for (int e = 0; e < mesh.n_elements(); ++e) {
    for (int c = 0; c < 4; ++c) {
      const int node = mesh.elements(e, c);
      nodal.col(node) += field.volume_m3[e] * corner(e, c);
      weight[node] += field.volume_m3[e];
    }
  }
  const double young = material.youngs_modulus_pa(), poisson = material.poissons_ratio();
  double missing = 0.0;
  for (int e = 0; e < mesh.n_elements(); ++e) {
    StressTensor sum = StressTensor::Zero();
    double products = 0.0;
    for (int c = 0; c < 4; ++c) {
      const int node = mesh.elements(e, c);
      const StressTensor difference = nodal.col(node) / weight[node] - corner(e, c);
      products += complementary_density(difference, young, poisson);
      sum += difference;
    }
    missing += field.volume_m3[e] * (products + complementary_density(sum, young, poisson)) / 20.0;
  }
  const double all = missing + field.strain_energy_j;
  return all > 0.0 ? missing / all : 0.0;
}

}  // namespace klang::fracture
