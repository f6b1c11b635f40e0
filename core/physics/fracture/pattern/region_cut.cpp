#include "core/physics/fracture/pattern/region_cut.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <set>
#include <string>
#include <unordered_map>

#include "core/foundation/base/check.hpp"
#include "core/foundation/base/errors.hpp"

namespace klang::fracture {
namespace {

constexpr double kTouch = 1e-10;  // of the body's size: nearer to a plane is on it
constexpr int kMostShifts = 5;
constexpr double kThin = 100.0;   // times that: width of what is a line
constexpr double kVolume = 1e-9;  // of an element's: what its parts may lack

using Regions = std::vector<int>;  // sorted
using Corners = std::array<int, 4>;

/// A point as a mean of the nodes of one element: its functions' values follow from theirs.
struct Vertex {
  std::array<int, 4> nodes{};
  std::array<double, 4> weights{};
  int n_nodes = 0;
  Eigen::Vector3d at = Eigen::Vector3d::Zero();
  Regions regions;  // of the smallest value, to the tolerance; empty: not asked yet
};

struct Key {
  std::array<int, 4> corners{-1, -1, -1, -1};
  bool operator==(const Key&) const = default;
};
struct KeyHash {
  std::size_t operator()(const Key& key) const {
    std::uint64_t h = 1469598103934665603ull;
    for (const int c : key.corners) h = (h ^ static_cast<std::uint32_t>(c)) * 1099511628211ull;
    return static_cast<std::size_t>(h ^ (h >> 29));
  }
};

class Cutter {
 public:
  Cutter(const mesh::TetMesh& mesh, const RegionFields& fields) : mesh_(mesh), fields_(fields) {
    const Eigen::RowVector3d extent = mesh.nodes_m.colwise().maxCoeff() - mesh.nodes_m.colwise().minCoeff();
    touch_m_ = kTouch * extent.norm();
    margin_ = touch_m_ * fields.slopes.rowwise().maxCoeff();
    vertices_.resize(static_cast<std::size_t>(mesh.n_nodes()));
    for (int n = 0; n < mesh.n_nodes(); ++n) {
      Vertex& v = vertices_[static_cast<std::size_t>(n)];
      v.nodes[0] = n;
      v.weights[0] = 1.0;
      v.n_nodes = 1;
      v.at = mesh.nodes_m.row(n).transpose();
    }
  }

  /// Nothing where the parts of an element do not fill it.
  std::optional<RegionCut> run() {
    for (element_ = 0; element_ < mesh_.n_elements(); ++element_) {
      Corners corners;
      for (int c = 0; c < 4; ++c) corners[c] = mesh_.elements(element_, c);
      find_candidates(corners);
      if (candidates_.size() == 1) {
        emit(corners, candidates_[0]);
      } else {
        for (const int v : corners)
          if (at(v).regions.empty()) at(v).regions = regions_at(at(v));
        cut(corners);
        if (failed_) return std::nullopt;
      }
    }
    RegionCut made;
    made.mesh.nodes_m.resize(static_cast<Eigen::Index>(vertices_.size()), 3);
    for (std::size_t v = 0; v < vertices_.size(); ++v)
      made.mesh.nodes_m.row(static_cast<Eigen::Index>(v)) = vertices_[v].at.transpose();
    made.mesh.elements.resize(static_cast<Eigen::Index>(elements_.size()), 4);
    for (std::size_t e = 0; e < elements_.size(); ++e)
      for (int c = 0; c < 4; ++c) made.mesh.elements(static_cast<Eigen::Index>(e), c) = elements_[e][c];
    made.region = std::move(region_);
    made.element = std::move(parent_);
    return made;
  }

 private:
  Vertex& at(int v) { return vertices_[static_cast<std::size_t>(v)]; }
  double value(int region, const Vertex& v) const {
    double sum = 0.0;
    for (int k = 0; k < v.n_nodes; ++k) sum += v.weights[k] * fields_.values(region, v.nodes[k]);
    return sum;
  }
  double tolerance(int a, int b) const { return a == b ? 0.0 : touch_m_ * fields_.slopes(a, b); }

