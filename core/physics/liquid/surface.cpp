#include "core/physics/liquid/surface.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>

namespace klang::liquid {
namespace {

using Eigen::Vector3d;

enum Label : std::uint8_t { kLiquid, kAir, kSolid, kWall };
constexpr double kLeastShare = 0.02;  // of an edge: no slivers
constexpr int kDropped = -1;

/// Region of the interface between two labels; a triangle is oriented out of the first one.
int region_of(Label inside, Label outside) {
  if (inside == kLiquid) return outside == kAir ? 0 : outside == kWall ? 1 : 2;
  if (inside == kSolid && outside != kLiquid) return 3;
  return kDropped;
}

/// Corners along a path from (0,0,0) to (1,1,1): one tetrahedron for each order of the axes.
constexpr std::array<std::array<int, 3>, 6> kOrders{{{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}}};

class Mesher {
 public:
  Mesher(const GridShape& shape, const Field& phi, const Field& solid)
      : shape_(shape), phi_(phi), solid_(solid), nx_(shape.nx + 2), ny_(shape.ny + 2), nz_(shape.nz + 2) {
    const std::size_t n = static_cast<std::size_t>(nx_) * ny_ * nz_;
    label_.resize(n);
    for (std::size_t node = 0; node < n; ++node) label_[node] = label(node);
    edge_vertex_.assign(7 * n, -1);
  }

  LiquidSurface run() {
    const std::array<std::size_t, 3> stride{1, static_cast<std::size_t>(nx_), static_cast<std::size_t>(nx_) * ny_};
    for (int k = 0; k + 1 < nz_; ++k)
      for (int j = 0; j + 1 < ny_; ++j)
        for (int i = 0; i + 1 < nx_; ++i) {
          const std::size_t base = i + stride[1] * j + stride[2] * k;
          bool mixed = false;
          for (int c = 1; c < 8 && !mixed; ++c)
            mixed =
                label_[base + (c & 1) * stride[0] + ((c >> 1) & 1) * stride[1] + (c >> 2) * stride[2]] != label_[base];
          if (!mixed) continue;
          for (const auto& order : kOrders) {
            std::array<std::size_t, 4> nodes{base, 0, 0, 0};
            for (std::size_t s = 0; s < 3; ++s) nodes[s + 1] = nodes[s] + stride[static_cast<std::size_t>(order[s])];
            cut(nodes);
          }
        }
    LiquidSurface result;
    result.surface.vertices_m.resize(static_cast<Eigen::Index>(vertices_.size()), 3);
    for (std::size_t v = 0; v < vertices_.size(); ++v)
      result.surface.vertices_m.row(static_cast<Eigen::Index>(v)) = vertices_[v].transpose();
    result.surface.triangles.resize(static_cast<Eigen::Index>(triangles_.size()), 3);
    for (std::size_t t = 0; t < triangles_.size(); ++t)
      for (int c = 0; c < 3; ++c)
        result.surface.triangles(static_cast<Eigen::Index>(t), c) = triangles_[t][static_cast<std::size_t>(c)];
    result.region = std::move(region_);
    return result;
  }

 private:
  std::array<int, 3> place(std::size_t node) const {
    const std::size_t layer = static_cast<std::size_t>(nx_) * ny_;
    return {static_cast<int>(node % nx_), static_cast<int>(node % layer / nx_), static_cast<int>(node / layer)};
  }
  /// Distance to the box, below 0 inside: nodes stand half a cell from its walls.
  double wall(const std::array<int, 3>& at) const {
    double most = -HUGE_VAL;
    for (int axis = 0; axis < 3; ++axis) {
      const double g = at[static_cast<std::size_t>(axis)] - 0.5;
      most = std::max({most, -g, g - shape_.n(axis)});
    }
    return most * shape_.cell_m;
  }
  double solid_at(const std::array<int, 3>& at) const {
    return solid_.size() == 0 ? HUGE_VAL : solid_.clamped(at[0] - 1, at[1] - 1, at[2] - 1);
  }
  double phi_at(const std::array<int, 3>& at) const { return phi_.clamped(at[0] - 1, at[1] - 1, at[2] - 1); }
  Vector3d position(const std::array<int, 3>& at) const {
    return shape_.cell_m * Vector3d(at[0] - 0.5, at[1] - 0.5, at[2] - 0.5);
  }
  Label label(std::size_t node) const {
    const auto at = place(node);
    if (wall(at) > 0.0) return kWall;
    if (solid_at(at) < 0.0) return kSolid;
    return phi_at(at) < 0.0 ? kLiquid : kAir;
  }

