#include "core/physics/fracture/dynamic/element_contact.hpp"

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

ElementContact::ElementContact(Pairs which, double rate_sq_per_s2, Friction friction)
    : which_(which), rate_sq_per_s2_(rate_sq_per_s2), friction_(std::move(friction)) {}

void ElementContact::Elements::read(const CrackMesh& mesh) {
  changes_seen = mesh.n_changes();
  const std::size_t n = at(mesh.n_elements());
  struct Face {
    std::array<int, 3> nodes;
    int element;
    double area;
  };
  std::vector<Face> faces;
  faces.reserve(4 * n);
  area.assign(n, 0.0);
  free_area.assign(n, 0.0);
  share.assign(n, 0.0);
  size_m = 0.0;
  for (std::size_t e = 0; e < n; ++e) {
    const std::array<int, 4> nodes = mesh.nodes_of(static_cast<int>(e));
    const double volume = mesh.volume_m3(static_cast<int>(e));
    share[e] = 0.25 * mesh.density_kg_m3() * volume;
    size_m += std::cbrt(6.0 * volume);
    for (std::size_t k = 0; k < 4; ++k) {
      Face face{{nodes[(k + 1) % 4], nodes[(k + 2) % 4], nodes[(k + 3) % 4]}, static_cast<int>(e), 0.0};
      const Vector3d &p = mesh.rest_m[at(face.nodes[0])], &q = mesh.rest_m[at(face.nodes[1])],
                     &r = mesh.rest_m[at(face.nodes[2])];
      face.area = 0.5 * (q - p).cross(r - p).norm();
      area[e] = std::max(area[e], face.area);
      std::sort(face.nodes.begin(), face.nodes.end());
      faces.push_back(face);
    }
  }
  size_m /= static_cast<double>(n);
  std::sort(faces.begin(), faces.end(), [](const Face& a, const Face& b) { return a.nodes < b.nodes; });
  has_free_face.assign(n, 0);
  for (std::size_t i = 0; i < faces.size();) {
    const bool twice = i + 1 < faces.size() && faces[i].nodes == faces[i + 1].nodes;
    if (!twice) {
      const std::size_t e = at(faces[i].element);
      has_free_face[e] = 1;
      free_area[e] = std::max(free_area[e], faces[i].area);
    }
    i += twice ? 2 : 1;
  }
}

/// Keys of pairs whose boxes, made larger by half the margin, intersect; ascending.
std::vector<std::array<int, 4>> ElementContact::near_pairs(const Meshes& meshes) const {
  std::vector<detail::BoxTree> trees;
  for (std::size_t m = 0; m < meshes.size(); ++m) {
    const CrackMesh& mesh = *meshes[m];
    std::vector<std::pair<int, Eigen::AlignedBox3d>> boxes;
    for (int e = 0; e < mesh.n_elements(); ++e) {
      if (elements_[m].has_free_face[at(e)] == 0) continue;
      Eigen::AlignedBox3d box;
      for (const int node : mesh.nodes_of(e)) box.extend(mesh.place_m[at(node)]);
      box.min().array() -= 0.5 * margin_m_;
      box.max().array() += 0.5 * margin_m_;
      boxes.emplace_back(e, box);
    }
    trees.emplace_back(std::move(boxes));
  }
  std::vector<std::array<int, 4>> keys;
  const int n = static_cast<int>(trees.size());
  for (int a = 0; a < n; ++a) {
    if (which_ == Pairs::kOwn)
      for (const auto& [e, f] : trees[at(a)].pairs())
        if (!share_a_node(*meshes[at(a)], e, f)) keys.push_back({a, a, e, f});
    for (int b = a + 1; which_ == Pairs::kOfOthers && b < n; ++b)
      for (const auto& [e, f] : trees[at(a)].pairs_with(trees[at(b)])) keys.push_back({a, b, e, f});
  }
  return keys;
}

