#include "core/physics/fracture/dynamic/self_contact.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "core/physics/fracture/dynamic/detail/at.hpp"
#include "core/physics/fracture/dynamic/detail/box_tree.hpp"

namespace klang::fracture {
namespace {

using detail::at;
using Eigen::Vector3d;

constexpr double kMargin = 0.3;  ///< of the mean size of elements, by which boxes are larger

TetCorners corners_of(const CrackMesh& mesh, int element) {
  TetCorners corners;
  const std::array<int, 4> nodes = mesh.nodes_of(element);
  for (std::size_t k = 0; k < 4; ++k) corners[k] = mesh.place_m[at(nodes[k])];
  return corners;
}

/// Whether two elements that share no node have corners at one place of the rest shape: a crack has parted them.
bool were_neighbours(const CrackMesh& mesh, int a, int b) {
  for (const int i : mesh.nodes_of(a))
    for (const int j : mesh.nodes_of(b))
      if (mesh.rest_m[at(i)] == mesh.rest_m[at(j)]) return true;
  return false;
}

bool share_a_node(const CrackMesh& mesh, int a, int b) {
  const std::array<int, 4> mine = mesh.nodes_of(a), theirs = mesh.nodes_of(b);
  for (const int i : mine)
    for (const int j : theirs)
      if (i == j) return true;
  return false;
}

/// Shape functions of an element at a place.
Eigen::Vector4d weights_at(const TetCorners& c, const Vector3d& x) {
  Eigen::Matrix3d edges;
  for (int k = 0; k < 3; ++k) edges.col(k) = c[at(k + 1)] - c[0];
  const Vector3d w = edges.inverse() * (x - c[0]);
  return {1.0 - w.sum(), w[0], w[1], w[2]};
}

}  // namespace

void SelfContact::read_elements(const CrackMesh& mesh) {
  const std::size_t n = at(mesh.n_elements());
  struct Face {
    std::array<int, 3> nodes;
    int element;
  };
  std::vector<Face> faces;
  faces.reserve(4 * n);
  area_.assign(n, 0.0);
  share_.assign(n, 0.0);
  double size_m = 0.0;
  for (std::size_t e = 0; e < n; ++e) {
    const std::array<int, 4> nodes = mesh.nodes_of(static_cast<int>(e));
    const double volume = mesh.volume_m3(static_cast<int>(e));
    share_[e] = 0.25 * mesh.density_kg_m3() * volume;
    size_m += std::cbrt(6.0 * volume);
    for (std::size_t k = 0; k < 4; ++k) {
      Face face{{nodes[(k + 1) % 4], nodes[(k + 2) % 4], nodes[(k + 3) % 4]}, static_cast<int>(e)};
      const Vector3d &p = mesh.rest_m[at(face.nodes[0])], &q = mesh.rest_m[at(face.nodes[1])],
                     &r = mesh.rest_m[at(face.nodes[2])];
      area_[e] = std::max(area_[e], 0.5 * (q - p).cross(r - p).norm());
      std::sort(face.nodes.begin(), face.nodes.end());
      faces.push_back(face);
    }
  }
  margin_m_ = kMargin * size_m / static_cast<double>(n);
  std::sort(faces.begin(), faces.end(), [](const Face& a, const Face& b) { return a.nodes < b.nodes; });
  has_free_face_.assign(n, 0);
  for (std::size_t i = 0; i < faces.size();) {
    const bool twice = i + 1 < faces.size() && faces[i].nodes == faces[i + 1].nodes;
    if (!twice) has_free_face_[at(faces[i].element)] = 1;
    i += twice ? 2 : 1;
  }
}

void SelfContact::find_pairs(const CrackMesh& mesh) {
  const bool is_cut = changes_seen_ != mesh.n_changes(), is_first = changes_seen_ < 0;
  if (is_cut) read_elements(mesh);
  changes_seen_ = mesh.n_changes();
  std::vector<std::pair<int, Eigen::AlignedBox3d>> boxes;
  for (int e = 0; e < mesh.n_elements(); ++e) {
    if (has_free_face_[at(e)] == 0) continue;
    Eigen::AlignedBox3d box;
    for (const int node : mesh.nodes_of(e)) box.extend(mesh.place_m[at(node)]);
    box.min().array() -= 0.5 * margin_m_;
    box.max().array() += 0.5 * margin_m_;
    boxes.emplace_back(e, box);
  }
  std::vector<Pair> pairs;
  auto old = pairs_.begin();
  for (const auto& [a, b] : detail::BoxTree(std::move(boxes)).pairs()) {
    if (share_a_node(mesh, a, b)) continue;
    Pair pair;
    while (old != pairs_.end() && std::pair(old->first, old->second) < std::pair(a, b)) ++old;
    // What cuts leave of an element lies within what it was: gaps stay.
    if (old != pairs_.end() && old->first == a && old->second == b) {
      pair = *old;
    } else {
      pair.first = a;
      pair.second = b;
      pair.is_new = is_cut && !is_first;
    }
    // A face that is covered gives its three corners a third each: the squared rate is kappa A^2/3 (1/m_a + 1/m_b).
    const double area = std::min(area_[at(a)], area_[at(b)]);
    pair.kappa = 3.0 * rate_sq_per_s2_ / (area * area * (1.0 / share_[at(a)] + 1.0 / share_[at(b)]));
    pairs.push_back(pair);
  }
  pairs_ = std::move(pairs);
  valid_to_m_ = travel_m_ + margin_m_;
  awake_.clear();
  asleep_ = {};
  for (std::size_t i = 0; i < pairs_.size(); ++i) {
    if (pairs_[i].due_m <= travel_m_) {
      awake_.push_back(i);
    } else if (pairs_[i].due_m <= valid_to_m_) {
      asleep_.push({pairs_[i].due_m, i});
    }
  }
}

void SelfContact::wake() {
  const std::size_t n = awake_.size();
  while (!asleep_.empty() && asleep_.top().at_m <= travel_m_) {
    awake_.push_back(asleep_.top().pair);
    asleep_.pop();
  }
  std::sort(awake_.begin() + static_cast<std::ptrdiff_t>(n), awake_.end());
  std::inplace_merge(awake_.begin(), awake_.begin() + static_cast<std::ptrdiff_t>(n), awake_.end());
}

void SelfContact::push(const CrackMesh& mesh, const Pair& pair, const TetOverlap& overlap) {
  const double beyond = overlap.volume_m3 - pair.spared_m3, pressure = pair.kappa * beyond;
  forces_.energy_j += 0.5 * pressure * beyond;
  const std::array<int, 2> elements = {pair.first, pair.second};
  ElementTouch touch{elements, overlap.centre_m, Vector3d::Zero()};
  Rubbing rubbing;
  for (std::size_t side = 0; side < 2; ++side) {
    const std::array<int, 4> nodes = mesh.nodes_of(elements[side]);
    const Eigen::Vector4d weight = weights_at(corners_of(mesh, elements[side]), overlap.centre_m);
    for (std::size_t k = 0; k < 4; ++k) {
      const std::size_t node = at(nodes[k]);
      const Vector3d force = -pressure * overlap.gradient_m2[4 * side + k];
      if (forces_.normal_n[node].isZero(0.0)) pushed_.push_back(nodes[k]);
      forces_.normal_n[node] += force;
      if (side == 0) touch.force_n += force;
      rubbing.nodes[4 * side + k] = nodes[k];
      rubbing.weight[4 * side + k] = weight[static_cast<Eigen::Index>(k)];
    }
  }
  rubbing_.push_back(rubbing);
  forces_.touches.push_back(touch);
}

/// Impulses J on touches change their slides by A J, A = W M^-1 W^T; what a touch takes at most is its slide over the sum of its row of |A|
/// or more, so that the energy that all take, J A J / 2 against J slide, never falls below 0.
void SelfContact::rub(const CrackMesh& mesh, double dt_s) {
  weight_sums_.resize(at(mesh.n_nodes()), 0.0);
  for (const Rubbing& r : rubbing_)
    for (std::size_t k = 0; k < 8; ++k) weight_sums_[at(r.nodes[k])] += std::abs(r.weight[k]);
  for (std::size_t i = 0; i < rubbing_.size(); ++i) {
    const Rubbing& r = rubbing_[i];
    ElementTouch& touch = forces_.touches[i];
    Vector3d slide = Vector3d::Zero();  // of the first on the second
    double inverse_mass = 0.0;
    for (std::size_t k = 0; k < 8; ++k) {
      const std::size_t node = at(r.nodes[k]);
      slide += (k < 4 ? r.weight[k] : -r.weight[k]) * mesh.velocity_m_s[node];
      inverse_mass += std::abs(r.weight[k]) * weight_sums_[node] / mesh.mass_kg_of[node];
    }
    const double push_n = touch.force_n.norm();
    if (!(push_n > 0.0)) continue;
    slide -= slide.dot(touch.force_n) / (push_n * push_n) * touch.force_n;
    const double speed = slide.norm(), most = speed / (inverse_mass * dt_s);
    if (!(speed > 0.0)) continue;
    const Vector3d drag = -std::min(friction_ * push_n, most) / speed * slide;
    for (std::size_t k = 0; k < 8; ++k)
      forces_.friction_n[at(r.nodes[k])] += (k < 4 ? r.weight[k] : -r.weight[k]) * drag;
    touch.force_n += drag;
  }
  for (const Rubbing& r : rubbing_)
    for (const int node : r.nodes) weight_sums_[at(node)] = 0.0;
}

const SelfContact::Forces& SelfContact::forces(const CrackMesh& mesh, double dt_s) {
  const std::size_t n = at(mesh.n_nodes());
  Vector3d mean = Vector3d::Zero();
  for (std::size_t i = 0; i < place_before_.size(); ++i) mean += mesh.place_m[i] - place_before_[i];
  if (!place_before_.empty()) mean /= static_cast<double>(place_before_.size());
  double moved_sq = 0.0;
  for (std::size_t i = 0; i < place_before_.size(); ++i)
    moved_sq = std::max(moved_sq, (mesh.place_m[i] - place_before_[i] - mean).squaredNorm());
  travel_m_ += 2.0 * std::sqrt(moved_sq);
  place_before_ = mesh.place_m;
  for (const int node : pushed_) forces_.normal_n[at(node)] = forces_.friction_n[at(node)] = Vector3d::Zero();
  pushed_.clear();
  rubbing_.clear();
  forces_.touches.clear();
  forces_.energy_j = 0.0;
  forces_.normal_n.resize(n, Vector3d::Zero());
  forces_.friction_n.resize(n, Vector3d::Zero());
  if (changes_seen_ != mesh.n_changes() || !(travel_m_ < valid_to_m_)) find_pairs(mesh);
  wake();
  std::size_t kept = 0;
  for (const std::size_t i : awake_) {
    Pair& pair = pairs_[i];
    const TetCorners a = corners_of(mesh, pair.first), b = corners_of(mesh, pair.second);
    if (pair.axis < 0) pair.axis = widest_axis(a, b, true);
    double gap_m = gap_along_m(a, b, pair.axis);
    if (!(gap_m > 0.0)) {
      pair.axis = widest_axis(a, b, true);
      gap_m = gap_along_m(a, b, pair.axis);
    }
    if (!(gap_m > 0.0)) {
      const auto overlap = tet_overlap(a, b);
      if (!overlap) {
        pair.axis = widest_axis(a, b, false);
        gap_m = gap_along_m(a, b, pair.axis);
        pair.spared_m3 = 0.0;
      } else {
        if (pair.is_new && were_neighbours(mesh, pair.first, pair.second)) pair.spared_m3 = overlap->volume_m3;
        pair.spared_m3 = std::min(pair.spared_m3, overlap->volume_m3);
        if (overlap->volume_m3 > pair.spared_m3) push(mesh, pair, *overlap);
      }
    } else {
      pair.spared_m3 = 0.0;
    }
    pair.is_new = false;
    if (gap_m > 0.0) {
      pair.due_m = travel_m_ + gap_m;
      if (pair.due_m <= valid_to_m_) asleep_.push({pair.due_m, i});
    } else {
      pair.due_m = travel_m_;
      awake_[kept++] = i;
    }
  }
  awake_.resize(kept);
  if (friction_ > 0.0) rub(mesh, dt_s);
  return forces_;
}

}  // namespace klang::fracture
