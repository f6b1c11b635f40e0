#include "core/geometry/mesh/graded_patch.hpp"

#include <algorithm>
#include <array>
#include <map>
#include <set>

namespace klang::mesh {
namespace {

using Eigen::Index;
using Eigen::RowVector4d;
using Eigen::Vector3d;
using Edge = std::array<int, 2>;
using Face = std::array<int, 3>;

std::size_t nth(int i) { return static_cast<std::size_t>(i); }

/// Values of the coarse element's functions at barycentric l.
Eigen::VectorXd functions(int order, const RowVector4d& l) {
  if (order == 1) return l.transpose();
  Eigen::VectorXd value(10);
  for (int c = 0; c < 4; ++c) value[c] = l[c] * (2.0 * l[c] - 1.0);
  for (int e = 0; e < 6; ++e) value[4 + e] = 4.0 * l[kTetEdges[nth(e)][0]] * l[kTetEdges[nth(e)][1]];
  return value;
}

struct Tet {
  std::array<int, 4> node;
  int parent = 0;        ///< of the coarse mesh
  Eigen::Matrix4d bary;  ///< rows: corners in the parent
};

class Cutter {
 public:
  Cutter(const TetMesh& coarse, const std::vector<int>& elements, const Grading& grading)
      : coarse_(coarse), grading_(grading) {
    std::map<int, int> number_of;
    for (const int e : elements) {
      Tet tet;
      for (int c = 0; c < 4; ++c) {
        const int node = coarse.elements(e, c);
        const auto [found, is_new] = number_of.try_emplace(node, static_cast<int>(place_m_.size()));
        if (is_new) place_m_.push_back(coarse.nodes_m.row(node).transpose());
        tet.node[nth(c)] = found->second;
      }
      tet.parent = e;
      tet.bary.setIdentity();
      tets_.push_back(tet);
    }
  }
  void cut() {
    while (static_cast<int>(tets_.size()) < grading_.most_elements && pass()) {
    }
  }
  const std::vector<Tet>& tets() const { return tets_; }
  Vector3d at(int parent, const RowVector4d& l) const {
    Vector3d x = Vector3d::Zero();
    const Eigen::VectorXd value = functions(coarse_.order(), l);
    for (Index k = 0; k < value.size(); ++k)
      x += value[k] * coarse_.nodes_m.row(coarse_.elements(parent, k)).transpose();
    return x;
  }
  const Vector3d& place_m(int node) const { return place_m_[nth(node)]; }

 private:
  double length_sq(const Edge& e) const { return (place_m_[nth(e[0])] - place_m_[nth(e[1])]).squaredNorm(); }
  static Edge edge_of(const Tet& tet, int e) {
    const int a = tet.node[nth(kTetEdges[nth(e)][0])], b = tet.node[nth(kTetEdges[nth(e)][1])];
    return {std::min(a, b), std::max(a, b)};
  }
  /// Equal lengths, as of regular meshes, by the nodes: all elements around an edge then agree.
  bool is_longer(const Edge& a, const Edge& b) const {
    const double la = length_sq(a), lb = length_sq(b);
    if (std::abs(la - lb) > 1e-9 * std::max(la, lb)) return la > lb;
    return a < b;
  }
  Edge longest_of(const Tet& tet) const {
    Edge longest = edge_of(tet, 0);
    for (int e = 1; e < 6; ++e)
      if (const Edge other = edge_of(tet, e); is_longer(other, longest)) longest = other;
    return longest;
  }
  bool is_too_long(const Tet& tet, const Edge& longest) const {
    double near_sq = HUGE_VAL;
    for (const int node : tet.node) near_sq = std::min(near_sq, (place_m_[nth(node)] - grading_.place_m).squaredNorm());
    const double most = std::clamp(grading_.growth * std::sqrt(near_sq), grading_.smallest_m,
                                   std::max(grading_.smallest_m, grading_.largest_m));
    return length_sq(longest) > most * most;
  }
  bool pass() {
    std::map<Edge, std::vector<int>> around;
    std::vector<Edge> longest(tets_.size());
    std::vector<int> open;
    for (std::size_t t = 0; t < tets_.size(); ++t) {
      for (int e = 0; e < 6; ++e) around[edge_of(tets_[t], e)].push_back(static_cast<int>(t));
      longest[t] = longest_of(tets_[t]);
      if (is_too_long(tets_[t], longest[t])) open.push_back(static_cast<int>(t));
    }
    if (open.empty()) return false;
    std::set<Edge> wanted;
    while (!open.empty()) {
      const Edge edge = longest[nth(open.back())];
      open.pop_back();
      if (!wanted.insert(edge).second) continue;
      for (const int t : around[edge])
        if (longest[nth(t)] != edge) open.push_back(t);
    }
    for (const Edge& edge : wanted) {
      const std::vector<int>& star = around[edge];
      if (std::all_of(star.begin(), star.end(), [&](int t) { return longest[nth(t)] == edge; })) halve(edge, star);
    }
    return true;
  }
  void halve(const Edge& edge, const std::vector<int>& star) {
    const int middle = static_cast<int>(place_m_.size());
    for (const int t : star) {
      Tet& tet = tets_[nth(t)];
      const auto corner = [&](int node) {
        return std::find(tet.node.begin(), tet.node.end(), node) - tet.node.begin();
      };
      const auto a = corner(edge[0]), b = corner(edge[1]);
      const RowVector4d l = 0.5 * (tet.bary.row(a) + tet.bary.row(b));
      if (t == star.front()) place_m_.push_back(at(tet.parent, l));
      Tet other = tet;
      tet.node[static_cast<std::size_t>(a)] = middle;
      tet.bary.row(a) = l;
      other.node[static_cast<std::size_t>(b)] = middle;
      other.bary.row(b) = l;
      tets_.push_back(other);
    }
  }

