#include "core/sound/scene/scene_yielding.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

#include "core/foundation/base/parallel.hpp"
#include "core/geometry/mesh/mass_properties.hpp"
#include "core/sound/scene/detail/held_touch.hpp"
#include "core/sound/stage/modal_voice.hpp"
#include "core/sound/stage/yielding_contact.hpp"

namespace klang::scene {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double kLongestS = 0.02,
                 kLongestInTimes = 20.0;  // that a contact is followed: besides, in Hertz' contact times

/// How a body of the log answers pushes, in its own frame.
using rigid::PushedBody;

double answer_between(const PushedBody& body, const Vector3d& at, const Vector3d& push, const Vector3d& at2,
                      const Vector3d& push2) {
  return body.inverse_mass * push.dot(push2) +
         (at - body.centre).cross(push).dot(body.inverse_inertia * (at2 - body.centre).cross(push2));
}

PushedBody answer_of(double mass_kg, const Vector3d& centre_m, const Matrix3d& inertia_kg_m2) {
  return {1.0 / mass_kg, centre_m, inertia_kg_m2.inverse()};
}

/// One row of a log's body as the scene knows it.
struct Member {
  const SceneBody* body = nullptr;  ///< it, or what it is a piece of
  bool is_piece = false;
};

class Members {
 public:
  Members(const Scene& scene, const events::EventLog& log, const SurfaceOfPiece& surface_of_piece)
      : scene_(scene), surface_of_piece_(surface_of_piece) {
    std::map<std::string, const SceneBody*> by_name;
    for (const SceneBody& body : scene.bodies) by_name[body.name] = &body;
    for (const events::Body& body : log.bodies) {
      Member member;
      if (body.parent >= 0) {
        member = {members_[static_cast<std::size_t>(body.parent)].body, true};
      } else if (const auto found = by_name.find(body.name); found != by_name.end()) {
        member.body = found->second;
      }
      members_.push_back(member);
    }
  }
  const SceneBody* body(int row) const { return members_[static_cast<std::size_t>(row)].body; }
  rigid::Skin skin(int row) const {
    return skin_of(row >= 0 ? scene_.material_of(*body(row))
                            : scene_.materials[static_cast<std::size_t>(*scene_.floor_material)]);
  }
  /// Whether it is known how the row's body answers; answer() has it from then on.
  bool find(int row) {
    const auto [entry, is_new] = answers_.try_emplace(row);
    if (is_new) entry->second = found(row);
    return entry->second.has_value();
  }
  const PushedBody& answer(int row) const { return *answers_.at(row); }

