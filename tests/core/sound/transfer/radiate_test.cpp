#include "core/sound/transfer/radiate.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/geometry/mesh/quality.hpp"
#include "core/geometry/mesh/surface_check.hpp"
#include "core/geometry/mesh/surface_coarsening.hpp"
#include "core/geometry/shapes/shape.hpp"
#include "core/sound/bem/sphere_radiation.hpp"
#include "core/sound/transfer/modal_surface.hpp"

namespace {

using namespace klang::acoustics;
namespace mesh = klang::mesh;
namespace modal = klang::modal;

constexpr double kRadius = 0.05;

/// A curved ball whose "modes" move the surface by P_0, P_1, P_2 of cos(theta) along the normal.
modal::ModalModel ball(const std::vector<double>& ka) {
  modal::ModalModel model;
  model.mesh = mesh::mesh_shape({"sphere", {{"radius_m", kRadius}}, {}}, mesh::ShapeDivisions{{4, 4, 4}}, 2);
  const int n = model.mesh.n_nodes();
  model.shapes = Eigen::MatrixXd::Zero(3 * n, static_cast<Eigen::Index>(ka.size()));
  model.angular_frequency_rad_s.resize(static_cast<Eigen::Index>(ka.size()));
  for (std::size_t mode = 0; mode < ka.size(); ++mode) {
    model.angular_frequency_rad_s[static_cast<Eigen::Index>(mode)] = ka[mode] * Medium().sound_speed_m_s / kRadius;
    for (int node = 0; node < n; ++node) {
      const Eigen::Vector3d x = model.mesh.nodes_m.row(node).transpose();
      const double r = std::max(x.norm(), 1e-9);
      model.shapes.col(static_cast<Eigen::Index>(mode)).segment<3>(3 * node) =
          x / r * std::legendre(static_cast<unsigned>(mode), x[2] / r);
    }
  }
  return model;
}

modal::ModalModel plate() {
  modal::ModalModel model;
  const mesh::ShapeSpec spec{"box", {{"length_m", 0.2}, {"width_m", 0.15}, {"height_m", 0.002}}, {}};
  model.mesh = mesh::mesh_shape(spec, mesh::ShapeDivisions{{12, 9, 1}}, 2);
  model.shapes = Eigen::MatrixXd::Zero(3 * model.mesh.n_nodes(), 1);
  for (int node = 0; node < model.mesh.n_nodes(); ++node)
    model.shapes(3 * node + 2, 0) = std::cos(40.0 * (model.mesh.nodes_m(node, 0) + 0.1));
  model.angular_frequency_rad_s = Eigen::VectorXd::Constant(1, 2.0 * klang::kPi * 1000.0);
  return model;
}

double longest_edge(const mesh::SurfaceMesh& surface) {
  double longest = 0.0;
  for (Eigen::Index t = 0; t < surface.triangles.rows(); ++t)
    for (int c = 0; c < 3; ++c)
      longest = std::max(longest, (surface.vertices_m.row(surface.triangles(t, c)) -
                                   surface.vertices_m.row(surface.triangles(t, (c + 1) % 3)))
                                      .norm());
  return longest;
}

class StopAfter : public klang::Monitor {
 public:
  bool stop_requested() const override { return stop; }
  bool stop = false;
};

}  // namespace

TEST(Coarsening, ThinPlateStaysClosedAndKeepsItsVolume) {
  const ModalSurface fine(plate(), 0.01);
  const double wall_m = wall_tolerance_m(fine.triangles());
  EXPECT_LE(std::abs(wall_m - 0.0002), 1e-9);
  const double before = mesh::check_closed_surface(fine.triangles(), "fine").volume_m3;
  for (const double edge_m : {0.02, 0.04}) {
    const mesh::SurfaceMesh coarse = checked_coarsened(fine.triangles(), {edge_m, wall_m});
    EXPECT_LT(coarse.triangles.rows(), fine.triangles().triangles.rows() / 2);
    EXPECT_LE(longest_edge(coarse), 1.4 * edge_m * (1 + 1e-12));
    EXPECT_LE(std::abs(mesh::check_closed_surface(coarse, "coarse").volume_m3 / before - 1.0), 0.02) << edge_m;
  }
}

TEST(Coarsening, WithoutToleranceACurvedSurfaceStaysAsItIs) {
  const mesh::SurfaceMesh sphere = geodesic_sphere(0.1, 4);
  EXPECT_EQ(coarsened(sphere, {0.2, 0.0}).triangles.rows(), sphere.triangles.rows());
  EXPECT_THROW(coarsened(sphere, {0.0, 0.1}), klang::InputError);
}

