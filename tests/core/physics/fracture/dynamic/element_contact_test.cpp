// Contact of a solid with itself: volumes and gradients of clipped tetrahedra, conservation, two pieces, a sheet that folds.
#include "core/physics/fracture/dynamic/element_contact.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <memory>
#include <random>

#include "core/physics/fracture/dynamic/explicit_solid.hpp"
#include "tests/core/physics/fracture/dynamic/lattice.hpp"

namespace klang::fracture {
namespace {

using Eigen::Vector3d;

std::size_t at(int i) { return static_cast<std::size_t>(i); }

TetCorners unit_tet(const Vector3d& shift) {
  return {shift, shift + Vector3d::UnitX(), shift + Vector3d::UnitY(), shift + Vector3d::UnitZ()};
}

TetCorners element(const mesh::TetMesh& mesh, int e, const Vector3d& shift) {
  TetCorners corners;
  for (int c = 0; c < 4; ++c) corners[at(c)] = mesh.nodes_m.row(mesh.elements(e, c)).transpose() + shift;
  return corners;
}

TEST(TetOverlap, ShiftedSimplicesHaveTheClosedFormVolumeAndCentre) {
  for (const double s : {0.0, 1e-3, 0.3, 0.9}) {
    const auto overlap = tet_overlap(unit_tet(Vector3d::Zero()), unit_tet({s, 0.0, 0.0}));
    ASSERT_TRUE(overlap.has_value());
    const double side = 1.0 - s;
    EXPECT_LE(std::abs(overlap->volume_m3 - side * side * side / 6.0), 1e-15);
    EXPECT_LE((overlap->centre_m - Vector3d(s + side / 4.0, side / 4.0, side / 4.0)).norm(), 1e-14);
  }
  EXPECT_FALSE(tet_overlap(unit_tet(Vector3d::Zero()), unit_tet({1.001, 0.0, 0.0})).has_value());
}

TEST(TetOverlap, PiecesOfTwoBoxesSumToWhatTheBoxesHaveInCommon) {
  const mesh::TetMesh a = test::lattice({3, 2, 2}, {0.3, 0.2, 0.2}, 0.2, 3),
                      b = test::lattice({2, 2, 3}, {0.2, 0.25, 0.3}, 0.2, 5);
  // Some faces in one plane (y = 0 of both), as pieces of one body have them.
  for (const Vector3d& shift : {Vector3d(0.15, 0.0, 0.05), Vector3d(-0.1, -0.07, -0.2), Vector3d(0.0, 0.0, 0.0)}) {
    double sum = 0.0, expected = 1.0;
    for (int i = 0; i < a.n_elements(); ++i)
      for (int j = 0; j < b.n_elements(); ++j)
        if (const auto overlap = tet_overlap(element(a, i, Vector3d::Zero()), element(b, j, shift)))
          sum += overlap->volume_m3;
    const Vector3d size_a(0.3, 0.2, 0.2), size_b(0.2, 0.25, 0.3);
    for (int axis = 0; axis < 3; ++axis)
      expected *= std::min(size_a[axis], shift[axis] + size_b[axis]) - std::max(0.0, shift[axis]);
    EXPECT_LE(std::abs(sum / expected - 1.0), 1e-12) << shift.transpose();
  }
}

TEST(TetOverlap, GradientIsThatOfTheVolumeAndItsSumAndMomentVanish) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> number(-1.0, 1.0);
  int n_seen = 0;
  double worst = 0.0;
  for (int trial = 0; trial < 400; ++trial) {
    std::array<Vector3d, 8> x;
    for (Vector3d& p : x) p = Vector3d(number(random), number(random), number(random));
    const auto split = [&](const std::array<Vector3d, 8>& p) {
      std::pair<TetCorners, TetCorners> both;
      for (std::size_t k = 0; k < 4; ++k) both.first[k] = p[k], both.second[k] = p[4 + k];
      return both;
    };
    for (std::size_t first : {std::size_t{0}, std::size_t{4}})
      if ((x[first + 1] - x[first]).cross(x[first + 2] - x[first]).dot(x[first + 3] - x[first]) < 0.0)
        std::swap(x[first + 2], x[first + 3]);
    const auto [a, b] = split(x);
    const auto overlap = tet_overlap(a, b);
    if (!overlap) {
      EXPECT_GT(gap_along_m(a, b, widest_axis(a, b, false)), 0.0);
      continue;
    }
    EXPECT_LE(gap_along_m(a, b, widest_axis(a, b, false)), 0.0);
    if (overlap->volume_m3 < 1e-3) continue;
    ++n_seen;
    Vector3d sum = Vector3d::Zero(), moment = Vector3d::Zero();
    for (std::size_t k = 0; k < 8; ++k) {
      sum += overlap->gradient_m2[k];
      moment += x[k].cross(overlap->gradient_m2[k]);
    }
    EXPECT_LE(sum.norm() + moment.norm(), 1e-13);
    for (std::size_t k = 0; k < 8; ++k)
      for (int axis = 0; axis < 3; ++axis) {
        constexpr double kStep = 1e-6;
        std::array<double, 2> volume{};
        for (const int way : {0, 1}) {
          auto moved = x;
          moved[k][axis] += way == 0 ? -kStep : kStep;
          const auto [c, d] = split(moved);
          volume[at(way)] = tet_overlap(c, d)->volume_m3;
        }
        const double slope = (volume[1] - volume[0]) / (2.0 * kStep);
        worst = std::max(worst, std::abs(slope - overlap->gradient_m2[k][axis]));
      }
  }
  EXPECT_GE(n_seen, 30);
  EXPECT_LE(worst, 1e-8);
}

SolidOptions soft(bool touches, double friction) {
  SolidOptions options;
  options.material.lame_lambda_pa = 6e5;
  options.material.lame_mu_pa = 4e5;
  options.material.density_kg_m3 = 1000.0;
  options.self_contact = touches;
  options.self_friction = friction;
  return options;
}

/// Two boxes in one mesh, the second turned and beside the first's middle, flying at each other.
CrackMesh two_pieces(double speed_m_s) {
  const mesh::TetMesh a = test::lattice({3, 3, 3}, {0.1, 0.1, 0.1}, 0.2, 1),
                      b = test::lattice({3, 2, 2}, {0.1, 0.06, 0.06}, 0.2, 2);
  mesh::TetMesh both;
  both.nodes_m.resize(a.nodes_m.rows() + b.nodes_m.rows(), 3);
  both.nodes_m.topRows(a.nodes_m.rows()) = a.nodes_m;
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(0.4, Vector3d(0.2, 1.0, 0.5).normalized()).toRotationMatrix();
  both.nodes_m.bottomRows(b.nodes_m.rows()) =
      ((b.nodes_m * turn.transpose()).rowwise() + Eigen::RowVector3d(0.13, 0.04, 0.03));
  both.elements.resize(a.elements.rows() + b.elements.rows(), 4);
  both.elements << a.elements, (b.elements.array() + static_cast<int>(a.nodes_m.rows())).matrix();
  CrackMesh mesh(both, 1000.0);
  for (std::size_t i = 0; i < mesh.rest_m.size(); ++i)
    mesh.velocity_m_s[i] = Vector3d(1.0, 2.0, 0.5) -
                           (static_cast<Eigen::Index>(i) < a.nodes_m.rows() ? 0.0 : speed_m_s) * Vector3d::UnitX();
  return mesh;
}

struct Flight {
  Vector3d momentum_error, spin_error, second_before, second_after;
  double energy_error = 0.0, rubbed_j = 0.0, largest_contact_j = 0.0, kinetic_j = 0.0;
};
Flight fly(double share, bool touches, double friction) {
  ExplicitSolid solid(two_pieces(2.0), soft(touches, friction));
  const std::size_t n_first = 64;
  const auto momentum = [&](std::size_t from) {
    Vector3d sum = Vector3d::Zero();
    for (std::size_t i = from; i < solid.mesh().rest_m.size(); ++i)
      sum += solid.mesh().mass_kg_of[i] * solid.mesh().velocity_m_s[i];
    return sum;
  };
  const auto spin = [&] {
    Vector3d sum = Vector3d::Zero();
    for (std::size_t i = 0; i < solid.mesh().rest_m.size(); ++i)
      sum += solid.mesh().mass_kg_of[i] * solid.mesh().place_m[i].cross(solid.mesh().velocity_m_s[i]);
    return sum;
  };
  Flight flight;
  const Vector3d momentum_0 = momentum(0), spin_0 = spin();
  flight.second_before = momentum(n_first);
  const double start = solid.energies().sum_j();
  flight.kinetic_j = 0.5 * 0.36 * 4.0 / 1.36;  // of both about their centre
  const double dt = share * solid.step_limit_s();
  while (solid.time_s() < 0.15) {
    solid.step(dt);
    const SolidEnergies e = solid.energies();
    flight.energy_error = std::max(flight.energy_error, std::abs(e.sum_j() - start));
    flight.largest_contact_j = std::max(flight.largest_contact_j, e.contact_j);
  }
  flight.momentum_error = momentum(0) - momentum_0;
  flight.spin_error = spin() - spin_0;
  flight.second_after = momentum(n_first);
  flight.rubbed_j = solid.energies().friction_j;
  EXPECT_TRUE(!touches || friction > 0.0 || !solid.self_contact()->last().any()) << "they have not parted yet";
  return flight;
}

TEST(ElementContact, TwoPiecesPushEachOtherAwayAndKeepEnergyMomentumAndMoment) {
  std::vector<double> errors;
  for (const double share : {0.8, 0.4, 0.2}) {
    const Flight flight = fly(share, true, 0.0);
    EXPECT_LE(flight.momentum_error.norm(), 1e-12 * 2.0);
    EXPECT_LE(flight.spin_error.norm(), 1e-12 * 0.2);
    EXPECT_GT(flight.largest_contact_j, 1e-3 * flight.kinetic_j);
    EXPECT_GT(flight.second_after.x() - flight.second_before.x(), 0.5);  // 0.36 kg at -1 m/s of -1.47 beside the centre
    errors.push_back(flight.energy_error / flight.kinetic_j);
  }
  EXPECT_LE(errors[0], 1e-3);
  EXPECT_GT(std::log2(errors[0] / errors[2]) / 2.0, 1.5) << errors[0] << " " << errors[1] << " " << errors[2];
  const Flight through = fly(0.8, false, 0.0);
  EXPECT_LE((through.second_after - through.second_before).norm(), 1e-12);
}

TEST(ElementContact, FrictionTakesEnergyAndKeepsMomentumAndMoment) {
  const Flight flight = fly(0.8, true, 0.6);
  EXPECT_LE(flight.momentum_error.norm(), 1e-12 * 2.0);
  EXPECT_LE(flight.spin_error.norm(), 1e-12 * 0.2);
  EXPECT_GT(flight.rubbed_j, 1e-3 * flight.kinetic_j);
  EXPECT_LE(flight.energy_error, 2e-3 * flight.kinetic_j);
}

// Two blocks on each other, face to face: each node takes part in many contacts, which together may stop what slides and not throw it back.
TEST(ElementContact, StickingFrictionOfManyContactsNeverGivesEnergy) {
  CrackMesh mesh = two_pieces(0.0);
  const Eigen::Index n_first = 64;
  for (std::size_t i = 0; i < mesh.rest_m.size(); ++i) {
    const bool second = static_cast<Eigen::Index>(i) >= n_first;
    // The second one upright on the first, 2 mm within it.
    if (second) {
      const mesh::TetMesh b = test::lattice({3, 2, 2}, {0.1, 0.06, 0.06}, 0.2, 2);
      mesh.place_m[i] = b.nodes_m.row(static_cast<Eigen::Index>(i) - n_first).transpose() + Vector3d(0.0, 0.02, 0.098);
    }
    mesh.velocity_m_s[i] = (second ? 1.0 : 0.0) * Vector3d(0.01, 0.004, 0.0);
  }
  const auto kinetic_j = [&] {
    double sum = 0.0;
    for (std::size_t i = 0; i < mesh.rest_m.size(); ++i)
      sum += 0.5 * mesh.mass_kg_of[i] * mesh.velocity_m_s[i].squaredNorm();
    return sum;
  };
  constexpr double kStep = 1e-4;
  ElementContact contact(ElementContact::Pairs::kOwn, 0.25 / (kStep * kStep), [](int, int) { return 1e6; });
  const double start = kinetic_j();
  double before = start;
  for (int n = 0; n < 20; ++n) {
    const ElementContact::Forces& forces = contact.forces({&mesh}, kStep);
    ASSERT_GT(forces.touches.size(), 30u);
    for (std::size_t i = 0; i < mesh.rest_m.size(); ++i)
      mesh.velocity_m_s[i] += kStep / mesh.mass_kg_of[i] * forces.of[0].friction_n[i];
    EXPECT_LE(kinetic_j(), before * (1.0 + 1e-12));
    before = kinetic_j();
  }
  EXPECT_LT(before, 0.9 * start);
}

/// Half a turn about the y-z diagonal.
Vector3d turned(const Vector3d& x) { return {-x.x(), x.z(), x.y()}; }

/// Two solids, the second the first one turned, that fly at each other; places of both at the end.
std::array<std::vector<Vector3d>, 2> meet_turned(double share, double friction, double& energy_error) {
  std::vector<std::unique_ptr<ExplicitSolid>> solids;
  for (const bool second : {false, true}) {
    mesh::TetMesh mesh = test::lattice({3, 3, 3}, {0.1, 0.1, 0.1}, 0.2, 1);
    // Beside each other, so that no edge of one lies on one of the other: what they have in common has a bend there.
    mesh.nodes_m.rowwise() += Eigen::RowVector3d(-0.1005, 0.007, -0.004);
    if (second)
      for (Eigen::Index i = 0; i < mesh.nodes_m.rows(); ++i)
        mesh.nodes_m.row(i) = turned(mesh.nodes_m.row(i).transpose()).transpose();
    CrackMesh cracks(mesh, 1000.0);
    for (Vector3d& velocity : cracks.velocity_m_s)
      velocity = second ? turned({1.0, 0.4, -0.1}) : Vector3d(1.0, 0.4, -0.1);
    solids.push_back(std::make_unique<ExplicitSolid>(std::move(cracks), soft(false, 0.0)));
  }
  const double limit = solids[0]->step_limit_s(), dt = share * limit;
  ElementContact contact(ElementContact::Pairs::kOfOthers, kElementContactRate / (limit * limit),
                         [friction](int, int) { return friction; });
  const std::vector<const CrackMesh*> meshes = {&solids[0]->mesh(), &solids[1]->mesh()};
  contact.forces(meshes, dt);
  for (std::size_t i = 0; i < 2; ++i)
    solids[i]->set_mutual_forces([&contact, i]() -> const NodeForces& { return contact.last().of[i]; });
  const auto sum_j = [&] {
    return solids[0]->energies().sum_j() + solids[1]->energies().sum_j() + contact.last().energy_j;
  };
  const double start = sum_j(), kinetic = start;
  double most_j = 0.0;
  while (solids[0]->time_s() < 0.03) {
    for (auto& solid : solids) solid->go(dt);
    contact.forces(meshes, dt);
    for (auto& solid : solids) solid->arrive();
    most_j = std::max(most_j, contact.last().energy_j);
    energy_error = std::max(energy_error, std::abs(sum_j() - start) / kinetic);
  }
  EXPECT_GT(most_j, 1e-3 * kinetic);
  EXPECT_FALSE(contact.last().any()) << "they have not parted yet";
  const double rubbed = solids[0]->energies().friction_j + solids[1]->energies().friction_j;
  EXPECT_TRUE(friction > 0.0 ? rubbed > 1e-3 * kinetic : rubbed == 0.0) << rubbed;
  std::array<std::vector<Vector3d>, 2> places;
  for (std::size_t i = 0; i < 2; ++i) {
    Vector3d momentum = Vector3d::Zero();
    for (std::size_t k = 0; k < solids[i]->mesh().rest_m.size(); ++k)
      momentum += solids[i]->mesh().mass_kg_of[k] * solids[i]->mesh().velocity_m_s[k];
    EXPECT_GT(momentum.x() * (i == 0 ? -1.0 : 1.0), 0.5) << "1 kg of 1 m/s goes back";
    places[i] = solids[i]->mesh().place_m;
  }
  return places;
}

TEST(ElementContact, TwoThatAreOneAnotherTurnedMoveSoAndKeepTheirEnergyToOrderTwo) {
  for (const double friction : {0.0, 0.5}) {
    std::vector<double> errors;
    for (const double share : {0.8, 0.4, 0.2}) {
      errors.push_back(0.0);
      const auto places = meet_turned(share, friction, errors.back());
      double worst = 0.0;
      for (std::size_t i = 0; i < places[0].size(); ++i)
        worst = std::max(worst, (places[0][i] - turned(places[1][i])).norm());
      EXPECT_LE(worst, 1e-12) << friction;
    }
    EXPECT_LE(errors[0], 2e-3);
    EXPECT_GT(std::log2(errors[0] / errors[2]) / 2.0, 1.5) << errors[0] << " " << errors[1] << " " << errors[2];
  }
}

/// A strip bent to a hairpin, its rest shape, whose arms are thrown at each other.
double common_volume_of_arms(bool touches, double& energy_error, double& contact_j) {
  constexpr double kThick = 0.004, kGap = 0.012, kArm = 0.1;
  mesh::TetMesh strip = test::lattice({44, 4, 1}, {1.0, 0.03, kThick});
  const double inner = 0.5 * kGap, bend = M_PI * (inner + 0.5 * kThick), length = 2.0 * kArm + bend;
  for (Eigen::Index i = 0; i < strip.nodes_m.rows(); ++i) {
    const double s = length * strip.nodes_m(i, 0), r = inner + strip.nodes_m(i, 2);
    if (s < kArm) {
      strip.nodes_m(i, 0) = kArm - s, strip.nodes_m(i, 2) = -r;
    } else if (s > kArm + bend) {
      strip.nodes_m(i, 0) = s - kArm - bend, strip.nodes_m(i, 2) = r;
    } else {
      const double angle = (s - kArm) / bend * M_PI;
      strip.nodes_m(i, 0) = -r * std::sin(angle), strip.nodes_m(i, 2) = -r * std::cos(angle);
    }
  }
  CrackMesh mesh(strip, 1000.0);
  for (std::size_t i = 0; i < mesh.rest_m.size(); ++i)
    if (mesh.rest_m[i].x() > 0.0)
      mesh.velocity_m_s[i].z() = (mesh.rest_m[i].z() > 0.0 ? -15.0 : 15.0) * mesh.rest_m[i].x();
  ExplicitSolid solid(std::move(mesh), soft(touches, 0.0));
  const double start = solid.energies().sum_j();
  double worst = 0.0;
  energy_error = contact_j = 0.0;
  while (solid.time_s() < 0.02) {
    for (int k = 0; k < 25; ++k) solid.step(solid.step_limit_s());
    double sum = 0.0;
    const CrackMesh& now = solid.mesh();
    const auto corners = [&](int e) {
      TetCorners c;
      for (std::size_t k = 0; k < 4; ++k) c[k] = now.place_m[at(now.nodes_of(e)[k])];
      return c;
    };
    for (int a = 0; a < now.n_elements(); ++a)
      for (int b = 0; b < a; ++b)
        if (now.rest_m[at(now.nodes_of(a)[0])].z() > 0.9 * inner &&
            now.rest_m[at(now.nodes_of(b)[0])].z() < -0.9 * inner &&
            (now.place_m[at(now.nodes_of(a)[0])] - now.place_m[at(now.nodes_of(b)[0])]).norm() < 0.03)
          if (const auto overlap = tet_overlap(corners(a), corners(b))) sum += overlap->volume_m3;
    worst = std::max(worst, sum);
    energy_error = std::max(energy_error, std::abs(solid.energies().sum_j() - start) / start);
    contact_j = std::max(contact_j, solid.energies().contact_j);
  }
  return worst;
}

TEST(ElementContact, ASheetThatFoldsOntoItselfStopsAtItself) {
  double energy_error = 0.0, contact_j = 0.0;
  const double arm_m3 = 0.1 * 0.03 * 0.004, through = common_volume_of_arms(false, energy_error, contact_j);
  EXPECT_GT(through, 0.2 * arm_m3);
  EXPECT_LE(common_volume_of_arms(true, energy_error, contact_j), 0.06 * arm_m3);
  EXPECT_GT(contact_j, 0.0);
  EXPECT_LE(energy_error, 1e-3);
}

}  // namespace
}  // namespace klang::fracture
