#include "core/physics/rigid/detail/hull_axis.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>

namespace klang::rigid::detail {
namespace {

using Eigen::Vector3d;

constexpr double kParallel = 1e-9;  // sine between directions that are one
constexpr double kOnALine = 1e-9;   // twice the area of a triangle over its longest side squared
constexpr double kFlat = 1e-5;      // sine between faces that touch as one: far below what bodies that rest overlap by
constexpr double kTie = 1e-13;      // of the sizes: a face is taken before edges that part no better

double lowest(const Eigen::MatrixX3d& by_axis, const Vector3d& direction) {
  return (direction.x() * by_axis.col(0) + direction.y() * by_axis.col(1) + direction.z() * by_axis.col(2)).minCoeff();
}

/// Unit, out of a face; zero where its corners lie on a line.
Vector3d normal_of(const Eigen::Matrix3Xd& all, const std::vector<int>& face) {
  Vector3d sum = Vector3d::Zero();
  double longest = 0.0;
  for (std::size_t i = 0; i < face.size(); ++i) {
    const Vector3d to = all.col(face[(i + 1) % face.size()]) - all.col(face[0]);
    sum += (all.col(face[i]) - all.col(face[0])).cross(to);
    longest = std::max(longest, to.squaredNorm());
  }
  const double area = sum.norm();
  return area > kOnALine * longest ? Vector3d(sum / area) : Vector3d(Vector3d::Zero());
}

using FaceOfSide = std::map<std::pair<int, int>, std::size_t>;

/// A face on a line gets the normal of the face along its longest side, so that the faces along its other sides meet that one.
void lend_normals(const Eigen::Matrix3Xd& all, const std::vector<std::vector<int>>& faces, const FaceOfSide& face_of,
                  std::vector<Vector3d>& normals) {
  for (bool lent = true; lent;) {
    lent = false;
    for (std::size_t f = 0; f < faces.size(); ++f) {
      if (!normals[f].isZero(0)) continue;
      const std::vector<int>& face = faces[f];
      double longest = -1.0;
      Vector3d along = Vector3d::Zero();
      for (std::size_t i = 0; i < face.size(); ++i) {
        const int from = face[i], to = face[(i + 1) % face.size()];
        const auto back = face_of.find({to, from});
        const double length = (all.col(to) - all.col(from)).norm();
        if (back == face_of.end() || !(length > longest)) continue;
        longest = length;
        along = normals[back->second];
      }
      if (along.isZero(0)) continue;
      normals[f] = along;
      lent = true;
    }
  }
}

/// The hull, anticlockwise about a normal, of corners in a plane; corners on its sides are left out.
std::vector<int> rim(const Eigen::Matrix3Xd& all, const std::set<int>& corners, const Vector3d& normal) {
  const Vector3d x = normal.unitOrthogonal(), y = normal.cross(x);
  std::vector<std::array<double, 3>> points;
  for (const int corner : corners)
    points.push_back({x.dot(all.col(corner)), y.dot(all.col(corner)), static_cast<double>(corner)});
  std::sort(points.begin(), points.end());
  const auto turn = [](const auto& p, const auto& q, const auto& r) {
    const double ux = q[0] - p[0], uy = q[1] - p[1], vx = r[0] - q[0], vy = r[1] - q[1];
    return (ux * vy - uy * vx) - kOnALine * std::hypot(ux, uy) * std::hypot(vx, vy);
  };
  std::vector<std::array<double, 3>> hull;
  for (int half = 0; half < 2; ++half) {  // there below, back above
    const std::size_t start = hull.size();
    for (const auto& point : points) {
      while (hull.size() >= start + 2 && turn(hull[hull.size() - 2], hull.back(), point) <= 0) hull.pop_back();
      hull.push_back(point);
    }
    hull.pop_back();
    std::reverse(points.begin(), points.end());
  }
  std::vector<int> loop;
  for (const auto& point : hull) loop.push_back(static_cast<int>(point[2]));
  return loop;
}

/// @param normals  of the faces, zero for those on a line
std::vector<HullFeatures::Plate> plates_of(const Eigen::Matrix3Xd& all, const std::vector<std::vector<int>>& faces,
                                           const std::vector<Vector3d>& normals) {
  std::vector<HullFeatures::Plate> plates;
  std::vector<bool> taken(faces.size(), false);
  for (std::size_t f = 0; f < faces.size(); ++f) {
    if (taken[f] || normals[f].isZero(0)) continue;
    HullFeatures::Plate plate;
    plate.normal = normals[f];
    plate.offset = (all.transpose() * plate.normal).maxCoeff();
    std::set<int> corners;
    for (std::size_t g = f; g < faces.size(); ++g) {
      if (taken[g] || !(normals[g].dot(plate.normal) > 0 && normals[g].cross(plate.normal).norm() < kFlat)) continue;
      taken[g] = true;
      corners.insert(faces[g].begin(), faces[g].end());
    }
    plate.corners = rim(all, corners, plate.normal);
    if (plate.corners.size() >= 3) plates.push_back(std::move(plate));
  }
  return plates;
}

}  // namespace

HullFeatures::HullFeatures(const Eigen::Matrix3Xd& all, const std::vector<std::vector<int>>& faces)
    : corners(all),
      by_axis(all.transpose()),
      centre(all.rowwise().mean()),
      size((all.colwise() - centre).colwise().norm().maxCoeff()) {
  std::vector<Vector3d> kept, of_face;
  FaceOfSide face_of_side;
  for (std::size_t f = 0; f < faces.size(); ++f) {
    const std::vector<int>& face = faces[f];
    for (std::size_t i = 0; i < face.size(); ++i) face_of_side[{face[i], face[(i + 1) % face.size()]}] = f;
    of_face.push_back(normal_of(all, face));
    const Vector3d& normal = of_face.back();
    bool known = normal.isZero(0);
    for (const Vector3d& other : kept)
      known = known || (normal.cross(other).norm() < kParallel && normal.dot(other) > 0);
    if (!known) kept.push_back(normal);
  }
  plates = plates_of(all, faces, of_face);
  lend_normals(all, faces, face_of_side, of_face);
  normals.resize(3, static_cast<Eigen::Index>(kept.size()));
  offsets.resize(normals.cols());
  for (Eigen::Index f = 0; f < normals.cols(); ++f) {
    normals.col(f) = kept[static_cast<std::size_t>(f)];
    offsets[f] = -lowest(by_axis, -normals.col(f));
  }
  whole = normals.cols() >= 4;
  for (const auto& [side, face] : face_of_side) {
    const auto back = face_of_side.find({side.second, side.first});
    const bool both = back != face_of_side.end();
    const Vector3d left = of_face[face], right = both ? of_face[back->second] : left;
    if (!both || left.isZero(0) || right.isZero(0)) {
      whole = false;
      if (both && side.first > side.second) continue;
    } else if (side.first > side.second || !(left.cross(right).norm() > kParallel)) {
      continue;  // known, or inside a flat face
    }
    const auto index = [&](const Vector3d& normal) {
      for (Eigen::Index f = 0; f < normals.cols(); ++f)
        if (normal.cross(normals.col(f)).norm() < kParallel && normal.dot(normals.col(f)) > 0) return f;
      whole = false;
      return Eigen::Index{0};
    };
    edges.push_back(
        {all.col(side.first), all.col(side.second) - all.col(side.first), left, right, {index(left), index(right)}});
  }
}

double gap_along(const HullFeatures& a, const HullFeatures& b, const Eigen::Isometry3d& b_to_a,
                 const Vector3d& normal) {
  return lowest(a.by_axis, normal) + lowest(b.by_axis, -(b_to_a.linear().transpose() * normal)) -
         normal.dot(b_to_a.translation());
}

namespace {

using Edge = HullFeatures::Edge;

Edge moved(const Edge& edge, const Eigen::Isometry3d& to) {
  const Eigen::Matrix3d& turn = to.linear();
  return {to * edge.from, turn * edge.along, turn * edge.left, turn * edge.right, edge.faces};
}

Eigen::MatrixX3d placed(const Eigen::MatrixX3d& corners, const Eigen::Isometry3d& to) {
  Eigen::MatrixX3d there(corners.rows(), 3);
  for (int i = 0; i < 3; ++i)
    there.col(i) =
        (to(i, 0) * corners.col(0) + to(i, 1) * corners.col(1) + to(i, 2) * corners.col(2)).array() + to(i, 3);
  return there;
}

/// Of corners over the planes of a hull's faces, in its frame: a column per face.
Eigen::MatrixXd heights_over(const HullFeatures& hull, const Eigen::MatrixX3d& corners) {
  Eigen::MatrixXd heights(corners.rows(), hull.normals.cols());
  for (Eigen::Index f = 0; f < heights.cols(); ++f) {
    const Vector3d normal = hull.normals.col(f);
    heights.col(f) = (normal.x() * corners.col(0) + normal.y() * corners.col(1) + normal.z() * corners.col(2)).array() -
                     hull.offsets[f];
  }
  return heights;
}

/// Edges that can be of an axis along which the hulls overlap less than by `-gap`. With a point of the other hull at least that deep
/// below both faces of an edge there is none: every direction between the two normals sees that point as deep (one that is above both is
/// higher still along directions between).
std::vector<std::size_t> edges_that_count(const HullFeatures& hull, const Eigen::MatrixXd& heights, double gap) {
  constexpr double kSameFace = 10 * kParallel;  // of the sizes: normals that are one
  const double enough = std::min(gap, 0.0) - kSameFace * (hull.size + heights.cwiseAbs().maxCoeff());
  const auto counts = [&](const Edge& edge) {
    const double *left = heights.col(edge.faces[0]).data(), *right = heights.col(edge.faces[1]).data();
    for (Eigen::Index k = 0; k < heights.rows(); ++k)
      if (std::max(left[k], right[k]) <= enough) return false;
    return true;
  };
  std::vector<std::size_t> kept;
  for (std::size_t i = 0; i < hull.edges.size(); ++i)
    if (!hull.whole || counts(hull.edges[i])) kept.push_back(i);
  return kept;
}

/// Whether the arcs of normals of an edge of a and of one of -b cross: then they span a face of the Minkowski difference.
bool arcs_cross(const Edge& a, const Edge& b) {
  const Vector3d c = -b.left, d = -b.right;
  const double c_ba = -c.dot(a.along), d_ba = -d.dot(a.along);  // along is parallel to left x right, either way
  if (c_ba * d_ba >= 0) return false;
  const double a_dc = a.left.dot(b.along), b_dc = a.right.dot(b.along);
  if (a_dc * b_dc >= 0) return false;
  // The same hemisphere: c . (right x left) and right . (d x c) have one sign.
  const double side = a.left.cross(a.right).dot(a.along) * c.cross(d).dot(b.along);
  return (side > 0 ? 1.0 : -1.0) * c_ba * b_dc < 0;
}

/// Over pairs of edges. Of whole hulls only those that are sides of the Minkowski difference, else those that lie outermost along
/// their axis.
class EdgePairs {
 public:
  /// @param corners_b  in a's frame
  /// @param near       hull_axis()
  EdgePairs(const HullFeatures& a, const HullFeatures& b, const Eigen::MatrixX3d& corners_b, double near)
      : corners_a_(a.by_axis),
        corners_b_(corners_b),
        size_a_(a.size),
        size_b_(b.size),
        near_(near),
        whole_(a.whole && b.whole) {}