void ElementContact::find_pairs(const Meshes& meshes) {
  const bool is_first = elements_.empty();
  elements_.resize(meshes.size());
  std::vector<char> is_cut(meshes.size(), 0);
  double size_m = 0.0, n_all = 0.0;
  for (std::size_t m = 0; m < meshes.size(); ++m) {
    is_cut[m] = elements_[m].changes_seen != meshes[m]->n_changes() ? 1 : 0;
    if (is_cut[m] != 0) elements_[m].read(*meshes[m]);
    size_m += elements_[m].size_m * static_cast<double>(meshes[m]->n_elements());
    n_all += static_cast<double>(meshes[m]->n_elements());
  }
  margin_m_ = kMargin * size_m / n_all;
  if (is_first) {
    modulus_pa_m_ = HUGE_VAL;
    for (std::size_t m = 0; m < meshes.size(); ++m)
      for (int e = 0; e < meshes[m]->n_elements(); ++e)
        if (elements_[m].has_free_face[at(e)] != 0)
          modulus_pa_m_ = std::min(modulus_pa_m_, modulus_pa_m(static_cast<int>(m), e));
  }
  std::vector<Pair> pairs;
  auto old = pairs_.begin();
  for (const std::array<int, 4>& key : near_pairs(meshes)) {
    const auto& [a, b, e, f] = key;
    Pair pair;
    while (old != pairs_.end() && old->key < key) ++old;
    // What cuts leave of an element lies within what it was: gaps stay.
    if (old != pairs_.end() && old->key == key) {
      pair = *old;
    } else {
      pair.key = key;
      pair.is_new = (is_cut[at(a)] != 0 || is_cut[at(b)] != 0) && !is_first;
    }
    // A face that is covered gives its three corners a third each: the squared rate is kappa A^2/3 (1/m_a + 1/m_b).
    const Elements &mine = elements_[at(a)], &theirs = elements_[at(b)];
    const double area = std::min(mine.area[at(e)], theirs.area[at(f)]);
    pair.kappa = 3.0 * rate_sq_per_s2_ / (area * area * (1.0 / mine.share[at(e)] + 1.0 / theirs.share[at(f)]));
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

void ElementContact::wake() {
  const std::size_t n = awake_.size();
  while (!asleep_.empty() && asleep_.top().at_m <= travel_m_) {
    awake_.push_back(asleep_.top().pair);
    asleep_.pop();
  }
  std::sort(awake_.begin() + static_cast<std::ptrdiff_t>(n), awake_.end());
  std::inplace_merge(awake_.begin(), awake_.begin() + static_cast<std::ptrdiff_t>(n), awake_.end());
}

/// k of an element: a face that is covered gives its three corners a third each, and the other side moves as much.
double ElementContact::modulus_pa_m(int mesh, int element) const {
  const Elements& elements = elements_[at(mesh)];
  const double most = 1.5 * rate_sq_per_s2_ * elements.share[at(element)] / elements.free_area[at(element)];
  return std::min(most, modulus_pa_m_);
}

/// Each pair has half the pressure of either element.
void ElementContact::push_bodies(const Meshes& meshes) {
  common_m3_.clear();
  for (const auto& [i, overlap] : common_) {
    const std::array<int, 4>& key = pairs_[i].key;
    common_m3_[{key[0], key[2]}] += overlap.volume_m3;
    common_m3_[{key[1], key[3]}] += overlap.volume_m3;
  }
  const auto pressure_of = [&](int mesh, int element) {
    return 0.5 * modulus_pa_m(mesh, element) * common_m3_.at({mesh, element}) /
           elements_[at(mesh)].free_area[at(element)];
  };
  for (const auto& [which, volume] : common_m3_) forces_.energy_j += 0.5 * pressure_of(which[0], which[1]) * volume;
  for (const auto& [i, overlap] : common_) {
    const auto& [a, b, e, f] = pairs_[i].key;
    push(meshes, pairs_[i], overlap, pressure_of(a, e) + pressure_of(b, f));
  }
}

void ElementContact::push(const Meshes& meshes, const Pair& pair, const TetOverlap& overlap, double pressure) {
  ElementTouch touch{{pair.key[0], pair.key[1]}, {pair.key[2], pair.key[3]}, overlap.centre_m, Vector3d::Zero()};
  Rubbing rubbing;
  for (std::size_t side = 0; side < 2; ++side) {
    const std::size_t m = at(touch.meshes[side]);
    const CrackMesh& mesh = *meshes[m];
    std::vector<Vector3d>& normal_n = forces_.of[m].normal_n;
    const std::array<int, 4> nodes = mesh.nodes_of(touch.elements[side]);
    const Eigen::Vector4d weight = weights_at(corners_of(mesh, touch.elements[side]), overlap.centre_m);
    for (std::size_t k = 0; k < 4; ++k) {
      const std::size_t node = at(nodes[k]);
      const Vector3d force = -pressure * overlap.gradient_m2[4 * side + k];
      if (normal_n[node].isZero(0.0)) pushed_.push_back({m, node});
      normal_n[node] += force;
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
void ElementContact::rub(const Meshes& meshes, double dt_s) {
  weight_sums_.resize(meshes.size());
  for (std::size_t m = 0; m < meshes.size(); ++m) weight_sums_[m].resize(at(meshes[m]->n_nodes()), 0.0);
  for (std::size_t i = 0; i < rubbing_.size(); ++i)
    for (std::size_t k = 0; k < 8; ++k)
      weight_sums_[at(forces_.touches[i].meshes[k / 4])][at(rubbing_[i].nodes[k])] += std::abs(rubbing_[i].weight[k]);
  for (std::size_t i = 0; i < rubbing_.size(); ++i) {
    const Rubbing& r = rubbing_[i];
    ElementTouch& touch = forces_.touches[i];
    const double friction = friction_(touch.meshes[0], touch.meshes[1]);
    Vector3d slide = Vector3d::Zero();  // of the first on the second
    double inverse_mass = 0.0;
    for (std::size_t k = 0; k < 8; ++k) {
      const std::size_t node = at(r.nodes[k]), m = at(touch.meshes[k / 4]);
      slide += (k < 4 ? r.weight[k] : -r.weight[k]) * meshes[m]->velocity_m_s[node];
      inverse_mass += std::abs(r.weight[k]) * weight_sums_[m][node] / meshes[m]->mass_kg_of[node];
    }
    const double push_n = touch.force_n.norm();
    if (!(push_n > 0.0 && friction > 0.0)) continue;
    slide -= slide.dot(touch.force_n) / (push_n * push_n) * touch.force_n;
    const double speed = slide.norm(), most = speed / (inverse_mass * dt_s);
    if (!(speed > 0.0)) continue;
    const Vector3d drag = -std::min(friction * push_n, most) / speed * slide;
    for (std::size_t k = 0; k < 8; ++k)
      forces_.of[at(touch.meshes[k / 4])].friction_n[at(r.nodes[k])] += (k < 4 ? r.weight[k] : -r.weight[k]) * drag;
    touch.force_n += drag;
  }
  for (std::size_t i = 0; i < rubbing_.size(); ++i)
    for (std::size_t k = 0; k < 8; ++k)
      weight_sums_[at(forces_.touches[i].meshes[k / 4])][at(rubbing_[i].nodes[k])] = 0.0;
}

void ElementContact::note_travel(const Meshes& meshes) {
  place_before_.resize(meshes.size());
  Vector3d mean = Vector3d::Zero();
  std::size_t n = 0;
  for (std::size_t m = 0; m < meshes.size(); ++m) {
    for (std::size_t i = 0; i < place_before_[m].size(); ++i) mean += meshes[m]->place_m[i] - place_before_[m][i];
    n += place_before_[m].size();
  }
  if (n > 0) mean /= static_cast<double>(n);
  double moved_sq = 0.0;
  for (std::size_t m = 0; m < meshes.size(); ++m)
    for (std::size_t i = 0; i < place_before_[m].size(); ++i)
      moved_sq = std::max(moved_sq, (meshes[m]->place_m[i] - place_before_[m][i] - mean).squaredNorm());
  travel_m_ += 2.0 * std::sqrt(moved_sq);
  for (std::size_t m = 0; m < meshes.size(); ++m) place_before_[m] = meshes[m]->place_m;
}

void ElementContact::clear(const Meshes& meshes) {
  for (const auto& [m, node] : pushed_)
    forces_.of[m].normal_n[node] = forces_.of[m].friction_n[node] = Vector3d::Zero();
  pushed_.clear();
  rubbing_.clear();
  common_.clear();
  forces_.touches.clear();
  forces_.energy_j = 0.0;
  forces_.of.resize(meshes.size());
  for (std::size_t m = 0; m < meshes.size(); ++m) {
    forces_.of[m].normal_n.resize(at(meshes[m]->n_nodes()), Vector3d::Zero());
    forces_.of[m].friction_n.resize(at(meshes[m]->n_nodes()), Vector3d::Zero());
  }
}

/// Pushes where two elements have something in common. Returns how far they lie apart; 0 or less: they may touch.
double ElementContact::look_at(const Meshes& meshes, Pair& pair) {
  const auto& [m, n, first, second] = pair.key;
  const TetCorners a = corners_of(*meshes[at(m)], first), b = corners_of(*meshes[at(n)], second);
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
      if (pair.is_new && m == n && were_neighbours(*meshes[at(m)], first, second)) pair.spared_m3 = overlap->volume_m3;
      pair.spared_m3 = std::min(pair.spared_m3, overlap->volume_m3);
      const double beyond = overlap->volume_m3 - pair.spared_m3;
      if (which_ == Pairs::kOfOthers) {
        common_.emplace_back(static_cast<std::size_t>(&pair - pairs_.data()), *overlap);
      } else if (beyond > 0.0) {
        forces_.energy_j += 0.5 * pair.kappa * beyond * beyond;
        push(meshes, pair, *overlap, pair.kappa * beyond);
      }
    }
  } else {
    pair.spared_m3 = 0.0;
  }
  pair.is_new = false;
  return gap_m;
}

const ElementContact::Forces& ElementContact::forces(const Meshes& meshes, double dt_s) {
  note_travel(meshes);
  clear(meshes);
  bool is_cut = elements_.empty();
  for (std::size_t m = 0; !is_cut && m < meshes.size(); ++m)
    is_cut = elements_[m].changes_seen != meshes[m]->n_changes();
  if (is_cut || !(travel_m_ < valid_to_m_)) find_pairs(meshes);
  wake();
  std::size_t kept = 0;
  for (const std::size_t i : awake_) {
    Pair& pair = pairs_[i];
    const double gap_m = look_at(meshes, pair);
    if (gap_m > 0.0) {
      pair.due_m = travel_m_ + gap_m;
      if (pair.due_m <= valid_to_m_) asleep_.push({pair.due_m, i});
    } else {
      pair.due_m = travel_m_;
      awake_[kept++] = i;
    }
  }
  awake_.resize(kept);
  push_bodies(meshes);
  if (!rubbing_.empty()) rub(meshes, dt_s);
  return forces_;
}

}  // namespace klang::fracture
