#include <gtest/gtest.h>

#include <cmath>

#include "core/modal/axisymmetric_modes.hpp"

namespace klang::modal {
namespace {

std::vector<double> sorted_hz(const AxisymmetricBody& body, const std::vector<HarmonicModes>& modes, bool repeat) {
  std::vector<double> hz;
  for (std::size_t s = 0; s < modes.size(); ++s)
    for (Eigen::Index k = 0; k < modes[s].angular_frequency_sq.size(); ++k)
      for (int copy = 0; copy < (repeat ? body.system(s).multiplicity : 1); ++copy)
        hz.push_back(std::sqrt(modes[s].angular_frequency_sq[k]) / (2.0 * kPi));
  std::sort(hz.begin(), hz.end());
  return hz;
}

TEST(Axisymmetric, X) {
  solid::Material m; m.lame_lambda_pa = 4.98e10; m.lame_mu_pa = 2.57e10; m.density_kg_m3 = 2700;
  mesh::ShapeSpec s{"tube", {{"length_m", 0.505}, {"outer_radius_m", 0.0125}, {"wall_m", 0.001}}, {}};
  for (double e : {0.04, 0.02, 0.01}) {
  AxisymmetricBody body(mesh::mesh_section(s, mesh::section_divisions(s, e)));
  auto modes = body.modes_up_to(m, 9000);
  auto hz = sorted_hz(body, modes, false);
  printf("%d nodes:", body.section().n_nodes());
  for (double f : hz) printf(" %.5f", f);
  printf("\n");}
  mesh::ShapeSpec ball{"sphere", {{"radius_m", 1.0}}, {}};
  m = solid::from_youngs_modulus(2*1.29, 0.29, 1.0); 
  for (double e : {0.6, 0.4, 0.3}) {
  AxisymmetricBody body(mesh::mesh_section(ball, mesh::section_divisions(ball, e)));
  auto modes = body.modes_up_to(m, 6/(2*kPi));
  auto hz = sorted_hz(body, modes, true);
  printf("%d nodes:", body.section().n_nodes());
  for (double f : hz) printf(" %.8f", f*2*kPi);
  printf("\n");}
}

}  // namespace
}  // namespace klang::modal
