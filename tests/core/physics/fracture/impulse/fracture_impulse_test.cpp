// Fracture impulses against closed forms and against tests/reference/impulses.json: six pieces, bar, beam.
#include "core/physics/fracture/impulse/fracture_impulse.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "core/foundation/base/errors.hpp"
#include "tests/places.hpp"

namespace klang::fracture {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using nlohmann::json;

json reference() {
  std::ifstream file(klang::test::source_dir() + "/tests/reference/impulses.json");
  return json::parse(file);
}
Vector3d vector(const json& list) { return {list[0].get<double>(), list[1].get<double>(), list[2].get<double>()}; }

PieceMass cuboid(double x0, double x1, double width, double height, double density) {
  const double l = x1 - x0, m = density * l * width * height;
  const Vector3d sq(l * l, width * width, height * height);
  return {m,
          {0.5 * (x0 + x1), 0.0, 0.0},
          m / 12.0 * Vector3d(sq[1] + sq[2], sq[0] + sq[2], sq[0] + sq[1]).asDiagonal().toDenseMatrix()};
}

/// Sums over a motion of pieces: momentum, angular momentum about the origin, kinetic energy.
struct Sums {
  Vector3d momentum = Vector3d::Zero(), spin = Vector3d::Zero();
  double kinetic = 0.0;
};
Sums sums_of(const std::vector<PieceMass>& pieces, const std::vector<Vector3d>& v, const std::vector<Vector3d>& w) {
  Sums s;
  for (std::size_t d = 0; d < pieces.size(); ++d) {
    s.momentum += pieces[d].mass_kg * v[d];
    s.spin += pieces[d].centre_m.cross(pieces[d].mass_kg * v[d]) + pieces[d].inertia_kg_m2 * w[d];
    s.kinetic += 0.5 * pieces[d].mass_kg * v[d].squaredNorm() + 0.5 * w[d].dot(pieces[d].inertia_kg_m2 * w[d]);
  }
  return s;
}

struct SixPieces {
  std::vector<PieceMass> pieces;
  std::vector<CrackFace> faces;
  ParentMotion motion;
  double energy_j = 0.0;
  json expected;
};
SixPieces six_pieces() {
  SixPieces s;
  s.expected = reference().at("six_pieces");
  const json& e = s.expected;
  auto cuts = e.at("cuts_x").get<std::vector<double>>();
  cuts.insert(cuts.begin(), 0.0);
  cuts.push_back(e.at("dims")[0]);
  double mass = 0.0;
  for (std::size_t i = 0; i + 1 < cuts.size(); ++i) {
    s.pieces.push_back(cuboid(cuts[i], cuts[i + 1], e.at("dims")[1], e.at("dims")[2], e.at("rho")));
    s.motion.centre_m += s.pieces.back().mass_kg * s.pieces.back().centre_m;
    mass += s.pieces.back().mass_kg;
  }
  s.motion.centre_m /= mass;
  s.motion.velocity_m_s = vector(e.at("V"));
  s.motion.angular_velocity_rad_s = vector(e.at("Omega"));
  s.energy_j = e.at("dE");
  for (const json& t : e.at("crack_triangles")) {
    Matrix3d stress;
    for (int r = 0; r < 3; ++r) stress.row(r) = vector(t.at("stress")[r]).transpose();
    s.faces.push_back({t.at("left"), t.at("right"), t.at("area"), vector(t.at("normal_out_of_left")),
                       vector(t.at("point")), stress, stress});
  }
  return s;
}
ImpulseForm unclipped() {
  ImpulseForm form;
  form.closed_cracks_hold = false;
  return form;
}

TEST(FractureImpulse, SixPiecesGoApartAsTheReference) {
  const SixPieces s = six_pieces();
  const FractureImpulses push = fracture_impulses(s.faces, s.pieces, s.energy_j, unclipped(), s.motion);
  ASSERT_EQ(push.status, PushStatus::kPushed);
  EXPECT_LE(std::abs(push.tau_s / s.expected.at("tau").get<double>() - 1.0), 1e-12);
  for (std::size_t d = 0; d < 6; ++d) {
    const Vector3d arm = s.pieces[d].centre_m - s.motion.centre_m;
    const Vector3d v = s.motion.velocity_m_s + s.motion.angular_velocity_rad_s.cross(arm) + push.velocity_m_s[d];
    const Vector3d w = s.motion.angular_velocity_rad_s + push.angular_velocity_rad_s[d];
    EXPECT_LE((push.forces[d].force_n - vector(s.expected.at("S")[d])).norm(), 1e-12 * 200.0);
    EXPECT_LE((push.forces[d].moment_n_m - vector(s.expected.at("J")[d])).norm(), 1e-12 * 4.0);
    EXPECT_LE((v - vector(s.expected.at("v_plus")[d])).norm(), 1e-12 * v.norm());
    EXPECT_LE((w - vector(s.expected.at("omega_plus")[d])).norm(), 1e-12 * w.norm());
  }
}

TEST(FractureImpulse, KeepsMomentumAndAngularMomentumAndGainsTheEnergy) {
  const SixPieces s = six_pieces();
  std::vector<Vector3d> v0, w0, v1, w1;
  for (const ImpulseForm& form : {unclipped(), ImpulseForm{}}) {
    const FractureImpulses push = fracture_impulses(s.faces, s.pieces, s.energy_j, form, s.motion);
    v0.clear(), w0.clear(), v1.clear(), w1.clear();
    for (std::size_t d = 0; d < 6; ++d) {
      v0.push_back(s.motion.velocity_m_s +
                   s.motion.angular_velocity_rad_s.cross(s.pieces[d].centre_m - s.motion.centre_m));
      w0.push_back(s.motion.angular_velocity_rad_s);
      v1.push_back(v0[d] + push.velocity_m_s[d]);
      w1.push_back(w0[d] + push.angular_velocity_rad_s[d]);
    }
    const Sums before = sums_of(s.pieces, v0, w0), after = sums_of(s.pieces, v1, w1);
    EXPECT_LE((after.momentum - before.momentum).norm(), 1e-13 * before.momentum.norm());
    EXPECT_LE((after.spin - before.spin).norm(), 1e-13);
    EXPECT_LE(std::abs(after.kinetic - before.kinetic - s.energy_j), 1e-12);
    EXPECT_LE(std::abs(push.kinetic_j - s.energy_j), 1e-12);
  }
}

// tests/reference/impulses.json, six_pieces, with_r_from_parent_centre_as_printed.
TEST(FractureImpulse, ArmsFromTheParentsCentreBreakAngularMomentum) {
  const SixPieces s = six_pieces();
  ImpulseForm form = unclipped();
  form.arm = ArmFrom::kParent;
  const FractureImpulses push = fracture_impulses(s.faces, s.pieces, s.energy_j, form, s.motion);
  const json& printed = s.expected.at("with_r_from_parent_centre_as_printed");
  EXPECT_LE(std::abs(push.tau_s / printed.at("tau").get<double>() - 1.0), 1e-9);
  const Sums change = sums_of(s.pieces, push.velocity_m_s, push.angular_velocity_rad_s);
  EXPECT_LE(std::abs(change.spin.norm() / printed.at("angular_momentum_change").get<double>() - 1.0), 1e-9);
}

TEST(FractureImpulse, ThePrintedSignPullsPiecesUnderTensionTogether) {
  const std::vector<PieceMass> halves{cuboid(-0.1, 0.0, 0.03, 0.006, 2600.0), cuboid(0.0, 0.1, 0.03, 0.006, 2600.0)};
  const Matrix3d tension = Vector3d(5e6, 0.0, 0.0).asDiagonal();
  const std::vector<CrackFace> faces{{0, 1, 1.8e-4, Vector3d::UnitX(), Vector3d::Zero(), tension, tension}};
  const FractureImpulses mended = fracture_impulses(faces, halves, 0.01);
  EXPECT_LT(mended.velocity_m_s[0].x(), 0.0);
  EXPECT_GT(mended.velocity_m_s[1].x(), 0.0);
  EXPECT_GT(fracture_impulses(faces, halves, 0.01, paper_form()).velocity_m_s[0].x(), 0.0);
}

// tests/reference/impulses.json, bar_end_push_cut_middle: force F/2 at the cut, compressive.
TEST(FractureImpulse, BarPushedAtItsEndFliesApartAsTheClosedForm) {
  const json bar = reference().at("bar_end_push_cut_middle");
  const double length = bar.at("L"), width = bar.at("b"), height = bar.at("h"), force = bar.at("F"),
               strain = bar.at("E_S");
  const std::vector<PieceMass> halves{cuboid(0.0, 0.5 * length, width, height, bar.at("rho")),
                                      cuboid(0.5 * length, length, width, height, bar.at("rho"))};
  const Matrix3d stress = Vector3d(-0.5 * force / (width * height), 0.0, 0.0).asDiagonal();
  const std::vector<CrackFace> faces{
      {0, 1, width * height, Vector3d::UnitX(), {0.5 * length, 0.0, 0.0}, stress, stress}};
  for (const json& row : bar.at("cases")) {
    const double energy_j = (1.0 - row.at("share_used").get<double>()) * strain;
    const FractureImpulses push = fracture_impulses(faces, halves, energy_j, unclipped());
    EXPECT_LE(std::abs(push.tau_s / row.at("tau_s").get<double>() - 1.0), 1e-12);
    EXPECT_LE(std::abs(push.velocity_m_s[0].norm() / row.at("speed_of_halves").get<double>() - 1.0), 1e-12);
    // A cut under compression stays shut: nobody is pushed.
    const FractureImpulses shut = fracture_impulses(faces, halves, energy_j);
    EXPECT_EQ(shut.status, PushStatus::kNothingTensile);
    EXPECT_EQ(shut.velocity_m_s[0].norm() + shut.velocity_m_s[1].norm() + shut.kinetic_j, 0.0);
  }
}

// tests/reference/impulses.json, beam_struck_middle_cut_middle: the bending stress M z / I over the height of the cut, by strips
// whose moments are summed exactly.
TEST(FractureImpulse, BeamStruckInTheMiddleTurnsItsHalvesAsTheClosedForm) {
  const json beam = reference().at("beam_struck_middle_cut_middle");
  const json bar = reference().at("bar_end_push_cut_middle");
  const double length = bar.at("L"), width = bar.at("b"), height = bar.at("h"), moment = beam.at("moment");
  std::vector<PieceMass> halves{cuboid(0.0, 0.5 * length, width, height, bar.at("rho")),
                                cuboid(0.5 * length, length, width, height, bar.at("rho"))};
  // The reference takes a slender half's m (L/2)^2 / 12 with the height.
  EXPECT_LE(std::abs(halves[0].inertia_kg_m2(1, 1) / beam.at("inertia_half").get<double>() - 1.0), 1e-12);
  const double second = width * height * height * height / 12.0;
  std::vector<CrackFace> faces;
  const int n = 40;
  for (int i = 0; i < n; ++i) {
    const double z0 = height * (static_cast<double>(i) / n - 0.5), z1 = z0 + height / n;
    const double middle = (z0 * z0 + z0 * z1 + z1 * z1) / (1.5 * (z0 + z1));  // where the strip's force acts
    const Matrix3d stress = Vector3d(moment * 0.5 * (z0 + z1) / second, 0.0, 0.0).asDiagonal();
    faces.push_back({0, 1, width * height / n, Vector3d::UnitX(), {0.5 * length, 0.0, middle}, stress, stress});
  }
  const FractureImpulses push = fracture_impulses(faces, halves, beam.at("dE"), unclipped());
  EXPECT_LE(std::abs(push.tau_s / beam.at("tau_s").get<double>() - 1.0), 1e-12);
  for (const Vector3d& spin : push.angular_velocity_rad_s)
    EXPECT_LE(std::abs(spin.norm() / beam.at("omega_halves_rad_s").get<double>() - 1.0), 1e-12);
}

// One traction for both sides (errata 59): where the two elements differ, each piece by its own element would gain momentum from nowhere.
TEST(FractureImpulse, DifferentStressOnTheTwoSidesKeepsMomentumOnlyWithOneTraction) {
  SixPieces s = six_pieces();
  for (CrackFace& face : s.faces) face.stress_b_pa *= 1.5;
  const FractureImpulses one = fracture_impulses(s.faces, s.pieces, s.energy_j, unclipped(), s.motion);
  ImpulseForm own = unclipped();
  own.sides = TractionSides::kOwn;
  const FractureImpulses two = fracture_impulses(s.faces, s.pieces, s.energy_j, own, s.motion);
  EXPECT_LE(sums_of(s.pieces, one.velocity_m_s, one.angular_velocity_rad_s).momentum.norm(), 1e-15);
  EXPECT_GE(sums_of(s.pieces, two.velocity_m_s, two.angular_velocity_rad_s).momentum.norm(), 1e-4);
}

// Errata 52: a free bar's first n longitudinal modes take 2 n times what its rigid motion takes of an impulse at its end.
TEST(FractureImpulse, ModesTakeTheirShareOfTheEnergy) {
  const std::vector<PieceMass> halves{cuboid(-0.1, 0.0, 0.03, 0.006, 2600.0), cuboid(0.0, 0.1, 0.03, 0.006, 2600.0)};
  const Matrix3d tension = Vector3d(5e6, 0.0, 0.0).asDiagonal();
  const std::vector<CrackFace> faces{{0, 1, 1.8e-4, Vector3d::UnitX(), Vector3d::Zero(), tension, tension}};
  const double force = 5e6 * 1.8e-4;
  for (const int modes : {1, 5, 20}) {
    const double g_sq = 2.0 * modes * 2.0 * force * force / halves[0].mass_kg;
    const FractureImpulses push = fracture_impulses(faces, halves, 0.01, {}, {}, g_sq);
    EXPECT_LE(std::abs(push.modal_j / push.kinetic_j - 2.0 * modes), 1e-12 * modes);
    EXPECT_LE(std::abs(push.modal_j + push.kinetic_j - 0.01), 1e-14);
  }
}

TEST(FractureImpulse, FrictionHoldsAClosedCrackUntilShearExceedsIt) {
  const std::vector<PieceMass> halves{cuboid(-0.1, 0.0, 0.03, 0.006, 2600.0), cuboid(0.0, 0.1, 0.03, 0.006, 2600.0)};
  for (const double shear : {0.3e6, 0.5e6}) {
    Matrix3d stress = Matrix3d::Zero();
    stress(0, 0) = -1e6;
    stress(0, 1) = stress(1, 0) = shear;
    const std::vector<CrackFace> faces{{0, 1, 1.8e-4, Vector3d::UnitX(), Vector3d::Zero(), stress, stress}};
    const std::vector<PieceForce> forces = crack_forces(faces, halves, {});
    const double released = std::max(0.0, shear - 0.4e6);  // friction 0.4
    EXPECT_LE((forces[0].force_n - Vector3d(0.0, -1.8e-4 * released, 0.0)).norm(), 1e-12 * 1.8e-4 * 1e6);
  }
}

// c_R / c_s = 0.8740320488976422, 0.910995890975347, 0.9194016867619662, 0.9421954331163838 (roots of Rayleigh's equation to 15
// digits, made outside this project).
TEST(RayleighSpeed, IsTheRootOfItsEquation) {
  EXPECT_LE(std::abs(rayleigh_speed_ratio(0.0) - 0.8740320488976422), 1e-14);
  EXPECT_LE(std::abs(rayleigh_speed_ratio(0.2) - 0.910995890975347), 1e-14);
  EXPECT_LE(std::abs(rayleigh_speed_ratio(0.25) - 0.9194016867619662), 1e-14);
  EXPECT_LE(std::abs(rayleigh_speed_ratio(0.4) - 0.9421954331163838), 1e-14);
  EXPECT_THROW(rayleigh_speed_ratio(0.5), InputError);
}

}  // namespace
}  // namespace klang::fracture
