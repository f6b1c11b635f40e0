#include "core/physics/rigid/detail/hull_axis.hpp"

#include <algorithm>
#include <cmath>

namespace klang::rigid::detail {
namespace {

using Edge = HullFeatures::Edge;
using Eigen::Vector3d;

constexpr double kTie = 1e-13;       // of the sizes: a face is taken before edges that part no better
constexpr double kRounding = 1e-14;  // of the sizes: more than what sums of places lose

/// Edges that are tried, in the frame of the call.
struct KeptEdge {
  std::size_t number = 0;
  Vector3d from, along;
  Eigen::Index left = 0, right = 0;  // rows of the faces' normals
  bool along_turn = false;
};

/// Room that is kept from call to call.
struct Room {
  Eigen::MatrixX3d corners_a, corners_b;  // each in the other's frame
  Eigen::MatrixXd heights_a, heights_b;   // of the other hull's corners, or its one point, over each face
  std::vector<std::size_t> of_a, of_b;
  std::vector<KeptEdge> edges_b;
  std::vector<Eigen::Index> row_of_face;
  Eigen::MatrixX3d normals_b;  // of faces beside edges_b
  Eigen::VectorXd across;      // along an edge of a
};

void place_corners(const Eigen::MatrixX3d& corners, const Eigen::Isometry3d& to, Eigen::MatrixX3d& there) {
  there.resize(corners.rows(), 3);
  for (int i = 0; i < 3; ++i)
    there.col(i) =
        (to(i, 0) * corners.col(0) + to(i, 1) * corners.col(1) + to(i, 2) * corners.col(2)).array() + to(i, 3);
}

/// Edges that can be of an axis along which the hulls overlap less than by `-gap`. With a point of the other hull at least that deep
/// below both faces of an edge there is none: every direction between the two normals sees that point as deep (one that is above both is
/// higher still along directions between).
void find_edges_that_count(const HullFeatures& hull, const Eigen::MatrixXd& heights, double gap,
                           std::vector<std::size_t>& kept) {
  constexpr double kSameFace = 1e-8;  // of the sizes: normals that are one
  kept.clear();
  if (!hull.whole) {
    for (std::size_t i = 0; i < hull.edges.size(); ++i) kept.push_back(i);
    return;
  }
  const double enough = std::min(gap, 0.0) - kSameFace * (hull.size + heights.cwiseAbs().maxCoeff());
  if (heights.rows() == 1) {  // those of the faces that the point does not lie so deep under
    for (Eigen::Index f = 0; f < heights.cols(); ++f)
      if (heights(0, f) > enough)
        for (const int edge : hull.edges_of_face[static_cast<std::size_t>(f)])
          kept.push_back(static_cast<std::size_t>(edge));
    std::sort(kept.begin(), kept.end());
    kept.erase(std::unique(kept.begin(), kept.end()), kept.end());
    return;
  }
  const auto counts = [&](const Edge& edge) {
    const double *left = heights.col(edge.faces[0]).data(), *right = heights.col(edge.faces[1]).data();
    for (Eigen::Index k = 0; k < heights.rows(); ++k)
      if (std::max(left[k], right[k]) <= enough) return false;
    return true;
  };
  for (std::size_t i = 0; i < hull.edges.size(); ++i)
    if (counts(hull.edges[i])) kept.push_back(i);
}

/// Over pairs of edges. Of whole hulls only those that are sides of the Minkowski difference, whose arcs of normals cross, else those
/// that lie outermost along their axis.
class EdgePairs {
 public:
  /// @param room  holds the edges that count, and b's corners
  /// @param near  hull_axis()
  EdgePairs(const HullFeatures& a, const HullFeatures& b, const Eigen::Isometry3d& b_to_a, double near, Room& room)
      : a_(a), b_(b), near_(near), whole_(a.whole && b.whole), room_(room) {
    room.edges_b.clear();
    room.row_of_face.assign(static_cast<std::size_t>(b.normals.cols()), -1);
    room.normals_b.resize(b.normals.cols(), 3);
    Eigen::Index n_rows = 0;
    const auto row_of = [&](Eigen::Index face) {
      Eigen::Index& row = room.row_of_face[static_cast<std::size_t>(face)];
      if (row < 0) {
        row = n_rows++;
        room.normals_b.row(row) = (b_to_a.linear() * b.normals.col(face)).transpose();
      }
      return row;
    };
    for (const std::size_t j : room.of_b) {
      const Edge& edge = b.edges[j];
      room.edges_b.push_back({j, b_to_a * edge.from, b_to_a.linear() * edge.along, row_of(edge.faces[0]),
                              row_of(edge.faces[1]), edge.along_turn});
    }
    n_rows_ = n_rows;
  }

  /// @returns  the best so far parts the two
  bool try_all(HullAxis& best) {
    const auto normals = room_.normals_b.topRows(n_rows_);
    for (const std::size_t i : room_.of_a) {
      const Edge& ea = a_.edges[i];
      if (whole_)
        room_.across = ea.along.x() * normals.col(0) + ea.along.y() * normals.col(1) + ea.along.z() * normals.col(2);
      for (const KeptEdge& eb : room_.edges_b)
        if ((!whole_ || arcs_cross(ea, eb)) && try_pair(ea, i, eb, best)) return true;
    }
    return false;
  }