  /// Regions that may have a part of the element: none of the others lies below them everywhere.
  void find_candidates(const Corners& corners) {
    const Eigen::MatrixXd& values = fields_.values;
    int best = 0;
    double lowest_top = HUGE_VAL;
    for (int r = 0; r < fields_.n_regions(); ++r) {
      const double top = std::max(std::max(values(r, corners[0]), values(r, corners[1])),
                                  std::max(values(r, corners[2]), values(r, corners[3])));
      if (top < lowest_top) {
        lowest_top = top;
        best = r;
      }
    }
    candidates_.clear();
    for (int r = 0; r < fields_.n_regions(); ++r) {
      const double bottom = std::min(std::min(values(r, corners[0]), values(r, corners[1])),
                                     std::min(values(r, corners[2]), values(r, corners[3])));
      if (r == best || bottom <= lowest_top + margin_[r]) candidates_.push_back(r);
    }
  }

  Regions regions_at(const Vertex& v) const {
    int least = candidates_[0];
    double lowest = HUGE_VAL;
    for (const int r : candidates_) {
      const double here = value(r, v);
      if (here < lowest) {
        lowest = here;
        least = r;
      }
    }
    Regions all;
    for (const int r : candidates_)
      if (value(r, v) - lowest <= tolerance(r, least)) all.push_back(r);
    return all;
  }

  int add(const std::array<int, 4>& corners, const std::array<double, 4>& weights, int n) {
    Vertex v;
    for (int k = 0; k < n; ++k) {
      const Vertex& from = at(corners[k]);
      for (int m = 0; m < from.n_nodes; ++m) {
        int slot = 0;
        while (slot < v.n_nodes && v.nodes[slot] != from.nodes[m]) ++slot;
        if (slot == v.n_nodes) {
          v.nodes[slot] = from.nodes[m];
          v.weights[slot] = 0.0;
          ++v.n_nodes;
        }
        v.weights[slot] += weights[k] * from.weights[m];
      }
      v.at += weights[k] * from.at;
    }
    v.regions = regions_at(v);
    vertices_.push_back(std::move(v));
    return static_cast<int>(vertices_.size()) - 1;
  }
  /// With the regions that meet here, whatever rounding says.
  void meet(int vertex, std::initializer_list<int> regions) {
    Regions& all = at(vertex).regions;
    all.insert(all.end(), regions);
    std::sort(all.begin(), all.end());
    all.erase(std::unique(all.begin(), all.end()), all.end());
  }

  /// Where the least function changes on an edge, from its lower node on.
  const std::vector<int>& points_on_edge(int low, int high) {
    const auto [it, fresh] = points_.try_emplace(Key{{low, high, -1, -1}});
    if (!fresh) return it->second;
    int here = at(low).regions[0];
    for (const int r : at(low).regions)
      if (value(r, at(high)) < value(here, at(high))) here = r;
    while (!contains(at(high).regions, here)) {
      const double begin = value(here, at(low)), end = value(here, at(high));
      double first = 1.0;
      int next = -1;
      for (const int r : candidates_) {
        const double below = end - value(r, at(high)), gap = std::max(value(r, at(low)) - begin, 0.0);
        if (!(below > 0.0)) continue;
        const double t = gap / (gap + below);
        if (next < 0 || t < first || (t == first && value(r, at(high)) < value(next, at(high)))) {
          first = t;
          next = r;
        }
      }
      if (next < 0) break;
      const int made = add({low, high, -1, -1}, {1.0 - first, first, 0.0, 0.0}, 2);
      meet(made, {here, next});
      // Several may end here: the one that is least from here on goes on.
      for (const int r : at(made).regions)
        if (value(r, at(high)) < value(next, at(high))) next = r;
      it->second.push_back(made);
      here = next;
    }
    return it->second;
  }

