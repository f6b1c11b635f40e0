#include "core/sound/scene/scene_cracking.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/sound/scene/detail/body_meeting.hpp"
#include "core/sound/scene/detail/deforming_body.hpp"

namespace klang::scene {

struct CrackingBodies::State {
  const Scene& scene;
  const SceneNotes& notes;
  std::vector<std::unique_ptr<detail::DeformingBody>> bodies;
  std::vector<detail::PressedBody> pressed;
  std::vector<rigid::EnergyLedger> rows;         ///< of all cracking bodies, one per step of the world, and the start
  std::unique_ptr<detail::BodyMeeting> meeting;  ///< where there are several

  void add_row(double time_s);
  void bound_shapes();
};

void CrackingBodies::State::add_row(double time_s) {
  rigid::EnergyLedger row;
  row.time_s = time_s;
  for (const auto& body : bodies) {
    const fracture::SolidEnergies e = body->solid().energies();
    row.kinetic_j += e.kinetic_j;
    row.potential_j += e.potential_j;
    row.strain_j += e.elastic_j;
    row.viscous_j += e.viscous_j;
    row.plastic_j += e.plastic_j;
    row.contact_j += e.contact_j;
    row.friction_j += e.friction_j;
    row.correction_j += e.lost_j - body->lumped_j();
    row.work_j += e.work_j;
  }
  if (meeting) {
    row.contact_j += meeting->stored_j();
    row.correction_j += meeting->lost_j();
  }
  // Bodies were put in with what they had.
  row.work_j += rows.empty() ? row.sum_j() : rows.front().work_j;
  row.residual_j = row.sum_j();
  rows.push_back(row);
}

std::vector<std::pair<int, const fracture::CrackMesh*>> CrackingBodies::meshes() const {
  std::vector<std::pair<int, const fracture::CrackMesh*>> meshes;
  for (const auto& body : state_->bodies) meshes.emplace_back(body->row(), &body->solid().mesh());
  return meshes;
}

void CrackingBodies::State::bound_shapes() {
  std::vector<detail::ShapeKeeper*> keepers;
  for (const auto& body : bodies) keepers.push_back(&body->shapes());
  detail::thin_to(scene.frames.most_shape_bytes, keepers);
}

namespace {

/// (lambda + 2 mu) V e^2 with the strain e that places off by 64 units of their last digit make.
double round_off_j(const fracture::ExplicitSolid& solid) {
  const fracture::CrackMesh& mesh = solid.mesh();
  const solid::Material& material = solid.options().material;
  double reach_m = 0.0, volume_m3 = 0.0, least_m3 = HUGE_VAL;
  for (const Eigen::Vector3d& place : mesh.place_m) reach_m = std::max(reach_m, place.norm());
  for (int e = 0; e < mesh.n_elements(); ++e) {
    volume_m3 += mesh.volume_m3(e);
    least_m3 = std::min(least_m3, mesh.volume_m3(e));
  }
  const double strain = 64.0 * std::numeric_limits<double>::epsilon() * reach_m / std::cbrt(least_m3);
  return (material.lame_lambda_pa + 2.0 * material.lame_mu_pa) * volume_m3 * strain * strain;
}

}  // namespace

CrackingBodies::CrackingBodies(const Scene& scene, rigid::RigidWorld& world, std::uint64_t seed,
                               const SceneNotes& notes, Monitor& monitor)
    : state_(std::make_unique<State>(State{scene, notes, {}, {}, {}, {}})) {
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    if (scene.bodies[i].model != BodyModel::kCracking) continue;
    const int row = static_cast<int>(i);
    state_->bodies.push_back(
        std::make_unique<detail::DeformingBody>(scene, row, world.spec(row), seed, notes, monitor));
    world.remove(row);
  }
  if (!any()) return;
  for (int i = 0; i < world.n_bodies(); ++i)
    if (world.is_there(i)) state_->pressed.emplace_back(world, i);
  for (const auto& body : state_->bodies) body->keep_frames(scene.pose_rate_hz);
  if (state_->bodies.size() > 1) {
    std::vector<detail::DeformingBody*> all;
    for (const auto& body : state_->bodies) all.push_back(body.get());
    state_->meeting = std::make_unique<detail::BodyMeeting>(std::move(all));
  }
  state_->add_row(world.time_s());
}
CrackingBodies::~CrackingBodies() = default;

