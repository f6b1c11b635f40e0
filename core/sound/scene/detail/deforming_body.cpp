#include "core/sound/scene/detail/deforming_body.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "core/foundation/base/errors.hpp"
#include "core/geometry/mesh/mass_properties.hpp"
#include "core/sound/scene/detail/held_nodes.hpp"

namespace klang::scene::detail {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kSmallestStepS = 1e-10, kInertiaToSay = 0.02;
constexpr double kBending = 6.0, kBendingToSay = 0.1;  ///< of the stiffness

std::size_t at(int i) { return static_cast<std::size_t>(i); }

std::vector<int> all_nodes(const fracture::CrackMesh& mesh) {
  std::vector<int> nodes(at(mesh.n_nodes()));
  for (std::size_t i = 0; i < nodes.size(); ++i) nodes[i] = static_cast<int>(i);
  return nodes;
}

}  // namespace

/// Springs against the floor and rigid bodies, for the solid to ask for.
struct DeformingBody::Pressing {
  const Scene& scene;
  rigid::Skin skin;
  double rate_sq = 0.0;  ///< stiffness over mass
  double step_s = 0.0;
  std::vector<PressedBody>* bodies = nullptr;
  /// Depth at which a node is not pushed yet: that at which a cut put it into a body between nodes that were outside. A spring that is
  /// tight from the start would make energy. It shrinks as the node comes out.
  std::vector<double> spared_m;
  std::vector<int> targets;  ///< of the pushes that were made last: number in bodies, or -1: floor

  /// A node in something: number in bodies or -1, how deep, the way out, its speed there.
  struct Touch {
    int node = 0, target = -1;
    double depth_m = 0.0;
    Vector3d out, speed;
    double friction = 0.0, mass_kg = 0.0;
  };

  void add(const fracture::CrackMesh& mesh, const Touch& touch, std::vector<fracture::NodePush>& pushes) {
    const auto& [node, target, depth_m, out, speed, friction, mass] = touch;
    fracture::NodePush push;
    push.node = node;
    const double normal_n = rate_sq * mass * depth_m;
    push.normal_n = normal_n * out;
    const Vector3d along = speed - speed.dot(out) * out;
    // At most what stops the node in a step.
    const double slow = friction * normal_n * step_s / mesh.mass_kg_of[at(node)];
    push.friction_n = -friction * normal_n / std::max({along.norm(), slow, 1e-300}) * along;
    pushes.push_back(push);
    targets.push_back(target);
  }

  void spare_new_nodes(const fracture::CrackMesh& mesh) {
    while (spared_m.size() < at(mesh.n_nodes())) {
      const auto node = spared_m.size();
      const std::size_t old = at(mesh.made_of(static_cast<int>(node)));
      double spared = 0.0;
      if (old != node && mesh.place_m[old] == mesh.place_m[node]) {
        spared = spared_m[old];
      } else if (old != node) {
        for (const PressedBody& body : *bodies)
          if (const auto depth = body.depth_of(mesh.place_m[node])) spared = std::max(spared, depth->depth_m);
      }
      spared_m.push_back(spared);
    }
  }

  void operator()(const fracture::CrackMesh& mesh, std::vector<fracture::NodePush>& pushes) {
    targets.clear();
    if (scene.solver.floor) {
      const double friction = rigid::pair_friction(skin, *scene.solver.floor);
      for (int i = 0; i < mesh.n_nodes(); ++i)
        if (mesh.place_m[at(i)].z() < 0.0 && mesh.held[at(i)] < 0)
          add(mesh,
              {i, -1, -mesh.place_m[at(i)].z(), Vector3d::UnitZ(), mesh.velocity_m_s[at(i)], friction,
               mesh.mass_kg_of[at(i)]},
              pushes);
    }
    if (bodies == nullptr || bodies->empty()) return;
    spare_new_nodes(mesh);
    Eigen::AlignedBox3d box;
    for (const Vector3d& x : mesh.place_m) box.extend(x);
    for (std::size_t b = 0; b < bodies->size(); ++b) {
      PressedBody& body = (*bodies)[b];
      if (!body.is_near(box.min(), box.max())) continue;
      const double friction = rigid::pair_friction(skin, body.skin());
      for (int i = 0; i < mesh.n_nodes(); ++i) {
        const Vector3d& x = mesh.place_m[at(i)];
        if (!body.may_have(x) || mesh.held[at(i)] >= 0) continue;
        auto depth = body.depth_of(x);
        if (!depth) continue;
        double& spared = spared_m[at(i)];
        spared = std::min(spared, depth->depth_m);
        if (depth->depth_m -= spared; depth->depth_m > 0.0)
          add(mesh,
              {i, static_cast<int>(b), depth->depth_m, depth->out, mesh.velocity_m_s[at(i)] - body.velocity_at(x),
               friction, std::min(mesh.mass_kg_of[at(i)], body.mass_kg())},
              pushes);
      }
    }
  }
};

