#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/sound/soundbank/proxy.hpp"
#include "tests/core/sound/soundbank/small_bank.hpp"

using namespace klang;
namespace sb = klang::soundbank;

// SB eq. 12 and errata 44: I1 >= I2 >= I3 gives a <= b <= c.
TEST(AxesOfMoments, GiveBackTheEllipsoid) {
  const Eigen::Vector3d axes = Eigen::Vector3d(0.2, 0.5, 0.9).normalized();
  const auto square = axes.array().square();
  const Eigen::Vector3d moments(square[1] + square[2], square[0] + square[2], square[0] + square[1]);
  EXPECT_LE((sb::axes_of_moments(3.7 * moments) - axes).norm(), 1e-14);
  EXPECT_LE((sb::axes_of_moments(3.7 * moments.reverse()) - axes).norm(), 1e-14);
}

TEST(AxesOfMoments, MomentsThatNoBodyHasAreRefused) {
  EXPECT_THROW(sb::axes_of_moments({3.0, 1.0, 1.0}), InputError);
  EXPECT_THROW(sb::axes_of_moments({1.0, 0.0, 1.0}), InputError);
  EXPECT_THROW(sb::axes_of_moments({1.0, NAN, 1.0}), InputError);
  EXPECT_EQ(sb::axes_of_moments({2.0, 1.0, 1.0})[0], 0.0);  // a flat disk
}

TEST(PrincipalFrame, IsAProperRotationToTheProxysAxes) {
  const Eigen::Matrix3d turn = (Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, -1).normalized())).toRotationMatrix();
  for (const double sign : {1.0, -1.0}) {  // a mirrored frame must not give a mirrored body
    Eigen::Matrix3d axes = turn;
    axes.col(1) *= sign;
    const Eigen::Matrix3d inertia = axes * Eigen::Vector3d(1.3, 3.0, 2.2).asDiagonal() * axes.transpose();
    const sb::PrincipalFrame frame = sb::principal_frame(inertia);
    EXPECT_LE(std::abs(frame.rotation.determinant() - 1.0), 1e-12);
    const Eigen::Matrix3d turned = frame.rotation * inertia * frame.rotation.transpose();
    EXPECT_LE((turned - Eigen::Matrix3d(Eigen::Vector3d(3.0, 2.2, 1.3).asDiagonal())).norm(), 1e-12);
  }
}

// errata 44: closed form of SB eqs. 23 and 24.
TEST(PointOfNormal, LiesOnTheEllipsoidWithThatNormalAndSolvesThePrintedSystem) {
  const Eigen::Vector3d axes(0.2, 0.5, 0.9);
  for (const Eigen::Vector3d& raw : {Eigen::Vector3d(1, -2, 0.5), Eigen::Vector3d(0.1, 0.1, -3),
                                     Eigen::Vector3d(0, 0, 1), Eigen::Vector3d(-1, 1, 1)}) {
    const Eigen::Vector3d n = raw.normalized(), p = sb::point_of_normal(axes, raw);
    EXPECT_LE(std::abs(p.cwiseQuotient(axes).squaredNorm() - 1.0), 1e-14);
    EXPECT_LE((p.cwiseQuotient(axes.cwiseProduct(axes)).normalized() - n).norm(), 1e-14);
    const Eigen::Array3d square = p.cwiseQuotient(axes).array().square();
    const Eigen::Array3d over = axes.array().square().inverse();
    EXPECT_LE(
        std::abs((n[0] * n[0] - 1.0) * over[0] * square[0] + n[0] * n[0] * (over[1] * square[1] + over[2] * square[2])),
        1e-12 * over[0]);
  }
}

