#include <gtest/gtest.h>

#include <cmath>

#include "core/physics/rigid/detail/body_state.hpp"

using namespace klang::rigid::detail;
using Eigen::Vector3d;

namespace {

BodyState top() {
  BodyState body;
  body.mass = body.inverse_mass = 1.0;
  body.inertia = Vector3d(1e-5, 2e-5, 3e-5).asDiagonal();
  body.inverse_inertia = body.inertia.inverse();
  body.spin = Vector3d(10, 0.1, 10);
  return body;
}

double error_after_one_second(int steps) {
  BodyState body = top();
  for (int i = 0; i < steps; ++i) rotate_freely(body, 1.0 / steps);
  // tests/reference/contact.json, free_top: angular velocity in body axes after 1 s.
  return (body.turn.conjugate() * body.spin - Vector3d(-9.249002832728621, 3.8034124940871097, 9.756093026067045))
      .norm();
}

}  // namespace

TEST(FreeRotation, AnAsymmetricTopTurnsAsTheReferenceWithOrderFour) {
  const double errors[] = {error_after_one_second(100), error_after_one_second(200), error_after_one_second(400),
                           error_after_one_second(800)};
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(std::log2(errors[i] / errors[i + 1]), 4.0, 0.3) << errors[i];
  EXPECT_LE(error_after_one_second(5000), 1e-8);
}

TEST(FreeRotation, EnergyAndAngularMomentumStayForTenThousandSteps) {
  BodyState body = top();
  const double energy = body.kinetic();
  const Vector3d momentum = body.angular_momentum();
  for (int i = 0; i < 10000; ++i) rotate_freely(body, 1e-3);
  EXPECT_NEAR(body.kinetic(), energy, 1e-11 * energy);
  EXPECT_LE((body.angular_momentum() - momentum).norm(), 1e-11 * momentum.norm());
}