TEST(ModalSurface, CarriesTheVolumeFlowToTheLastDigits) {
  const modal::ModalModel model = ball({1.0, 1.0, 1.0});
  const ModalSurface fine(model, 0.01);
  EXPECT_LE(std::abs(fine.area_m2() / (4.0 * klang::kPi * kRadius * kRadius) - 1.0), 2e-3);
  const RadiatingSurface coarse = radiating_surface(checked_coarsened(fine.triangles(), {0.015, 0.0008}));
  const ModalSurface::Carrier carrier = fine.carrier(coarse);
  EXPECT_GT(carrier.area_of_element_m2.minCoeff(), 0.0);
  for (int mode = 0; mode < 3; ++mode) {
    const Eigen::VectorXd velocity = fine.corner_velocity_m_s(mode, carrier, coarse);
    const double flow = (velocity.reshaped(3, coarse.n_triangles()).colwise().mean() * coarse.areas_m2).value();
    EXPECT_LE(std::abs(flow - fine.volume_flow_m3_s(mode)), 1e-12 * fine.area_m2());
  }
}

TEST(Radiate, ModesOfOneFrequencySoundAsEachAlone) {
  const modal::ModalModel model = ball({0.8, 0.8, 0.8});
  const RadiateResult together = radiate(model);
  ASSERT_TRUE(together.usable());
  ASSERT_EQ(together.transfer.modes.size(), 3U);
  for (std::size_t mode = 0; mode < 3; ++mode) {
    std::vector<ModeTransfer> others = together.transfer.modes;
    others.erase(others.begin() + static_cast<std::ptrdiff_t>(mode));
    const RadiateResult alone = radiate(model, {}, klang::silent_monitor(), others);
    ASSERT_TRUE(alone.usable());
    const auto& one = alone.transfer.modes[mode].multipole.coefficients_pa;
    const auto& all = together.transfer.modes[mode].multipole.coefficients_pa;
    ASSERT_EQ(one.size(), all.size());
    EXPECT_LE((one - all).norm(), 1e-8 * one.norm()) << mode;
  }
}

TEST(ModalSurface, PatternOfAWaveHasItsWavelength) {
  const modal::ModalModel model = plate();
  const ModalSurface fine(model, 0.01);
  EXPECT_LE(std::abs(fine.pattern_wavelength_m(0) / (2.0 * klang::kPi / 40.0) - 1.0), 0.1);
}

TEST(Radiate, ModesOfABallMatchTheExactSphere) {
  const std::vector<double> ka{0.5, 2.0, 4.0};
  const RadiateResult result = radiate(ball(ka));
  ASSERT_TRUE(result.usable());
  ASSERT_EQ(result.transfer.modes.size(), 3u);
  for (int mode = 0; mode < 3; ++mode) {
    const ModeTransfer& transfer = result.transfer.modes[static_cast<std::size_t>(mode)];
    const SphereCase sphere{mode, kRadius, ka[static_cast<std::size_t>(mode)], 4};
    const std::complex<double> exact = sphere_coefficient_pa(sphere, {});
    EXPECT_LE(std::abs(transfer.multipole.coefficients_pa[mode * (mode + 1)] - exact), 0.01 * std::abs(exact)) << mode;
    const double power =
        2.0 * klang::kPi * kRadius * kRadius / (2 * mode + 1) * sphere_impedance(mode, sphere.ka, {}).real();
    EXPECT_LE(std::abs(transfer.radiated_power_w / power - 1.0), 0.02) << mode;
    EXPECT_EQ(transfer.decay_radiation_per_s, transfer.radiated_power_w);
    EXPECT_GE(transfer.kept_power_fraction, 0.999);
    EXPECT_LE(*transfer.residual, 1e-9);
    EXPECT_EQ(transfer.mode, mode);
  }
}

TEST(Radiate, StoppedRunGoesOnToTheSameBits) {
  const modal::ModalModel model = ball({0.5, 0.8, 1.0, 1.2});
  RadiateOptions options;
  options.min_elements = 100;
  const RadiateResult whole = radiate(model, options);
  StopAfter monitor;
  std::vector<ModeTransfer> finished;
  EXPECT_THROW(radiate(model, options, monitor, {},
                       [&](const ModeTransfer& mode) {
                         finished.push_back(mode);
                         monitor.stop = true;
                       }),
               klang::Interrupted);
  ASSERT_GE(finished.size(), 1u);
  ASSERT_LT(finished.size(), 4u);
  std::set<int> fresh;
  const RadiateResult rest = radiate(model, options, klang::silent_monitor(), finished,
                                     [&](const ModeTransfer& mode) { fresh.insert(mode.mode); });
  EXPECT_EQ(fresh.size() + finished.size(), 4u);
  ASSERT_EQ(rest.transfer.modes.size(), 4u);
  for (std::size_t i = 0; i < 4; ++i)
    EXPECT_EQ(rest.transfer.modes[i].multipole.coefficients_pa, whole.transfer.modes[i].multipole.coefficients_pa) << i;
}

TEST(Radiate, FrequenciesThatTheElementsCannotResolveAreRefused) {
  RadiateOptions options;
  options.max_elements = options.min_elements = 100;
  EXPECT_THROW(radiate(ball({20.0}), options), klang::InputError);
  options.elements_per_wavelength = 1.0;
  EXPECT_THROW(radiate(ball({1.0}), options), klang::InputError);
}