namespace {

/// Straight elements do not bend but shear: with n of them across, a bar was 1.73, 1.24 and 1.1 times too stiff for n = 2, 3, 4 and broke at loads that much too
/// high, about 1 + 6/n^3 (1.75, 1.22, 1.09).
void warn_of_stiff_bending(const SceneBody& body, double thinnest_m, const SceneNotes& notes) {
  if (!notes.warning || !(body.max_edge_m > 0.0)) return;
  const double across = std::max(1.0, std::round(thinnest_m / body.max_edge_m)), more = kBending / std::pow(across, 3);
  if (!(more > kBendingToSay)) return;
  const std::string how =
      across > 1.0 ? "some " + std::to_string(std::lround(100.0 * more)) + " %" : std::string("several times");
  notes.warning("body " + body.name + ": with " + to_text(across) + (across > 1.0 ? " edges" : " edge") +
                " across where it is thinnest its mesh bends " + how +
                " too stiffly there, and breaks in bending at loads that much too high: a smaller max_edge_m");
}

}  // namespace

DeformingBody::DeformingBody(const Scene& scene, int row, const rigid::RigidBodySpec& spec, std::uint64_t seed,
                             const SceneNotes& notes, Monitor& monitor)
    : row_(row), name_(scene.bodies[at(row)].name), shapes_(row, scene.frames.wanted() ? scene.frames.rate_hz : 0.0) {
  const SceneBody& body = scene.bodies[at(row)];
  const SceneMaterial& material = scene.material_of(body);
  const mesh::TetMesh mesh = crack_mesh_of(body, seed + at(row), notes, monitor);
  warn_of_stiff_bending(body, 2.0 * spec.smallest_half_width_m(), notes);
  const std::vector<HeldNodes> holds = held_nodes_of(scene, row, mesh);
  located(body.place, [&] {
    // The mass of the shape itself, which chords of round shapes do not fill.
    fracture::SolidOptions options;
    options.material = material.elastic;
    options.material.density_kg_m3 = spec.mass_kg / mesh::mass_properties(mesh).volume_m3;
    fracture::CrackMesh cracks(mesh, options.material.density_kg_m3);
    n_elements_start_ = cracks.n_elements();
    const Matrix3d turn = spec.orientation.toRotationMatrix();
    const Vector3d centre = spec.position_m + turn * spec.centre_m;
    for (std::size_t i = 0; i < cracks.rest_m.size(); ++i) {
      cracks.place_m[i] = spec.position_m + turn * cracks.rest_m[i];
      cracks.velocity_m_s[i] = spec.velocity_m_s + spec.angular_velocity_rad_s.cross(cracks.place_m[i] - centre);
    }
    // Masses at corners have a larger moment of inertia than the body, of second order in the edges.
    const Vector3d& spin = spec.angular_velocity_rad_s;
    const double own_j = 0.5 * spin.dot(turn * (spec.inertia_kg_m2 * (turn.transpose() * spin)));
    for (std::size_t i = 0; i < cracks.rest_m.size(); ++i)
      lumped_j_ += 0.5 * cracks.mass_kg_of[i] * spin.cross(cracks.place_m[i] - centre).squaredNorm();
    lumped_j_ -= own_j;
    if (notes.warning && lumped_j_ > kInertiaToSay * own_j)
      notes.warning("body " + name_ + ": the masses of its mesh have " +
                    std::to_string(std::lround(100.0 * lumped_j_ / own_j)) +
                    " % more moment of inertia about its spin than its shape (correction_j has that energy): a smaller "
                    "max_edge_m");
    std::vector<fracture::HoldPath> paths;
    for (const HeldNodes& held : holds) {
      for (const int node : held.nodes) cracks.held[at(node)] = static_cast<int>(paths.size());
      paths.push_back(held.hold->path);
      paths.back().set_start_velocity(cracks.velocity_m_s[at(held.nodes.front())]);
    }
    options.viscosity_lambda_pa_s = body.crack.viscosity_lambda_pa_s;
    options.viscosity_mu_pa_s = body.crack.viscosity_mu_pa_s;
    options.integrator = body.crack.integrator;
    if (body.crack.crack.total_stress) options.damping_cap = 0.0;  // literature = "paper"
    options.gravity_m_s2 = scene.solver.gravity_m_s2;
    options.self_contact = body.crack.self_contact;
    options.self_friction = rigid::pair_friction(spec.skin, spec.skin);
    options.plasticity = fracture::read_plasticity(body.crack.plasticity, material.elastic,
                                                   {"gamma1", "gamma2", "yield_stress_pa", "plastic_strain_limit"});
    pressing_ = std::make_unique<Pressing>(Pressing{scene, spec.skin, 0.0, 0.0, nullptr, {}, {}});
    solid_ = std::make_unique<fracture::ExplicitSolid>(
        std::move(cracks), options, std::move(paths),
        [pressing = pressing_.get()](const fracture::CrackMesh& m, double, std::vector<fracture::NodePush>& pushes) {
          (*pressing)(m, pushes);
        });
    pressing_->step_s = solid_->step_limit_s();
    pressing_->rate_sq = 0.1 / (pressing_->step_s * pressing_->step_s);
    solid_->refresh();
    cracker_ = std::make_unique<fracture::Cracker>(*solid_, body.crack.crack);
    strength_ = body.crack.crack.strength_pa;
    heard_ = body.sounds();
    touched_.assign(at(solid_->mesh().n_nodes()), 0);
    return 0;
  });
  shapes_.keep(solid_->mesh(), 0.0);
}
DeformingBody::~DeformingBody() = default;

