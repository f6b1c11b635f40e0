#include "core/sound/scene/scene_yielding.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "core/foundation/base/conventions.hpp"
#include "core/physics/modal/modes_of.hpp"
#include "core/sound/scene/scene_floor.hpp"
#include "core/sound/scene/scene_motion.hpp"
#include "core/sound/stage/modal_voice.hpp"

namespace klang::scene {
namespace {

constexpr double kRateHz = 192000.0;

Scene scene_of(const std::string& restitution, const std::string& body) {
  return parse_scene(
      "[world.floor]\nmaterial = \"glass\"\n[[material]]\nname = \"glass\"\nyoungs_modulus_pa = 70e9\n"
      "poissons_ratio = 0.2\ndensity_kg_m3 = 2500\nfriction = 0\nrestitution = " +
          restitution + "\n[sound]\nsample_rate_hz = 192000\n[[body]]\nname = \"body\"\nmaterial = \"glass\"\n" + body,
      "drop.toml");
}

std::vector<HeardBody> heard(const Scene& scene) {
  const SceneBody& body = scene.bodies[0];
  modal::ModesOptions options;
  options.eigen.band = {20.0, scene.sound.high_hz};
  options.eigen.most = 200;
  const modal::EigenResult modes =
      modal::modes_of({body.shape, {}, 2}, mesh_of(body), scene.material_of(body).elastic, options);
  return {{0, std::make_shared<const SoundModel>(SoundModel{modes.model, {}, false, {}}),
           scene.material_of(body).damping_heard()}};
}

/// Energy that the log's impacts leave in the modes, without damping.
double vibration_j(const events::EventLog& log, const HeardBody& body, const stage::ImpactPulses* pulses) {
  const modal::ModalModel& modes = body.model->modes;
  stage::PushedModes pushed;
  for (Eigen::Index m = 0; m < modes.n_modes(); ++m) pushed.numbers.push_back(m);
  pushed.angular_frequency_rad_s = modes.angular_frequency_rad_s;
  pushed.decay_per_s = Eigen::VectorXd::Zero(modes.n_modes());
  pushed.sample_rate_hz = kRateHz;
  const auto impulses = stage::modal_impulses(log, 0, stage::push_at_nearest_node(modes), pushed, pulses);
  double energy_j = 0.0;
  for (Eigen::Index m = 0; m < modes.n_modes(); ++m) {
    std::vector<stage::ModalImpulse> own;
    for (stage::ModalImpulse impulse : impulses) {
      impulse.impulse = Eigen::VectorXd::Constant(1, impulse.impulse[m]);
      own.push_back(impulse);
    }
    const double omega = modes.angular_frequency_rad_s[m];
    const Eigen::VectorXd z = stage::oscillation({{omega, 0.0, 1.0}}, own, kRateHz, 20000);
    // Of a free oscillation: two neighbouring samples give its amplitude.
    const double angle = omega / kRateHz, first = z[19990], second = z[19991];
    const double other = (second - first * std::cos(angle)) / std::sin(angle);
    energy_j += 0.5 * omega * omega * (first * first + other * other);
  }
  return energy_j;
}

/// Impacts of the log, the first of them alone.
events::EventLog first_impact(events::EventLog log) {
  if (log.impulses.empty()) return log;
  const double time_s = log.impulses.front().time_s;
  std::erase_if(log.impulses, [&](const events::Impulse& row) {
    return row.kind != events::ImpulseKind::kImpact || row.time_s > time_s;
  });
  for (events::Impulse& row : log.impulses) row.time_s = 0.01;
  return log;
}

const std::string kPlate =
    "shape = { kind = \"box\", length_m = 0.2, width_m = 0.15, height_m = 0.006 }\nmax_edge_m = 0.012\nposition_m = "
    "[0, 0, 0.11]\n"
    "rotation_deg = [6, 9, 0]\nvelocity_m_s = [0, 0, -2]\n";

TEST(SceneYielding, AThinPlateRingsWithNoMoreThanItsImpactTook) {
  // With modes that give back four fifths of the speed, a restitution of 0.95 leaves less than they would take.
  for (const bool scarce : {false, true}) {
    const Scene scene = scene_of(scarce ? "0.95" : "0.5", kPlate);
    const SceneMotion motion = move(scene, 0.06);
    const std::vector<HeardBody> bodies = heard(scene);
    const events::EventLog log = first_impact(motion.log);
    ASSERT_EQ(log.impulses.size(), 1U);
    const stage::ImpactPulses pulses = impact_pulses(scene, log, bodies, {});
    ASSERT_EQ(pulses.size(), 1U);
    const double with = vibration_j(log, bodies[0], &pulses), rigid = vibration_j(log, bodies[0], nullptr);
    double taken_j = 0.0;
    for (const rigid::EnergyLedger& row : motion.ledger)
      if (taken_j == 0.0) taken_j = row.contact_j;
    EXPECT_GT(taken_j, 0.0);
    EXPECT_LE(with, 1.001 * taken_j);
    EXPECT_GT(with, (scarce ? 0.99 : 0.1) * taken_j);
    EXPECT_GT(rigid, 2.0 * taken_j);  // as if it did not yield
  }
}

TEST(SceneYielding, WhatLosesNothingIsSilent) {
  const Scene scene = scene_of("1", kPlate);
  const events::EventLog log = first_impact(move(scene, 0.06).log);
  const std::vector<HeardBody> bodies = heard(scene);
  const stage::ImpactPulses pulses = impact_pulses(scene, log, bodies, {});
  EXPECT_LE(vibration_j(log, bodies[0], &pulses), 1e-9 * vibration_j(log, bodies[0], nullptr));
}

/// However little of it the body's modes may take: low modes of a slab feel the impulse, whatever the force over time.
TEST(SceneYielding, TheFloorFeelsTheWholeImpulse) {
  for (const char* restitution : {"1", "0.95"}) {
    Scene scene = scene_of(restitution, kPlate);
    FloorSound slab;
    slab.slab_m = {3.0, 3.0, 0.2};
    slab.high_hz = 150.0;
    scene.floor_sound = slab;
    events::EventLog log = move(scene, 0.06).log;
    ASSERT_FALSE(log.impulses.empty());
    log.impulses.resize(1);  // at its own time: the body lies on the floor then
    const stage::ImpactPulses pulses = impact_pulses(scene, log, heard(scene), {});
    ASSERT_EQ(pulses.size(), 1U);
    EXPECT_LT(pulses.begin()->second.share, 1.0) << restitution;
    const double with = floor_sound_of(scene, log, pulses, 0.1).sound_pa.samples.norm(),
                 rigid = floor_sound_of(scene, log, {}, 0.1).sound_pa.samples.norm();
    EXPECT_GT(rigid, 0.0);
    EXPECT_LE(std::abs(with / rigid - 1.0), 0.05) << restitution;
  }
}

TEST(SceneYielding, TheFloorRingsOnAsLongAsItsSlowestMode) {
  Scene scene = scene_of("0.5", kPlate);
  EXPECT_EQ(floor_ring_time_s(scene), 0.0);
  FloorSound slab;
  slab.slab_m = {3.0, 3.0, 0.2};
  scene.floor_sound = slab;
  const auto& glass = scene.materials[static_cast<std::size_t>(*scene.floor_material)];
  const double lowest = slab_modes(slab, glass.elastic).front().angular_frequency_rad_s;
  const damping::LawValue damping = glass.damping_heard();
  const double decay_per_s =
      damping.law->decay_per_s(Eigen::VectorXd::Constant(1, lowest), damping.parameters.data())[0];
  EXPECT_GT(decay_per_s, 0.0);
  EXPECT_NEAR(floor_ring_time_s(scene), std::log(1000.0) / decay_per_s, 1e-9);
}

TEST(SceneYielding, ABallStrikesABlockAsHertzSays) {
  const Scene scene = parse_scene(
      "[world]\ngravity_m_s2 = [0, 0, 0]\n[[material]]\nname = \"glass\"\nyoungs_modulus_pa = 70e9\npoissons_ratio = "
      "0.2\ndensity_kg_m3 = 2500\nfriction = 0\nrestitution = 0.9\n[sound]\nsample_rate_hz = 192000\nband_hz = [20, "
      "12000]\n[[body]]\nname = \"block\"\nmaterial = \"glass\"\nshape = { kind = \"box\", length_m = 0.22, width_m = "
      "0.2, height_m = 0.18 }\nmax_edge_m = 0.05\n[[body]]\nname = \"ball\"\nmaterial = \"glass\"\nshape = { kind = "
      "\"sphere\", radius_m = 0.006 }\nposition_m = [0.03, 0.02, 0.098]\nvelocity_m_s = [0, 0, -1]\n",
      "ball.toml");
  const std::vector<HeardBody> bodies = heard(scene);
  const events::EventLog log = first_impact(move(scene, 0.02).log);
  ASSERT_EQ(log.impulses.size(), 2U);
  const stage::ImpactPulses pulses = impact_pulses(scene, log, bodies, {});
  ASSERT_EQ(pulses.size(), 2U);
  const double with = vibration_j(log, bodies[0], &pulses), rigid = vibration_j(log, bodies[0], nullptr);
  EXPECT_GT(bodies[0].model->modes.n_modes(), 3);
  EXPECT_LE(std::abs(with / rigid - 1.0), 0.05);
}

/// Two centimetres from its hinge a plate gives way two thirds as far as it would without: of what the impact took, no more.
TEST(SceneYielding, APlateOnAHingeRingsWithNoMoreThanItsImpactTook) {
  const std::string text =
      "duration_s = 0.02\n[world]\ngravity_m_s2 = [0, 0, 0]\n[[material]]\nname = \"glass\"\nyoungs_modulus_pa = "
      "70e9\npoissons_ratio = 0.2\ndensity_kg_m3 = 2500\nfriction = 0\nrestitution = 0.97\n[sound]\nsample_rate_hz = "
      "192000\n[[body]]\nname = \"plate\"\nmaterial = \"glass\"\nshape = { kind = \"box\", length_m = 0.2, width_m = "
      "0.15, height_m = 0.006 }\nmax_edge_m = 0.012\n[[body]]\nname = \"ball\"\nmaterial = \"glass\"\nshape = { kind = "
      "\"sphere\", radius_m = 0.02 }\nposition_m = [-0.08, 0.02, 0.0235]\nvelocity_m_s = [0, 0, -1]\n[[hinge]]\nbody = "
      "\"plate\"\nat_m = [-0.1, 0, 0]\naxis = [0, 1, 0]\n";
  const Scene scene = parse_scene(text, "hinged.toml");
  const SceneMotion motion = move(scene, 0.02);
  const std::vector<HeardBody> bodies = heard(scene);
  const events::EventLog log = first_impact(motion.log);
  ASSERT_EQ(log.impulses.size(), 2U);
  const stage::ImpactPulses pulses = impact_pulses(scene, log, bodies, {});
  ASSERT_EQ(pulses.size(), 2U);
  ASSERT_LT(pulses.begin()->second.share, 1.0);  // else modes take less than there is
  double taken_j = 0.0;
  for (const rigid::EnergyLedger& row : motion.ledger)
    if (taken_j == 0.0) taken_j = row.contact_j;
  EXPECT_NEAR(vibration_j(log, bodies[0], &pulses) / taken_j, 1.0, 1e-2);
}

/// A plate that goes round on a cord is struck across it. Between poses that are a sixtieth of a second apart it is far off its circle.
TEST(SceneYielding, ATautCordIsTautWhateverThePosesThatAreKept) {
  double share[2];
  for (const int rate : {60, 10000}) {
    const std::string text =
        "duration_s = 0.03\n[solver]\nrate_hz = 10000\npose_rate_hz = " + std::to_string(rate) +
        "\n[world]\ngravity_m_s2 = [0, 0, 0]\n[[material]]\nname = \"glass\"\nyoungs_modulus_pa = 70e9\n"
        "poissons_ratio = 0.2\ndensity_kg_m3 = 2500\nfriction = 0\nrestitution = 0.97\n[[body]]\nname = \"plate\"\n"
        "material = \"glass\"\nshape = { kind = \"box\", length_m = 0.1, width_m = 0.08, height_m = 0.006 }\n"
        "max_edge_m = 0.02\nvelocity_m_s = [4, 0, 0]\n[[body]]\nname = \"ball\"\nmaterial = \"glass\"\nshape = { kind "
        "= "
        "\"sphere\", radius_m = 0.02 }\nposition_m = [0.04, 0, 0.037]\nvelocity_m_s = [0, 0, -1]\nsound = \"none\"\n"
        "[[cord]]\nbody = \"plate\"\nat_m = [0, 0, 0]\nto_m = [0, 0, 0.2]\n";
    const Scene scene = parse_scene(text, "cord.toml");
    const stage::ImpactPulses pulses = impact_pulses(scene, first_impact(move(scene, 0.03).log), heard(scene), {});
    ASSERT_FALSE(pulses.empty()) << rate;
    share[rate == 60 ? 0 : 1] = pulses.begin()->second.share;
  }
  EXPECT_GT(share[1], 0.0);
  EXPECT_NEAR(share[0] / share[1], 1.0, 1e-3);
}

}  // namespace
}  // namespace klang::scene