  /// @param i, j  numbers of the edges
  /// @returns     the best so far parts the two
  bool try_pair(const Edge& ea, std::size_t i, const Edge& eb, std::size_t j, HullAxis& best) const {
    if (whole_ && !arcs_cross(ea, eb)) return false;
    Vector3d normal = ea.along.cross(eb.along);
    const double length = normal.norm();
    if (!(length > 1e-6 * ea.along.norm() * eb.along.norm())) return false;
    normal /= length;
    const auto take = [&](const Vector3d& way) {
      const double low = lowest(corners_a_, way), high = -lowest(corners_b_, -way), gap = low - high;
      if (!(gap > best.gap + kTie * (size_a_ + size_b_))) return false;
      constexpr double kOutermost = 1e-9;
      if (way.dot(ea.from) > low + kOutermost * size_a_ || way.dot(eb.from) < high - kOutermost * size_b_) return false;
      best = {way, gap, std::array{i, j}};
      return gap > near_;
    };
    if (whole_) return take(normal.dot(ea.left + ea.right) < 0 ? normal : Vector3d(-normal));
    return take(normal) || take(-normal);
  }

 private:
  const Eigen::MatrixX3d &corners_a_, &corners_b_;
  double size_a_, size_b_, near_;
  bool whole_;
};

}  // namespace

namespace {

/// Axes that are faces' normals.
class Faces {
 public:
  /// @param corners  of the other hull, in its frame  @param point  of the other hull, or none
  Faces(const HullFeatures& hull, const Eigen::MatrixX3d& corners, const Vector3d* point, double at_least)
      : hull_(hull), corners_(corners), at_least_(at_least) {
    if (point != nullptr)
      heights_ = (point->transpose() * hull.normals) - hull.offsets.transpose();
    else
      heights_ = heights_over(hull, corners);
    known_ = point == nullptr;
  }
  Eigen::Index n() const { return heights_.cols(); }
  /// Of the other hull's lowest corner, or of its point where that cannot part them better than what is known.
  double gap(Eigen::Index f, double best) const {
    constexpr double kSure = 1e-12;  // of the size
    if (known_) return heights_.col(f).minCoeff();
    if (heights_(0, f) < std::max(best, at_least_) - kSure * hull_.size) return -HUGE_VAL;
    return lowest(corners_, hull_.normals.col(f)) - hull_.offsets[f];
  }
  const Eigen::MatrixXd& heights() const { return heights_; }

