#include "core/sound/stage/yielding_contact.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>

#include "core/foundation/base/conventions.hpp"
#include "core/sound/stage/oscillator_bank.hpp"

namespace klang::stage {
namespace {

constexpr double kPlaceX = 0.47, kPlaceY = 0.46;  // of the sides: near the middle, off every low mode's nodal line

struct Plate {
  double side_m, thickness_m, youngs_modulus_pa, poissons_ratio, density_kg_m3;
  double mass_per_area() const { return density_kg_m3 * thickness_m; }
  double bending_stiffness() const {
    return youngs_modulus_pa * std::pow(thickness_m, 3) / (12.0 * (1.0 - poissons_ratio * poissons_ratio));
  }
  double wide_resistance_kg_s() const { return 8.0 * std::sqrt(bending_stiffness() * mass_per_area()); }
};

/// Bending modes of a square thin plate with pinned edges, in closed form.
void add_modes(const Plate& plate, double highest_hz, YieldingContact& contact) {
  std::vector<std::pair<double, double>> modes;
  const double limit = 2.0 * kPi * highest_hz;
  for (int m = 1;; ++m) {
    const auto omega = [&](int n) {
      return (m * m + n * n) * std::pow(kPi / plate.side_m, 2) *
             std::sqrt(plate.bending_stiffness() / plate.mass_per_area());
    };
    if (omega(1) > limit) break;
    for (int n = 1; omega(n) <= limit; ++n)
      modes.emplace_back(omega(n), 2.0 / (plate.side_m * std::sqrt(plate.mass_per_area())) *
                                       std::sin(m * kPi * kPlaceX) * std::sin(n * kPi * kPlaceY));
  }
  std::sort(modes.begin(), modes.end());
  const auto n = static_cast<Eigen::Index>(modes.size());
  contact.angular_frequency_rad_s.resize(n);
  contact.shapes.resize(n, 1);
  for (Eigen::Index i = 0; i < n; ++i) {
    contact.angular_frequency_rad_s[i] = modes[static_cast<std::size_t>(i)].first;
    contact.shapes(i, 0) = modes[static_cast<std::size_t>(i)].second;
  }
  contact.residual_m_n = residual_of_higher_modes_m_n(contact.angular_frequency_rad_s, contact.shapes);
}

/// A ball on something heavy that is held.
YieldingContact ball(double mass_kg, double approach_m_s, double stiffness) {
  YieldingContact contact;
  contact.mobility_per_kg = Eigen::MatrixXd::Constant(1, 1, 1.0 / mass_kg);
  contact.approach_m_s = Eigen::VectorXd::Constant(1, approach_m_s);
  contact.stiffness_n_m32 = Eigen::VectorXd::Constant(1, stiffness);
  contact.residual_m_n = Eigen::VectorXd::Zero(1);
  contact.shapes.resize(0, 1);
  return contact;
}

double duration_s(const ContactForces& forces) {
  const auto touched = (forces.force_n.col(0).array() > 0.0).count();
  return static_cast<double>(touched) * forces.step_s;
}

// tests/reference: contact.json, hertz, steel on glass.
TEST(YieldingContact, WithoutModesIsHertz) {
  const double mass_kg = 0.0041102503884466466, modulus_pa = 49842072980.04951, radius_m = 0.005;
  const YieldingContact contact = ball(mass_kg, 1.0, 4.0 / 3.0 * modulus_pa * std::sqrt(radius_m));
  const ContactForces forces = yielding_forces(contact, 1e-3);
  EXPECT_LE(std::abs(forces.force_n.maxCoeff() / 312.8058809304773 - 1.0), 1e-3);
  EXPECT_LE(std::abs(duration_s(forces) / 4.83430727616528e-05 - 1.0), 0.015);  // a step of 1 % at either end
  EXPECT_LE(std::abs(forces.impulse_n_s[0] / (2.0 * mass_kg) - 1.0), 1e-3);
  EXPECT_LE(std::abs(hertz_stiffness_n_m32(mass_kg, 1.0, 4.83430727616528e-05) / contact.stiffness_n_m32[0] - 1.0),
            1e-9);
}

// contact.json, zener_plate: restitution, duration over T0 and peak over m v / T0 for lambda = m / (8 sqrt(D rho h) T0). The plate is so wide
// that no wave is back before the ball has left.
TEST(YieldingContact, ABallOnAWidePlateIsZeners) {
  const Plate plate{1.6, 0.006, 72e9, 0.2, 2500.0};
  struct Row {
    double lambda, restitution, duration, peak;
  };
  const struct { double highest_hz, tolerance; } bands[] = {{20000.0, 0.02}, {100000.0, 0.004}};
  for (const auto& [highest_hz, tolerance] : bands)
    for (const Row& row : {Row{0.25, 0.6576546757505927, 3.3875515713146367, 0.906779850085098},
                           Row{0.5, 0.43689530094150725, 3.6244414510265672, 0.7502314355381937},
                           Row{1.0, 0.18412287416502068, 4.387612018013551, 0.5561608668111468}}) {
      const double unit_s = 3e-5, speed_m_s = 1.0, mass_kg = row.lambda * plate.wide_resistance_kg_s() * unit_s;
      YieldingContact contact = ball(mass_kg, speed_m_s, mass_kg / (std::sqrt(speed_m_s) * std::pow(unit_s, 2.5)));
      add_modes(plate, highest_hz, contact);
      const ContactForces forces = yielding_forces(contact, 2.5e-4);
      const double restitution = forces.impulse_n_s[0] / (mass_kg * speed_m_s) - 1.0;
      EXPECT_LE(std::abs(restitution - row.restitution), tolerance) << row.lambda;
      EXPECT_LE(std::abs(duration_s(forces) / unit_s / row.duration - 1.0), 0.03) << row.lambda;
      EXPECT_LE(std::abs(forces.force_n.maxCoeff() * unit_s / (mass_kg * speed_m_s) / row.peak - 1.0), tolerance)
          << row.lambda;
      // What the ball has lost is in the plate.
      const double lost_j = 0.5 * mass_kg * speed_m_s * speed_m_s * (1.0 - restitution * restitution);
      EXPECT_LE(std::abs(vibration_j(contact, forces) / lost_j - 1.0), 2e-3) << row.lambda;
    }
}

TEST(YieldingContact, ABallOnAThickPlateIsHertzs) {
  const Plate plate{1.6, 0.2, 72e9, 0.2, 2500.0};
  const double mass_kg = 0.01, unit_s = 3e-5;
  YieldingContact contact = ball(mass_kg, 1.0, mass_kg / std::pow(unit_s, 2.5));
  add_modes(plate, 20000.0, contact);
  const ContactForces forces = yielding_forces(contact, 1e-3);
  EXPECT_LE(std::abs(forces.force_n.maxCoeff() * unit_s / mass_kg / 1.143262628857505 - 1.0), 0.01);
  EXPECT_LE(std::abs(duration_s(forces) / unit_s / 3.218065459721568 - 1.0), 0.015);
}

TEST(YieldingContact, FourPlacesOfABlockThatLandsFlatShareItsMass) {
  YieldingContact four = ball(1.0, 1.0, 1e9);
  four.mobility_per_kg = Eigen::MatrixXd::Constant(4, 4, 1.0);  // all push the centre
  four.approach_m_s = Eigen::VectorXd::Ones(4);
  four.stiffness_n_m32 = Eigen::VectorXd::Constant(4, 1e9);
  four.residual_m_n = Eigen::VectorXd::Zero(4);
  four.shapes.resize(0, 4);
  const ContactForces forces = yielding_forces(four, 1e-2), quarter = yielding_forces(ball(0.25, 1.0, 1e9), 1e-2);
  for (int i = 0; i < 4; ++i) EXPECT_LE(std::abs(forces.impulse_n_s[i] / quarter.impulse_n_s[0] - 1.0), 1e-3);
  EXPECT_LE(std::abs(forces.force_n.maxCoeff() / quarter.force_n.maxCoeff() - 1.0), 1e-3);
}

// A history as oscillators take it: the response of an undamped mode to a half sine, in closed form.
TEST(YieldingContact, OscillatorsFollowAHistory) {
  const double rate_hz = 48000.0, length_s = 7.3e-4, begin_s = 0.00313;
  ForceHistory history{begin_s, length_s / 4000.0, {}};
  for (int i = 0; i <= 4000; ++i) history.force_per_s.push_back(kPi / (2.0 * length_s) * std::sin(kPi * i / 4000.0));
  for (const double hz : {200.0, 3000.0, 19000.0}) {
    const double omega = 2.0 * kPi * hz, p = kPi / length_s;
    ModalImpulse impulse{0.0, Eigen::VectorXd::Ones(1), 0.0, sampled(history, rate_hz)};
    const Eigen::VectorXd heard = oscillation({{omega, 0.0, 1.0}}, {impulse}, rate_hz, 480);
    double worst = 0.0;
    for (int n = 0; n < 480; ++n) {
      const double t = n / rate_hz - begin_s;
      double z = 0.0;  // q'' + omega^2 q = (p / 2) sin p t
      const auto during = [&](double s) {
        return 0.5 * p / (omega * omega - p * p) * (std::sin(p * s) - p / omega * std::sin(omega * s));
      };
      if (t > 0.0) z = during(t) + (t > length_s ? during(t - length_s) : 0.0);
      worst = std::max(worst, std::abs(z - heard[n]));
    }
    EXPECT_LE(worst * omega, 1e-6) << hz;
  }
}

}  // namespace
}  // namespace klang::stage