 private:
  /// Whether the arcs of normals of an edge of a and of one of -b cross: then they span a face of the Minkowski difference.
  bool arcs_cross(const Edge& a, const KeptEdge& b) const {
    const double b_left = room_.across[b.left], b_right = room_.across[b.right];
    if (b_left * b_right >= 0) return false;
    const double a_left = a.left.dot(b.along), a_right = a.right.dot(b.along);
    if (a_left * a_right >= 0) return false;
    // The same hemisphere, by the side to which each edge's normals turn.
    return (a.along_turn == b.along_turn ? 1.0 : -1.0) * b_left * a_right < 0;
  }

  bool try_pair(const Edge& ea, std::size_t i, const KeptEdge& eb, HullAxis& best) const {
    Vector3d normal = ea.along.cross(eb.along);
    const double length = normal.norm();
    if (!(length > 1e-6 * ea.along.norm() * eb.along.norm())) return false;
    normal /= length;
    const double sizes = a_.size + b_.size;
    const auto take = [&](const Vector3d& way) {
      // No gap is wider than the distance of two corners along it.
      if (way.dot(ea.from - eb.from) <= best.gap + (kTie - kRounding) * sizes) return false;
      const double low = lowest_along(a_.by_axis, way), high = -lowest_along(room_.corners_b, -way), gap = low - high;
      if (!(gap > best.gap + kTie * sizes)) return false;
      constexpr double kOutermost = 1e-9;
      if (way.dot(ea.from) > low + kOutermost * a_.size || way.dot(eb.from) < high - kOutermost * b_.size) return false;
      best = {way, gap, std::array{i, eb.number}};
      return gap > near_;
    };
    if (whole_) return take(normal.dot(ea.left + ea.right) < 0 ? normal : Vector3d(-normal));
    return take(normal) || take(-normal);
  }

  const HullFeatures &a_, &b_;
  double near_;
  bool whole_;
  Room& room_;
  Eigen::Index n_rows_ = 0;
};

/// Axes that are faces' normals.
class Faces {
 public:
  /// @param corners  of the other hull, in its frame  @param point  of the other hull, or none
  Faces(const HullFeatures& hull, const Eigen::MatrixX3d& corners, const Vector3d* point, double at_least,
        Eigen::MatrixXd& heights)
      : hull_(hull), corners_(corners), at_least_(at_least), heights_(heights), known_(point == nullptr) {
    const Eigen::MatrixX3d& normals = hull.normals_by_axis;
    heights.resize(point != nullptr ? 1 : corners.rows(), normals.rows());
    if (point != nullptr) {
      heights.row(0) =
          (point->x() * normals.col(0) + point->y() * normals.col(1) + point->z() * normals.col(2) - hull.offsets)
              .transpose();
      return;
    }
    for (Eigen::Index f = 0; f < heights.cols(); ++f)
      heights.col(f) =
          (normals(f, 0) * corners.col(0) + normals(f, 1) * corners.col(1) + normals(f, 2) * corners.col(2)).array() -
          hull.offsets[f];
  }
  Eigen::Index n() const { return heights_.cols(); }
  /// Of the other hull's lowest corner, or of its point where that cannot part them better than what is known.
  double gap(Eigen::Index f, double best) const {
    constexpr double kSure = 1e-12;  // of the size
    if (known_) return heights_.col(f).minCoeff();
    if (heights_(0, f) < std::max(best, at_least_) - kSure * hull_.size) return -HUGE_VAL;
    return lowest_along(corners_, hull_.normals.col(f)) - hull_.offsets[f];
  }

 private:
  const HullFeatures& hull_;
  const Eigen::MatrixX3d& corners_;
  double at_least_;
  const Eigen::MatrixXd& heights_;
  bool known_;
};

}  // namespace

HullAxis hull_axis(const HullFeatures& a, const HullFeatures& b, const Eigen::Isometry3d& b_to_a, double near,
                   const HullHint* hint) {
  static thread_local Room room;
  const Eigen::Isometry3d a_to_b = b_to_a.inverse();
  place_corners(b.by_axis, b_to_a, room.corners_b);
  HullAxis best;
  best.gap = -HUGE_VAL;
  const auto take = [&](const Vector3d& normal, double gap) {
    if (gap > best.gap) best = {normal, gap, {}};
    return gap > near;
  };
  Vector3d on_a, on_b;
  if (hint != nullptr) on_a = a_to_b * hint->on_a, on_b = b_to_a * hint->on_b;
  const double at_least = hint != nullptr ? hint->gap : -HUGE_VAL;
  const Faces over_a(a, room.corners_b, hint != nullptr ? &on_b : nullptr, at_least, room.heights_a);
  for (Eigen::Index f = 0; f < over_a.n(); ++f)
    if (take(-a.normals.col(f), over_a.gap(f, best.gap))) return best;
  place_corners(a.by_axis, a_to_b, room.corners_a);
  const Faces over_b(b, room.corners_a, hint != nullptr ? &on_a : nullptr, at_least, room.heights_b);
  for (Eigen::Index f = 0; f < over_b.n(); ++f)
    if (take(b_to_a.linear() * b.normals.col(f), over_b.gap(f, best.gap))) return best;
  const double parted = std::max(best.gap, at_least - kTie * (a.size + b.size));
  find_edges_that_count(a, room.heights_a, parted, room.of_a);
  find_edges_that_count(b, room.heights_b, parted, room.of_b);
  if (EdgePairs(a, b, b_to_a, near, room).try_all(best)) return best;
  constexpr double kLost =
      1e-9;  // of the sizes: edges that are nearly parallel have no axis, and faces were left out for theirs
  if (best.gap < at_least - kLost * (a.size + b.size)) return hull_axis(a, b, b_to_a, near);
  return best;
}

}  // namespace klang::rigid::detail