  /// Share of the edge from a to b at which the labels change.
  double share(std::size_t a, std::size_t b) const {
    const auto pa = place(a), pb = place(b);
    const auto between = [](double from, double to) {
      const double difference = from - to;
      return std::abs(difference) > 0.0 && std::isfinite(difference) ? from / difference : 0.5;
    };
    double t = 0.5;
    if (label_[a] == kWall || label_[b] == kWall) {
      t = between(wall(pa), wall(pb));
    } else if (label_[a] == kSolid || label_[b] == kSolid) {
      t = between(solid_at(pa), solid_at(pb));
    } else {
      t = between(phi_at(pa), phi_at(pb));
    }
    return std::clamp(t, kLeastShare, 1.0 - kLeastShare);
  }

  int add_vertex(const Vector3d& x) {
    vertices_.push_back(x);
    return static_cast<int>(vertices_.size()) - 1;
  }

  int edge(std::size_t a, std::size_t b) {
    if (a > b) std::swap(a, b);
    const auto pa = place(a), pb = place(b);
    const int direction = (pb[0] - pa[0]) + 2 * (pb[1] - pa[1]) + 4 * (pb[2] - pa[2]);  // 1 to 7
    int& vertex = edge_vertex_[7 * a + static_cast<std::size_t>(direction - 1)];
    if (vertex < 0) {
      const double t = share(a, b);
      vertex = add_vertex((1.0 - t) * position(pa) + t * position(pb));
    }
    return vertex;
  }

  /// Distances whose zero sets meet in a face of three labels.
  double first_of(std::size_t node, bool air_and_liquid) const {
    return air_and_liquid ? phi_at(place(node)) : solid_at(place(node));
  }
  double second_of(std::size_t node, bool with_wall) const {
    return with_wall ? wall(place(node)) : solid_at(place(node));
  }

  /// In a face of three labels: where their lines meet, if that is in it; else the middle of its edges' points.
  int face(std::size_t a, std::size_t b, std::size_t c) {
    std::array<std::size_t, 3> key{a, b, c};
    std::sort(key.begin(), key.end());
    const auto found = face_vertex_.find(key);
    if (found != face_vertex_.end()) return found->second;
    const int ab = edge(key[0], key[1]), bc = edge(key[1], key[2]), ca = edge(key[2], key[0]);
    Vector3d x = (at(ab) + at(bc) + at(ca)) / 3.0;
    bool has[4] = {false, false, false, false};
    for (const std::size_t node : key) has[label_[node]] = true;
    Eigen::Matrix3d lines = Eigen::Matrix3d::Ones();
    for (int n = 0; n < 3; ++n) {
      const std::size_t node = key[static_cast<std::size_t>(n)];
      lines(0, n) = first_of(node, has[kLiquid] && has[kAir]) / shape_.cell_m;
      lines(1, n) = second_of(node, has[kWall]) / shape_.cell_m;
    }
    if (lines.allFinite() && std::abs(lines.determinant()) > 1e-9) {
      const Vector3d shares = lines.inverse() * Vector3d::UnitZ();
      if (shares.minCoeff() >= kLeastShare)
        x = shares[0] * position(place(key[0])) + shares[1] * position(place(key[1])) +
            shares[2] * position(place(key[2]));
    }
    return face_vertex_[key] = add_vertex(x);
  }

  const Vector3d& at(int vertex) const { return vertices_[static_cast<std::size_t>(vertex)]; }

  /// A corner of a polygon, and where it would be with every edge cut in the middle: that tells which way round the polygon runs, also
  /// where the real one is bent or next to nothing.
  struct Corner {
    int vertex;
    Vector3d ideal;
  };
  Corner edge_corner(std::size_t a, std::size_t b) {
    return {edge(a, b), 0.5 * (position(place(a)) + position(place(b)))};
  }
  Corner face_corner(std::size_t a, std::size_t b, std::size_t c) {
    return {face(a, b, c), (position(place(a)) + position(place(b)) + position(place(c))) / 3.0};
  }
  Corner middle_corner(const std::array<std::size_t, 4>& nodes) {
    Vector3d sum = Vector3d::Zero();
    for (const std::size_t node : nodes) sum += 0.25 * position(place(node));
    return {centre(nodes), sum};
  }

  void polygon(const std::vector<Corner>& ring, int region, const Vector3d& out) {
    Vector3d normal = Vector3d::Zero();
    for (std::size_t c = 1; c + 1 < ring.size(); ++c)
      normal += (ring[c].ideal - ring[0].ideal).cross(ring[c + 1].ideal - ring[0].ideal);
    const bool turn = normal.dot(out) < 0.0;
    for (std::size_t c = 1; c + 1 < ring.size(); ++c) {
      const int b = ring[c].vertex, d = ring[c + 1].vertex;
      triangles_.push_back(turn ? std::array<int, 3>{ring[0].vertex, d, b} : std::array<int, 3>{ring[0].vertex, b, d});
      region_.push_back(region);
    }
  }

