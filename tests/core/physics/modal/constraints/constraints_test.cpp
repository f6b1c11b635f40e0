// Constraints and contact of modal bodies against tests/reference/oscillator.json and tests/reference/modal_contact.json.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "core/foundation/base/errors.hpp"
#include "core/physics/modal/constraints/touching_body.hpp"
#include "tests/places.hpp"

namespace klang::modal {
namespace {

nlohmann::json reference(bool contact) {
  std::ifstream file(contact ? klang::test::source_dir() + "/tests/reference/modal_contact.json"
                             : klang::test::source_dir() + "/tests/reference/oscillator.json");
  return nlohmann::json::parse(file);
}

Eigen::VectorXd vector_of(const nlohmann::json& values) {
  Eigen::VectorXd v(static_cast<Eigen::Index>(values.size()));
  for (std::size_t i = 0; i < values.size(); ++i) v[static_cast<Eigen::Index>(i)] = values[i];
  return v;
}
Eigen::MatrixXd matrix_of(const nlohmann::json& rows) {
  Eigen::MatrixXd m(static_cast<Eigen::Index>(rows.size()), static_cast<Eigen::Index>(rows[0].size()));
  for (std::size_t i = 0; i < rows.size(); ++i) m.row(static_cast<Eigen::Index>(i)) = vector_of(rows[i]).transpose();
  return m;
}

TEST(ModalStep, IsThatOfTheReferenceForEveryDamping) {
  const nlohmann::json values = reference(false);
  const double dt = 1.0 / values.at("fs").get<double>();
  for (const auto& c : values.at("cases")) {
    const ModalStep step = modal_step(c.at("lam"), c.at("c"), dt);
    EXPECT_LE(std::abs(step.h / c.at("S_ii_hdt").get<double>() - 1.0), 1e-12) << c.at("name");
    EXPECT_LE(std::abs(step.h_integral / c.at("H_dt").get<double>() - 1.0), 2e-11) << c.at("name");
    EXPECT_LE(std::abs(step.z_z - c.at("A")[0][0].get<double>()), 1e-13);
    EXPECT_LE(std::abs(step.v_v - c.at("A")[1][1].get<double>()), 1e-13);
    EXPECT_LE(std::abs(step.v_z - c.at("A")[1][0].get<double>()), 1e-12 * (1.0 + std::abs(step.v_z)));
  }
}

TEST(ModalStep, PositionConstraintHitsItsTargetAndThePrintedOneDoesNot) {  // erratum 12
  const nlohmann::json example = reference(false).at("position_constraint_example");
  const Eigen::MatrixXd w = matrix_of(example.at("W"));
  ModalState state(vector_of(example.at("lam")), vector_of(example.at("c")));
  state.z = vector_of(example.at("z0"));
  state.v = vector_of(example.at("zd0"));
  state.set_step(example.at("Dt"));
  const Eigen::VectorXd target = vector_of(example.at("d_star"));
  const Eigen::VectorXd forces = position_forces(state, w, target);
  EXPECT_LE((forces - vector_of(example.at("f_constant_form"))).norm(), 1e-9 * forces.norm());
  const Eigen::VectorXd impulse = position_impulse_forces(state, w, target);
  EXPECT_LE((impulse - vector_of(example.at("f_impulse_form"))).norm(), 1e-9 * impulse.norm());
  EXPECT_GE((vector_of(example.at("d_end_printed_as_impulse")) - target).norm(), 0.1);
  state.advance(w.transpose() * forces);
  EXPECT_LE((w * state.z - target).norm(), 1e-15);
}

TEST(ModalStep, AHeldPlaceStaysAtStepEndsForASecond) {
  Eigen::VectorXd lambda(4), damping(4);
  lambda << 0.0, 1e5, 7e5, 4e6;
  damping << 0.0, 2.0, 5.0, 9.0;
  Eigen::MatrixXd w(1, 4);
  w << 0.7, -0.4, 0.25, 0.1;
  ModalState state(lambda, damping);
  state.set_step(5e-4);
  state.v << 0.3, 0.1, -0.2, 0.0;
  const Eigen::VectorXd target = Eigen::VectorXd::Zero(1);
  for (int i = 0; i < 2000; ++i) {
    state.advance(w.transpose() * position_forces(state, w, target));
    ASSERT_LE(std::abs((w * state.z)[0]), 1e-12);
  }
}

TEST(ContactProblem, LinearProgramPushesAContactThatSeparatesAndTheLcpDoesNot) {  // erratum 71
  const nlohmann::json all = reference(true);
  for (const char* key : {"lp_is_not_lcp", "rod_two_contacts"}) {
    const nlohmann::json& c = all.at(key);
    const Eigen::MatrixXd a = matrix_of(c.at("A"));
    const Eigen::VectorXd b = Eigen::VectorXd::Constant(2, -1.0);
    const ContactForces lcp = solve_lcp(a, b), lp = solve_contact_lp(a, b);
    EXPECT_LE((lcp.forces - vector_of(c.at(c.contains("lcp") ? "lcp" : "lcp_force"))).norm(), 1e-12) << key;
    EXPECT_LE((lp.forces - vector_of(c.at(c.contains("lp") ? "lp" : "lp_minimal_total_force"))).norm(), 1e-12) << key;
    EXPECT_LE(lcp.residual, 1e-12);
    EXPECT_GE(lp.residual, 0.1);
    const Eigen::VectorXd away = a * lp.forces + b;
    EXPECT_GT(lp.forces[1], 0.0);
    EXPECT_GT(away[1], 0.5);
  }
}

TEST(ContactProblem, RandomComplementarityProblemsAreSolvedAlsoSingularOnes) {
  std::srand(5);
  for (int i = 0; i < 200; ++i) {
    const Eigen::Index n = 1 + i % 12;
    const Eigen::MatrixXd g = Eigen::MatrixXd::Random(n, 1 + i % 7);
    const Eigen::MatrixXd a = g * g.transpose();
    const Eigen::VectorXd b = g * Eigen::VectorXd::Random(g.cols());  // in range: there is an answer
    EXPECT_LE(solve_lcp(a, b).residual, 1e-9) << i;
  }
}

TEST(ContactProblem, ABlockOnAnInclineSticksUpToTheAngleOfFriction) {
  const double mu = 0.4;
  const Eigen::MatrixXd a = Eigen::Matrix3d::Identity();
  for (const double offset_deg : {-0.1, 0.1}) {
    const double angle = std::atan(mu) + offset_deg * M_PI / 180.0;
    const Eigen::Vector3d b(-std::cos(angle), -std::sin(angle), 0.0);
    const ContactForces solved = solve_friction(a, b, Eigen::VectorXd::Constant(1, mu));
    const Eigen::VectorXd slide = a * solved.forces + b;
    EXPECT_LE(solved.residual, 1e-9);
    EXPECT_NEAR(solved.forces[0], std::cos(angle), 1e-12);
    if (offset_deg < 0.0) {
      EXPECT_LE(slide.tail<2>().norm(), 1e-12);
    } else {
      EXPECT_LE(std::abs(-slide[1] - (std::sin(angle) - mu * std::cos(angle))), 1e-12);
    }
  }
}

TEST(ContactProblem, AFaceOfManyCornersSticksOrSlidesInFewGuesses) {
  // 25 corners of a block with 6 modes: 75 forces for 12 motions.
  std::srand(7);
  const double mu = 0.3, speed_down = 1e-3;
  Eigen::MatrixXd rows(75, 12);
  for (Eigen::Index i = 0; i < 25; ++i) {
    const Eigen::Vector3d arm(0.02 * static_cast<double>(i % 5 - 2), 0.015 * static_cast<double>(i / 5 - 2), -0.02);
    for (Eigen::Index k = 0; k < 3; ++k) {
      const Eigen::Vector3d along = Eigen::Vector3d::Unit((k + 2) % 3);  // normal first
      rows.block<1, 3>(3 * i + k, 0) = along.transpose() / std::sqrt(0.3);
      rows.block<1, 3>(3 * i + k, 3) = arm.cross(along).transpose() / std::sqrt(3e-4);
      rows.block<1, 6>(3 * i + k, 6) = 0.3 * Eigen::RowVectorXd::Random(6);
    }
  }
  for (const double along : {0.0, 0.5 * mu * speed_down, 1.0}) {
    Eigen::VectorXd motion = Eigen::VectorXd::Zero(12);
    motion[2] = -speed_down * std::sqrt(0.3);
    motion[0] = along * std::sqrt(0.3);
    const Eigen::VectorXd b = rows * motion;
    const ContactForces solved =
        solve_friction(rows * rows.transpose(), b, Eigen::VectorXd::Constant(25, mu), {0, 0, 1e-10, 1e-10, {}});
    EXPECT_LE(solved.residual, 1e-10) << along;  // without a sweep
    const Eigen::VectorXd left = rows * (motion + rows.transpose() * solved.forces);
    if (along <= mu * speed_down) {
      EXPECT_LE(left.norm(), 1e-9 * speed_down) << along;
    } else {
      EXPECT_GT(left.norm(), 0.5) << along;
    }
    for (Eigen::Index i = 0; i < 25; ++i) {
      EXPECT_GE(left[3 * i], -1e-9 * speed_down);
      EXPECT_GE(solved.forces[3 * i], 0.0);
      EXPECT_LE(solved.forces.segment<2>(3 * i + 1).norm(), mu * solved.forces[3 * i] * (1 + 1e-9));
    }
  }
}

TEST(BarOnWall, ReboundAndShockAreThoseOfTheModesThatAreKept) {  // erratum 72
  for (const auto& row : reference(true).at("bar_on_wall").at("rows")) {
    BarOnWall bar;
    bar.n_modes = row.at("elastic_modes");
    if (bar.n_modes > 16) continue;
    const Rebound rebound = bar_on_wall(bar);
    EXPECT_LE(std::abs(rebound.energy_lost - row.at("energy_lost_at_impact_over_initial").get<double>()), 1e-12);
    EXPECT_LE(std::abs(rebound.energy_lost - 1.0 / (1 + 2 * bar.n_modes)), 1e-12);
    if (bar.n_modes == 0) {
      EXPECT_LE(std::abs(rebound.restitution), 1e-12);
      continue;
    }
    EXPECT_LE(std::abs(rebound.restitution - row.at("restitution_of_centre_first_release").get<double>()), 1e-4)
        << bar.n_modes;
    EXPECT_LE(std::abs(rebound.contact_s / 2.0 - row.at("first_contact_time_over_2L_per_c").get<double>()), 1e-4);
    EXPECT_LE(rebound.residual, 1e-6);
  }
}

TEST(BarOnWall, ResidualFlexibilityLosesNothingAndComesNearerToOneFaster) {
  std::vector<double> plain, flexible;
  for (const int n : {1, 2, 4, 8, 16}) {
    BarOnWall bar;
    bar.n_modes = n;
    plain.push_back(1.0 - bar_on_wall(bar).restitution);
    bar.residual_flexibility = true;
    const Rebound rebound = bar_on_wall(bar);
    flexible.push_back(1.0 - rebound.restitution);
    EXPECT_EQ(rebound.energy_lost, 0.0);
  }
  for (std::size_t i = 0; i < plain.size(); ++i) EXPECT_LT(std::abs(flexible[i]), plain[i]);
}

/// The spring of the discarded modes swings against the kept ones, and what it holds when the wave comes back depends on the phase: that comes
/// back with every fifth mode. Levels of one phase have an order, others have none.
TEST(BarOnWall, ResidualFlexibilityIsOfOrderOneAmongModesOfOnePhase) {
  for (const int phase : {1, 2, 3}) {
    double before = 0.0, width_before = 0.0;
    for (const int fives : {1, 2, 4, 8}) {
      BarOnWall bar;
      bar.n_modes = 5 * fives + phase;
      bar.residual_flexibility = true;
      const double error = 1.0 - bar_on_wall(bar).restitution, width = 1.0 / (bar.n_modes + 0.5);
      EXPECT_GT(error, 1e-3);
      if (before > 0.0) {
        EXPECT_NEAR(std::log(before / error) / std::log(width_before / width), 1.0, 0.06) << bar.n_modes;
      }
      before = error;
      width_before = width;
    }
  }
}

TEST(KeptModes, LargestDeflectionDoesNotDependOnTheMeshAndThePrintedSumDoes) {  // erratum 73
  for (const auto& row : reference(true).at("mode_discarding").at("bar_first_mode")) {
    const int n = row.at("nodes");
    // First longitudinal mode of a unit bar, lumped masses.
    Eigen::VectorXd shape(n);
    double mass = 0.0;
    for (int i = 0; i < n; ++i) {
      shape[i] = std::cos(M_PI * i / (n - 1));
      mass += (i == 0 || i == n - 1 ? 0.5 : 1.0) / (n - 1) * shape[i] * shape[i];
    }
    shape /= std::sqrt(mass);
    const double lambda = M_PI * M_PI;
    const double printed = shape.squaredNorm() / lambda, largest = shape.cwiseAbs2().maxCoeff() / lambda;
    EXPECT_NEAR(printed / row.at("norm_sq_over_lambda").get<double>(), 1.0, 0.01) << n;
    EXPECT_NEAR(largest / row.at("max_node_sq_over_lambda").get<double>(), 1.0, 0.01) << n;
    Eigen::MatrixXd shapes = Eigen::MatrixXd::Zero(3 * n, 1);
    for (int i = 0; i < n; ++i) shapes(3 * i, 0) = shape[i];
    EXPECT_EQ(kept_modes(shapes, Eigen::VectorXd::Constant(1, lambda), 0.19).size(), 1u);
    EXPECT_EQ(kept_modes(shapes, Eigen::VectorXd::Constant(1, lambda), 0.22).size(), 0u);
  }
}

}  // namespace
}  // namespace klang::modal