  const TetMesh& coarse_;
  const Grading& grading_;
  std::vector<Tet> tets_;
  std::vector<Vector3d> place_m_;
};

Face face_of(const TetMesh& mesh, int element, int f) {
  Face face;
  for (int k = 0; k < 3; ++k) face[nth(k)] = mesh.elements(element, kTetFaces[nth(f)][nth(k)]);
  std::sort(face.begin(), face.end());
  return face;
}

}  // namespace

GradedPatch graded_patch(const TetMesh& coarse, const std::vector<int>& elements, const Grading& grading) {
  Cutter cutter(coarse, elements, grading);
  cutter.cut();
  std::map<Face, int> in_all, in_patch;
  for (const int e : elements)
    for (int f = 0; f < 4; ++f) ++in_patch[face_of(coarse, e, f)];
  for (int e = 0; e < coarse.n_elements(); ++e)
    for (int f = 0; f < 4; ++f) {
      const Face face = face_of(coarse, e, f);
      if (in_patch.count(face) > 0) ++in_all[face];
    }
  GradedPatch patch;
  const std::vector<Tet>& tets = cutter.tets();
  patch.mesh.elements.resize(static_cast<Index>(tets.size()), 10);
  std::map<Edge, int> number_of;  // of two corners, or one twice
  std::vector<Eigen::Triplet<double>> weights;
  std::vector<Vector3d> nodes;
  for (std::size_t t = 0; t < tets.size(); ++t) {
    const Tet& tet = tets[t];
    std::array<RowVector4d, 10> bary;
    for (int k = 0; k < 10; ++k) {
      const int a = k < 4 ? k : kTetEdges[nth(k - 4)][0], b = k < 4 ? k : kTetEdges[nth(k - 4)][1];
      bary[nth(k)] = 0.5 * (tet.bary.row(a) + tet.bary.row(b));
      const Edge key = {std::min(tet.node[nth(a)], tet.node[nth(b)]), std::max(tet.node[nth(a)], tet.node[nth(b)])};
      const auto [found, is_new] = number_of.try_emplace(key, static_cast<int>(nodes.size()));
      patch.mesh.elements(static_cast<Index>(t), k) = found->second;
      if (!is_new) continue;
      nodes.push_back(cutter.at(tet.parent, bary[nth(k)]));
      patch.is_shared.push_back(0);
      const Eigen::VectorXd value = functions(coarse.order(), bary[nth(k)]);
      for (Index i = 0; i < value.size(); ++i)
        if (value[i] != 0.0) weights.emplace_back(found->second, coarse.elements(tet.parent, i), value[i]);
    }
    for (int f = 0; f < 4; ++f) {
      const Face face = face_of(coarse, tet.parent, f);
      if (in_all[face] == in_patch[face]) continue;
      for (int k = 0; k < 10; ++k)  // halves of halves are exact
        if (bary[nth(k)][f] == 0.0) patch.is_shared[nth(patch.mesh.elements(static_cast<Index>(t), k))] = 1;
    }
  }
  patch.mesh.nodes_m.resize(static_cast<Index>(nodes.size()), 3);
  for (std::size_t i = 0; i < nodes.size(); ++i) patch.mesh.nodes_m.row(static_cast<Index>(i)) = nodes[i].transpose();
  patch.from_coarse.resize(static_cast<Index>(nodes.size()), coarse.n_nodes());
  patch.from_coarse.setFromTriplets(weights.begin(), weights.end());
  return patch;
}

}  // namespace klang::mesh
