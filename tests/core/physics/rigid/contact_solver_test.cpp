#include "core/physics/rigid/detail/contact_solver.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "core/physics/rigid/detail/mixing.hpp"

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

// Ten cubes of mass 1 on each other, all falling at 1 m/s: the impulse on the i-th from below stops all above it. Sweeps alone pass it
// on by a cube or two each and leave 1e-3 m/s after 200.
TEST(ContactSolver, APileIsSolvedInTwoHundredSweeps) {
  std::vector<BodyState> cubes(10);
  Bodies bodies{cubes, {}};
  for (std::size_t i = 0; i < cubes.size(); ++i) {
    cubes[i].mass = cubes[i].inverse_mass = 1.0;
    cubes[i].inverse_inertia = 6 * Eigen::Matrix3d::Identity();
    cubes[i].centre.z() = 0.5 + static_cast<double>(i);
    cubes[i].velocity = Vector3d(0, 0, -1);
    bodies.inverse_inertia.push_back(cubes[i].inverse_inertia);
  }
  std::vector<Contact> corners;
  for (int i = 0; i < 10; ++i) {
    for (const double x : {-0.5, 0.5}) {
      for (const double y : {-0.5, 0.5}) {
        Contact c = point(Vector3d(x, y, -0.5), 0.5);
        c.a = i;
        c.b = i - 1;
        c.arm_b = Vector3d(x, y, 0.5);
        corners.push_back(c);
      }
    }
  }
  std::vector<Contact*> contacts;
  for (Contact& c : corners) contacts.push_back(&c);
  EXPECT_LE(solve_contacts(contacts, &Contact::impact, 200, 1e-9, bodies), 1e-8);
  for (int i = 0; i < 10; ++i) {
    double impulse = 0;
    for (const Contact& c : corners) impulse += c.a == i ? c.impact[0] : 0.0;
    EXPECT_NEAR(impulse, 10 - i, 1e-6) << i;
  }
}

// x -> A x + b with a spectral radius of 0.99 in six dimensions: alone a thousand steps to 1e-4.
TEST(Mixing, EndsALinearIterationInAFewSteps) {
  Eigen::VectorXd shrink(6), solution(6), x = Eigen::VectorXd::Zero(6);
  shrink << 0.99, 0.9, 0.7, 0.3, -0.2, -0.8;
  solution << 1, -2, 3, 4, -5, 6;
  Mixing mixing(Eigen::VectorXd::Ones(6));
  int n = 0;
  for (; n < 40 && (x - solution).norm() > 1e-9; ++n) x = mixing.next(x, solution + shrink.cwiseProduct(x - solution));
  EXPECT_LE(n, 12);
}
