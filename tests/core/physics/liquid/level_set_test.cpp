#include "core/physics/liquid/level_set.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/random.hpp"
#include "core/physics/liquid/carried_level.hpp"

namespace klang::liquid {
namespace {

using Eigen::Vector3d;

TEST(PlaneFraction, IsTheShareOfPointsBehindThePlane) {
  RandomStream random(3, 0);
  for (int turn = 0; turn < 200; ++turn) {
    Vector3d slope(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1));
    if (turn % 5 == 0) slope.x() = 0.0;
    if (turn % 7 == 0) slope.y() = 0.0;
    const double value = random.uniform(-0.8, 0.8);
    constexpr int kPoints = 40;
    double sum = 0.0;
    for (int c = 0; c < kPoints * kPoints * kPoints; ++c) {
      const Vector3d x((c % kPoints + 0.5) / kPoints - 0.5, (c / kPoints % kPoints + 0.5) / kPoints - 0.5,
                       (c / (kPoints * kPoints) + 0.5) / kPoints - 0.5);
      sum += value + slope.dot(x) < 0.0 ? 1.0 : 0.0;
    }
    EXPECT_LE(std::abs(plane_fraction(value, slope) - sum / std::pow(kPoints, 3)), 0.02) << turn;
  }
}

TEST(Redistance, FindsTheDistanceOfABallFromABadFunctionToItsFullDepth) {
  double before = 0.0;
  for (const int n : {16, 32, 64}) {
    const GridShape shape{n, n, n, 1.0 / n};
    const Vector3d centre(0.5, 0.47, 0.51);
    Field phi(n, n, n);
    for (int k = 0; k < n; ++k)
      for (int j = 0; j < n; ++j)
        for (int i = 0; i < n; ++i) {
          const double d = (shape.centre_m(i, j, k) - centre).norm() - 0.35;
          phi(i, j, k) = std::tanh(3.0 * d) * 0.8;
        }
    redistance(shape, 3.0 / n, 10.0, phi);
    double worst = 0.0;
    for (int k = 0; k < n; ++k)
      for (int j = 0; j < n; ++j)
        for (int i = 0; i < n; ++i) {
          const Vector3d x = shape.centre_m(i, j, k);
          if ((x - centre).norm() > 2.0 / n)
            worst = std::max(worst, std::abs(phi(i, j, k) - ((x - centre).norm() - 0.35)));
        }
    if (before > 0.0) {
      EXPECT_LE(worst, 0.75 * before) << n;  // first order, with its logarithm
    }
    before = worst;
  }
  EXPECT_LE(before, 0.02);
}

TEST(Volume, OfDropsHollowsAndFilmsIsWhatTheyHold) {
  const double h = 0.005;
  const GridShape shape{32, 32, 32, h};
  const SolidField open = solid_field(shape, {});
  const auto volume_of = [&](const auto& phi_at) {
    Field phi(32, 32, 32);
    for (int k = 0; k < 32; ++k)
      for (int j = 0; j < 32; ++j)
        for (int i = 0; i < 32; ++i) phi(i, j, k) = phi_at(shape.centre_m(i, j, k));
    return liquid_volume_m3(shape, phi, open);
  };
  const Vector3d middle(0.081, 0.0793, 0.0782);
  for (const double cells : {1.5, 2.0, 3.0, 4.0, 6.0, 10.0}) {
    const double r = cells * h, exact = 4.0 / 3.0 * std::numbers::pi * r * r * r;
    EXPECT_LE(std::abs(volume_of([&](const Vector3d& x) { return (x - middle).norm() - r; }) / exact - 1.0),
              cells < 2.0 ? 0.05 : 0.02 * 4.0 / (cells * cells))
        << cells << " cells: 0.25 / cells^2 too large by planes alone";
    const double hollow = 0.16 * 0.16 * 0.16 - exact;
    EXPECT_LE(std::abs(volume_of([&](const Vector3d& x) { return r - (x - middle).norm(); }) - hollow) / exact,
              cells < 2.0 ? 0.05 : 0.02 * 4.0 / (cells * cells))
        << cells;
  }
  double mean = 0.0;
  for (int place = 0; place < 8; ++place)  // a film of 0.6 cells, where centres see it as they happen to stand
    mean += volume_of([&](const Vector3d& x) { return std::abs(x.z() - 0.08 - h * place / 8.0) - 0.3 * h; }) / 8.0;
  EXPECT_LE(std::abs(mean / (0.6 * h * 0.16 * 0.16) - 1.0), 0.25);
}

TEST(Advection, CarriesAPlaneExactlyAwayFromTheWalls) {
  const GridShape shape{20, 6, 20, 0.05};
  Field phi(20, 6, 20);
  MacGrid u(shape);
  for (double& value : u[0].data()) value = 0.3;
  for (double& value : u[2].data()) value = -0.1;
  const Vector3d normal = Vector3d(0.3, 0.0, 1.0).normalized();
  const auto plane = [&](const Vector3d& x, double t) {
    return normal.dot(x - t * Vector3d(0.3, 0.0, -0.1) - Vector3d(0.5, 0.15, 0.5));
  };
  for (int k = 0; k < 20; ++k)
    for (int j = 0; j < 6; ++j)
      for (int i = 0; i < 20; ++i) phi(i, j, k) = plane(shape.centre_m(i, j, k), 0.0);
  for (int step = 0; step < 2; ++step) advect_level_set(shape, u, 0.1, 1e3, phi);
  for (int k = 6; k < 14; ++k)
    for (int i = 6; i < 14; ++i)
      EXPECT_LE(std::abs(phi(i, 3, k) - plane(shape.centre_m(i, 3, k), 0.2)), 1e-12) << i << " " << k;
}

TEST(Particles, KeepUniformAndLinearVelocityThroughTheGrid) {
  const GridShape shape{8, 8, 8, 0.1};
  Particles particles;
  RandomStream random(5, 2);
  const auto flow = [](const Vector3d& x) {
    return Vector3d(0.2 + x.y() - 0.3 * x.z(), -0.1 + 0.5 * x.x(), 0.7 * x.z() - 0.2 * x.y());
  };
  Eigen::Matrix3f gradient;
  gradient << 0, 1, -0.3F, 0.5F, 0, 0, 0, -0.2F, 0.7F;
  for (int p = 0; p < 4000; ++p) {
    const Vector3d x = 0.8 * Vector3d(random.uniform(), random.uniform(), random.uniform());
    particles.add(x, flow(x).cast<float>(), gradient);
  }
  particles.sort(shape);
  MacGrid u(shape), weight(shape);
  particles_to_faces(shape, particles, u, weight);
  for (int axis = 0; axis < 3; ++axis)
    for (int c = 2; c < 6; ++c)
      EXPECT_LE(std::abs(u[axis](c, 4, 3) - flow(face_m(shape, axis, c, 4, 3))[axis]), 1e-6) << axis;
  const Grid3<std::uint8_t> everywhere(8, 8, 8, 1);
  faces_to_particles(shape, {u, nullptr, 0.0, everywhere, Eigen::Vector3f::Zero()}, particles);
  for (std::size_t p = 0; p < particles.size(); ++p) {
    const Vector3d x = particles.x_m[p];
    if (x.minCoeff() < 0.2 || x.maxCoeff() > 0.6) continue;
    EXPECT_LE((particles.v_m_s[p].cast<double>() - flow(x)).norm(), 1e-6);
    EXPECT_LE((particles.affine_per_s[p] - gradient).norm(), 1e-4F);
  }
}

/// A ball, and particles in it that carry its distance.
struct CarriedBall {
  GridShape shape{20, 20, 20, 0.05};
  Field phi{20, 20, 20};
  Particles particles;
  CarriedBall() {
    for (int k = 0; k < 20; ++k)
      for (int j = 0; j < 20; ++j)
        for (int i = 0; i < 20; ++i) phi(i, j, k) = (shape.centre_m(i, j, k) - Vector3d::Constant(0.5)).norm() - 0.3;
    RandomStream random(8, 1);
    for (int p = 0; p < 60000; ++p) {
      const Vector3d x(random.uniform(), random.uniform(), random.uniform());
      if (at_centres(phi, x, 0.05) < 0.0) particles.add(x, Eigen::Vector3f::Zero());
    }
    particles.sort(shape);
    update_carried(shape, phi, {MacGrid(shape)}, {}, particles);
  }
};

TEST(CarriedLevel, LeavesAGridThatAgreesAsItIs) {
  CarriedBall ball;
  const Field before = ball.phi;
  correct_by_carried(ball.shape, ball.particles, {}, ball.phi);
  EXPECT_EQ(ball.phi.data(), before.data());
  update_carried(ball.shape, ball.phi, {MacGrid(ball.shape)}, {}, ball.particles);
  correct_by_carried(ball.shape, ball.particles, {}, ball.phi);
  EXPECT_EQ(ball.phi.data(), before.data());
}

TEST(CarriedLevel, BringsBackWhatTheGridLost) {
  CarriedBall ball;
  const Field before = ball.phi;
  const auto worst_below = [&](double offset_m) {
    double worst = 0.0;
    for (std::size_t c = 0; c < before.size(); ++c)
      if (before[c] > -0.03 && before[c] < 0.0) worst = std::max(worst, std::abs(ball.phi[c] - before[c] - offset_m));
    return worst / 0.05;  // cells
  };
  for (double& value : ball.phi.data()) value += 0.2 * 0.05;  // lost: a fifth of a cell
  for (int turn = 0; turn < 30; ++turn) correct_by_carried(ball.shape, ball.particles, {}, ball.phi);
  EXPECT_LE(worst_below(0.0), 0.06) << "cells outside, which few particles reach, lag";
  update_carried(ball.shape, ball.phi, {MacGrid(ball.shape)}, {}, ball.particles);
  ball.phi = before;
  for (double& value : ball.phi.data()) value -= 0.2 * 0.05;
  for (int turn = 0; turn < 30; ++turn) correct_by_carried(ball.shape, ball.particles, {}, ball.phi);
  EXPECT_LE(worst_below(0.0), 0.06) << "shifts of the grid are no news to them";
}

TEST(CarriedLevel, GrowsAsTheFlowStretchesItAlongTheNormal) {
  const GridShape shape{20, 20, 20, 0.05};
  Field phi(20, 20, 20);
  for (int k = 0; k < 20; ++k)
    for (int j = 0; j < 20; ++j)
      for (int i = 0; i < 20; ++i) phi(i, j, k) = shape.centre_m(i, j, k).z() - 0.5;
  MacGrid u(shape);  // up along z, together along x: rate 3 per second
  for (int k = 0; k < u[2].nz(); ++k)
    for (int j = 0; j < 20; ++j)
      for (int i = 0; i < 20; ++i) u[2](i, j, k) = 3.0 * (face_m(shape, 2, i, j, k).z() - 0.5);
  Particles particles;
  for (int p = 0; p < 50; ++p) particles.add(Vector3d(0.3 + 0.005 * p, 0.5, 0.45), Eigen::Vector3f::Zero());
  particles.sort(shape);
  CarriedLevel everywhere;
  everywhere.resolved_bend = -1.0;
  update_carried(shape, phi, {u}, everywhere, particles);
  for (int turn = 0; turn < 10; ++turn) update_carried(shape, phi, {u, 0.01}, everywhere, particles);
  for (const double carried : particles.phi_m) EXPECT_NEAR(carried, -0.05 * std::pow(1.03, 10), 1e-12);
  for (int turn = 0; turn < 200; ++turn) update_carried(shape, phi, {u, 0.01}, everywhere, particles);
  for (const double carried : particles.phi_m)
    EXPECT_NEAR(carried, -0.05, 0.05 + 1e-12) << "a cell off the grid at most";
}

TEST(CarriedLevel, IsForgottenFiveCellsFromWhereTheGridIsPoor) {
  const GridShape shape{20, 3, 20, 0.05};
  Field phi(20, 3, 20);
  for (int k = 0; k < 20; ++k)
    for (int j = 0; j < 3; ++j)
      for (int i = 0; i < 20; ++i) {  // a step down at x = 0.5
        const Vector3d x = shape.centre_m(i, j, k);
        phi(i, j, k) = std::max(x.z() - 0.55, std::min(x.x() - 0.5, x.z() - 0.2));
      }
  Particles particles;
  particles.add(Vector3d(0.025, 0.08, 0.54), Eigen::Vector3f::Zero());
  particles.add(Vector3d(0.475, 0.08, 0.54), Eigen::Vector3f::Zero());
  particles.sort(shape);
  const MacGrid u(shape);
  update_carried(shape, phi, {u}, {}, particles);
  for (double& value : phi.data()) value += 0.01;
  update_carried(shape, phi, {u}, {}, particles);
  for (std::size_t p = 0; p < 2; ++p) {
    const bool far_off = particles.x_m[p].x() < 0.1;
    EXPECT_NEAR(particles.phi_m[p] - at_centres(phi, particles.x_m[p], 0.05), far_off ? 0.0 : -0.01, 1e-12);
  }
}

}  // namespace
}  // namespace klang::liquid
