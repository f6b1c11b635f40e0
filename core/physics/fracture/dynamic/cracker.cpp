#include "core/physics/fracture/dynamic/cracker.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "core/foundation/base/errors.hpp"
#include "core/physics/fracture/dynamic/detail/at.hpp"

namespace klang::fracture {
namespace {

using detail::at;
using Eigen::Vector3d;

double mean_edge_m(const CrackMesh& mesh) {
  double sum = 0.0;
  int n = 0;
  for (int e = 0; e < mesh.n_elements(); ++e) {
    const std::array<int, 4> nodes = mesh.nodes_of(e);
    for (std::size_t a = 0; a < 4; ++a)
      for (std::size_t b = 0; b < a; ++b, ++n) sum += (mesh.rest_m[at(nodes[a])] - mesh.rest_m[at(nodes[b])]).norm();
  }
  return sum / n;
}

constexpr double kTurnsOff = 0.5;    ///< cosine: a plane that differs by more is a new crack's
constexpr double kNearFront = 2.0;   ///< times its stress: what may start beside a front
constexpr double kFrontReach = 2.5;  ///< mean edges

using Edge = std::array<int, 2>;

/// Elements of each side of a plane at a face, and how many.
struct Beside {
  std::array<int, 2> count = {0, 0}, element = {0, 0};
};

/// Edges opposite to a node in its star, ascending.
std::set<Edge> link_edges(const CrackMesh& mesh, int node) {
  std::set<Edge> edges;
  for (const int element : mesh.star(node)) {
    const std::array<int, 4> nodes = mesh.nodes_of(element);
    for (std::size_t a = 0; a < 4; ++a)
      for (std::size_t b = a + 1; b < 4; ++b)
        if (nodes[a] != node && nodes[b] != node)
          edges.insert({std::min(nodes[a], nodes[b]), std::max(nodes[a], nodes[b])});
  }
  return edges;
}

/// Distances of a star's corners from the plane, in rest coordinates; 0 where they count as in it.
class Sides {
 public:
  Sides(const CrackMesh& mesh, int node, const Vector3d& normal, double offset_m, double snap_rad)
      : mesh_(mesh), node_(node), normal_(normal), offset_m_(offset_m) {
    shortest_m_ = HUGE_VAL;
    for (const int element : mesh.star(node))
      for (const int other : mesh.nodes_of(element)) {
        if (other == node) continue;
        const double length = (mesh.rest_m[at(other)] - mesh.rest_m[at(node)]).norm();
        shortest_m_ = std::min(shortest_m_, length);
        distance_[other] = std::abs(raw(other)) <= std::sin(snap_rad) * length ? 0.0 : raw(other);
      }
  }
  double raw(int node) const { return normal_.dot(mesh_.rest_m[at(node)] - mesh_.rest_m[at(node_)]) - offset_m_; }
  double operator()(int node) const { return distance_.at(node); }
  void put_in_plane(int node) { distance_[node] = 0.0; }
  bool cuts(const Edge& edge) const { return distance_.at(edge[0]) * distance_.at(edge[1]) < 0.0; }
  double share(const Edge& edge) const {
    const double a = distance_.at(edge[0]), b = distance_.at(edge[1]);
    return a / (a - b);
  }
  double shortest_m() const { return shortest_m_; }
  bool above(int element) const {
    double sum = 0.0, own = 0.0;
    for (const int other : mesh_.nodes_of(element))
      if (other != node_) {
        sum += distance_.at(other);
        own += raw(other);
      }
    return sum != 0.0 ? sum > 0.0 : own > 0.0;
  }

