// A small step of a modal body of 18,847 corners and 40 modes (H03's brain): its state; with the places of all corners; above the floor, with what may touch.
#include <benchmark/benchmark.h>

#include "core/sound/scene/detail/modal_contacts.hpp"
#include "tests/core/sound/scene/modal_corners.hpp"

namespace {

using namespace klang;

constexpr int kModes = 40;
void state(benchmark::State& bench) {
  scene::detail::ModalBody body = test::ball_of_corners(static_cast<int>(bench.range(0)), kModes);
  for (auto _ : bench) body.fly(body.dt_s, Eigen::Vector3d::Zero());
}

void state_and_all_corners(benchmark::State& bench) {
  scene::detail::ModalBody body = test::ball_of_corners(static_cast<int>(bench.range(0)), kModes);
  for (auto _ : bench) {
    body.fly(body.dt_s, Eigen::Vector3d::Zero());
    body.refresh();
  }
}

/// It hovers: what is asked is which corners touch.
void above_the_floor(benchmark::State& bench) {
  scene::Scene scene;
  scene.solver.floor = rigid::Skin{};
  std::vector<scene::detail::ModalBody> bodies = {test::ball_of_corners(static_cast<int>(bench.range(0)), kModes)};
  bodies[0].centre_m.z() += 0.006;
  scene::detail::ModalContacts contacts(scene, bodies, {});
  std::vector<scene::detail::PressedBody> none;
  double dt_s = bodies[0].dt_s;
  for (auto _ : bench) {
    bodies[0].fly(dt_s, Eigen::Vector3d::Zero());
    dt_s = contacts.solve(none, bodies[0].dt_s);
  }
  bench.counters["looked_at"] = static_cast<double>(bodies[0].looked_at.size());
}

/// A rigid box touches its side: what is asked is which corners are in it; nothing pushes.
void beside_a_box(benchmark::State& bench) {
  scene::Scene scene;
  rigid::RigidWorld world({});
  rigid::RigidBodySpec box;
  box.name = "box";
  Eigen::Matrix3Xd corners(3, 8);
  for (int i = 0; i < 8; ++i)
    corners.col(i) = Eigen::Vector3d((i & 1) ? 0.05 : -0.05, (i & 2) ? 0.04 : -0.04, (i & 4) ? 0.03 : -0.03);
  box.parts.push_back({corners});
  box.mass_kg = 1.0;
  box.inertia_kg_m2 = 1e-3 * Eigen::Matrix3d::Identity();
  box.position_m = {0.146, 0.0, 0.09};
  world.add(box);
  std::vector<scene::detail::PressedBody> others;
  others.emplace_back(world, 0, scene::detail::PressedBody::Way::kStruck);
  others[0].begin(world, 1e-4, Eigen::Vector3d::Zero());
  std::vector<scene::detail::ModalBody> bodies = {test::ball_of_corners(static_cast<int>(bench.range(0)), kModes)};
  scene::detail::ModalContacts contacts(scene, bodies, {});
  double dt_s = bodies[0].dt_s;
  for (auto _ : bench) {
    bodies[0].fly(dt_s, Eigen::Vector3d::Zero());
    bodies[0].time_s += dt_s;
    dt_s = contacts.solve(others, bodies[0].dt_s);
  }
  bench.counters["looked_at"] = static_cast<double>(bodies[0].looked_at.size());
}

/// It lies on the floor on a flat of a hundredth of its corners, with friction, after it came to rest.
void at_rest(benchmark::State& bench) {
  constexpr double kFlat = -0.0885;
  scene::Scene scene;
  scene.solver.floor = rigid::Skin{};
  scene.solver.floor->friction = 0.3;
  std::vector<scene::detail::ModalBody> bodies = {test::ball_of_corners(static_cast<int>(bench.range(0)), kModes)};
  scene::detail::ModalBody& body = bodies[0];
  body.skin.friction = 0.3;
  for (scene::detail::ModalPlace& place : body.places) place.rest_m.z() = std::max(place.rest_m.z(), kFlat);
  body.groups = scene::detail::corner_groups(body.places);
  body.turn.setIdentity();
  // A hundred times as fast, so that it does not sag: 2 to 18 kHz, which ring for some milliseconds.
  body.modes = modal::ModalState(1e4 * body.modes.lambda(), Eigen::VectorXd::Constant(kModes, 500.0));
  body.dt_s = 2.5e-6;
  body.centre_m.z() = -kFlat;
  scene::detail::ModalContacts contacts(scene, bodies, {});
  std::vector<scene::detail::PressedBody> none;
  double dt_s = body.dt_s;
  const auto step = [&] {
    body.fly(dt_s, scene.solver.gravity_m_s2);
    body.time_s += dt_s;
    body.touches.clear();
    dt_s = contacts.solve(none, body.dt_s);
  };
  for (int k = 0; k < 20000; ++k) step();
  for (auto _ : bench) step();
  bench.counters["looked_at"] = static_cast<double>(body.looked_at.size());
  bench.counters["touch"] = static_cast<double>(body.touches.size());
  bench.counters["sunk_um"] = 1e6 * (-kFlat - body.centre_m.z());
}

BENCHMARK(at_rest)->Arg(500)->Arg(18847)->Unit(benchmark::kMicrosecond);
BENCHMARK(beside_a_box)->Arg(500)->Arg(18847)->Unit(benchmark::kMicrosecond);
BENCHMARK(state)->Arg(500)->Arg(18847)->Unit(benchmark::kMicrosecond);
BENCHMARK(state_and_all_corners)->Arg(500)->Arg(18847)->Unit(benchmark::kMicrosecond);
BENCHMARK(above_the_floor)->Arg(500)->Arg(18847)->Unit(benchmark::kMicrosecond);

}  // namespace
