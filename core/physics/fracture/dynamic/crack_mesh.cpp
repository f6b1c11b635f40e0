#include "core/physics/fracture/dynamic/crack_mesh.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <string>

#include "core/foundation/base/check.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/geometry/mesh/hanging_nodes.hpp"
#include "core/physics/fracture/dynamic/detail/at.hpp"

namespace klang::fracture {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

using detail::at;

/// Rest edges as columns; their inverse has the gradients of corners 1 to 3 as rows.
Matrix3d edges_of(const std::vector<Vector3d>& places, const std::array<int, 4>& nodes) {
  Matrix3d edges;
  for (int k = 0; k < 3; ++k) edges.col(k) = places[at(nodes[at(k + 1)])] - places[at(nodes[0])];
  return edges;
}

}  // namespace

CrackMesh::CrackMesh(const mesh::TetMesh& mesh, double density_kg_m3) : density_kg_m3_(density_kg_m3) {
  if (mesh.n_elements() == 0) throw InputError("mesh", "has no tetrahedra");
  mesh::refuse_hanging_nodes(mesh);
  for (int i = 0; i < mesh.n_nodes(); ++i) rest_m.push_back(mesh.nodes_m.row(i).transpose());
  place_m = rest_m;
  velocity_m_s.assign(rest_m.size(), Vector3d::Zero());
  mass_kg_of.assign(rest_m.size(), 0.0);
  held.assign(rest_m.size(), -1);
  stars_.resize(rest_m.size());
  for (int i = 0; i < n_nodes(); ++i) made_of_.push_back(i);
  for (int e = 0; e < mesh.n_elements(); ++e) {
    const std::array<int, 4> nodes = {mesh.elements(e, 0), mesh.elements(e, 1), mesh.elements(e, 2),
                                      mesh.elements(e, 3)};
    const Matrix3d edges = edges_of(rest_m, nodes);
    const double volume = edges.determinant() / 6.0, size = edges.colwise().norm().maxCoeff();
    if (!(volume > 1e-9 * size * size * size))
      throw InputError("mesh", "element " + std::to_string(e) + " is flat or inverted", to_text(volume) + " m3");
    const int element = add_element();
    set_element(element, nodes, edges.inverse(), volume);
    for (const int node : nodes) {
      stars_[at(node)].push_back(element);
      mass_kg_of[at(node)] += density_kg_m3_ * volume / 4.0;
    }
  }
  for (int i = 0; i < n_nodes(); ++i)
    if (stars_[at(i)].empty()) throw InputError("mesh", "has a node without elements", std::to_string(i));
}

std::array<int, 4> CrackMesh::nodes_of(int element) const {
  const ElementBlock& b = block(element);
  const int lane = element % kLanes;
  return {b.node[0][lane], b.node[1][lane], b.node[2][lane], b.node[3][lane]};
}

Matrix3d CrackMesh::beta_of(int element) const {
  Matrix3d beta;
  for (int i = 0; i < 9; ++i) beta(i / 3, i % 3) = block(element).beta[i][element % kLanes];
  return beta;
}

double CrackMesh::volume_m3(int element) const { return block(element).volume_m3[element % kLanes]; }

Sym CrackMesh::plastic_of(int element) const {
  Sym strain;
  for (std::size_t i = 0; i < 6; ++i) strain[i] = block(element).plastic[i][element % kLanes];
  return strain;
}

void CrackMesh::set_plastic(int element, const Sym& strain) {
  for (std::size_t i = 0; i < 6; ++i) block(element).plastic[i][element % kLanes] = strain[i];
}

void CrackMesh::set_damping_share(int element, double share) {
  block(element).damped_m3[element % kLanes] = share * volume_m3(element);
}

Matrix3d CrackMesh::gradient_of(int element) const { return edges_of(place_m, nodes_of(element)) * beta_of(element); }

double CrackMesh::mass_kg() const {
  double sum = 0.0;
  for (const double mass : mass_kg_of) sum += mass;
  return sum;
}

int CrackMesh::add_element() {
  if (n_elements_ % kLanes == 0) {
    ElementBlock empty{};
    for (int i = 0; i < 9; i += 4)
      for (double& value : empty.beta[i]) value = 1.0;
    blocks.push_back(empty);
  }
  return n_elements_++;
}

void CrackMesh::set_element(int element, const std::array<int, 4>& nodes, const Matrix3d& beta, double volume_m3) {
  ElementBlock& b = block(element);
  const int lane = element % kLanes;
  for (std::size_t k = 0; k < 4; ++k) b.node[k][lane] = nodes[k];
  for (int i = 0; i < 9; ++i) b.beta[i][lane] = beta(i / 3, i % 3);
  b.volume_m3[lane] = b.damped_m3[lane] = volume_m3;
}

int CrackMesh::add_node_like(int node) {
  rest_m.push_back(Vector3d(rest_m[at(node)]));
  place_m.push_back(Vector3d(place_m[at(node)]));
  velocity_m_s.push_back(Vector3d(velocity_m_s[at(node)]));
  held.push_back(int{held[at(node)]});
  mass_kg_of.push_back(0.0);
  made_of_.push_back(node);
  stars_.emplace_back();
  return n_nodes() - 1;
}

