// Both passes against exact fields: tests/reference/fluid.json and a sum of images.
#include "core/sound/dual_domain/dual_domain.hpp"

#include <gtest/gtest.h>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/parallel.hpp"
#include "tests/core/sound/dual_domain/liquid_shapes.hpp"

namespace {

using namespace klang;
using namespace klang::bubble;
using Eigen::Vector3d;
using klang::test::Complex;

constexpr double kBallRadiusM = 0.05;

std::vector<DualDomainResult> solve(const LiquidBoundary& boundary, double frequency_hz, const Vector3d& bubble_m,
                                    int n_fluid, int n_air, std::uint64_t seed = 1,
                                    const DualDomainOptions& options = {}) {
  return solve_dual_domain(boundary, frequency_hz, random_source_points(boundary, n_fluid, n_air, seed),
                           {{bubble_m, 0.001}}, options);
}

/// tests/reference/fluid.json: pressure_release_sphere, rows with b = 0.
struct BallRow {
  double frequency_hz, slope;
};
constexpr BallRow kConcentric[] = {{500, 31.889474788404545}, {1500, 32.36282971277046}, {4000, 35.90123035258314}};

/// Pressure-release ball of radius a, unit source at (0, 0, b): dP/dr on the surface at the pole angle gamma,
///   1 / (4 pi a^2) sum (2n + 1) j_n(k b) / j_n(k a) P_n(cos gamma)
double eccentric_slope(double k, double a, double b, double gamma) {
  double sum = 0.0, p0 = 1.0, p1 = std::cos(gamma);
  for (int n = 0; n < 40; ++n) {
    const double ratio =
        std::sph_bessel(static_cast<unsigned>(n), k * b) / std::sph_bessel(static_cast<unsigned>(n), k * a);
    sum += (2 * n + 1) * ratio * p0;
    const double next = ((2 * n + 3) * std::cos(gamma) * p1 - (n + 1) * p0) / (n + 2);
    p0 = p1;
    p1 = next;
  }
  return sum / (4.0 * kPi * a * a);
}

/// A rigid ball of radius a within a pressure-release ball of radius b about the same centre, unit source at (0, 0, r0) between:
/// dP/dr on the free surface at the pole angle gamma. Each degree: j_n(k r<) h_n(k r>) + A j_n(k r) + B y_n(k r), A and B from the
/// two surfaces; e^{-ikR} / R = -ik sum (2n + 1) j_n h_n P_n.
Complex shell_slope(double k, double a, double b, double r0, double gamma) {
  const auto j = [](int n, double x) { return std::sph_bessel(static_cast<unsigned>(n), x); };
  const auto y = [](int n, double x) { return std::sph_neumann(static_cast<unsigned>(n), x); };
  const auto slope = [](const auto& f, int n, double x) { return n / x * f(n, x) - f(n + 1, x); };
  Complex sum = 0.0;
  double p0 = 1.0, p1 = std::cos(gamma);
  for (int n = 0; n < 40; ++n) {
    const Complex out(j(n, k * b), -y(n, k * b)), out_slope(slope(j, n, k * b), -slope(y, n, k * b));
    const Complex source(j(n, k * r0), -y(n, k * r0));
    const double ja = slope(j, n, k * a), ya = slope(y, n, k * a), jb = j(n, k * b), yb = y(n, k * b);
    const Complex at_b = -j(n, k * r0) * out, at_a = -source * ja;
    const double det = jb * ya - yb * ja;
    const Complex regular = (at_b * ya - yb * at_a) / det, singular = (jb * at_a - at_b * ja) / det;
    sum += (2.0 * n + 1.0) * p0 * k *
           (j(n, k * r0) * out_slope + regular * slope(j, n, k * b) + singular * slope(y, n, k * b));
    const double next = ((2 * n + 3) * std::cos(gamma) * p1 - (n + 1) * p0) / (n + 2);
    p0 = p1;
    p1 = next;
  }
  return Complex(0.0, k / (4.0 * kPi)) * sum;
}

/// Free ball with a rigid one sunk in it.
bubble::BoundaryMesh shell(double inner_m, double outer_m, int divisions) {
  bubble::BoundaryMesh mesh = test::ball(outer_m, divisions), solid = test::ball(inner_m, divisions / 2);
  const Eigen::Index n = mesh.surface.vertices_m.rows(), m = mesh.surface.triangles.rows();
  mesh.surface.vertices_m.conservativeResize(n + solid.surface.vertices_m.rows(), 3);
  mesh.surface.vertices_m.bottomRows(solid.surface.vertices_m.rows()) = solid.surface.vertices_m;
  mesh.surface.triangles.conservativeResize(m + solid.surface.triangles.rows(), 3);
  for (Eigen::Index t = 0; t < solid.surface.triangles.rows(); ++t) {  // out of the liquid: into the solid
    const auto corners = solid.surface.triangles.row(t);
    mesh.surface.triangles.row(m + t) << static_cast<int>(n) + corners[0], static_cast<int>(n) + corners[2],
        static_cast<int>(n) + corners[1];
  }
  mesh.region.insert(mesh.region.end(), static_cast<std::size_t>(solid.surface.triangles.rows()), 2);
  return mesh;
}

}  // namespace

