#include "core/physics/rigid/detail/hull_features.hpp"

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
    offsets[f] = -lowest_along(by_axis, -normals.col(f));
  }
  if (kept.empty()) return;  // corners on a line: faces without normals have no edges either
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
    const Vector3d along = all.col(side.second) - all.col(side.first);
    edges.push_back(
        {all.col(side.first), along, left, right, {index(left), index(right)}, left.cross(right).dot(along) > 0});
  }
  normals_by_axis = normals.transpose();
  edges_of_face.resize(kept.size());
  for (std::size_t i = 0; i < edges.size(); ++i)
    for (const Eigen::Index face : edges[i].faces)
      edges_of_face[static_cast<std::size_t>(face)].push_back(static_cast<int>(i));
  plates_of_corner.resize(static_cast<std::size_t>(all.cols()));
  for (std::size_t i = 0; i < plates.size(); ++i)
    for (const int corner : plates[i].corners)
      plates_of_corner[static_cast<std::size_t>(corner)].push_back(static_cast<int>(i));
}

double gap_along(const HullFeatures& a, const HullFeatures& b, const Eigen::Isometry3d& b_to_a,
                 const Vector3d& normal) {
  return lowest_along(a.by_axis, normal) + lowest_along(b.by_axis, -(b_to_a.linear().transpose() * normal)) -
         normal.dot(b_to_a.translation());
}

}  // namespace klang::rigid::detail