  static bool contains(const Regions& all, int region) { return std::binary_search(all.begin(), all.end(), region); }
  bool known(const std::vector<int>& vertices, const Regions& regions) {
    return std::any_of(vertices.begin(), vertices.end(), [&](int v) {
      const Regions& has = at(v).regions;
      return std::includes(has.begin(), has.end(), regions.begin(), regions.end());
    });
  }

  /// The point of the simplex of n nodes where n functions are equal, if it is inside and they are least there.
  template <int n>
  void add_meeting(const std::array<int, 4>& nodes, const Regions& regions, const std::vector<int>& rim,
                   std::vector<int>& found) {
    Eigen::Matrix<double, n, n> equal;
    for (int c = 0; c < n; ++c) {
      for (int r = 1; r < n; ++r)
        equal(r - 1, c) = (fields_.values(regions[r], nodes[c]) - fields_.values(regions[0], nodes[c])) /
                          fields_.slopes(regions[r], regions[0]);
      equal(n - 1, c) = 1.0;
    }
    const Eigen::PartialPivLU<Eigen::Matrix<double, n, n>> lu(equal);
    const Eigen::Matrix<double, n, 1> weights = lu.solve(Eigen::Matrix<double, n, 1>::Unit(n - 1));
    if (!weights.allFinite() || !(weights.minCoeff() > 0.0)) return;
    if (known(rim, regions) || known(found, regions)) return;
    std::array<double, 4> as_array{};
    for (int c = 0; c < n; ++c) as_array[c] = weights[c];
    const int made = add(nodes, as_array, n);
    if (std::includes(at(made).regions.begin(), at(made).regions.end(), regions.begin(), regions.end()))
      found.push_back(made);
    else
      vertices_.pop_back();
  }

  /// All points inside a simplex of n nodes where n regions meet. Lines on which n - 1 of them meet lead from the rim to each of
  /// them, since regions are convex: for each n - 1 that meet at a known point every other region is tried.
  template <int n>
  std::vector<int> meetings(const std::array<int, 4>& nodes, const std::vector<int>& rim) {
    std::vector<int> found;
    std::set<Regions> lines;
    std::vector<Regions> open;
    const auto add_lines = [&](int vertex) {
      const Regions& here = at(vertex).regions;
      if (here.size() < n - 1) return;
      std::vector<bool> taken(here.size(), false);
      std::fill(taken.begin(), taken.begin() + (n - 1), true);
      do {
        Regions line;
        for (std::size_t r = 0; r < here.size(); ++r)
          if (taken[r]) line.push_back(here[r]);
        if (lines.insert(line).second) open.push_back(line);
      } while (std::prev_permutation(taken.begin(), taken.end()));
    };
    for (const int v : rim) add_lines(v);
    while (!open.empty()) {
      const Regions line = open.back();
      open.pop_back();
      for (const int r : candidates_) {
        if (contains(line, r)) continue;
        Regions all = line;
        all.insert(std::upper_bound(all.begin(), all.end(), r), r);
        const std::size_t before = found.size();
        add_meeting<n>(nodes, all, rim, found);
        if (found.size() > before) add_lines(found.back());
      }
    }
    return found;
  }

  /// Where three functions are equal inside a face. rim: its corners and the points on its edges.
  const std::vector<int>& points_on_face(const std::array<int, 3>& face, const std::vector<int>& rim) {
    const auto [it, fresh] = points_.try_emplace(Key{{face[0], face[1], face[2], -1}});
    if (fresh) it->second = meetings<3>({face[0], face[1], face[2], -1}, rim);
    return it->second;
  }

