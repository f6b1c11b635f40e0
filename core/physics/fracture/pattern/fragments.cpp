#include "core/physics/fracture/pattern/fragments.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <map>
#include <numeric>

#include "core/geometry/mesh/tet_geometry.hpp"

namespace klang::fracture {
namespace {

/// A face of the cut mesh with its one or two elements.
struct Side {
  std::array<int, 3> nodes{};  // sorted
  int element = 0, face = 0;
};
struct InnerFace {
  int element_a = 0, face_a = 0, element_b = 0;
  double area_m2 = 0.0;
};

double face_area(const mesh::TetMesh& mesh, int element, int face) {
  std::array<Eigen::Vector3d, 3> p;
  for (int c = 0; c < 3; ++c) p[c] = mesh.nodes_m.row(mesh.elements(element, mesh::kTetFaces[face][c])).transpose();
  return 0.5 * (p[1] - p[0]).cross(p[2] - p[0]).norm();
}

class Joined {
 public:
  explicit Joined(std::size_t n) : up_(n) { std::iota(up_.begin(), up_.end(), 0); }
  int root(int i) {
    while (up_[static_cast<std::size_t>(i)] != i) {
      up_[static_cast<std::size_t>(i)] = up_[static_cast<std::size_t>(up_[static_cast<std::size_t>(i)])];
      i = up_[static_cast<std::size_t>(i)];
    }
    return i;
  }
  void join(int a, int b) {
    a = root(a);
    b = root(b);
    up_[static_cast<std::size_t>(std::max(a, b))] = std::min(a, b);
  }

 private:
  std::vector<int> up_;
};

/// Faces by which two elements of different regions or of one meet, and, by element, whether it has an outer face.
struct Faces {
  std::vector<InnerFace> inner;
  std::vector<bool> outer;
};
Faces faces_of(const mesh::TetMesh& mesh) {
  std::vector<Side> sides;
  sides.reserve(4 * static_cast<std::size_t>(mesh.n_elements()));
  for (int e = 0; e < mesh.n_elements(); ++e)
    for (int f = 0; f < 4; ++f) {
      Side side{{}, e, f};
      for (int c = 0; c < 3; ++c) side.nodes[c] = mesh.elements(e, mesh::kTetFaces[f][c]);
      std::sort(side.nodes.begin(), side.nodes.end());
      sides.push_back(side);
    }
  std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) {
    return a.nodes != b.nodes ? a.nodes < b.nodes : a.element < b.element;
  });
  Faces faces;
  faces.outer.assign(static_cast<std::size_t>(mesh.n_elements()), false);
  for (std::size_t i = 0; i < sides.size(); ++i) {
    if (i + 1 < sides.size() && sides[i].nodes == sides[i + 1].nodes) {
      faces.inner.push_back({sides[i].element, sides[i].face, sides[i + 1].element, 0.0});
      ++i;
    } else {
      faces.outer[static_cast<std::size_t>(sides[i].element)] = true;
    }
  }
  return faces;
}

/// Parts joined by faces, and what stays with a neighbour.
class Parts {
 public:
  Parts(const RegionCut& cut, const Faces& faces) {
    Joined joined(cut.region.size());
    for (const InnerFace& f : faces.inner)
      if (cut.region[f.element_a] == cut.region[f.element_b]) joined.join(f.element_a, f.element_b);
    std::vector<int> part_of_root(cut.region.size(), -1);
    std::vector<int> roots;
    for (int e = 0; e < cut.mesh.n_elements(); ++e)
      if (joined.root(e) == e) roots.push_back(e);
    std::stable_sort(roots.begin(), roots.end(), [&](int a, int b) { return cut.region[a] < cut.region[b]; });
    for (std::size_t p = 0; p < roots.size(); ++p) part_of_root[roots[p]] = static_cast<int>(p);
    part.resize(cut.region.size());
    volume.assign(roots.size(), 0.0);
    outer.assign(roots.size(), false);
    for (int e = 0; e < cut.mesh.n_elements(); ++e) {
      part[e] = part_of_root[joined.root(e)];
      volume[part[e]] += mesh::tet_volume_m3(cut.mesh, e);
      if (faces.outer[e]) outer[part[e]] = true;
    }
    shared_area.resize(roots.size());
    for (const InnerFace& f : faces.inner) {
      if (part[f.element_a] == part[f.element_b]) continue;
      shared_area[part[f.element_a]][part[f.element_b]] += f.area_m2;
      shared_area[part[f.element_b]][part[f.element_a]] += f.area_m2;
    }
    into.resize(roots.size());
    std::iota(into.begin(), into.end(), 0);
  }