  /// Labels of four corners in groups; each pair of groups is parted by a polygon.
  void cut(const std::array<std::size_t, 4>& nodes) {
    std::array<Label, 4> labels{};
    for (std::size_t c = 0; c < 4; ++c) labels[c] = label_[nodes[c]];
    for (int first = 0; first < 4; ++first)
      for (int second = 0; second < 4; ++second) {
        const auto inside = static_cast<Label>(first), outside = static_cast<Label>(second);
        const int region = first == second ? kDropped : region_of(inside, outside);
        if (region != kDropped) part(nodes, labels, inside, outside, region);
      }
  }

  void part(const std::array<std::size_t, 4>& nodes, const std::array<Label, 4>& labels, Label inside, Label outside,
            int region) {
    std::array<std::size_t, 4> in{}, out{}, rest{};
    std::size_t n_in = 0, n_out = 0, n_rest = 0;
    for (std::size_t c = 0; c < 4; ++c)
      (labels[c] == inside ? in[n_in++] : labels[c] == outside ? out[n_out++] : rest[n_rest++]) = nodes[c];
    if (n_in == 0 || n_out == 0) return;
    Vector3d from = Vector3d::Zero(), to = Vector3d::Zero();
    for (std::size_t c = 0; c < n_in; ++c) from += position(place(in[c])) / static_cast<double>(n_in);
    for (std::size_t c = 0; c < n_out; ++c) to += position(place(out[c])) / static_cast<double>(n_out);
    std::vector<Corner> ring;
    if (n_rest == 0) {
      if (n_in == 2 && n_out == 2) {
        ring = {edge_corner(in[0], out[0]), edge_corner(in[0], out[1]), edge_corner(in[1], out[1]),
                edge_corner(in[1], out[0])};
      } else if (n_in == 1) {
        ring = {edge_corner(in[0], out[0]), edge_corner(in[0], out[1]), edge_corner(in[0], out[2])};
      } else {
        ring = {edge_corner(in[0], out[0]), edge_corner(in[1], out[0]), edge_corner(in[2], out[0])};
      }
    } else if (n_rest == 1) {
      const std::size_t a = in[n_in - 1], b = out[n_out - 1];
      ring = {edge_corner(in[0], out[0]), edge_corner(a, b), face_corner(a, b, rest[0]),
              face_corner(in[0], out[0], rest[0])};
    } else if (rest_labels_agree(nodes, labels, inside, outside)) {
      ring = {edge_corner(in[0], out[0]), face_corner(in[0], out[0], rest[0]), face_corner(in[0], out[0], rest[1])};
    } else {
      ring = {edge_corner(in[0], out[0]), face_corner(in[0], out[0], rest[0]), middle_corner(nodes),
              face_corner(in[0], out[0], rest[1])};
    }
    polygon(ring, region, to - from);
  }

  bool rest_labels_agree(const std::array<std::size_t, 4>& nodes, const std::array<Label, 4>& labels, Label inside,
                         Label outside) const {
    int other = -1;
    for (std::size_t c = 0; c < nodes.size(); ++c) {
      if (labels[c] == inside || labels[c] == outside) continue;
      if (other >= 0 && labels[c] != static_cast<Label>(other)) return false;
      other = labels[c];
    }
    return true;
  }

  int centre(const std::array<std::size_t, 4>& nodes) {
    std::array<std::size_t, 4> key = nodes;
    std::sort(key.begin(), key.end());
    const auto found = centre_vertex_.find(key);
    if (found != centre_vertex_.end()) return found->second;
    Vector3d sum = Vector3d::Zero();
    for (std::size_t a = 0; a < 4; ++a)
      for (std::size_t b = a + 1; b < 4; ++b) sum += at(edge(key[a], key[b])) / 6.0;
    return centre_vertex_[key] = add_vertex(sum);
  }

  const GridShape& shape_;
  const Field &phi_, &solid_;
  int nx_, ny_, nz_;
  std::vector<Label> label_;
  std::vector<int> edge_vertex_;
  std::map<std::array<std::size_t, 3>, int> face_vertex_;
  std::map<std::array<std::size_t, 4>, int> centre_vertex_;
  std::vector<Vector3d> vertices_;
  std::vector<std::array<int, 3>> triangles_;
  std::vector<int> region_;
};

}  // namespace

LiquidSurface liquid_surface(const GridShape& shape, const Field& phi_m, const Field& solid_m) {
  return Mesher(shape, phi_m, solid_m).run();
}

}  // namespace klang::liquid
