#include "core/physics/fracture/pattern/power_cells.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace klang::fracture {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kLargestShift = 0.6;  // |w_i - w_j| / d^2
constexpr double kOnPlane = 1e-12;     // of the size

/// Plane convex hull (Andrew's chain): the corners' numbers; points on its sides are left out. Points nearer than the tolerance are one,
/// and x that differ by less are equal: else points of a side along y would come in the order of their rounding.
std::vector<int> plane_hull(std::vector<Vector2d> points, double tolerance) {
  std::vector<int> order, hull;
  for (std::size_t i = 0; i < points.size(); ++i)
    if (std::none_of(order.begin(), order.end(),
                     [&](int k) { return (points[k] - points[i]).norm() <= 2.0 * tolerance; }))
      order.push_back(static_cast<int>(i));
  std::sort(order.begin(), order.end(), [&](int a, int b) { return points[a].x() < points[b].x(); });
  for (std::size_t i = 1; i < order.size(); ++i)
    if (points[order[i]].x() - points[order[i - 1]].x() <= tolerance) points[order[i]].x() = points[order[i - 1]].x();
  std::sort(order.begin(), order.end(), [&](int a, int b) {
    return points[a].x() != points[b].x() ? points[a].x() < points[b].x() : points[a].y() < points[b].y();
  });
  if (order.size() < 3) return order;
  const auto chain = [&](auto begin, auto end) {
    std::vector<int> side;
    for (auto it = begin; it != end; ++it) {
      const Vector2d& p = points[*it];
      while (side.size() >= 2) {
        const Vector2d a = points[side.back()] - points[side[side.size() - 2]], b = p - points[side.back()];
        if (a.x() * b.y() - a.y() * b.x() > 1e-12 * a.norm() * b.norm()) break;
        side.pop_back();
      }
      side.push_back(*it);
    }
    side.pop_back();
    hull.insert(hull.end(), side.begin(), side.end());
  };
  chain(order.begin(), order.end());
  chain(order.rbegin(), order.rend());
  return hull;
}

Eigen::VectorXd power_weights(const std::vector<Seed>& seeds, double alpha) {
  const auto n = static_cast<Eigen::Index>(seeds.size());
  Eigen::VectorXd weights = Eigen::VectorXd::Zero(n);
  if (n < 2 || alpha == 0.0) return weights;
  Eigen::MatrixXd distance_sq(n, n);
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j < n; ++j) distance_sq(i, j) = (seeds[i].at_m - seeds[j].at_m).squaredNorm();
  // The first weight is 0 while solving; lengths in the largest distance.
  const double unit = distance_sq.maxCoeff();
  Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(n, n);
  Eigen::VectorXd right = Eigen::VectorXd::Zero(n);
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = i + 1; j < n; ++j) {
      const double d_sq = distance_sq(i, j) / unit, weight = 1.0 / (d_sq * d_sq * d_sq);
      const double ratio = std::pow(seeds[j].density / seeds[i].density, alpha);
      const double wanted = d_sq * (ratio - 1.0) / (ratio + 1.0);
      normal(i, i) += weight;
      normal(j, j) += weight;
      normal(i, j) -= weight;
      normal(j, i) -= weight;
      right[i] += weight * wanted;
      right[j] -= weight * wanted;
    }
  weights.tail(n - 1) = normal.bottomRightCorner(n - 1, n - 1).ldlt().solve(right.tail(n - 1));
  weights.array() -= weights.mean();
  double largest = 0.0;
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = i + 1; j < n; ++j)
      largest = std::max(largest, std::abs(weights[i] - weights[j]) * unit / distance_sq(i, j));
  if (largest > kLargestShift) weights *= kLargestShift / largest;
  return unit * weights;
}

}  // namespace

PowerCells::PowerCells(std::vector<Seed> seeds, double alpha)
    : seeds_(std::move(seeds)), weights_m2_(power_weights(seeds_, alpha)) {}

RegionFields PowerCells::fields(const mesh::TetMesh& mesh) const {
  const Vector3d middle = mesh.nodes_m.colwise().mean().transpose();
  const auto n = static_cast<Eigen::Index>(seeds_.size());
  RegionFields fields{Eigen::MatrixXd(n, mesh.n_nodes()), Eigen::MatrixXd::Zero(n, n)};
  for (Eigen::Index i = 0; i < n; ++i) {
    const Vector3d p = seeds_[i].at_m - middle;
    for (int v = 0; v < mesh.n_nodes(); ++v) {
      const Vector3d x = mesh.nodes_m.row(v).transpose() - middle;
      fields.values(i, v) = p.squaredNorm() - weights_m2_[i] - 2.0 * p.dot(x);
    }
    for (Eigen::Index j = 0; j < n; ++j) fields.slopes(i, j) = 2.0 * (seeds_[i].at_m - seeds_[j].at_m).norm();
  }
  return fields;
}

std::vector<HalfSpace> PowerCells::half_spaces(int cell) const {
  std::vector<HalfSpace> all;
  const Vector3d& p = seeds_[cell].at_m;
  for (int j = 0; j < n_cells(); ++j) {
    if (j == cell) continue;
    const Vector3d towards = seeds_[j].at_m - p;
    const double distance = towards.norm();
    const Vector3d normal = towards / distance;
    all.push_back({normal, normal.dot(p) + 0.5 * distance + (weights_m2_[cell] - weights_m2_[j]) / (2.0 * distance)});
  }
  return all;
}

Eigen::Matrix3Xd clipped_corners(const Eigen::Matrix3Xd& corners_m, const HalfSpace& half_space) {
  if (corners_m.cols() == 0) return corners_m;
  const double size = (corners_m.rowwise().maxCoeff() - corners_m.rowwise().minCoeff()).norm();
  const Eigen::VectorXd height = (half_space.normal.transpose() * corners_m).transpose().array() - half_space.offset_m;
  if (height.maxCoeff() <= kOnPlane * size) return corners_m;
  if (height.minCoeff() >= -kOnPlane * size) return Eigen::Matrix3Xd(3, 0);
  std::vector<Vector3d> kept, section;
  for (Eigen::Index i = 0; i < corners_m.cols(); ++i) {
    if (height[i] <= kOnPlane * size) (height[i] >= -kOnPlane * size ? section : kept).push_back(corners_m.col(i));
    if (height[i] >= -kOnPlane * size) continue;
    for (Eigen::Index j = 0; j < corners_m.cols(); ++j)
      if (height[j] > kOnPlane * size) {
        const double t = height[i] / (height[i] - height[j]);
        section.push_back((1.0 - t) * corners_m.col(i) + t * corners_m.col(j));
      }
  }
  const Vector3d e = half_space.normal.unitOrthogonal(), f = half_space.normal.cross(e);
  std::vector<Vector2d> flat;
  for (const Vector3d& p : section) flat.emplace_back(p.dot(e), p.dot(f));
  for (const int i : plane_hull(flat, kOnPlane * size)) kept.push_back(section[i]);
  Eigen::Matrix3Xd out(3, static_cast<Eigen::Index>(kept.size()));
  for (std::size_t i = 0; i < kept.size(); ++i) out.col(static_cast<Eigen::Index>(i)) = kept[i];
  return out;
}

}  // namespace klang::fracture