  /// The smallest part that breaks a rule goes first; -1 where none does.
  int first_to_merge(const FragmentRules& rules) const {
    int found = -1;
    for (int p = 0; p < n_parts(); ++p) {
      if (into[p] != p || shared_area[p].empty()) continue;
      const bool small = volume[p] < rules.least_volume_m3;
      const bool inside = rules.merge_enclosed && is_enclosed(p);
      if ((small || inside) && (found < 0 || volume[p] < volume[found])) found = p;
    }
    return found;
  }
  bool is_enclosed(int p) const { return !outer[p] && shared_area[p].size() == 1; }

  void merge(int p) {
    int with = -1;
    double most = -1.0;
    for (const auto& [other, area] : shared_area[p])
      if (area > most) {
        most = area;
        with = other;
      }
    into[p] = with;
    volume[with] += volume[p];
    outer[with] = outer[with] || outer[p];
    for (const auto& [other, area] : shared_area[p]) {
      shared_area[other].erase(p);
      if (other == with) continue;
      shared_area[with][other] += area;
      shared_area[other][with] += area;
    }
    shared_area[p].clear();
  }
  int root(int p) const {
    while (into[p] != p) p = into[p];
    return p;
  }
  int n_parts() const { return static_cast<int>(volume.size()); }

  std::vector<int> part;  // by element
  std::vector<double> volume;
  std::vector<bool> outer;
  std::vector<std::map<int, double>> shared_area;
  std::vector<int> into;
};

}  // namespace

Fragments fragments_of(RegionCut cut, const FragmentRules& rules) {
  Fragments out;
  Faces faces = faces_of(cut.mesh);
  for (InnerFace& f : faces.inner)
    if (cut.region[f.element_a] != cut.region[f.element_b]) f.area_m2 = face_area(cut.mesh, f.element_a, f.face_a);
  Parts parts(cut, faces);
  for (int p = parts.first_to_merge(rules); p >= 0; p = parts.first_to_merge(rules)) {
    parts.merge(p);
    ++out.n_merged;
  }
  std::vector<int> number(static_cast<std::size_t>(parts.n_parts()), -1);
  std::vector<int> region_of_part(static_cast<std::size_t>(parts.n_parts()), 0);
  for (std::size_t e = 0; e < cut.region.size(); ++e) region_of_part[parts.part[e]] = cut.region[e];
  for (int p = 0; p < parts.n_parts(); ++p)
    if (parts.root(p) == p) {
      number[p] = out.n_fragments++;
      out.region.push_back(region_of_part[p]);
      if (parts.is_enclosed(p)) out.enclosed.push_back(number[p]);
    }
  out.fragment.resize(cut.region.size());
  for (std::size_t e = 0; e < cut.region.size(); ++e) out.fragment[e] = number[parts.root(parts.part[e])];
  for (const InnerFace& f : faces.inner) {
    const int a = out.fragment[f.element_a], b = out.fragment[f.element_b];
    if (a == b) continue;
    CrackTriangle crack;
    crack.a = std::min(a, b);
    crack.b = std::max(a, b);
    for (int c = 0; c < 3; ++c) crack.nodes[c] = cut.mesh.elements(f.element_a, mesh::kTetFaces[f.face_a][c]);
    if (a > b) std::swap(crack.nodes[1], crack.nodes[2]);
    crack.element_a = cut.element[a < b ? f.element_a : f.element_b];
    crack.element_b = cut.element[a < b ? f.element_b : f.element_a];
    crack.area_m2 = f.area_m2;
    out.crack_area_m2 += crack.area_m2;
    out.cracks.push_back(crack);
  }
  out.cut = std::move(cut);
  return out;
}

mesh::TetMesh fragment_mesh(const Fragments& fragments, int fragment, std::vector<int>* element_of) {
  const mesh::TetMesh& whole = fragments.cut.mesh;
  std::vector<int> row(static_cast<std::size_t>(whole.n_nodes()), -1), nodes, elements;
  for (int e = 0; e < whole.n_elements(); ++e)
    if (fragments.fragment[e] == fragment) elements.push_back(e);
  mesh::TetMesh piece;
  piece.elements.resize(static_cast<Eigen::Index>(elements.size()), 4);
  for (std::size_t i = 0; i < elements.size(); ++i)
    for (int c = 0; c < 4; ++c) {
      const int node = whole.elements(elements[i], c);
      if (row[node] < 0) {
        row[node] = static_cast<int>(nodes.size());
        nodes.push_back(node);
      }
      piece.elements(static_cast<Eigen::Index>(i), c) = row[node];
    }
  piece.nodes_m.resize(static_cast<Eigen::Index>(nodes.size()), 3);
  for (std::size_t n = 0; n < nodes.size(); ++n)
    piece.nodes_m.row(static_cast<Eigen::Index>(n)) = whole.nodes_m.row(nodes[n]);
  if (element_of != nullptr) *element_of = std::move(elements);
  return piece;
}

}  // namespace klang::fracture