 private:
  const HullFeatures& hull_;
  const Eigen::MatrixX3d& corners_;
  double at_least_;
  Eigen::MatrixXd heights_;  // a column per face, a row per corner or the point
  bool known_;
};

}  // namespace

HullAxis hull_axis(const HullFeatures& a, const HullFeatures& b, const Eigen::Isometry3d& b_to_a, double near,
                   const HullHint* hint) {
  const Eigen::Isometry3d a_to_b = b_to_a.inverse();
  const Eigen::MatrixX3d corners_b = placed(b.by_axis, b_to_a);
  HullAxis best;
  best.gap = -HUGE_VAL;
  const auto take = [&](const Vector3d& normal, double gap) {
    if (gap > best.gap) best = {normal, gap, {}};
    return gap > near;
  };
  Vector3d on_a, on_b;
  if (hint != nullptr) on_a = a_to_b * hint->on_a, on_b = b_to_a * hint->on_b;
  const double at_least = hint != nullptr ? hint->gap : -HUGE_VAL;
  const Faces over_a(a, corners_b, hint != nullptr ? &on_b : nullptr, at_least);
  for (Eigen::Index f = 0; f < over_a.n(); ++f)
    if (take(-a.normals.col(f), over_a.gap(f, best.gap))) return best;
  const Eigen::MatrixX3d corners_a = placed(a.by_axis, a_to_b);
  const Faces over_b(b, corners_a, hint != nullptr ? &on_a : nullptr, at_least);
  for (Eigen::Index f = 0; f < over_b.n(); ++f)
    if (take(b_to_a.linear() * b.normals.col(f), over_b.gap(f, best.gap))) return best;
  const double parted = std::max(best.gap, at_least - kTie * (a.size + b.size));
  const std::vector<std::size_t> of_a = edges_that_count(a, over_a.heights(), parted);
  std::vector<Edge> edges_b;
  const std::vector<std::size_t> of_b = edges_that_count(b, over_b.heights(), parted);
  for (const std::size_t j : of_b) edges_b.push_back(moved(b.edges[j], b_to_a));
  const EdgePairs pairs(a, b, corners_b, near);
  for (const std::size_t i : of_a)
    for (std::size_t k = 0; k < of_b.size(); ++k)
      if (pairs.try_pair(a.edges[i], i, edges_b[k], of_b[k], best)) return best;
  constexpr double kLost =
      1e-9;  // of the sizes: edges that are nearly parallel have no axis, and faces were left out for theirs
  if (best.gap < at_least - kLost * (a.size + b.size)) return hull_axis(a, b, b_to_a, near);
  return best;
}

}  // namespace klang::rigid::detail
