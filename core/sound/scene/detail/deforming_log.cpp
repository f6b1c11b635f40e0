// What a cracking body did, in the log of the motion.
#include <algorithm>
#include <cmath>

#include "core/physics/fracture/dynamic/part_meshes.hpp"
#include "core/sound/scene/detail/deforming_body.hpp"

namespace klang::scene::detail {
namespace {

using Eigen::Vector3d;

constexpr std::size_t kPullSteps = 25;  ///< over which a pull is taken to have risen
constexpr double kIntoLip =
    1e-3;  ///< of the way to the middle of its element: pulls at both lips of a slit have one place

std::size_t index(int i) { return static_cast<std::size_t>(i); }

Vector3d centre_of(const fracture::CrackMesh& mesh, int element) {
  Vector3d sum = Vector3d::Zero();
  for (const int node : mesh.nodes_of(element)) sum += mesh.rest_m[index(node)];
  return 0.25 * sum;
}

std::vector<int> nodes_of_all(const fracture::CrackMesh& mesh) {
  std::vector<int> nodes(index(mesh.n_nodes()));
  for (std::size_t i = 0; i < nodes.size(); ++i) nodes[i] = static_cast<int>(i);
  return nodes;
}

}  // namespace

std::vector<int> DeformingBody::add_to(const Scene& scene, SceneMotion& motion) const {
  const fracture::CrackMesh& mesh = solid_->mesh();
  const FittedFrame whole = fitted_frame(mesh, nodes_of_all(mesh));
  motion.final[index(row_)] = whole.state;
  std::vector<int> row_of_element(index(mesh.n_elements()), row_);
  std::vector<std::vector<int>> nodes(index(n_pieces_));
  std::vector<int> rows = {row_};
  const std::optional<double> broken = broken_s();
  if (broken) {
    rows.clear();
    const std::vector<int>& piece_of = versions_.back().piece_of_node;
    for (int i = 0; i < mesh.n_nodes(); ++i) nodes[index(piece_of[index(i)])].push_back(i);
    int n_pieces = 0;
    const std::vector<int> piece_of_element = mesh.fragments(n_pieces);
    std::vector<mesh::TetMesh> parts = fracture::part_meshes(mesh, scene.bodies[index(row_)].sounds());
    for (int p = 0; p < n_pieces_; ++p) {
      const FittedFrame frame = fitted_frame(mesh, nodes[index(p)]);
      rows.push_back(static_cast<int>(motion.log.bodies.size()));
      motion.log.bodies.push_back({scene.bodies[index(row_)].name + "/" + std::to_string(p + 1), row_});
      motion.mass_kg.push_back(frame.mass_kg);
      motion.final.push_back(frame.state);
      motion.pieces.push_back({rows.back(), row_, mesh::boundary_surface(parts[index(p)]), std::move(parts[index(p)])});
    }
    for (std::size_t e = 0; e < row_of_element.size(); ++e) row_of_element[e] = rows[index(piece_of_element[e])];
    motion.log.fractures.push_back({*broken, row_});
    if (scene.bodies[index(row_)].sounds() && scene.fracture.impulses) add_pulls(rows, piece_of_element, motion);
  }
  if (shapes_.n_bytes() > 0) motion.shapes.bodies.push_back(shapes_.shapes(row_of_element));
  // A piece's frames are those of the piece of then that held its oldest node.
  const auto is_broken = [&](double time_s) { return broken && time_s >= *broken; };
  std::vector<std::vector<int>> rows_then;  ///< of the pieces of a version
  std::size_t version_then = versions_.size();
  for (const Kept& kept : frames_) {
    events::Pose pose = kept.pose;
    pose.body = row_;
    if (!is_broken(pose.time_s) || pose.time_s == *broken) {
      if (kept.piece == 0) motion.log.poses.push_back(pose);
    }
    if (!is_broken(pose.time_s)) continue;
    if (version_then != kept.version) {
      version_then = kept.version;
      rows_then.assign(index(versions_[version_then].n_pieces), {});
      for (std::size_t p = 0; p < rows.size(); ++p)
        rows_then[index(piece_then(versions_[version_then], nodes[p].front()))].push_back(rows[p]);
    }
    for (const int piece_row : rows_then[index(kept.piece)]) {
      pose.body = piece_row;
      motion.log.poses.push_back(pose);
    }
  }
  for (const Contact& contact : contacts_) {
    auto impulse = impulse_of(contact, rows);
    if (!impulse) continue;
    if (contact.other_node >= 0) {
      if (!is_broken(contact.time_s)) continue;
      Contact opposite = contact;
      opposite.node = contact.other_node;
      opposite.impulse_n_s = -contact.impulse_n_s;
      auto theirs = impulse_of(opposite, rows);
      if (!theirs) continue;
      impulse->other = theirs->body;
      theirs->other = impulse->body;
      motion.log.impulses.push_back(*impulse);
      motion.log.impulses.push_back(*theirs);
      continue;
    }
    motion.log.impulses.push_back(*impulse);
    if (contact.other < 0) continue;
    events::Impulse opposite = *impulse;
    opposite.body = contact.other;
    opposite.other = impulse->body;
    const double end_s = contact.time_s + contact.duration_s;
    const events::Pose other = motion.log.motion_of(contact.other).at(end_s);
    opposite.point_m = other.to_body(frame_at(end_s, contact.node)->pose.to_world(impulse->point_m));
    opposite.impulse_n_s = other.orientation().conjugate() * Vector3d(-contact.impulse_n_s);
    motion.log.impulses.push_back(opposite);
  }
  return rows;
}

std::optional<events::Impulse> DeformingBody::impulse_of(const Contact& contact, const std::vector<int>& rows) const {
  // Its direction in the body's frame: by the frame that is kept at the end of the step.
  const Kept* used = frame_at(contact.time_s + contact.duration_s, contact.node);
  if (used == nullptr) return {};
  events::Impulse impulse;
  impulse.time_s = contact.time_s;
  impulse.duration_s = contact.duration_s;
  impulse.shape = events::PulseShape::kHeld;
  impulse.kind = contact.is_new ? events::ImpulseKind::kImpact : events::ImpulseKind::kLasting;
  const std::optional<double> broken = broken_s();
  const bool is_broken = broken && contact.time_s >= *broken;
  impulse.body = is_broken ? rows[index(piece_of(contact.node))] : row_;
  impulse.other = contact.other;
  impulse.point_m = solid_->mesh().rest_m[index(contact.node)];
  impulse.impulse_n_s = used->pose.orientation().conjugate() * contact.impulse_n_s;
  return impulse;
}

/// The frame that is kept next, of the piece of then that held a node; none: none is kept any more.
const DeformingBody::Kept* DeformingBody::frame_at(double time_s, int node) const {
  const auto frame = std::lower_bound(frames_.begin(), frames_.end(), time_s - 1e-9,
                                      [](const Kept& k, double t) { return k.pose.time_s < t; });
  if (frame == frames_.end()) return nullptr;
  if (versions_.empty()) return &*frame;
  // Those of all pieces are kept at once, in their order.
  const int piece = piece_then(versions_[frame->version], node);
  if (frames_.end() - frame <= piece) return &*frame;
  const auto own = frame + piece;
  return own->pose.time_s == frame->pose.time_s && own->piece == piece ? &*own : &*frame;
}

void DeformingBody::add_pulls(const std::vector<int>& row_of_piece, const std::vector<int>& piece_of_element,
                              SceneMotion& motion) const {
  const fracture::CrackMesh& mesh = solid_->mesh();
  for (const fracture::PartedFace& face : cracker_->faces()) {
    const std::array<int, 2> pieces = {piece_of_element[index(face.elements[0])],
                                       piece_of_element[index(face.elements[1])]};
    if (face.pull_n.isZero(0.0)) continue;
    const auto last = std::lower_bound(steps_s_.begin(), steps_s_.end(), face.time_s,
                                       [](const auto& step, double time_s) { return step[1] < time_s; });
    if (last == steps_s_.end()) continue;
    const auto n = static_cast<std::size_t>(last - steps_s_.begin()) + 1, first = n - std::min(n, kPullSteps);
    for (std::size_t k = first; k < n; ++k) {
      events::Impulse impulse;
      impulse.time_s = steps_s_[k][0];
      impulse.duration_s = steps_s_[k][1] - steps_s_[k][0];
      impulse.shape = events::PulseShape::kHeld;
      impulse.kind = events::ImpulseKind::kFracture;
      const double share = static_cast<double>(k + 1 - first) / static_cast<double>(n - first);
      for (std::size_t side = 0; side < 2; ++side) {
        impulse.body = row_of_piece[index(pieces[side])];
        impulse.other = row_of_piece[index(pieces[1 - side])];
        const Eigen::Vector3d pull = side == 0 ? face.pull_n : Eigen::Vector3d(-face.pull_n);
        impulse.point_m = face.centre_m + kIntoLip * (centre_of(mesh, face.elements[side]) - face.centre_m);
        const Kept* frame = frame_at(steps_s_[k][1], mesh.nodes_of(face.elements[side])[0]);
        if (frame == nullptr) continue;
        impulse.impulse_n_s = share * impulse.duration_s * (frame->pose.orientation().conjugate() * pull);
        motion.log.impulses.push_back(impulse);
      }
    }
  }
}

/// Nodes that were made since have the piece of what they were made of: the oldest node of a piece stands for it.
int DeformingBody::piece_then(const Version& version, int node) const {
  int now = node;
  while (index(now) >= version.piece_of_node.size()) now = solid_->mesh().made_of(now);
  return version.piece_of_node[index(now)];
}

}  // namespace klang::scene::detail