TEST(SunkSolid, SurfaceSlopeBesideARigidBallIsTheSeries) {
  constexpr double kInner = 0.025, kDepth = 0.035;
  const LiquidBoundary boundary(shell(kInner, kBallRadiusM, 12));
  for (const double frequency_hz : {500.0, 4000.0}) {
    const auto result = solve(boundary, frequency_hz, {0, 0, kDepth}, 60, 40);
    SourcePoints regular = random_source_points(boundary, 60, 40, 1);
    regular.solid_m.clear();
    const auto unable = solve_dual_domain(boundary, frequency_hz, regular, {{{0, 0, kDepth}, 0.001}});
    ASSERT_TRUE(result[0].usable() && unable[0].usable()) << result[0].message;
    double error = 0.0, size = 0.0, without = 0.0, regular_error = 0.0;
    for (std::size_t i = 0; i < boundary.samples().size(); ++i) {
      const BoundarySample& s = boundary.samples()[i];
      if (s.region != BoundaryRegion::kFreeSurface) continue;
      const double gamma = std::acos(std::clamp(s.point_m.z() / s.point_m.norm(), -1.0, 1.0));
      const Complex exact = shell_slope(2 * kPi * frequency_hz / 1497, kInner, kBallRadiusM, kDepth, gamma);
      error += s.area_m2 *
               std::norm(result[0].normal_derivative[static_cast<Eigen::Index>(i)] / result[0].source_strength - exact);
      regular_error +=
          s.area_m2 *
          std::norm(unable[0].normal_derivative[static_cast<Eigen::Index>(i)] / unable[0].source_strength - exact);
      without +=
          s.area_m2 * std::norm(eccentric_slope(2 * kPi * frequency_hz / 1497, kBallRadiusM, kDepth, gamma) - exact);
      size += s.area_m2 * std::norm(exact);
    }
    EXPECT_LE(std::sqrt(error / size), 0.005) << frequency_hz;
    // The solid matters, and regular waves alone cannot tell of it.
    EXPECT_GT(std::sqrt(without / size), 0.05);
    EXPECT_GT(std::sqrt(regular_error / size), 5.0 * std::sqrt(error / size));
  }
}

TEST(PressureReleaseBall, SurfaceSlopeOfACentralBubbleIsTheReference) {
  const LiquidBoundary boundary(test::ball(kBallRadiusM, 12));
  for (const BallRow& row : kConcentric) {
    const auto result = solve(boundary, row.frequency_hz, Vector3d::Zero(), 60, 40);
    ASSERT_TRUE(result[0].usable()) << result[0].message;
    for (const Complex& slope : (result[0].normal_derivative / result[0].source_strength).eval())
      EXPECT_LE(std::abs(slope - row.slope) / row.slope, 5e-3) << row.frequency_hz;
  }
}

