#include "core/physics/rigid/detail/contact_solver.hpp"

#include <gtest/gtest.h>

using namespace klang::rigid::detail;
using Eigen::Vector3d;

namespace {

Contact point(const Vector3d& arm, double friction) {
  Contact c;
  c.arm_a = arm;
  c.arm_b.setZero();
  c.axes << 0, 1, 0, 0, 0, 1, 1, 0, 0;
  c.friction = friction;
  return c;
}

}  // namespace

// A body of mass and inertia 1 falls at 1 m/s on two points on one side of its centre, at 0.1 and 2 m. J = 1 / (1 + 0.1^2) at the near
// one stops that, and the far one then rises at J (1 + 0.1 * 2) - 1 = 0.188 m/s: the complementary solution leaves it alone.
TEST(ContactSolver, APointThatSeparatesIsNotPushed) {
  BodyState body;
  body.mass = body.inverse_mass = 1.0;
  body.inverse_inertia = Eigen::Matrix3d::Identity();
  body.velocity = Vector3d(0, 0, -1);
  Bodies bodies{{&body, 1}, {body.inverse_inertia}};
  Contact near = point(Vector3d(0.1, 0, 0), 0), far = point(Vector3d(2.0, 0, 0), 0);
  Contact* contacts[] = {&near, &far};
  const double residual = solve_contacts(contacts, &Contact::impact, 1000, 1e-15, bodies);
  EXPECT_LE(residual, 1e-12);
  EXPECT_NEAR(near.impact[0], 1 / 1.01, 1e-12);
  EXPECT_EQ(far.impact[0], 0.0);
  EXPECT_NEAR(relative_velocity(far, bodies)[0], 1.2 / 1.01 - 1, 1e-12);
}

TEST(ContactSolver, FrictionLiesAgainstTheSlidingAndWithinTheCone) {
  BodyState body;
  body.mass = body.inverse_mass = 1.0;
  body.velocity = Vector3d(3, 4, -1);
  Bodies bodies{{&body, 1}, {Eigen::Matrix3d::Zero()}};
  Contact c = point(Vector3d::Zero(), 0.3);
  Contact* contacts[] = {&c};
  EXPECT_LE(solve_contacts(contacts, &Contact::impact, 1000, 1e-15, bodies), 1e-12);
  EXPECT_NEAR(c.impact[0], 1.0, 1e-12);
  EXPECT_NEAR(c.impact.tail<2>().norm(), 0.3, 1e-12);
  EXPECT_LE((body.velocity - Vector3d(3 - 0.18, 4 - 0.24, 0)).norm(), 1e-12);
}