Eigen::AlignedBox3d DeformingBody::box() const {
  Eigen::AlignedBox3d box;
  for (const Vector3d& x : solid_->mesh().place_m) box.extend(x);
  return box;
}

const rigid::Skin& DeformingBody::skin() const { return pressing_->skin; }

void DeformingBody::begin(double until_s, std::vector<PressedBody>& pressed) {
  steps_s_.push_back({solid_->time_s(), until_s});
  pressing_on_ = pressing_->bodies = &pressed;
  pushes_.clear();
  own_pushes_.clear();
}

void DeformingBody::note_pushes(double dt_s) {
  for (std::size_t k = 0; k < solid_->pushes().size(); ++k) {
    const fracture::NodePush& push = solid_->pushes()[k];
    const int target = pressing_->targets[k];
    const Vector3d impulse = dt_s * (push.normal_n + push.friction_n);
    if (target >= 0) {
      PressedBody& other = (*pressing_on_)[at(target)];
      const Vector3d& place = solid_->mesh().place_m[at(push.node)];
      other.push(place, -dt_s * push.normal_n);
      if (!push.friction_n.isZero(0.0)) other.rub(place, -dt_s * push.friction_n);
    }
    pushes_.try_emplace({push.node, target < 0 ? -1 : (*pressing_on_)[at(target)].body()}, Vector3d::Zero())
        .first->second += impulse;
  }
  if (const fracture::ElementContact* own = solid_->self_contact())
    for (const fracture::ElementTouch& touch : own->last().touches)
      own_pushes_.try_emplace(touch.elements, Vector3d::Zero()).first->second += dt_s * touch.force_n;
}

double DeformingBody::step_limit_s() const {
  const double limit = solid_->step_limit_s();
  if (!(limit >= kSmallestStepS) || solid_->mesh().n_elements() > kMostElements)
    throw NumericalError("body " + name_ + ": steps of " + to_text(limit) + " s, " +
                         std::to_string(solid_->mesh().n_elements()) + " elements: the cracks have made it too fine");
  return limit;
}

void DeformingBody::go(double dt_s) {
  pressing_->step_s = dt_s;
  note_pushes(solid_->options().integrator == fracture::Integrator::kLeapfrog ? 0.5 * dt_s : dt_s);
  solid_->go(dt_s);
}

void DeformingBody::arrive() {
  try {
    solid_->arrive();
  } catch (const NumericalError& error) {
    throw NumericalError("body " + name_ + ": " + error.what());
  }
  shapes_.keep(solid_->mesh(), solid_->time_s());
  if (solid_->options().integrator == fracture::Integrator::kLeapfrog) note_pushes(0.5 * pressing_->step_s);
}

bool DeformingBody::open() {
  const std::size_t faces_before = cracker_->faces().size();
  const int n = cracker_->open(*solid_);
  if (n == 0) return false;
  double area = 0.0;
  for (std::size_t f = faces_before; f < cracker_->faces().size(); ++f) area += cracker_->faces()[f].area_m2;
  note_splits(n, area);
  return true;
}

void DeformingBody::end() {
  const auto [begin_s, until_s] = steps_s_.back();
  pressed_ = pressed_ || !pushes_.empty();
  std::vector<char> touched(at(solid_->mesh().n_nodes()), 0);
  for (const auto& [key, impulse] : pushes_) {
    const bool before = at(key.first) < touched_.size() && touched_[at(key.first)] != 0;
    contacts_.push_back({begin_s, until_s - begin_s, key.first, key.second, -1, !before, impulse});
    touched[at(key.first)] = 1;
  }
  note_pieces(until_s);
  add_own_contacts(touched);
  touched_ = std::move(touched);
}