TEST(PressureReleaseBall, SurfaceSlopeOfABubbleOffTheCentreIsTheSeries) {
  const LiquidBoundary boundary(test::ball(kBallRadiusM, 12));
  EXPECT_NEAR(eccentric_slope(2 * kPi * 500 / 1497, 0.05, 1e-4, 0.3), kConcentric[0].slope, 0.2);
  for (const double b : {0.01, 0.02, 0.03, 0.04})
    for (const double frequency_hz : {500.0, 1500.0, 4000.0}) {
      const auto result = solve(boundary, frequency_hz, {0, 0, b}, 60, 40);
      ASSERT_TRUE(result[0].usable()) << result[0].message;
      double error = 0.0, size = 0.0;
      for (std::size_t i = 0; i < boundary.samples().size(); ++i) {
        const BoundarySample& s = boundary.samples()[i];
        const double exact =
            eccentric_slope(2 * kPi * frequency_hz / 1497, 0.05, b, std::acos(s.point_m.z() / s.point_m.norm()));
        const double off =
            std::abs(result[0].normal_derivative[static_cast<Eigen::Index>(i)] / result[0].source_strength - exact);
        error += s.area_m2 * off * off;
        size += s.area_m2 * exact * exact;
      }
      EXPECT_LE(std::sqrt(error / size), 5e-3);
    }
}

TEST(ConcentricBall, PressureInTheAirIsTheExactTwoWayOne) {
  // tests/reference/fluid.json: concentric_two_way_exact, P at 0.5 m for a unit source.
  const struct {
    double frequency_hz;
    Complex exact;
  } rows[] = {{500, {2.8036253487840175e-05, -0.00017229111284443492}},
              {1500, {-8.46648322272779e-05, 7.732643034122478e-05}},
              {4000, {5.469712482068791e-05, 1.5735696951745025e-05}}};
  const LiquidBoundary boundary(test::ball(kBallRadiusM, 12));
  for (const auto& row : rows) {
    const auto result = solve(boundary, row.frequency_hz, Vector3d::Zero(), 60, 100);
    ASSERT_TRUE(result[0].usable()) << result[0].message;
    for (const Vector3d& direction :
         {Vector3d(1, 0, 0), Vector3d(0, -1, 0), Vector3d(0.6, 0, 0.8), Vector3d(0, 0, -1)}) {
      const Complex p = air_pressure(result[0], 0.5 * direction) / result[0].source_strength;
      EXPECT_LE(std::abs(p - row.exact) / std::abs(row.exact), 1e-2) << row.frequency_hz;
    }
  }
}

TEST(ClosedTank, ReferenceAgreesWithItself) {
  const test::TankImages images({0.30, 0.22, 0.15}, 2 * kPi * 1500 / 1497);
  EXPECT_NEAR(images.by_modes(0.075, 0.05), images.by_images(0.075, 0.05),
              1e-5 * std::abs(images.by_modes(0.075, 0.05)));
  // tests/reference/fluid.json: layer, f 500, H 0.1, d 0.02, r 0.1 and 0.01
  const test::TankImages layer({1, 1, 0.1}, 2 * kPi * 500 / 1497);
  EXPECT_NEAR(layer.layer(0.1, 0.02), 3.7322308342317947, 1e-8);
  EXPECT_NEAR(layer.layer(0.01, 0.02), 286.47383018113584, 1e-3);
}

TEST(ClosedTank, FreeSurfaceSlopeIsWithinEightPercentOfTheImagesAndFallsWithSources) {
  const Vector3d size(0.30, 0.22, 0.15);
  const LiquidBoundary boundary(test::tank(size, 0.0125));
  for (const Vector3d& bubble : {Vector3d(0.13, 0.10, -0.05), Vector3d(0.15, 0.11, -0.075), Vector3d(0.07, 0.15, -0.02),
                                 Vector3d(0.2, 0.06, -0.12)})
    for (const double frequency_hz : {500.0, 1500.0}) {
      const test::TankImages images(size, 2 * kPi * frequency_hz / 1497);
      std::vector<double> exact;
      for (const BoundarySample& s : boundary.samples())
        if (s.region == BoundaryRegion::kFreeSurface)
          exact.push_back(images.top_slope(s.point_m.x(), s.point_m.y(), bubble));
      double before = 1e9;
      for (const int n : {5, 15, 30, 60}) {
        const auto result = solve(boundary, frequency_hz, bubble, n, 20);
        ASSERT_TRUE(result[0].usable()) << result[0].message;
        double error = 0.0, scale = 0.0;
        std::size_t at = 0;
        for (std::size_t i = 0; i < boundary.samples().size(); ++i) {
          const BoundarySample& s = boundary.samples()[i];
          if (s.region != BoundaryRegion::kFreeSurface) continue;
          error += s.area_m2 *
                   std::norm(result[0].normal_derivative[static_cast<Eigen::Index>(i)] / result[0].source_strength -
                             exact[at]);
          scale += s.area_m2 * exact[at] * exact[at];
          ++at;
        }
        const double relative = std::sqrt(error / scale);
        EXPECT_LE(relative, before);
        before = relative;
      }
      EXPECT_LE(before, 0.01);  // the bar is 0.08; 0.0002 to 0.001 are reached
    }
}