bool CrackingBodies::any() const { return !state_->bodies.empty(); }

void CrackingBodies::after_step(rigid::RigidWorld& world) {
  if (!any()) return;
  const double end_s = world.time_s(), dt_s = end_s - state_->rows.back().time_s;
  auto& pressed = state_->pressed;
  pressed.erase(std::remove_if(pressed.begin(), pressed.end(),
                               [&](const detail::PressedBody& body) { return !world.is_there(body.body()); }),
                pressed.end());
  for (int i = pressed.empty() ? 0 : pressed.back().body() + 1; i < world.n_bodies(); ++i)
    if (world.is_there(i)) pressed.emplace_back(world, i);  // pieces that are new
  for (detail::PressedBody& other : pressed) other.begin(world, dt_s, state_->scene.solver.gravity_m_s2);
  // Each that goes alone presses over the whole step, on the velocity that those before it left.
  std::vector<char> together(state_->bodies.size(), 0);
  bool first = true;
  const auto rewind = [&] {
    if (!first)
      for (detail::PressedBody& other : pressed) other.rewind();
    first = false;
  };
  if (state_->meeting) {
    together = state_->meeting->choose(dt_s);
    if (std::count(together.begin(), together.end(), 1) > 0) {
      rewind();
      state_->meeting->advance(end_s, pressed);
    }
  }
  for (std::size_t i = 0; i < state_->bodies.size(); ++i) {
    if (together[i] != 0) continue;
    rewind();
    state_->bodies[i]->advance(end_s, pressed);
  }
  for (detail::PressedBody& other : pressed)
    if (const double got_j = other.end(world); got_j != 0.0) {
      world.book(&rigid::EnergyLedger::contact_j, other.rubbed_j() - got_j);
      world.book(&rigid::EnergyLedger::friction_j, -other.rubbed_j());
    }
  for (const auto& body : state_->bodies) body->keep_frames(state_->scene.pose_rate_hz);
  state_->bound_shapes();
  state_->add_row(end_s);
}

void CrackingBodies::add_to(SceneMotion& motion) const {
  add_ledger(motion, state_->rows);
  CrackSummary summary;
  bool apart = false;
  std::vector<std::vector<int>> rows;
  for (const auto& body : state_->bodies) {
    rows.push_back(body->add_to(state_->scene, motion));
    summary.n_splits += body->cracker().n_splits();
    summary.n_elements_start += body->n_elements_start();
    summary.n_elements_end += body->solid().mesh().n_elements();
    summary.round_off_j += round_off_j(body->solid());
    summary.dissipation_j += body->solid().energies().plastic_j;
    summary.max_strain = std::max(summary.max_strain, body->solid().largest_plastic_strain());
    summary.faces.insert(summary.faces.end(), body->cracker().faces().begin(), body->cracker().faces().end());
    summary.splits.insert(summary.splits.end(), body->splits().begin(), body->splits().end());
    apart = apart || (body->n_pieces() > 1 && body->solid().self_contact() == nullptr);
  }
  if (state_->meeting) state_->meeting->add_to(motion, rows);
  if (apart)
    summary.warnings.push_back(
        "pieces of a cracking body with self_contact = false do not feel one another: they can pass through each "
        "other");
  if (const double gamma2 = 2.0 * summary.max_strain; gamma2 > fracture::kDoubtfulGamma2)
    summary.warnings.push_back("plastic strain of norm " + std::to_string(summary.max_strain) +
                               ": its rest shape has lost some volume (erratum 68)");
  if (const int stride = state_->bodies.front()->shapes().stride(); stride > 1)
    summary.warnings.push_back(detail::words_of_thinning("cracking", stride, state_->scene.frames.most_shape_bytes));
  motion.log.sort();
  motion.cracks = std::move(summary);
}

}  // namespace klang::scene