 private:
  std::optional<PushedBody> found(int row) const {
    const Member& member = members_[static_cast<std::size_t>(row)];
    if (!member.body) return {};
    if (!member.is_piece) {
      if (member.body->fixed) return PushedBody{};
      const rigid::RigidBodySpec spec = rigid_body_of(scene_, *member.body);
      return answer_of(spec.mass_kg, spec.centre_m, spec.inertia_kg_m2);
    }
    const auto surface = surface_of_piece_ ? surface_of_piece_(row) : std::nullopt;
    if (!surface) return {};
    const mesh::MassProperties mass = mesh::mass_properties(*surface);
    const double density = scene_.material_of(*member.body).elastic.density_kg_m3;
    return answer_of(density * mass.volume_m3, mass.centre_m, density * mass.inertia_m5);
  }
  const Scene& scene_;
  const SurfaceOfPiece& surface_of_piece_;
  std::vector<Member> members_;
  std::map<int, std::optional<PushedBody>> answers_;
};

/// The rows of a pair's touch, those of either body in the log's order.
struct PairTouch {
  int a = 0, b = -1;
  double time_s = 0.0;
  std::vector<std::size_t> rows_a, rows_b;
};

bool is_impact(const events::Impulse& row) {
  return row.kind == events::ImpulseKind::kImpact && row.shape == events::PulseShape::kHertz && row.duration_s > 0.0 &&
         row.impulse_n_s.norm() > 0.0;
}

std::vector<PairTouch> pair_touches(const events::EventLog& log) {
  std::map<std::tuple<double, int, int>, PairTouch> touches;
  for (std::size_t i = 0; i < log.impulses.size(); ++i) {
    const events::Impulse& row = log.impulses[i];
    if (!is_impact(row)) continue;
    const int a = row.other < 0 ? row.body : std::min(row.body, row.other),
              b = row.other < 0 ? -1 : std::max(row.body, row.other);
    PairTouch& touch = touches[{row.time_s, a, b}];
    touch.a = a;
    touch.b = b;
    touch.time_s = row.time_s;
    (row.body == a ? touch.rows_a : touch.rows_b).push_back(i);
  }
  std::vector<PairTouch> list;
  for (auto& [key, touch] : touches) list.push_back(std::move(touch));
  return list;
}

/// The modes of a body that is heard, and how they are pushed.
struct HeardModes {
  VectorXd angular_frequency_rad_s;
  stage::ModalPush push;
};

struct Problem {
  stage::YieldingContact contact;
  VectorXd impulse_n_s;
  double taken_j = 0.0;  ///< by the contacts, from the motion
};

/// Adds what a body of the pair brings: its rigid answer and its modes.
void add_body(const events::EventLog& log, const std::vector<std::size_t>& rows, const PushedBody& answer,
              const HeardModes* modes, stage::YieldingContact& contact) {
  const auto n = static_cast<Index>(rows.size());
  std::vector<Vector3d> places, pushes;
  for (const std::size_t row : rows) {
    places.push_back(log.impulses[row].point_m);
    pushes.push_back(log.impulses[row].impulse_n_s.normalized());
  }
  for (Index i = 0; i < n; ++i)
    for (Index j = 0; j < n; ++j) {
      const auto p = static_cast<std::size_t>(i), q = static_cast<std::size_t>(j);
      contact.mobility_per_kg(i, j) += answer_between(answer, places[p], pushes[p], places[q], pushes[q]);
    }
  if (!modes) return;
  const Index before = contact.shapes.rows(), more = modes->angular_frequency_rad_s.size();
  Eigen::MatrixXd shapes(more, n);
  for (Index i = 0; i < n; ++i)
    shapes.col(i) = modes->push(places[static_cast<std::size_t>(i)], pushes[static_cast<std::size_t>(i)]);
  contact.residual_m_n += stage::residual_of_higher_modes_m_n(modes->angular_frequency_rad_s, shapes);
  contact.shapes.conservativeResize(before + more, n);
  contact.shapes.bottomRows(more) = shapes;
  contact.angular_frequency_rad_s.conservativeResize(before + more);
  contact.angular_frequency_rad_s.tail(more) = modes->angular_frequency_rad_s;
}

/// Where the two touch, for what holds them.
detail::PairPlaces places_of(const events::EventLog& log, const PairTouch& touch, const Members& members) {
  detail::PairPlaces places{touch.a, touch.b, touch.time_s, members.answer(touch.a), {}, {}, {}, {}};
  if (touch.b >= 0) places.answer_b = members.answer(touch.b);
  for (const std::size_t row : touch.rows_a) {
    places.at_a_m.push_back(log.impulses[row].point_m);
    places.impulse_n_s.push_back(log.impulses[row].impulse_n_s);
  }
  for (const std::size_t row : touch.rows_b) places.at_b_m.push_back(log.impulses[row].point_m);
  return places;
}

/// Speeds and stiffnesses from impulses and contact times: bodies that leave at e times the speed at which they came have u- = A J / (1 + e).
bool set_springs(const events::EventLog& log, const PairTouch& touch, double restitution, Problem& problem) {
  stage::YieldingContact& contact = problem.contact;
  const VectorXd change_m_s = contact.mobility_per_kg * problem.impulse_n_s;
  for (Index i = 0; i < change_m_s.size(); ++i) {
    const double alone = contact.mobility_per_kg(i, i);
    if (!(alone > 0.0)) return false;  // neither moves
    // A place that others push away has no such speed: as if it were alone.
    const double change = change_m_s[i] > 0.0 ? change_m_s[i] : alone * problem.impulse_n_s[i];
    contact.approach_m_s[i] = change / (1.0 + restitution);
    contact.stiffness_n_m32[i] = stage::hertz_stiffness_n_m32(
        1.0 / alone, contact.approach_m_s[i], log.impulses[touch.rows_a[static_cast<std::size_t>(i)]].duration_s);
  }
  problem.taken_j = 0.5 * (1.0 - restitution) * problem.impulse_n_s.dot(contact.approach_m_s);
  return true;
}

/// Of a touch's rows.
struct TouchForces {
  std::vector<stage::ForceHistory> histories;
  double share = 1.0;  ///< that modes feel
};

TouchForces forces_of(const Problem& problem, double time_s, double longest_duration_s) {
  stage::ContactForces forces =
      stage::yielding_forces(problem.contact, kLongestS + kLongestInTimes * longest_duration_s);
  const Index n = problem.impulse_n_s.size();
  for (Index i = 0; i < n; ++i) {
    if (!(forces.impulse_n_s[i] > 0.0)) return {};  // pushed away by others before it touched
    forces.force_n.col(i) *= problem.impulse_n_s[i] / forces.impulse_n_s[i];
  }
  const double vibration = problem.contact.shapes.rows() > 0 ? stage::vibration_j(problem.contact, forces) : 0.0;
  const double share = vibration > problem.taken_j ? std::sqrt(problem.taken_j / vibration) : 1.0;
  TouchForces found{{}, share};
  for (Index i = 0; i < n; ++i) {
    stage::ForceHistory history{time_s, forces.step_s, {}};
    for (Index r = 0; r < forces.force_n.rows(); ++r)
      history.force_per_s.push_back(forces.force_n(r, i) / problem.impulse_n_s[i]);
    found.histories.push_back(std::move(history));
  }
  return found;
}

}  // namespace