TEST(ClosedTank, WithoutImagesOfTheBubbleSixtySourcesStillDo) {
  const Vector3d size(0.30, 0.22, 0.15), bubble(0.13, 0.10, -0.05);
  const LiquidBoundary boundary(test::tank(size, 0.0125));
  DualDomainOptions options;
  options.images = false;
  for (const double frequency_hz : {500.0, 1500.0}) {
    const test::TankImages images(size, 2 * kPi * frequency_hz / 1497);
    const auto result = solve(boundary, frequency_hz, bubble, 60, 20, 1, options);
    ASSERT_TRUE(result[0].usable()) << result[0].message;
    double error = 0.0, scale = 0.0;
    for (std::size_t i = 0; i < boundary.samples().size(); ++i) {
      const BoundarySample& s = boundary.samples()[i];
      if (s.region != BoundaryRegion::kFreeSurface) continue;
      const double exact = images.top_slope(s.point_m.x(), s.point_m.y(), bubble);
      error += s.area_m2 *
               std::norm(result[0].normal_derivative[static_cast<Eigen::Index>(i)] / result[0].source_strength - exact);
      scale += s.area_m2 * exact * exact;
    }
    EXPECT_LE(std::sqrt(error / scale), 0.08) << frequency_hz;
  }
}

TEST(DualDomain, SketchedAnswerIsThatOfLapack) {
  const LiquidBoundary boundary(test::tank({0.30, 0.22, 0.15}, 0.0125));
  const Vector3d listener(0.4, -0.3, 0.6);
  for (const bool printed : {false, true}) {
    DualDomainOptions options = printed ? DualDomainOptions::as_printed() : DualDomainOptions{};
    for (const double frequency_hz : {500.0, 3000.0}) {
      options.solver = LeastSquares::kSketch;
      const auto fast = solve(boundary, frequency_hz, {0.13, 0.10, -0.05}, 20, 30, 1, options);
      options.solver = LeastSquares::kDirect;
      const auto direct = solve(boundary, frequency_hz, {0.13, 0.10, -0.05}, 20, 30, 1, options);
      ASSERT_TRUE(fast[0].usable() && direct[0].usable());
      EXPECT_GT(fast[0].n_air_steps, 5);  // the sketch was at work
      EXPECT_LE(std::abs(fast[0].fluid_residual / direct[0].fluid_residual - 1.0), 1e-3);
      EXPECT_LE(std::abs(fast[0].air_residual / direct[0].air_residual - 1.0), 1e-3);
      const Complex p = air_pressure(direct[0], listener);
      EXPECT_LE(std::abs(air_pressure(fast[0], listener) - p) / std::abs(p), 5e-3) << printed << " " << frequency_hz;
    }
  }
}

TEST(DualDomain, AStrongRidgeIsSolvedByTheSketchToo) {
  const LiquidBoundary boundary(test::tank({0.30, 0.22, 0.15}, 0.02));
  DualDomainOptions options;
  options.ridge = 0.01;
  const auto fast = solve(boundary, 1500.0, {0.13, 0.10, -0.05}, 20, 30, 1, options);
  options.solver = LeastSquares::kDirect;
  const auto direct = solve(boundary, 1500.0, {0.13, 0.10, -0.05}, 20, 30, 1, options);
  ASSERT_TRUE(fast[0].usable() && direct[0].usable()) << fast[0].message;
  EXPECT_LE(std::abs(fast[0].air_residual / direct[0].air_residual - 1.0), 1e-3);
}

TEST(DualDomain, SameBitsOnAnyNumberOfThreads) {
  const auto run = [](int n_threads) {
    set_thread_count(n_threads);
    const LiquidBoundary boundary(test::tank({0.30, 0.22, 0.15}, 0.02));
    const auto result = solve(boundary, 1000.0, {0.13, 0.10, -0.05}, 20, 20);
    set_thread_count(0);
    return std::pair(Eigen::VectorXcd(result[0].normal_derivative), Eigen::VectorXcd(result[0].air.coefficients));
  };
  const auto one = run(1), two = run(2);
  EXPECT_EQ((one.first - two.first).cwiseAbs().maxCoeff(), 0.0);
  EXPECT_EQ((one.second - two.second).cwiseAbs().maxCoeff(), 0.0);
}

