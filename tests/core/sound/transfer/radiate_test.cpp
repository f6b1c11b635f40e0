#include "core/sound/transfer/radiate.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/geometry/mesh/mirrored_surface.hpp"
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

TEST(Coarsening, TrianglesAreLargerWhereTheyMayBe) {
  const mesh::SurfaceMesh sphere = geodesic_sphere(0.1, 24);
  std::vector<double> times(static_cast<std::size_t>(sphere.vertices_m.rows()));
  for (std::size_t v = 0; v < times.size(); ++v)
    times[v] = sphere.vertices_m(static_cast<Eigen::Index>(v), 2) > 0.0 ? 1.0 : 3.0;
  const mesh::SurfaceMesh coarse = coarsened(sphere, {0.02, 0.004}, {}, times);
  mesh::check_closed_surface(coarse, "coarse");
  int n_above = 0, n_below = 0;
  for (Eigen::Index t = 0; t < coarse.triangles.rows(); ++t) {
    double z = 0.0;
    for (int c = 0; c < 3; ++c) z += coarse.vertices_m(coarse.triangles(t, c), 2);
    ++(z > 0.0 ? n_above : n_below);
  }
  EXPECT_GT(n_above, 4 * n_below);  // nine times fewer but for the seam
  EXPECT_GT(n_below, 20);
}

TEST(Coarsening, WithoutToleranceACurvedSurfaceStaysAsItIs) {
  const mesh::SurfaceMesh sphere = geodesic_sphere(0.1, 4);
  EXPECT_EQ(coarsened(sphere, {0.2, 0.0}).triangles.rows(), sphere.triangles.rows());
  EXPECT_THROW(coarsened(sphere, {0.0, 0.1}), klang::InputError);
}

TEST(MirrorPlanes, ArePlanesOfTheBodyAndNotOfADentedOne) {
  const auto planes_of = [](const mesh::ShapeSpec& shape, double dent_m) {
    mesh::SurfaceMesh surface = mesh::boundary_surface(mesh::mesh_shape(shape, mesh::ShapeDivisions{}, 1));
    Eigen::Index top = 0;
    (surface.vertices_m.col(2) + 0.1 * surface.vertices_m.col(0)).maxCoeff(&top);
    surface.vertices_m(top, 0) -= dent_m;
    return mesh::mirror_planes(surface, 1e-5).axes;
  };
  const mesh::ShapeSpec box{"box", {{"length_m", 0.2}, {"width_m", 0.15}, {"height_m", 0.01}}, {}};
  const mesh::ShapeSpec bowl{"bowl", {{"outer_radius_m", 0.1}, {"wall_m", 0.006}, {"depth_m", 0.07}}, {}};
  EXPECT_EQ(planes_of(box, 0.0), (std::vector<int>{0, 1, 2}));
  EXPECT_EQ(planes_of(bowl, 0.0), (std::vector<int>{0, 1}));
  EXPECT_EQ(planes_of(box, 1e-3), (std::vector<int>{}));
}

TEST(MirroredSurface, ClosesAndIsItsOwnImage) {
  const ModalSurface fine(plate(), 0.01);
  const double before = mesh::check_closed_surface(fine.triangles(), "fine").volume_m3;
  const mesh::MirrorPlanes planes = mesh::mirror_planes(fine.triangles(), 1e-5);
  ASSERT_EQ(planes.axes.size(), 3U);
  for (const double edge_m : {0.02, 0.04}) {
    const auto mirrored = mesh::mirrored_coarsened(fine.triangles(), {edge_m, 0.0002}, planes);
    ASSERT_TRUE(mirrored);
    EXPECT_LT(mirrored->surface.triangles.rows(), fine.triangles().triangles.rows() / 2);
    EXPECT_LE(longest_edge(mirrored->surface), 1.4 * edge_m * (1 + 1e-12));
    const double volume = mesh::check_closed_surface(mirrored->surface, "coarse").volume_m3;
    EXPECT_LE(std::abs(volume / before - 1.0), 0.02) << edge_m;
    for (int g = 0; g < 8; ++g)
      for (Eigen::Index v = 0; v < mirrored->surface.vertices_m.rows(); ++v) {
        const Eigen::Vector3d x = mirrored->surface.vertices_m.row(v).transpose();
        const Eigen::Vector3d image =
            mirrored->surface.vertices_m.row(mirrored->vertex_image[g][static_cast<std::size_t>(v)]).transpose();
        EXPECT_LE((planes.reflected(x, g) - image).norm(), 1e-15);
      }
  }
}