stage::ImpactPulses impact_pulses(const Scene& scene, const events::EventLog& log, const std::vector<HeardBody>& heard,
                                  const SurfaceOfPiece& surface_of_piece, Monitor& monitor) {
  Members members(scene, log, surface_of_piece);
  std::map<int, HeardModes> modes;
  for (const HeardBody& body : heard)
    modes[body.body] = {body.model->modes.angular_frequency_rad_s, stage::push_at_nearest_node(body.model->modes)};
  const auto modes_of = [&](int row) {
    const auto entry = modes.find(row);
    return entry == modes.end() ? nullptr : &entry->second;
  };
  const auto yields_already = [&](int row) {
    const SceneBody* const body = row < 0 ? nullptr : members.body(row);
    return row >= 0 && (!body || body->model == BodyModel::kModal || body->model == BodyModel::kCracking);
  };
  std::vector<PairTouch> touches;
  for (PairTouch& touch : pair_touches(log)) {
    if (!modes_of(touch.a) && !modes_of(touch.b)) continue;
    if (yields_already(touch.a) || yields_already(touch.b)) continue;
    if (touch.rows_a.empty() || (touch.b >= 0 && touch.rows_b.size() != touch.rows_a.size())) continue;
    if (touch.b >= 0 ? !members.find(touch.b) : !scene.floor_material) continue;
    if (!members.find(touch.a)) continue;
    touches.push_back(std::move(touch));
  }
  const detail::HeldTouches ties(
      scene, log, [&](int row) { return members.find(row) ? std::optional(members.answer(row)) : std::nullopt; });
  std::vector<TouchForces> forces(touches.size());
  for_each_job(
      touches.size(),
      [&](std::size_t t) {
        const PairTouch& touch = touches[t];
        const auto n = static_cast<Index>(touch.rows_a.size());
        Problem problem;
        problem.contact.mobility_per_kg = Eigen::MatrixXd::Zero(n, n);
        problem.contact.approach_m_s = problem.contact.stiffness_n_m32 = problem.contact.residual_m_n =
            problem.impulse_n_s = VectorXd::Zero(n);
        problem.contact.shapes.resize(0, n);
        double longest_s = 0.0;
        for (Index i = 0; i < n; ++i) {
          const events::Impulse& row = log.impulses[touch.rows_a[static_cast<std::size_t>(i)]];
          problem.impulse_n_s[i] = row.impulse_n_s.norm();
          longest_s = std::max(longest_s, row.duration_s);
        }
        add_body(log, touch.rows_a, members.answer(touch.a), modes_of(touch.a), problem.contact);
        if (touch.b >= 0) add_body(log, touch.rows_b, members.answer(touch.b), modes_of(touch.b), problem.contact);
        if (const auto held = ties.mobility_per_kg(places_of(log, touch, members)))
          problem.contact.mobility_per_kg = *held;
        const auto breaks = [&](int row) {
          const auto broken_s = row < 0 ? std::nullopt : log.broken_s(row);
          return broken_s && *broken_s - touch.time_s <= 1.0 / scene.solver.rate_hz;
        };
        // What breaks does so when it is compressed most: nothing was given back.
        const double restitution = breaks(touch.a) || breaks(touch.b)
                                       ? 0.0
                                       : rigid::pair_restitution(members.skin(touch.a), members.skin(touch.b));
        if (set_springs(log, touch, restitution, problem)) forces[t] = forces_of(problem, touch.time_s, longest_s);
      },
      "impacts", monitor);
  stage::ImpactPulses pulses;
  for (std::size_t t = 0; t < touches.size(); ++t)
    for (std::size_t i = 0; i < forces[t].histories.size(); ++i) {
      const stage::ImpactPulse pulse{stage::sampled(forces[t].histories[i], scene.sound.sample_rate_hz),
                                     forces[t].share};
      pulses[touches[t].rows_a[i]] = pulse;
      if (touches[t].b >= 0) pulses[touches[t].rows_b[i]] = pulse;
    }
  return pulses;
}

}  // namespace klang::scene