  /// Cuts one tetrahedron into the parts of its regions, each the hull of the points that have the region.
  void cut(const Corners& corners) {
    std::vector<int> all(corners.begin(), corners.end());
    const auto append = [](std::vector<int>& to, const std::vector<int>& more) {
      to.insert(to.end(), more.begin(), more.end());
    };
    for (const auto& pair : mesh::kTetEdges)
      append(all, points_on_edge(std::min(corners[pair[0]], corners[pair[1]]),
                                 std::max(corners[pair[0]], corners[pair[1]])));
    for (const auto& triple : mesh::kTetFaces) {
      std::array<int, 3> face{corners[triple[0]], corners[triple[1]], corners[triple[2]]};
      std::sort(face.begin(), face.end());
      std::vector<int> rim(face.begin(), face.end());
      for (const auto& [a, b] : {std::pair{0, 1}, {0, 2}, {1, 2}}) append(rim, points_on_edge(face[a], face[b]));
      append(all, points_on_face(face, rim));
    }
    const std::vector<int> rim = all;
    append(all, meetings<4>(corners, rim));
    std::sort(all.begin(), all.end());
    double sum = 0.0;
    for (const int region : candidates_) sum += add_part(corners, all, region);
    const double whole = volume(corners);
    if (!(std::abs(sum - whole) <= kVolume * whole)) failed_ = true;
  }

  bool on_face(const Vertex& v, const Corners& corners, int opposite) const {
    for (int k = 0; k < v.n_nodes; ++k)
      if (v.nodes[k] == corners[opposite]) return false;
    return true;
  }

  /// The part of one region in tetrahedra: from its lowest vertex to the triangles of its faces, each face a fan from its own lowest
  /// vertex, which neighbours do alike. Returns its volume.
  double add_part(const Corners& corners, const std::vector<int>& all, int region) {
    std::vector<int> of_region;
    for (const int v : all)
      if (contains(at(v).regions, region)) of_region.push_back(v);
    if (of_region.size() < 4) return 0.0;
    // Flat in one of the sides or against one other region: nothing of it is here.
    for (int f = 0; f < 4; ++f)
      if (std::all_of(of_region.begin(), of_region.end(), [&](int v) { return on_face(at(v), corners, f); }))
        return 0.0;
    for (const int other : candidates_)
      if (other != region && all_have(of_region, other)) return 0.0;
    double sum = 0.0;
    std::vector<int> polygon;
    for (int f = 0; f < 4; ++f) {
      polygon.clear();
      for (const int v : of_region)
        if (on_face(at(v), corners, f)) polygon.push_back(v);
      // A line of the side, where the region only touches it, is no face; a side that lies against another region is.
      const bool touches = std::any_of(candidates_.begin(), candidates_.end(),
                                       [&](int other) { return other != region && all_have(polygon, other); });
      if (!touches || !is_line(polygon)) sum += fan(polygon, of_region[0], region);
    }
    for (const int other : candidates_) {
      if (other == region) continue;
      polygon.clear();
      for (const int v : of_region)
        if (contains(at(v).regions, other)) polygon.push_back(v);
      bool thin = false;
      for (int f = 0; f < 4; ++f)
        thin = thin || std::all_of(polygon.begin(), polygon.end(), [&](int v) { return on_face(at(v), corners, f); });
      for (const int third : candidates_)
        thin = thin || (third != region && third != other && all_have(polygon, third));
      if (!thin) sum += fan(polygon, of_region[0], region);
    }
    return sum;
  }
  bool all_have(const std::vector<int>& vertices, int region) {
    return std::all_of(vertices.begin(), vertices.end(), [&](int v) { return contains(at(v).regions, region); });
  }
  bool is_line(const std::vector<int>& polygon) {
    double longest = 0.0, area = 0.0;
    for (const int p : polygon)
      for (const int q : polygon) {
        longest = std::max(longest, (at(p).at - at(q).at).norm());
        area = std::max(area, (at(p).at - at(polygon[0]).at).cross(at(q).at - at(polygon[0]).at).norm());
      }
    return area <= kThin * touch_m_ * longest;
  }