TEST(DualDomain, PrintedDensitiesAreTooLoudByTheirRatioAndTurnTheSign) {
  const LiquidBoundary boundary(test::ball(kBallRadiusM, 8));
  DualDomainOptions options;
  const auto right = solve(boundary, 1000.0, {0, 0, 0.01}, 20, 20, 1, options);
  options.literature = Literature::kPaper;
  const auto printed = solve(boundary, 1000.0, {0, 0, 0.01}, 20, 20, 1, options);
  const Complex gain = air_pressure(printed[0], {0.3, 0.1, 0.4}) / air_pressure(right[0], {0.3, 0.1, 0.4});
  EXPECT_NEAR(gain.real(), -1000.0 / 1.2041, 1e-6);
  EXPECT_NEAR(gain.imag(), 0.0, 1e-6);
}

TEST(DualDomain, BubblesOfOneCallGetTheirOwnAnswers) {
  const LiquidBoundary boundary(test::ball(kBallRadiusM, 8));
  const SourcePoints points = random_source_points(boundary, 20, 20, 3);
  const std::vector<SwingingBubble> bubbles{{{0, 0, 0.01}, 0.001}, {{0.02, -0.01, 0}, 0.002}};
  const auto both = solve_dual_domain(boundary, 1000.0, points, bubbles);
  for (std::size_t b = 0; b < 2; ++b) {
    const auto alone = solve_dual_domain(boundary, 1000.0, points, {bubbles[b]});
    const Complex p = air_pressure(alone[0], {0.3, 0.1, 0.4});
    EXPECT_LE(std::abs(air_pressure(both[b], {0.3, 0.1, 0.4}) - p), 1e-6 * std::abs(p));
  }
}

TEST(WallWeight, CarriesALengthSoThatUnitsDoNotMatter) {
  // The same tank in another unit: all lengths times 10, frequency over 10. P scales as 1/length, dP/dn as 1/length^2, whatever the
  // unit; with the printed alpha, an area ratio without a length, the answer depends on it.
  const auto slope = [](double scale, Literature literature) {
    const LiquidBoundary boundary(test::tank(scale * Vector3d(0.30, 0.22, 0.15), 0.02 * scale));
    DualDomainOptions options;
    options.literature = literature;
    options.images = false;
    const auto result = solve(boundary, 1000.0 / scale, scale * Vector3d(0.13, 0.10, -0.05), 10, 10, 1, options);
    return Eigen::VectorXcd(result[0].normal_derivative / result[0].source_strength * scale * scale);
  };
  const Eigen::VectorXcd one = slope(1.0, Literature::kCorrected);
  EXPECT_LE((slope(10.0, Literature::kCorrected) - one).norm() / one.norm(), 1e-6);
  const Eigen::VectorXcd printed = slope(1.0, Literature::kPaper);
  EXPECT_GE((slope(10.0, Literature::kPaper) - printed).norm() / printed.norm(), 1e-3);
}

TEST(DualDomain, CoarseSurfacesUseFewerSourcesAndStayRight) {
  const LiquidBoundary boundary(test::ball(kBallRadiusM, 4));  // 162 samples
  const auto result = solve(boundary, 4000.0, Vector3d::Zero(), 60, 100);
  ASSERT_TRUE(result[0].usable()) << result[0].message;
  EXPECT_EQ(result[0].n_fluid_sources, 9);
  EXPECT_EQ(result[0].n_air_sources, 6);
  const Complex exact(5.469712482068791e-05,
                      1.5735696951745025e-05);  // tests/reference/fluid.json: concentric_two_way_exact, 4000 Hz
  EXPECT_LE(std::abs(air_pressure(result[0], {0.5, 0, 0}) / result[0].source_strength - exact) / std::abs(exact), 1e-2);
}

TEST(DualDomain, RefusesBubblesOutsideAndOnTheBoundary) {
  const LiquidBoundary boundary(test::ball(kBallRadiusM, 4));
  EXPECT_THROW(solve(boundary, 1000.0, {0, 0, 0.06}, 5, 5), InputError);
  EXPECT_THROW(solve(boundary, 1000.0, {0, 0, 0.05}, 5, 5), InputError);
}