 private:
  const CrackMesh& mesh_;
  int node_;
  Vector3d normal_;
  double offset_m_ = 0.0, shortest_m_ = 0.0;
  std::map<int, double> distance_;
};

}  // namespace

double rayleigh_over_shear(double poissons_ratio) {
  const double k = (1.0 - 2.0 * poissons_ratio) / (2.0 - 2.0 * poissons_ratio);
  double low = 0.3, high = 1.0;  // the one root there
  for (int i = 0; i < 60; ++i) {
    const double x = 0.5 * (low + high), y = x * x;
    (y * y * y - 8.0 * y * y + (24.0 - 16.0 * k) * y - 16.0 * (1.0 - k) < 0.0 ? low : high) = x;
  }
  return 0.5 * (low + high);
}

void CrackOptions::validate() const {
  if (strength_pa.has_value() == toughness_n.has_value())
    throw InputError("crack", strength_pa ? "has a strength and a toughness" : "has neither strength nor toughness", "",
                     "strength_pa, or toughness_n");
  const double value = strength_pa.value_or(toughness_n.value_or(0.0));
  if (!(value > 0.0 && value <= 1e15))
    throw InputError("crack", strength_pa ? "strength_pa is out of range" : "toughness_n is out of range",
                     to_text(value), "above 0, up to 1e15");
  if (!(snap >= 0.0 && snap <= 0.5 && smallest_height >= 0.01 && smallest_height <= 0.5))
    throw InputError("crack", "snap or smallest_height is out of range",
                     to_text(snap) + ", " + to_text(smallest_height), "0 to 0.5 and 0.01 to 0.5");
  if (toughness_n && criterion == CrackCriterion::kRankine)
    throw InputError("crack", "toughness_n belongs to the separation tensor", "rankine", "strength_pa");
}

Cracker::Cracker(const ExplicitSolid& solid, const CrackOptions& options)
    : options_(options), material_(solid.options().material) {
  options_.validate();
  viscosity_ = {solid.options().viscosity_lambda_pa_s, solid.options().viscosity_mu_pa_s};
  front_speed_m_s_ =
      options_.speed_limit * rayleigh_over_shear(material_.poissons_ratio()) * material_.shear_speed_m_s();
  mean_edge_m_ = mean_edge_m(solid.mesh());
  smallest_height_m_ = options_.smallest_height * mean_edge_m_;
  ready_s_.assign(at(solid.mesh().n_nodes()), 0.0);
  on_crack_.assign(ready_s_.size(), 0);
  fronts_.assign(ready_s_.size(), {});
  front_until_s_.assign(ready_s_.size(), 0.0);
  slit_.resize(ready_s_.size());
  for (int i = 0; i < solid.mesh().n_nodes(); ++i) root_.push_back(i);
  const double rayleigh = rayleigh_over_shear(material_.poissons_ratio()) * material_.shear_speed_m_s();
  const double pressure_m_s =
      std::sqrt((material_.lame_lambda_pa + 2.0 * material_.lame_mu_pa) / material_.density_kg_m3);
  look_s_ = options_.total_stress ? 0.0 : 0.05 * mean_edge_m_ / pressure_m_s;
  pause_s_ = 4.0 * mean_edge_m_ / (options_.speed_limit > 0.0 ? front_speed_m_s_ : rayleigh);
}

int Cracker::open(ExplicitSolid& solid) {
  if (solid.time_s() < next_look_s_) return 0;
  next_look_s_ = solid.time_s() + look_s_;
  const CrackMesh& mesh = solid.mesh();
  // Where the stress is far below the strength no star can add up to it. A tau in newtons is one on the mean face at least; viscous stress is not
  // among what is known of elements.
  const double floor = options_.strength_pa && !options_.total_stress ? 0.4 * *options_.strength_pa : 0.0;
  const double floor_sq = floor * floor;
  std::vector<char> asked(at(mesh.n_nodes()), 0);
  bool any = false;
  for (int e = 0; e < mesh.n_elements(); ++e) {
    if (!(solid.stress_sq()[at(e)] > floor_sq)) continue;
    any = true;
    for (const int node : mesh.nodes_of(e)) asked[at(node)] = 1;
  }
  if (!any) return 0;
  struct Candidate {
    double over = 0.0;
    int node = 0;
    Vector3d normal;
  };
  std::vector<Candidate> found, fronts;
  const Viscosity* extra = options_.total_stress ? &viscosity_ : nullptr;
  const double now = solid.time_s();
  const bool runs = running_s_ >= 0.0 && now < running_s_ + pause_s_;
  const auto counts_as_front = [&](int i) { return options_.new_crack_factor > 1.0 && now < front_until_s_[at(i)]; };
  std::vector<int> nodes;
  for (int i = 0; i < mesh.n_nodes(); ++i)
    if (asked[at(i)] && mesh.held[at(i)] < 0 && mesh.star(i).size() >= 2 &&
        (now >= ready_s_[at(i)] || counts_as_front(i)))
      nodes.push_back(i);
  const std::vector<Separation> separations = separations_at(mesh, nodes, material_, options_.criterion, extra);
  for (std::size_t k = 0; k < nodes.size(); ++k) {
    const int i = nodes[k];
    const Separation& separation = separations[k];
    const double over = options_.strength_pa ? separation.stress_pa / *options_.strength_pa
                                             : separation.force_n / *options_.toughness_n;
    highest_ = std::max(highest_, over);
    if (counts_as_front(i)) fronts.push_back({over, i, separation.normal});
    if (!(over > 1.0) || now < ready_s_[at(i)]) continue;
    if (on_crack_[at(i)] || !runs || over > options_.new_crack_factor) found.push_back({over, i, separation.normal});
  }
  // What is overstressed because a front is near that has not got further yet is left to the front.
  const auto is_left_to_front = [&](const Candidate& candidate) {
    if (on_crack_[at(candidate.node)]) return false;
    for (const Candidate& front : fronts)
      if (candidate.over <= kNearFront * std::max(1.0, front.over) &&
          (mesh.rest_m[at(front.node)] - mesh.rest_m[at(candidate.node)]).norm() < kFrontReach * mean_edge_m_)
        return true;
    return false;
  };
  found.erase(std::remove_if(found.begin(), found.end(), is_left_to_front), found.end());
  std::stable_sort(found.begin(), found.end(), [](const Candidate& a, const Candidate& b) { return a.over > b.over; });
  std::vector<bool> touched(at(mesh.n_nodes()), false);
  int n = 0;
  for (const Candidate& candidate : found) {
    if (touched[at(candidate.node)]) continue;
    const bool starts = !on_crack_[at(candidate.node)] && running_s_ == solid.time_s();
    if (starts && !(candidate.over > options_.new_crack_factor)) continue;
    const std::vector<int> star = mesh.star(candidate.node);
    const Plane plane = plane_at(mesh, candidate.node, candidate.normal);
    if (!part(solid, candidate.node, plane) &&
        (plane.offset_m == 0.0 || !part(solid, candidate.node, {plane.normal, 0.0}))) {
      // Nothing of the star is across the plane: the surface is what it would make.
      ready_s_[at(candidate.node)] = solid.time_s() + 10.0 * solid.step_limit_s();
      continue;
    }
    if (n++ == 0) last_over_ = candidate.over;
    touched.resize(at(mesh.n_nodes()), true);
    for (const int element : star)
      for (const int node : mesh.nodes_of(element)) touched[at(node)] = true;
  }
  if (n > 0) solid.refresh();
  n_splits_ += n;
  return n;
}

bool Cracker::may_be_cut(const CrackMesh& mesh, const Edge& edge, double t, double shortest_m) const {
  const auto [a, b] = edge;
  const double length = (mesh.rest_m[at(a)] - mesh.rest_m[at(b)]).norm();
  if (std::min(t, 1.0 - t) * length < options_.snap * std::min(shortest_m, length)) return false;
  const Vector3d middle = (1.0 - t) * mesh.rest_m[at(a)] + t * mesh.rest_m[at(b)];
  for (const int element : mesh.star(a)) {
    const std::array<int, 4> nodes = mesh.nodes_of(element);
    if (std::count(nodes.begin(), nodes.end(), b) == 0) continue;
    for (const int replaced : {a, b}) {
      std::array<Vector3d, 4> corner;
      for (std::size_t k = 0; k < 4; ++k) corner[k] = nodes[k] == replaced ? middle : mesh.rest_m[at(nodes[k])];
      double largest = 0.0;
      for (const auto& face : mesh::kTetFaces)
        largest = std::max(
            largest,
            (corner[at(face[1])] - corner[at(face[0])]).cross(corner[at(face[2])] - corner[at(face[0])]).norm());
      const double six_volumes = mesh.volume_m3(element) * 6.0 * (replaced == a ? 1.0 - t : t);
      if (!(six_volumes >= smallest_height_m_ * largest)) return false;
    }
  }
  return true;
}

Cracker::Plane Cracker::plane_at(const CrackMesh& mesh, int node, const Vector3d& world_normal) const {
  // Planes of the world are planes of the rest shape: n -> F^T n, with the mean F around the node.
  std::set<int> elements(mesh.star(node).begin(), mesh.star(node).end());
  Eigen::Matrix3d f = Eigen::Matrix3d::Zero();
  for (const int element : mesh.star(node)) f += mesh.volume_m3(element) * mesh.gradient_of(element);
  if (!options_.follows_plane) return {(f.transpose() * world_normal).normalized(), 0.0};
  for (const int element : mesh.star(node))
    for (const int other : mesh.nodes_of(element)) elements.insert(mesh.star(other).begin(), mesh.star(other).end());
  Vector3d normal = (f.transpose() * mean_normal(mesh, {elements.begin(), elements.end()}, material_)).normalized();
  const Front& front = fronts_[at(node)];
  if (!(front.area_m2 > 0.0)) return {normal, 0.0};
  const Vector3d before = front.normal.normalized();
  if (normal.dot(before) < 0.0) normal = -normal;
  if (normal.dot(before) < kTurnsOff) return {normal, 0.0};  // it turns off: a new crack
  normal = (options_.turning * normal + (1.0 - options_.turning) * before).normalized();
  return {normal, front.offset_m3 / front.area_m2};
}

/// New nodes lie on cracks; copies go on as the node does that they were made of.
void Cracker::add_nodes(const CrackMesh& mesh, double now_s) {
  while (ready_s_.size() < at(mesh.n_nodes())) {
    const std::size_t node = ready_s_.size(), old = at(mesh.made_of(static_cast<int>(node)));
    const bool is_copy = mesh.rest_m[old] == mesh.rest_m[node];
    ready_s_.push_back(now_s);
    root_.push_back(is_copy ? int{root_[old]} : static_cast<int>(node));
    slit_.emplace_back();
    on_crack_.push_back(1);
    fronts_.push_back(is_copy ? Front(fronts_[old]) : Front());
    front_until_s_.push_back(is_copy ? double{front_until_s_[old]} : 0.0);
  }
}

/// What the nodes that the crack has come to go on with: the plane, and the faces that are parted there.
void Cracker::leave_front(const CrackMesh& mesh, int node, const Vector3d& normal, double offset_m,
                          const std::vector<PartedFace>& faces, const std::vector<Edge>& far_nodes) {
  for (std::size_t f = 0; f < faces.size(); ++f) {
    const std::array<int, 3> corners = {root_[at(node)], root_[at(far_nodes[f][0])], root_[at(far_nodes[f][1])]};
    for (const int corner : corners) slit_[at(corner)].insert(corners.begin(), corners.end());
    for (const int other : far_nodes[f]) {
      Front& front = fronts_[at(other)];
      const double area = front.normal.dot(normal) < 0.0 ? -faces[f].area_m2 : faces[f].area_m2;
      front.normal += area * normal;
      front.offset_m3 += area * (offset_m - normal.dot(mesh.rest_m[at(other)] - mesh.rest_m[at(node)]));
      front.area_m2 += faces[f].area_m2;
    }
  }
}

bool Cracker::part(ExplicitSolid& solid, int node, const Plane& plane) {
  CrackMesh& mesh = solid.mesh();
  const auto& [normal, offset_m] = plane;
  Sides side(mesh, node, normal, offset_m, options_.snap_rad);
  // The crack that is there lies in the plane.
  const auto& slit = slit_[at(root_[at(node)])];
  if (options_.follows_plane)
    for (const int element : mesh.star(node))
      for (const int other : mesh.nodes_of(element))
        if (other != node && slit.count(root_[at(other)]) > 0) side.put_in_plane(other);
  // Cuts near an end, or that leave slivers, go through the end instead, the least deviation first.
  const std::set<Edge> edges = link_edges(mesh, node);
  for (;;) {
    double least_m = HUGE_VAL;
    int nearest = -1;
    for (const Edge& edge : edges) {
      if (!side.cuts(edge) || may_be_cut(mesh, edge, side.share(edge), side.shortest_m())) continue;
      for (const int end : edge)
        if (std::abs(side(end)) < least_m) {
          least_m = std::abs(side(end));
          nearest = end;
        }
    }
    if (nearest < 0) break;
    side.put_in_plane(nearest);
  }
  std::vector<std::pair<double, Edge>> cuts;
  for (const Edge& edge : edges)
    if (side.cuts(edge)) cuts.push_back({-(mesh.rest_m[at(edge[0])] - mesh.rest_m[at(edge[1])]).norm(), edge});
  std::sort(cuts.begin(), cuts.end());
  if (cuts.empty()) {
    std::size_t n_above = 0;
    for (const int element : mesh.star(node)) n_above += side.above(element) ? 1 : 0;
    if (n_above == 0 || n_above == mesh.star(node).size()) return false;
  }
  for (const auto& [length, edge] : cuts) side.put_in_plane(mesh.bisect_edge(edge[0], edge[1], side.share(edge)));
  std::vector<int> upper;
  for (const int element : mesh.star(node))
    if (side.above(element)) upper.push_back(element);
  if (upper.empty() || upper.size() == mesh.star(node).size()) {
    add_nodes(mesh, solid.time_s());
    return !cuts.empty();
  }
  // Faces between the sides.
  std::map<Edge, Beside> sides_of;  // far edge of a face with the node: one element of each side
  for (const int element : mesh.star(node)) {
    const bool up = std::binary_search(upper.begin(), upper.end(), element);
    std::vector<int> far;
    for (const int other : mesh.nodes_of(element))
      if (other != node) far.push_back(other);
    std::sort(far.begin(), far.end());
    for (const Edge& edge : {Edge{far[0], far[1]}, Edge{far[0], far[2]}, Edge{far[1], far[2]}}) {
      Beside& beside = sides_of[edge];
      ++beside.count[up ? 1 : 0];
      beside.element[up ? 1 : 0] = element;
    }
  }
  std::set<int> around;
  std::vector<Edge> far_nodes;
  const std::size_t first_face = faces_.size();
  for (const auto& [edge, beside] : sides_of) {
    if (beside.count[0] != 1 || beside.count[1] != 1) continue;
    around.insert({edge[0], edge[1]});
    far_nodes.push_back(edge);
    PartedFace face;
    const Vector3d a = mesh.rest_m[at(node)], b = mesh.rest_m[at(edge[0])], c = mesh.rest_m[at(edge[1])];
    const Vector3d area = 0.5 * (b - a).cross(c - a);
    face.centre_m = (a + b + c) / 3.0;
    face.area_m2 = area.norm();
    face.normal = area.normalized();
    if (face.normal.dot(normal) < 0.0) face.normal = -face.normal;
    face.time_s = solid.time_s();
    face.elements = beside.element;
    for (const int element : face.elements)  // one pull for both sides
      face.pull_n += 0.5 * pull_through(mesh, element, face.area_m2 * face.normal, material_);
    faces_.push_back(face);
  }
  add_nodes(mesh, solid.time_s());
  if (options_.follows_plane)
    leave_front(mesh, node, normal, offset_m, {faces_.begin() + first_face, faces_.end()}, far_nodes);
  const int copy = mesh.double_node(node, upper);
  mesh.part_node(node);
  mesh.part_node(copy);
  for (const int other : around) mesh.part_node(other);
  // A front does not run faster than its speed limit.
  add_nodes(mesh, solid.time_s());
  on_crack_[at(node)] = 1;
  running_s_ = solid.time_s();
  front_until_s_[at(node)] = front_until_s_[at(copy)] = 0.0;
  for (const int other : around) {
    on_crack_[at(other)] = 1;
    front_until_s_[at(other)] = solid.time_s() + pause_s_;
    if (front_speed_m_s_ > 0.0)
      ready_s_[at(other)] =
          std::max(ready_s_[at(other)],
                   solid.time_s() + (mesh.rest_m[at(other)] - mesh.rest_m[at(node)]).norm() / front_speed_m_s_);
  }
  return true;
}

}  // namespace klang::fracture
