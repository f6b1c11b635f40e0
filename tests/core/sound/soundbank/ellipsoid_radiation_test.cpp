#include <gtest/gtest.h>

#include <cmath>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/parallel.hpp"
#include "core/sound/bem/sphere_radiation.hpp"
#include "core/sound/soundbank/ellipsoid_radiation.hpp"
#include "core/sound/soundbank/soundbank.hpp"
#include "core/sound/waves/multipole_transforms.hpp"
#include "tests/core/sound/soundbank/small_bank.hpp"

using namespace klang;
using soundbank::EllipsoidModes;
using soundbank::EllipsoidRadiation;

namespace {

/// The house's boundary elements for the same mode: normal velocity at the corners of a mesh of the ellipsoid.
acoustics::Multipole by_boundary_elements(const EllipsoidModes& modes, const soundbank::ModeId& id, int divisions,
                                          int order) {
  mesh::SurfaceMesh surface = acoustics::geodesic_sphere(1.0, divisions);
  for (Eigen::Index i = 0; i < surface.vertices_m.rows(); ++i)
    surface.vertices_m.row(i) = surface.vertices_m.row(i).cwiseProduct(modes.axes_m().transpose()).eval();
  const acoustics::HelmholtzBem solver(acoustics::radiating_surface(surface));
  const acoustics::RadiatingSurface& s = solver.surface();
  Eigen::VectorXcd velocity(3 * s.n_triangles());
  for (int t = 0; t < s.n_triangles(); ++t)
    for (int c = 0; c < 3; ++c) {
      const Eigen::Matrix3Xd xi = s.corner(t, c).cwiseQuotient(modes.axes_m()).normalized();
      const Eigen::Vector3d normal = xi.col(0).cwiseQuotient(modes.axes_m()).normalized();
      velocity[3 * t + c] = modes.shape_at(id, xi).col(0).dot(normal);
    }
  const auto bem = solver.solve(modes.angular_frequency_rad_s(id) / (2.0 * kPi), velocity);
  acoustics::OrderOptions options;
  options.fixed_order = order;
  return acoustics::multipole_from_surface(solver.field(bem), bem.wavenumber_per_m, {}, Eigen::Vector3d::Zero(),
                                           options)
      .multipole;
}

}  // namespace

TEST(EllipsoidRadiation, AgreesWithTheBoundaryElements) {
  const BlasThreads one(1);
  const EllipsoidModes modes(Eigen::Vector3d(0.06, 0.6, 1.0), test::glass());
  for (const auto& id : modes.lowest(2)) {
    const EllipsoidRadiation found = soundbank::radiate(modes, id);
    const acoustics::Multipole bem = by_boundary_elements(modes, id, 8, found.multipole.order);
    EXPECT_LE((found.multipole.coefficients_pa - bem.coefficients_pa).norm() / bem.coefficients_pa.norm(), 0.03)
        << id.mode_class;
  }
}

// The ball's breathing mode has one coefficient, in closed form; l = 2 stretching modes have only n = 2.
TEST(EllipsoidRadiation, BallRadiatesTheExactCoefficients) {
  const BlasThreads one(1);
  const double radius = 0.02;
  const EllipsoidModes modes({radius, radius, radius}, test::glass());
  const acoustics::Medium air;
  int n_seen = 0;
  for (const auto& id : modes.lowest(13)) {
    const EllipsoidRadiation found = soundbank::radiate(modes, id);
    if (!found.moves_normally) continue;
    ++n_seen;
    const double ka = found.multipole.wavenumber_per_m * radius;
    // Power of each degree from the normal velocity by orthogonality: all in one degree, |v|^2 = mean square x 4 pi.
    Eigen::Index degree = 0;
    const Eigen::VectorXd power = acoustics::power_by_order_w(found.multipole, air);
    power.maxCoeff(&degree);
    EXPECT_LE(power.sum() - power[degree], 1e-6 * power.sum());
    // P = 1/2 Re(Z) int v_n^2 dS; the integral by Gauss points.
    double square = 0.0;
    for (int i = 0; i < 40; ++i)
      for (int j = 0; j < 80; ++j) {
        const double theta = kPi * (i + 0.5) / 40, phi = 2.0 * kPi * (j + 0.5) / 80;
        const Eigen::Matrix3Xd xi =
            Eigen::Vector3d(std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta));
        const double v = modes.shape_at(id, xi).col(0).dot(xi.col(0));
        square += v * v * std::sin(theta) * kPi / 40 * kPi / 40 * radius * radius;
      }
    const double exact = 0.5 * acoustics::sphere_impedance(static_cast<int>(degree), ka, air).real() * square;
    EXPECT_LE(std::abs(found.radiated_power_w / exact - 1.0), 3e-3) << id.mode_class;  // of the sum over 3200 points
  }
  EXPECT_GE(n_seen, 5);
}

// SB eq. 9 for unit modal velocity: M -> gamma^-3/2 M; errata 41.
TEST(EllipsoidRadiation, ScaledBodySolvedAnewHasTheScaledMultipoles) {
  const BlasThreads one(1);
  const double gamma = 0.043;
  const Eigen::Vector3d axes(0.2, 0.5, 1.0);
  const EllipsoidModes unit(axes, test::glass()), scaled(gamma * axes, test::glass());
  for (const auto& id : unit.lowest(3)) {
    const acoustics::Multipole by_law =
        acoustics::with_size_factor(soundbank::radiate(unit, id).multipole, gamma, acoustics::ModalUnit::kVelocity);
    const acoustics::Multipole anew = soundbank::radiate(scaled, id).multipole;
    ASSERT_EQ(by_law.order, anew.order);
    const auto difference = std::min((by_law.coefficients_pa - anew.coefficients_pa).norm(),
                                     (by_law.coefficients_pa + anew.coefficients_pa).norm());
    EXPECT_LE(difference / anew.coefficients_pa.norm(), 1e-6);
  }
}

TEST(EllipsoidRadiation, TorsionOfABodyOfRevolutionIsSilent) {
  const EllipsoidModes modes({0.3, 0.3, 1.0}, test::glass());
  const EllipsoidRadiation found = soundbank::radiate(modes, {7, 0});  // twist about z: odd in x, y and z
  EXPECT_FALSE(found.moves_normally);
  EXPECT_EQ(found.radiated_power_w, 0.0);
}

TEST(PackedMultipole, ReadsBackWhatTheClassAllows) {
  const BlasThreads one(1);
  const EllipsoidModes modes(Eigen::Vector3d(0.2, 0.5, 1.0), test::glass());
  for (const auto& id : modes.lowest(6)) {
    const acoustics::Multipole m = soundbank::radiate(modes, id).multipole;
    const auto packed = soundbank::packed_multipole(m.coefficients_pa, m.order, id.mode_class);
    EXPECT_LE(packed.size() * 5, static_cast<std::size_t>(m.coefficients_pa.size()));
    const Eigen::VectorXcd back = soundbank::unpacked_multipole(packed, m.order, id.mode_class);
    EXPECT_LE((back - m.coefficients_pa).norm() / m.coefficients_pa.norm(), 1e-7);
  }
}
