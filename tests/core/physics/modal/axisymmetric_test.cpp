// Bodies of revolution by harmonics, against closed forms (Lamb), a Ritz series and the tetrahedra.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>

#include "core/foundation/base/errors.hpp"

#include "core/geometry/mesh/quality.hpp"
#include "core/physics/modal/revolution_modes.hpp"

namespace klang::modal {
namespace {

const solid::Material kAluminium{4.98e10, 2.57e10, 2700.0, "", ""};  // tests/reference/chimes.json: material

mesh::ShapeSpec tube(double length_m) {
  return {"tube", {{"length_m", length_m}, {"outer_radius_m", 0.0125}, {"wall_m", 0.001}}, {}};
}

AxisymmetricBody body_of(const mesh::ShapeSpec& spec, double edge_m) {
  return AxisymmetricBody(mesh::mesh_section(spec, mesh::section_divisions(spec, edge_m)));
}

/// Every frequency, pairs twice.
std::vector<double> all_hz(const AxisymmetricBody& body, const std::vector<HarmonicModes>& modes) {
  std::vector<double> hz;
  for (std::size_t s = 0; s < modes.size(); ++s)
    for (Eigen::Index k = 0; k < modes[s].angular_frequency_sq.size(); ++k)
      for (int copy = 0; copy < body.system(s).multiplicity; ++copy)
        hz.push_back(std::sqrt(modes[s].angular_frequency_sq[k]) / (2.0 * kPi));
  std::sort(hz.begin(), hz.end());
  return hz;
}

TEST(Axisymmetric, BallHasLambsFrequenciesWithTheirMultiplicity) {
  // tests/reference/sphere_lamb.json: cases[0] (nu = 0.29), x = omega a / c_s.
  const std::vector<std::pair<double, int>> lamb = {
      {2.501132620409397, 5}, {2.64500665425552, 5}, {3.509495880385619, 3}, {3.864699778223047, 7},
      {3.933378897104085, 7}, {4.86995540349663, 1}, {4.979266373405847, 5}, {5.038887801390728, 9},
      {5.094615632407945, 9}, {5.76345919689455, 3}};
  std::vector<double> wanted;
  for (const auto& [x, multiplicity] : lamb) wanted.insert(wanted.end(), static_cast<std::size_t>(multiplicity), x);
  AxisymmetricBody body = body_of({"sphere", {{"radius_m", 1.0}}, {}}, 0.4);
  const solid::Material unit = solid::from_youngs_modulus(2.0 * 1.29, 0.29, 1.0);  // mu = rho = 1
  const auto hz = all_hz(body, body.modes_up_to(unit, 6.0 / (2.0 * kPi)));
  ASSERT_EQ(hz.size(), wanted.size());
  for (std::size_t i = 0; i < wanted.size(); ++i)
    EXPECT_LE(std::abs(2.0 * kPi * hz[i] / wanted[i] - 1.0), 2e-6) << wanted[i];
}

TEST(Axisymmetric, TubesBendAsTheRitzSeriesToSixDigits) {
  // tests/reference/chimes.json: tubes[].ritz3d_bending
  const std::vector<std::pair<double, std::vector<double>>> tubes = {
      {0.505,
       {587.8831103242787, 1575.1159866675644, 2969.5312988027986, 4681.101830346376, 6630.651833302586,
        8750.000412714602}},
      {0.353, {1185.4672628861772, 3095.019228731142}}};
  for (const auto& [length_m, bending_hz] : tubes) {
    AxisymmetricBody body = body_of(tube(length_m), 0.02);
    const auto modes = body.modes_up_to(kAluminium, 9000.0);
    ASSERT_EQ(body.system(2).harmonic, 1);
    const auto& flexure = modes[2].angular_frequency_sq;
    ASSERT_GE(flexure.size(), static_cast<Eigen::Index>(bending_hz.size()));
    for (std::size_t k = 0; k < bending_hz.size(); ++k)
      EXPECT_LE(std::abs(std::sqrt(flexure[static_cast<Eigen::Index>(k)]) / (2.0 * kPi * bending_hz[k]) - 1.0), 1e-6);
  }
}

TEST(RevolutionModes, LowestTwentyOfATubeAreTheBandsFirstTwentyAndBendAsTheRitzSeries) {
  const mesh::TetMesh mesh = mesh::mesh_shape(tube(0.505));
  EigenOptions options;
  options.count = 20;
  options.estimate_mesh_error = true;
  const EigenResult lowest = solve_revolution_modes(tube(0.505), mesh, kAluminium, options);
  ASSERT_TRUE(lowest.usable());
  ASSERT_EQ(lowest.model.n_modes(), 20);
  ASSERT_EQ(lowest.model.shapes.cols(), 20);
  options.count = 0;
  options.band = {20.0, 6000.0};
  options.estimate_mesh_error = false;
  const EigenResult band = solve_revolution_modes(tube(0.505), mesh, kAluminium, options);
  ASSERT_GE(band.model.n_modes(), 20);
  EXPECT_FALSE(band.mesh_relative_error.has_value());
  const Eigen::VectorXd hz = lowest.model.frequency_hz(), band_hz = band.model.frequency_hz();
  for (Eigen::Index k = 0; k < 20; ++k) {
    EXPECT_LE(std::abs(hz[k] / band_hz[k] - 1.0), 5e-6) << k;
    EXPECT_LE((*lowest.mesh_relative_error)[k], 1e-4) << k;
    EXPECT_LE(std::abs(hz[k] / band_hz[k] - 1.0), (*lowest.mesh_relative_error)[k] + 1e-7) << k;
  }
  // tests/reference/chimes.json: tubes[0].ritz3d_bending
  for (const double bending_hz : {587.8831103242787, 1575.1159866675644, 2969.5312988027986, 4681.101830346376})
    EXPECT_EQ(((hz.array() / bending_hz - 1.0).abs() <= 2e-6).count(), 2) << bending_hz;
}

TEST(Axisymmetric, EigenvalueErrorFallsAtTwiceTheDegree) {
  AxisymmetricBody exact = body_of(tube(0.1), 0.004);
  const double reference = exact.modes_up_to(kAluminium, 20000.0)[2].angular_frequency_sq[0];
  for (const int degree : {1, 2}) {
    std::vector<double> error;
    for (const int n : {6, 12, 24, 48}) {
      AxisymmetricBody body(mesh::mesh_section(tube(0.1), {{n, std::max(1, n / 6), 0}, degree}));
      body.extend(3);
      error.push_back(body.lowest(kAluminium, {0, 0, 1})[2].angular_frequency_sq[0] / reference - 1.0);
    }
    for (std::size_t i = 1; i < error.size(); ++i) {
      const double order = std::log2(error[i - 1] / error[i]);
      EXPECT_GE(order, 2.0 * degree - 0.5) << "degree " << degree << " level " << i << " error " << error[i];
      EXPECT_LE(order, 2.0 * degree + 0.6) << "degree " << degree << " level " << i << " error " << error[i];
    }
  }
}

TEST(Axisymmetric, ProfileOfATubeGivesTheTube) {
  const auto path = std::filesystem::path(testing::TempDir()) / "klang-tube-profile.csv";
  std::ofstream(path) << "r_m,z_m\n0.0105,-0.05\n0.0125,-0.05\n0.0125,0.05\n0.0105,0.05\n";
  AxisymmetricBody polygon = body_of({"revolution", {}, path}, 0.01);
  AxisymmetricBody exact =
      body_of({"tube", {{"length_m", 0.1}, {"outer_radius_m", 0.0125}, {"wall_m", 0.002}}, {}}, 0.01);
  const auto a = all_hz(polygon, polygon.modes_up_to(kAluminium, 20000.0));
  const auto b = all_hz(exact, exact.modes_up_to(kAluminium, 20000.0));
  ASSERT_EQ(a.size(), b.size());
  ASSERT_GE(a.size(), 10u);
  for (std::size_t i = 0; i < a.size(); ++i) EXPECT_LE(std::abs(a[i] / b[i] - 1.0), 2e-5) << b[i];
  EXPECT_LE(std::abs(polygon.volume_m3() / exact.volume_m3() - 1.0), 1e-12);
}

TEST(Axisymmetric, EveryBodyAgreesWithItsTetrahedra) {
  const auto profile = std::filesystem::path(testing::TempDir()) / "klang-cone-profile.csv";
  std::ofstream(profile) << "r_m,z_m\n0,0\n0.03,0\n0.02,0.06\n0,0.06\n";
  struct Case {
    mesh::ShapeSpec spec;
    mesh::ShapeDivisions divisions;
    double tolerance;  // what these tetrahedra leave
  };
  const std::vector<Case> cases = {
      {{"rod", {{"length_m", 0.1}, {"radius_m", 0.01}}, {}}, {{20, 2, 2}}, 2e-3},
      {{"ellipsoid", {{"a_m", 0.03}, {"b_m", 0.03}, {"c_m", 0.05}}, {}}, {{4, 3, 1}}, 2e-3},
      {{"bowl", {{"outer_radius_m", 0.05}, {"wall_m", 0.014}, {"depth_m", 0.04}}, {}}, {{5, 5, 2}}, 5e-3},
      {{"revolution", {}, profile}, mesh::shape_divisions({"revolution", {}, profile}, {}), 4e-3}};
  constexpr int kModes = 8;
  for (const auto& [spec, divisions, tolerance] : cases) {
    AxisymmetricBody body = body_of(spec, 0.02);
    const mesh::TetMesh mesh = mesh::mesh_shape(spec, divisions, 2);
    EXPECT_LE(std::abs(body.volume_m3() / mesh::shape_volume_m3(spec) - 1.0), 1e-7) << spec.kind;
    EigenOptions options;
    options.count = kModes;
    options.prove_none_missing = false;
    const auto tets = solve_modes(mesh, solid::assemble(mesh), kAluminium, {}, options);
    ASSERT_TRUE(tets.usable()) << spec.kind;
    const Eigen::VectorXd f = tets.model.frequency_hz();
    const auto hz = all_hz(body, body.modes_up_to(kAluminium, 1.02 * f[kModes - 1]));
    ASSERT_GE(hz.size(), static_cast<std::size_t>(kModes)) << spec.kind;
    for (Eigen::Index k = 0; k < kModes; ++k) {
      // Tetrahedra converge from above.
      EXPECT_LE(f[k] / hz[static_cast<std::size_t>(k)] - 1.0, tolerance) << spec.kind << " mode " << k;
      EXPECT_GE(f[k] / hz[static_cast<std::size_t>(k)] - 1.0, -1e-4) << spec.kind << " mode " << k;
    }
  }
}

TEST(Axisymmetric, SampledShapesAreMassNormalisedModesOfTheTetrahedra) {
  const mesh::ShapeSpec spec{"rod", {{"length_m", 0.08}, {"radius_m", 0.012}}, {}};
  AxisymmetricBody body = body_of(spec, 0.02);
  const auto modes = body.modes_up_to(kAluminium, 60000.0);
  const mesh::TetMesh mesh = mesh::mesh_shape(spec);
  const auto sampled = sample_modes(body, modes, mesh, kAluminium);
  const auto assembled = solid::assemble(mesh);
  const auto stiffness = solid::stiffness(assembled, kAluminium.lame_lambda_pa, kAluminium.lame_mu_pa);
  const Eigen::MatrixXd& u = sampled.model.shapes;
  ASSERT_GE(u.cols(), 5);
  const Eigen::MatrixXd gram =
      kAluminium.density_kg_m3 * u.transpose() * (assembled.mass_unit_density.selfadjointView<Eigen::Lower>() * u);
  EXPECT_LE((gram - Eigen::MatrixXd::Identity(u.cols(), u.cols())).cwiseAbs().maxCoeff(), 2e-3);
  const Eigen::VectorXd energy = u.cwiseProduct(stiffness.selfadjointView<Eigen::Lower>() * u).colwise().sum();
  for (Eigen::Index k = 0; k < u.cols(); ++k)
    EXPECT_LE(std::abs(energy[k] / std::pow(sampled.model.angular_frequency_rad_s[k], 2) - 1.0), 0.02) << k;
}

TEST(Axisymmetric, BoxIsRefused) {
  const mesh::ShapeSpec box{"box", {{"length_m", 0.1}, {"width_m", 0.1}, {"height_m", 0.1}}, {}};
  EXPECT_FALSE(mesh::is_axisymmetric(box));
  EXPECT_THROW(mesh::section_divisions(box, 0.01), InputError);
}

}  // namespace
}  // namespace klang::modal
