#include "core/physics/fracture/quasistatic/load_request.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "core/foundation/base/errors.hpp"
#include "tests/core/physics/fracture/quasistatic/reference_mesh.hpp"
#include "tests/core/physics/solid/box_mesh.hpp"

namespace {

using namespace klang::fracture;
using Eigen::Vector3d;
using klang::InputError;
using klang::events::Impulse;
using klang::events::ImpulseKind;

Impulse impulse(double time_s, double duration_s, const Vector3d& place, const Vector3d& push,
                ImpulseKind kind = ImpulseKind::kImpact) {
  Impulse made;
  made.time_s = time_s;
  made.duration_s = duration_s;
  made.kind = kind;
  made.point_m = place;
  made.impulse_n_s = push;
  return made;
}

TEST(ContactLoad, PeakForceAndCompressionEnergyAreHertz) {
  // tests/reference/contact.json: hertz.cases (radius, speed, mass, duration, peak, impulse); e = 1.
  struct Case {
    double speed_m_s, mass_kg, duration_s, peak_n, impulse_n_s;
  };
  for (const Case& c :
       {Case{1.0, 0.010890854532444618, 8.771272603493277e-05, 456.814867842954, 0.021781709064889236},
        Case{4.43, 0.09047786842338605, 0.00012987455840887126, 11354.365876079679, 0.8016339142312003},
        Case{0.1, 0.03288200310757317, 0.00011198037289454958, 108.03319954174573, 0.0065764006215146345}}) {
    const ContactLoad load =
        contact_load(impulse(2.0, c.duration_s, {0, 0, 0}, {0, 0, c.impulse_n_s}), {0, 0, 1}, c.speed_m_s, 1.0);
    EXPECT_LE(std::abs(force_n(load, 2.0 + 0.5 * c.duration_s)[2] / c.peak_n - 1.0), 1e-11);  // 2 s + 44 us rounds off
    EXPECT_LE(std::abs(load.compression_energy_j / (0.5 * c.mass_kg * c.speed_m_s * c.speed_m_s) - 1.0), 1e-13);
    EXPECT_EQ(force_n(load, 1.9999), Vector3d(0, 0, 0));
    EXPECT_EQ(force_n(load, 2.0 + 1.01 * c.duration_s), Vector3d(0, 0, 0));
  }
}

TEST(ContactLoad, CompressionEnergyDoesNotDependOnTheRestitution) {
  // Mass 2 kg at 3 m/s: J = (1 + e) m v, at largest compression m v^2 / 2 is gone.
  for (const double e : {0.0, 0.3, 1.0}) {
    const ContactLoad load = contact_load(impulse(0, 1e-4, {0, 0, 0}, {7, 0, (1 + e) * 6}), {0, 0, 1}, 3.0, e);
    EXPECT_LE(std::abs(load.compression_energy_j - 9.0), 1e-14);
  }
}

TEST(LoadRequests, ImpactsThatOverlapAddUpAndOthersDoNot) {
  const std::vector<ContactLoad> loads = {
      contact_load(impulse(0.0, 2e-4, {1, 0, 0}, {0, 0, 1}), {0, 0, 1}, 1.0, 0.5),
      contact_load(impulse(1.0, 1e-4, {3, 0, 0}, {0, 0, 4}), {0, 0, 1}, 1.0, 0.5),
      contact_load(impulse(0.5e-4, 2e-4, {2, 0, 0}, {0, 0, 2}), {0, 0, 1}, 1.0, 0.5)};
  const std::vector<LoadRequest> requests = load_requests(loads);
  ASSERT_EQ(requests.size(), 3u);
  const double later = std::pow(std::sin(M_PI * 0.75), 1.5), peak = hertz_peak_over_mean();
  ASSERT_EQ(requests[1].impacts.size(), 2u);
  EXPECT_LE(std::abs(requests[1].time_s - 1.5e-4), 1e-18);
  EXPECT_LE(std::abs(requests[1].impacts[0].force_n[2] / (later * peak * 1 / 2e-4) - 1.0), 1e-12);
  EXPECT_LE(std::abs(requests[1].impacts[1].force_n[2] / (peak * 2 / 2e-4) - 1.0), 1e-12);
  // Hertz: force ~ depth^1.5, energy ~ depth^2.5, so that three quarters through the first holds (F / peak)^(5/3) of its energy.
  EXPECT_LE(std::abs(requests[1].budget_j - (std::pow(later, 5.0 / 3.0) * 1 + 2) / 1.5 / 2), 1e-14);
  ASSERT_EQ(requests[2].impacts.size(), 1u);
  EXPECT_EQ(requests[2].impacts[0].place_m[0], 3.0);
}

TEST(LoadRequests, AHarmlessImpactAsksForNothingOfItsOwnBesideAHardOne) {
  const std::vector<ContactLoad> loads = {
      contact_load(impulse(0.0, 2e-4, {1, 0, 0}, {0, 0, 1}), {0, 0, 1}, 1.0, 0.5),
      contact_load(impulse(0.5e-4, 2e-4, {2, 0, 0}, {0, 0, 0.9e-2}), {0, 0, 1}, 0.9e-2, 0.5)};
  const std::vector<LoadRequest> requests = load_requests(loads);
  ASSERT_EQ(requests.size(), 1u);
  EXPECT_LE(std::abs(requests[0].time_s - 1e-4), 1e-18);
  EXPECT_EQ(requests[0].impacts.size(), 2u);  // what it pushes then counts
  EXPECT_EQ(load_requests({loads[1]}).size(), 1u);
}

TEST(LoadRequests, ImpactsAtOnceAreOneRequestAndLastingContactsAreHeld) {
  const auto lasting = [](double t, double push) {
    return contact_load(impulse(t, 1e-3, {0, 0, 0}, {0, 0, push}, ImpulseKind::kLasting), {0, 0, 1}, 0.0, 0.5);
  };
  const std::vector<LoadRequest> requests =
      load_requests({lasting(0.0, 1e-3), lasting(1e-3, 1e-3),
                     contact_load(impulse(1.2e-3, 1e-4, {1, 0, 0}, {0, 0, 1}), {0, 0, 1}, 1.0, 0.5),
                     contact_load(impulse(1.2e-3, 1e-4, {2, 0, 0}, {0, 0, 1}), {0, 0, 1}, 1.0, 0.5)});
  ASSERT_EQ(requests.size(), 2u);
  EXPECT_EQ(requests[0].impacts.size(), 0u);
  ASSERT_EQ(requests[0].lasting.size(), 1u);
  EXPECT_LE(std::abs(requests[0].lasting[0].force_n[2] - 1.0), 1e-14);
  EXPECT_EQ(requests[0].budget_j, 0.0);
  EXPECT_EQ(requests[1].impacts.size(), 2u);
  EXPECT_EQ(requests[1].lasting.size(), 1u);
}

TEST(ImpactScale, SpendsTheBudgetAndNoMore) {
  EXPECT_EQ(impact_scale(2.0, 0.0, 3.0), 1.0);
  EXPECT_LE(std::abs(impact_scale(8.0, 0.0, 2.0) - 0.5), 1e-15);
  EXPECT_EQ(impact_scale(1.0, 0.0, 0.0), 0.0);
  for (const double cross : {3.0, -0.5, 1e-9}) {
    const double s = impact_scale(4.0, cross, 1.0);
    EXPECT_LE(std::abs(s * s * 4.0 + s * cross - 1.0), 1e-14) << cross;
  }
}

TEST(AllowedLoad, StrainEnergyIsTheCompressionEnergyWhereTheForceWouldExceedIt) {
  FreeBodySolver solver(klang::test::box_mesh(0.2, 0.02, 0.01, 10, 1, 1, 2), klang::test::reference_glass());
  ContactResponses responses(solver);
  const SurfacePlaces surface(solver.mesh());
  const double approach = 1.0, e = 0.5, push = 1.5 * solver.mass_kg() * approach;
  const auto request = [&](double duration_s) {
    return load_requests(
               {contact_load(impulse(0, duration_s, {0.1, 0.01, 0}, {0, 0, push}), {0, 0, 1}, approach, e),
                contact_load(impulse(0, 1e-3, {0.02, 0.01, 0}, {0, 0, 1e-3}, ImpulseKind::kLasting), {0, 0, 1}, 0, e)})
        .front();
  };
  const double budget = 0.5 * solver.mass_kg() * approach * approach;
  const AllowedLoad hard = allowed_load(responses, surface, request(1e-5)),
                    soft = allowed_load(responses, surface, request(0.05));
  EXPECT_GT(hard.unlimited_energy_j, 10.0 * budget);  // force = impulse / step without a limit makes energy
  EXPECT_LT(hard.scale, 1.0);
  const double held = responses.strain_energy_j(surface.at_nodes({{{0.02, 0.01, 0}, {0, 0, 1}}}));
  EXPECT_LE(std::abs((hard.strain_energy_j - held) / budget - 1.0), 1e-12);
  EXPECT_LE(std::abs(responses.field(hard.forces).strain_energy_j / hard.strain_energy_j - 1.0), 1e-10);
  EXPECT_EQ(soft.scale, 1.0);
  EXPECT_LE(std::abs(soft.strain_energy_j / soft.unlimited_energy_j - 1.0), 1e-12);
  // A harder contact still has the same energy: what the step or the stiffness says does not matter above the budget.
  EXPECT_LE(std::abs((allowed_load(responses, surface, request(1e-6)).strain_energy_j - held) / budget - 1.0), 1e-11);
}

TEST(ContactLoad, BadContactsAreRefused) {
  const Impulse good = impulse(0, 1e-4, {0, 0, 0}, {0, 0, 1});
  EXPECT_THROW(contact_load(impulse(0, 0.0, {0, 0, 0}, {0, 0, 1}), {0, 0, 1}, 1, 0.5), InputError);
  EXPECT_THROW(contact_load(impulse(0, 1e-4, {0, 0, 0}, {0, 0, std::nan("")}), {0, 0, 1}, 1, 0.5), InputError);
  EXPECT_THROW(contact_load(good, {0, 0, 1}, -1, 0.5), InputError);
  EXPECT_THROW(contact_load(good, {0, 0, 1}, 1, 1.5), InputError);
  EXPECT_THROW(contact_load(good, {0, 0, 1}, 1, std::nan("")), InputError);
}

}  // namespace
