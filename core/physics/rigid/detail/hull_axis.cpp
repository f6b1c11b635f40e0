#include "core/physics/rigid/detail/hull_axis.hpp"

#include <cmath>
#include <map>
#include <utility>

namespace klang::rigid::detail {
namespace {

using Eigen::Vector3d;

constexpr double kParallel = 1e-9;  // sine between directions that are one

double lowest(const Eigen::Matrix3Xd& corners, const Vector3d& direction) {
  double least = HUGE_VAL;
  for (Eigen::Index i = 0; i < corners.cols(); ++i) least = std::min(least, direction.dot(corners.col(i)));
  return least;
}

}  // namespace

HullFeatures::HullFeatures(const Eigen::Matrix3Xd& all, const std::vector<std::vector<int>>& faces)
    : corners(all), centre(all.rowwise().mean()) {
  std::vector<Vector3d> kept, of_face;
  std::map<std::pair<int, int>, std::size_t> face_of_side;
  for (const std::vector<int>& face : faces) {
    Vector3d normal = Vector3d::Zero();
    for (std::size_t i = 2; i < face.size(); ++i)
      normal += (all.col(face[i - 1]) - all.col(face[0])).cross(all.col(face[i]) - all.col(face[0]));
    normal.normalize();
    for (std::size_t i = 0; i < face.size(); ++i) face_of_side[{face[i], face[(i + 1) % face.size()]}] = of_face.size();
    of_face.push_back(normal);
    bool known = false;
    for (const Vector3d& other : kept)
      known = known || (normal.cross(other).norm() < kParallel && normal.dot(other) > 0);
    if (!known && normal.allFinite()) kept.push_back(normal);
  }
  normals.resize(3, static_cast<Eigen::Index>(kept.size()));
  offsets.resize(normals.cols());
  for (Eigen::Index f = 0; f < normals.cols(); ++f) {
    normals.col(f) = kept[static_cast<std::size_t>(f)];
    offsets[f] = -lowest(corners, -normals.col(f));
  }
  whole = normals.cols() >= 4;
  for (const auto& [side, face] : face_of_side) {
    const auto back = face_of_side.find({side.second, side.first});
    if (back == face_of_side.end()) whole = false;
    if (back == face_of_side.end() || side.first > side.second) continue;
    const Vector3d left = of_face[face], right = of_face[back->second];
    if (!(left.cross(right).norm() > kParallel)) continue;  // inside a flat face
    edges.push_back({all.col(side.first), all.col(side.second) - all.col(side.first), left, right});
  }
}

double gap_along(const HullFeatures& a, const HullFeatures& b, const Eigen::Isometry3d& b_to_a,
                 const Vector3d& normal) {
  return lowest(a.corners, normal) + lowest(b.corners, -(b_to_a.linear().transpose() * normal)) -
         normal.dot(b_to_a.translation());
}

namespace {

/// b with its corners, normals and edges in a's frame.
HullFeatures moved(const HullFeatures& b, const Eigen::Isometry3d& to) {
  HullFeatures there;
  const Eigen::Matrix3d turn = to.linear();
  there.corners = (turn * b.corners).colwise() + to.translation();
  there.normals = turn * b.normals;
  there.centre = to * b.centre;
  there.edges.reserve(b.edges.size());
  for (const HullFeatures::Edge& edge : b.edges)
    there.edges.push_back({to * edge.from, turn * edge.along, turn * edge.left, turn * edge.right});
  return there;
}

/// Whether the arcs of normals of an edge of a and of one of -b cross: then they span a face of the Minkowski difference.
bool arcs_cross(const HullFeatures::Edge& a, const HullFeatures::Edge& b) {
  const Vector3d c = -b.left, d = -b.right;
  const double c_ba = -c.dot(a.along), d_ba = -d.dot(a.along);  // along is parallel to left x right, either way
  if (c_ba * d_ba >= 0) return false;
  const double a_dc = a.left.dot(b.along), b_dc = a.right.dot(b.along);
  if (a_dc * b_dc >= 0) return false;
  // The same hemisphere.
  const double side = a.left.cross(a.right).dot(a.along) * c.cross(d).dot(b.along);
  return (side > 0 ? 1.0 : -1.0) * c_ba * b_dc > 0;
}

}  // namespace

HullAxis hull_axis(const HullFeatures& a, const HullFeatures& b, const Eigen::Isometry3d& b_to_a) {
  const HullFeatures there = moved(b, b_to_a);
  HullAxis best;
  best.gap = -HUGE_VAL;
  const auto take = [&](const Vector3d& normal, double gap) {
    if (gap > best.gap) best = {normal, gap};
    return gap > 0;
  };
  for (Eigen::Index f = 0; f < a.normals.cols(); ++f) {
    const Vector3d normal = a.normals.col(f);
    if (take(-normal, lowest(there.corners, normal) - a.offsets[f])) return best;
  }
  for (Eigen::Index f = 0; f < there.normals.cols(); ++f) {
    const Vector3d normal = there.normals.col(f);
    const double offset = b.offsets[f] + normal.dot(b_to_a.translation());
    if (take(normal, lowest(a.corners, normal) - offset)) return best;
  }
  const Vector3d from_b = a.centre - there.centre;
  for (const HullFeatures::Edge& ea : a.edges) {
    for (const HullFeatures::Edge& eb : there.edges) {
      if (a.whole && b.whole && !arcs_cross(ea, eb)) continue;
      Vector3d normal = ea.along.cross(eb.along);
      const double length = normal.norm();
      if (!(length > 1e-6 * ea.along.norm() * eb.along.norm())) continue;
      normal *= (normal.dot(from_b) < 0 ? -1.0 : 1.0) / length;
      if (take(normal, lowest(a.corners, normal) + lowest(there.corners, -normal))) return best;
    }
  }
  return best;
}

}  // namespace klang::rigid::detail