// A body that is an ellipsoid itself: places of its surface are the proxy's own, however large it is.
TEST(PointOfPlace, OfAnEllipsoidIsThePlaceItself) {
  const Eigen::Vector3d axes = Eigen::Vector3d(0.2, 0.5, 0.9).normalized(), body = 0.07 * axes;
  const double volume = 4.0 / 3.0 * kPi * body.prod();
  const Eigen::Array3d square = body.array().square();
  const Eigen::Vector3d moments =
      volume / 5.0 * Eigen::Vector3d(square[1] + square[2], square[0] + square[2], square[0] + square[1]);
  for (const Eigen::Vector3d& raw :
       {Eigen::Vector3d(1, -2, 0.5), Eigen::Vector3d(0.1, 0.1, -3), Eigen::Vector3d(-1, 1, 1)}) {
    const Eigen::Vector3d xi = raw.normalized();
    EXPECT_LE((sb::point_of_place(axes, body.cwiseProduct(xi), moments, volume) - axes.cwiseProduct(xi)).norm(), 1e-13);
    EXPECT_LE((sb::point_of_place(axes, 0.3 * body.cwiseProduct(xi), moments, volume) - axes.cwiseProduct(xi)).norm(),
              1e-13)
        << "pushed to the surface";
  }
  EXPECT_LE(
      (sb::point_of_place(axes, Eigen::Vector3d::Zero(), moments, volume) - Eigen::Vector3d(0, 0, axes[2])).norm(),
      1e-15);
}

TEST(ProxyFinder, NearestCellIsTheOneOfAFullSearch) {
  const sb::Soundbank& bank = test::small_bank();
  const sb::ProxyFinder finder(bank);
  for (int i = 1; i < 40; ++i) {
    const Eigen::Vector3d axes = sb::unit_axes({-0.017 * i, -0.009 * i});
    double best = HUGE_VAL, distance = 0.0;
    for (const sb::Cell& cell : bank.cells) best = std::min(best, (sb::unit_axes(cell.shape) - axes).norm());
    const int found = finder.nearest_cell(axes, distance);
    EXPECT_LE(std::abs(distance - best), 1e-14);
    EXPECT_LE(std::abs((sb::unit_axes(bank.cells[found].shape) - axes).norm() - best), 1e-14);
  }
}

TEST(ProxyFinder, ScaleComesFromTheLowestModeAlone) {
  const sb::Soundbank& bank = test::small_bank();
  const sb::ProxyFinder finder(bank);
  const Eigen::Vector3d axes = sb::unit_axes({-0.4, -0.2});
  const sb::Proxy one = finder.of_axes(axes, 1000.0), two = finder.of_axes(axes, 2000.0),
                  stiff = finder.of_axes(axes, 2000.0, 2.0 * bank.material.shear_speed_m_s());
  EXPECT_LE(std::abs(one.scale / two.scale - 2.0), 1e-12);
  EXPECT_LE(std::abs(stiff.scale / one.scale - 1.0), 1e-12);
  EXPECT_LE(std::abs(sb::proxy_frequencies_hz(bank, two, 4)[0] - 2000.0), 1e-8);
}

TEST(ProxyFinder, ThinnerBodiesAreMovedToTheBorderAndSaidSo) {
  const sb::ProxyFinder finder(test::small_bank());
  const sb::Proxy proxy = finder.find({2.0, 1.0, 1.0}, 1000.0);
  EXPECT_TRUE(proxy.clamped);
  EXPECT_LE(std::abs(proxy.axes[0] / proxy.axes[2] - 0.5), 1e-12);
  EXPECT_FALSE(finder.of_axes({0.6, 0.7, 1.0}, 1000.0).clamped);
}

// errata 40 and 41: a cell as a body of its own.
TEST(CellModes, AreTheDirectSolutionOfTheScaledBody) {
  const sb::Soundbank& bank = test::small_bank();
  const double gamma = 0.031;
  const int cell = static_cast<int>(bank.cells.size()) / 2;
  const sb::EllipsoidModes stored = sb::cell_modes(bank, cell, gamma);
  const sb::EllipsoidModes direct(stored.axes_m(), bank.material, {bank.degree, 12});
  const Eigen::Matrix3Xd at = Eigen::Vector3d(0.2, -0.5, 0.6);
  for (const sb::CellMode& mode : bank.cells[cell].modes) {
    EXPECT_LE(std::abs(stored.angular_frequency_rad_s(mode.id) / direct.angular_frequency_rad_s(mode.id) - 1.0), 1e-10);
    const Eigen::Vector3d s = stored.shape_at(mode.id, at), d = direct.shape_at(mode.id, at);
    EXPECT_LE(std::min((s - d).norm(), (s + d).norm()), 2e-6 * d.norm());
  }
}