void DeformingBody::advance(double until_s, std::vector<PressedBody>& pressed) {
  begin(until_s, pressed);
  while (until_s - solid_->time_s() > 1e-12 * std::max(1.0, until_s)) {
    const double left = until_s - solid_->time_s(), limit = step_limit_s();
    const double dt = left <= limit ? left : left / std::ceil(left / limit);
    go(dt);
    for (PressedBody& body : pressed) body.advance(dt);
    arrive();
    open();
  }
  end();
}

int DeformingBody::piece_of(int node) const { return versions_.empty() ? 0 : versions_.back().piece_of_node[at(node)]; }

void DeformingBody::note_pieces(double until_s) {
  if (solid_->mesh().n_changes() == changes_seen_) return;
  changes_seen_ = solid_->mesh().n_changes();
  Version version;
  version.time_s = until_s;
  version.piece_of_node.assign(at(solid_->mesh().n_nodes()), 0);
  const std::vector<int> piece = solid_->mesh().fragments(version.n_pieces);
  for (int e = 0; e < solid_->mesh().n_elements(); ++e)
    for (const int node : solid_->mesh().nodes_of(e)) version.piece_of_node[at(node)] = piece[at(e)];
  n_pieces_ = version.n_pieces;
  if (n_pieces_ > 1 && !broken_s_) broken_s_ = until_s;
  if (!splits_.empty() && !cracked_s_) cracked_s_ = until_s;
  if (!splits_.empty()) splits_.back().pieces = n_pieces_;
  versions_.push_back(std::move(version));
}

/// One contact for each pair of pieces, where the elements are that push most.
void DeformingBody::add_own_contacts(std::vector<char>& touched) {
  if (n_pieces_ < 2) return;
  struct Pushing {
    Contact contact;
    double largest = -1.0;
  };
  std::map<std::array<int, 2>, Pushing> pieces;
  const std::vector<int>& piece_of = versions_.back().piece_of_node;
  for (const auto& [elements, impulse] : own_pushes_) {
    std::array<int, 2> node = {solid_->mesh().nodes_of(elements[0])[0], solid_->mesh().nodes_of(elements[1])[0]};
    std::array<int, 2> piece = {piece_of[at(node[0])], piece_of[at(node[1])]};
    if (piece[0] == piece[1]) continue;
    const bool turned = piece[0] > piece[1];
    if (turned) {
      std::swap(piece[0], piece[1]);
      std::swap(node[0], node[1]);
    }
    Pushing& pushing = pieces[piece];
    pushing.contact.impulse_n_s += turned ? Vector3d(-impulse) : impulse;
    if (!(impulse.norm() > pushing.largest)) continue;
    pushing.largest = impulse.norm();
    pushing.contact.node = node[0];
    pushing.contact.other_node = node[1];
  }
  for (auto& [piece, pushing] : pieces) {
    Contact& contact = pushing.contact;
    contact.time_s = steps_s_.back()[0];
    contact.duration_s = steps_s_.back()[1] - contact.time_s;
    contact.is_new = at(contact.node) >= touched_.size() || touched_[at(contact.node)] == 0;
    contacts_.push_back(contact);
    touched[at(contact.node)] = 1;
  }
}

void DeformingBody::note_splits(int n, double area_m2) {
  const double now = solid_->time_s();
  if (splits_.empty() || splits_.back().time_s != now)
    splits_.push_back({now, 0.0, {}, row_, 0, n_pieces_, solid_->energies()});
  splits_.back().n += n;
  splits_.back().crack_area_m2 += area_m2;
  if (strength_) splits_.back().largest_stress_pa = cracker_->last_over() * *strength_;
}

void DeformingBody::keep_frames(double pose_rate_hz) {
  const double now = solid_->time_s();
  const bool due = now >= next_pose_s_ - 1e-12;
  if (!due && !pressed_) return;
  pressed_ = false;
  if (due) next_pose_s_ = now + 1.0 / pose_rate_hz;
  const fracture::CrackMesh& mesh = solid_->mesh();
  std::vector<std::vector<int>> nodes(at(n_pieces_));
  if (versions_.empty()) {
    nodes[0] = all_nodes(mesh);
  } else {
    for (int i = 0; i < mesh.n_nodes(); ++i) nodes[at(versions_.back().piece_of_node[at(i)])].push_back(i);
  }
  for (int piece = 0; piece < n_pieces_; ++piece) {
    Kept kept{versions_.empty() ? 0 : versions_.size() - 1, piece, fitted_frame(mesh, nodes[at(piece)]).pose};
    kept.pose.time_s = now;
    frames_.push_back(kept);
  }
}

}  // namespace klang::scene::detail