  /// Tetrahedra from the apex over a plane convex polygon; none if the apex is one of its corners.
  double fan(std::vector<int> polygon, int apex, int region) {
    if (polygon.size() < 3 || polygon[0] == apex) return 0.0;
    Eigen::Vector3d middle = Eigen::Vector3d::Zero(), normal = Eigen::Vector3d::Zero();
    for (const int v : polygon) middle += at(v).at / static_cast<double>(polygon.size());
    for (const int p : polygon)
      for (const int q : polygon) {
        const Eigen::Vector3d across = (at(p).at - middle).cross(at(q).at - middle);
        if (across.squaredNorm() > normal.squaredNorm()) normal = across;
      }
    const Eigen::Vector3d e = normal.unitOrthogonal(), f = normal.normalized().cross(e);
    const auto angle = [&](int v) { return std::atan2((at(v).at - middle).dot(f), (at(v).at - middle).dot(e)); };
    const int first = polygon[0];
    std::sort(polygon.begin(), polygon.end(), [&](int a, int b) {
      const double x = angle(a), y = angle(b);
      return x != y ? x < y : a < b;
    });
    std::rotate(polygon.begin(), std::find(polygon.begin(), polygon.end(), first), polygon.end());
    double sum = 0.0;
    for (std::size_t i = 1; i + 1 < polygon.size(); ++i) {
      Corners part{apex, first, polygon[i], polygon[i + 1]};
      double size = volume(part);
      if (size < 0.0) {
        std::swap(part[2], part[3]);
        size = -size;
      }
      sum += size;
      emit(part, region);
    }
    return sum;
  }
  double volume(const Corners& corners) {
    const Eigen::Vector3d& p = at(corners[0]).at;
    return (at(corners[1]).at - p).dot((at(corners[2]).at - p).cross(at(corners[3]).at - p)) / 6.0;
  }

  void emit(const Corners& corners, int region) {
    elements_.push_back(corners);
    region_.push_back(region);
    parent_.push_back(element_);
  }

  const mesh::TetMesh& mesh_;
  const RegionFields& fields_;
  double touch_m_ = 0.0;
  Eigen::VectorXd margin_;  // largest tolerance of a region
  std::vector<Vertex> vertices_;
  std::unordered_map<Key, std::vector<int>, KeyHash> points_;  // of an edge or a face
  Regions candidates_;
  int element_ = 0;
  bool failed_ = false;
  std::vector<Corners> elements_;
  std::vector<int> region_, parent_;
};

}  // namespace

RegionCut cut_regions(const mesh::TetMesh& mesh, const RegionFields& fields) {
  KLANG_CHECK(mesh.order() == 1, "tetrahedra to cut are straight");
  KLANG_CHECK(fields.values.cols() == mesh.n_nodes() && fields.n_regions() >= 1, "a value for each region and node");
  KLANG_CHECK(fields.slopes.rows() == fields.n_regions() && fields.slopes.cols() == fields.n_regions(),
              "square slopes");
  if (!fields.values.allFinite() || !mesh.nodes_m.allFinite())
    throw InputError("fracture", "a node or a region's function is not finite");
  if (std::optional<RegionCut> cut = Cutter(mesh, fields).run()) return std::move(*cut);
  // A point is on one plane by a hair and off another by a hair, or two functions are equal in all of an element: each function is shifted
  // by a little, another for each, so that planes move by some tolerances.
  const double size_m = (mesh.nodes_m.colwise().maxCoeff() - mesh.nodes_m.colwise().minCoeff()).norm();
  for (int shift = 1; shift <= kMostShifts; ++shift) {
    RegionFields shifted = fields;
    for (int r = 0; r < fields.n_regions(); ++r) {
      const double share = std::fmod(0.6180339887498949 * (r + 1), 1.0);
      shifted.values.row(r).array() += 10.0 * shift * share * kTouch * size_m * fields.slopes.maxCoeff();
    }
    if (std::optional<RegionCut> cut = Cutter(mesh, shifted).run()) return std::move(*cut);
  }
  throw InputError("fracture", "an element cannot be cut where its regions meet",
                   std::to_string(fields.n_regions()) + " regions");
}

}  // namespace klang::fracture