int CrackMesh::bisect_edge(int a, int b, double t) {
  const int middle = add_node_like(a);
  for (auto* values : {&rest_m, &place_m, &velocity_m_s})
    (*values)[at(middle)] = (1.0 - t) * (*values)[at(a)] + t * (*values)[at(b)];
  if (held[at(a)] != held[at(b)]) held[at(middle)] = -1;
  const double apart_sq = (velocity_m_s[at(a)] - velocity_m_s[at(b)]).squaredNorm();
  std::vector<int> around;
  std::set_intersection(stars_[at(a)].begin(), stars_[at(a)].end(), stars_[at(b)].begin(), stars_[at(b)].end(),
                        std::back_inserter(around));
  KLANG_CHECK(!around.empty() && t > 0.0 && t < 1.0, "no such edge to bisect");
  for (const int element : around) {
    const std::array<int, 4> nodes = nodes_of(element);
    const double volume = volume_m3(element), share = density_kg_m3_ * volume / 4.0;
    const Sym plastic = plastic_of(element);
    std::array<int, 4> near_a = nodes, near_b = nodes;
    std::replace(near_a.begin(), near_a.end(), b, middle);
    std::replace(near_b.begin(), near_b.end(), a, middle);
    const int other = add_element();
    set_element(element, near_a, edges_of(rest_m, near_a).inverse(), t * volume);
    set_element(other, near_b, edges_of(rest_m, near_b).inverse(), (1.0 - t) * volume);
    set_plastic(other, plastic);
    for (int i = 0; i < 6; ++i) block(other).elastic[i][other % kLanes] = block(element).elastic[i][element % kLanes];
    for (const int node : nodes)
      if (node != a && node != b) stars_[at(node)].push_back(other);
    auto& star_b = stars_[at(b)];
    star_b.erase(std::find(star_b.begin(), star_b.end(), element));
    star_b.push_back(other);
    stars_[at(middle)].push_back(element);
    stars_[at(middle)].push_back(other);
    mass_kg_of[at(a)] -= (1.0 - t) * share;
    mass_kg_of[at(b)] -= t * share;
    mass_kg_of[at(middle)] += share;
    lost_j_ += 0.5 * share * t * (1.0 - t) * apart_sq;
  }
  std::sort(stars_[at(middle)].begin(), stars_[at(middle)].end());
  ++n_changes_;
  return middle;
}

int CrackMesh::double_node(int node, const std::vector<int>& elements) {
  const int copy = add_node_like(node);
  auto& star = stars_[at(node)];
  for (const int element : elements) {
    ElementBlock& b = block(element);
    for (auto& corner : b.node)
      if (corner[element % kLanes] == node) corner[element % kLanes] = copy;
    const double share = density_kg_m3_ * volume_m3(element) / 4.0;
    mass_kg_of[at(copy)] += share;
    star.erase(std::find(star.begin(), star.end(), element));
    stars_[at(copy)].push_back(element);
  }
  std::sort(stars_[at(copy)].begin(), stars_[at(copy)].end());
  mass_kg_of[at(node)] = 0.0;
  for (const int element : star) mass_kg_of[at(node)] += density_kg_m3_ * volume_m3(element) / 4.0;
  ++n_changes_;
  return copy;
}

std::vector<int> CrackMesh::part_node(int node) {
  std::vector<int> copies;
  for (;;) {
    const std::vector<int>& star = stars_[at(node)];
    std::vector<int> reached = {star.front()};
    std::vector<bool> seen(star.size(), false);
    seen[0] = true;
    for (std::size_t i = 0; i < reached.size(); ++i) {
      const std::array<int, 4> mine = nodes_of(reached[i]);
      for (std::size_t j = 0; j < star.size(); ++j) {
        if (seen[j]) continue;
        const std::array<int, 4> theirs = nodes_of(star[j]);
        int shared = 0;
        for (const int corner : mine) shared += std::count(theirs.begin(), theirs.end(), corner) > 0 ? 1 : 0;
        if (shared != 3) continue;
        seen[j] = true;
        reached.push_back(star[j]);
      }
    }
    if (reached.size() == star.size()) return copies;
    std::sort(reached.begin(), reached.end());
    std::vector<int> rest;
    std::set_difference(star.begin(), star.end(), reached.begin(), reached.end(), std::back_inserter(rest));
    copies.push_back(double_node(node, rest));
    node = copies.back();
  }
}

std::vector<int> CrackMesh::fragments(int& n_fragments) const {
  std::vector<int> number(at(n_elements_), -1), stack;
  n_fragments = 0;
  for (int seed = 0; seed < n_elements_; ++seed) {
    if (number[at(seed)] >= 0) continue;
    stack.push_back(seed);
    number[at(seed)] = n_fragments;
    while (!stack.empty()) {
      const int element = stack.back();
      stack.pop_back();
      for (const int node : nodes_of(element))
        for (const int next : star(node))
          if (number[at(next)] < 0) {
            number[at(next)] = n_fragments;
            stack.push_back(next);
          }
    }
    ++n_fragments;
  }
  return number;
}

}  // namespace klang::fracture