TEST(MirroredSurface, SoundsAsTheSameElementsWithoutTheirMirrors) {
  const ModalSurface fine(plate(), 0.01);
  const auto mirrored =
      mesh::mirrored_coarsened(fine.triangles(), {0.04, 0.0002}, mesh::mirror_planes(fine.triangles(), 1e-5));
  ASSERT_TRUE(mirrored);
  RadiatingSurface surface = radiating_surface(*mirrored);
  const HelmholtzBem by_classes(surface);
  surface.mirrors = {};
  const HelmholtzBem whole(surface);
  // Without any symmetry, and of one class alone.
  Eigen::MatrixXcd velocity(3 * surface.n_triangles(), 2);
  for (int t = 0; t < surface.n_triangles(); ++t)
    for (int c = 0; c < 3; ++c) {
      const Eigen::Vector3d x = surface.corner(t, c);
      velocity(3 * t + c, 0) = std::complex<double>(std::cos(37.0 * x[0] + 20.0 * x[1] + 300.0 * x[2] + 0.4), x[1]);
      velocity(3 * t + c, 1) = surface.normals(2, t) * std::cos(40.0 * x[0]);
    }
  const BemResult one = by_classes.solve(900.0, velocity), other = whole.solve(900.0, velocity);
  ASSERT_TRUE(one.usable() && other.usable());
  // Not to round-off: a pair and its image may fall on either side of what counts as near.
  for (int c = 0; c < 2; ++c) {
    EXPECT_LE((one.pressure_pa.col(c) - other.pressure_pa.col(c)).norm(), 1e-5 * other.pressure_pa.col(c).norm()) << c;
    EXPECT_LE(std::abs(one.radiated_power_w[c] - other.radiated_power_w[c]), 1e-5 * other.power_scale_w[c]) << c;
  }
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

TEST(Radiate, OnADeviceModesRadiateAsOnTheProcessor) {
  const modal::ModalModel model = ball({0.5, 2.0});
  RadiateOptions options;
  options.min_elements = 100;
  const RadiateResult expected = radiate(model, options);
  EXPECT_EQ(expected.device, "processor");
  options.device.used = true;
  const RadiateResult found = radiate(model, options);
  EXPECT_NE(found.device, "processor");
  EXPECT_EQ(found.device_message, "");
  for (std::size_t i = 0; i < 2; ++i) {
    const auto& want = expected.transfer.modes[i];
    EXPECT_LE(std::abs(found.transfer.modes[i].radiated_power_w / want.radiated_power_w - 1.0), 1e-7);
  }
  options.device.memory_bytes = 1000;
  const RadiateResult without = radiate(model, options);
  EXPECT_EQ(without.device, "processor");
  EXPECT_NE(without.device_message.find("needs"), std::string::npos) << without.device_message;
  EXPECT_EQ(without.transfer.modes[0].radiated_power_w, expected.transfer.modes[0].radiated_power_w);
}

TEST(Radiate, ModesThatTheElementsCannotResolveAreLeftOutWhereThatIsAskedFor) {
  RadiateOptions options;
  options.max_elements = options.min_elements = 100;
  options.leave_out_coarse = true;
  const RadiateResult all = radiate(ball({0.5, 1.0}), options);
  EXPECT_EQ(all.n_left_out, 0);
  const RadiateResult some = radiate(ball({0.5, 1.0, 20.0}), options);
  ASSERT_TRUE(some.usable());
  EXPECT_EQ(some.n_left_out, 1);
  ASSERT_EQ(some.transfer.modes.size(), 2u);
  for (int mode = 0; mode < 2; ++mode)
    EXPECT_LE(std::abs(some.transfer.modes[static_cast<std::size_t>(mode)].radiated_power_w /
                           all.transfer.modes[static_cast<std::size_t>(mode)].radiated_power_w -
                       1.0),
              1e-9);
}

TEST(Radiate, FrequenciesThatTheElementsCannotResolveAreRefused) {
  RadiateOptions options;
  options.max_elements = options.min_elements = 100;
  EXPECT_THROW(radiate(ball({20.0}), options), klang::InputError);
  options.elements_per_wavelength = 1.0;
  EXPECT_THROW(radiate(ball({1.0}), options), klang::InputError);
}
