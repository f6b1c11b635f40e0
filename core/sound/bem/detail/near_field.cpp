#include "core/sound/bem/detail/near_field.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "core/foundation/base/parallel.hpp"
#include "core/foundation/math/triangle_rules.hpp"
#include "core/sound/bem/detail/static_integrals.hpp"

namespace klang::acoustics::detail {
namespace {

using Eigen::Vector3d;

constexpr double kNearRatio = 2.0;  ///< near: centroids closer than this times the sum of both radii

/// Neighbours by a grid of cells; triangles much larger than the others are compared with all.
class Grid {
 public:
  explicit Grid(const RadiatingSurface& surface) : surface_(surface) {
    std::vector<double> radii(surface.radii_m.data(), surface.radii_m.data() + surface.radii_m.size());
    std::sort(radii.begin(), radii.end());
    limit_m_ = 2.0 * radii[radii.size() / 2];
    cell_m_ = kNearRatio * 2.0 * limit_m_;
    for (int t = 0; t < surface.n_triangles(); ++t) {
      if (surface.radii_m[t] > limit_m_)
        large_.push_back(t);
      else
        cells_[cell(surface.centroids_m.col(t))].push_back(t);
    }
  }

  std::vector<int> near(int t) const {
    std::vector<int> found;
    const auto add = [&](int other) {
      const double reach = kNearRatio * (surface_.radii_m[t] + surface_.radii_m[other]);
      if ((surface_.centroids_m.col(t) - surface_.centroids_m.col(other)).norm() < reach) found.push_back(other);
    };
    if (surface_.radii_m[t] > limit_m_) {
      for (int other = 0; other < surface_.n_triangles(); ++other) add(other);
      return found;
    }
    const auto middle = cell(surface_.centroids_m.col(t));
    for (int x = -1; x <= 1; ++x)
      for (int y = -1; y <= 1; ++y)
        for (int z = -1; z <= 1; ++z) {
          const auto at = cells_.find({middle[0] + x, middle[1] + y, middle[2] + z});
          if (at != cells_.end()) std::for_each(at->second.begin(), at->second.end(), add);
        }
    std::for_each(large_.begin(), large_.end(), add);
    std::sort(found.begin(), found.end());
    return found;
  }

 private:
  std::array<long, 3> cell(const Vector3d& p) const {
    return {std::lround(std::floor(p[0] / cell_m_)), std::lround(std::floor(p[1] / cell_m_)),
            std::lround(std::floor(p[2] / cell_m_))};
  }
  const RadiatingSurface& surface_;
  double limit_m_ = 0.0, cell_m_ = 0.0;
  std::vector<int> large_;
  std::map<std::array<long, 3>, std::vector<int>> cells_;
};

bool touch(const RadiatingSurface& surface, int test, int other) {
  const auto corners = surface.triangles.col(other).array();
  for (int c = 0; c < 3; ++c)
    if ((corners == surface.triangles(c, test)).any()) return true;
  return false;
}

FlatTriangle flat(const RadiatingSurface& surface, int t) {
  return {surface.corner(t, 0), surface.corner(t, 1), surface.corner(t, 2)};
}

NearPair near_pair(const RadiatingSurface& surface, const FlatTriangle& test, const FlatTriangle& triangle, int t,
                   int other) {
  NearPair pair{other, Eigen::Matrix3d::Zero(), Eigen::Matrix3d::Zero(), Eigen::Matrix3d::Zero()};
  // The inner integral is smooth over the test triangle, but for a logarithm along what both share.
  for (const TrianglePoint& point : touch(surface, t, other) ? boundary_points() : seven_points()) {
    const Eigen::Map<const Vector3d> hats(point.at.data());
    const Vector3d x = hats[0] * test.corners[0] + hats[1] * test.corners[1] + hats[2] * test.corners[2];
    const double weight = point.weight * surface.areas_m2[t];
    StaticIntegrals inner = static_integrals(triangle, x, t != other);
    pair.single += weight * hats * inner.single.transpose();
    if (t == other) continue;  // flat: no double layer on itself
    pair.twice += weight * hats * inner.twice.transpose();
    pair.adjoint += weight * hats * (test.normal.transpose() * inner.gradient);
  }
  return pair;
}

}  // namespace

std::size_t NearField::n_pairs() const {
  std::size_t n = 0;
  for (const auto& row : pairs) n += row.size();
  return n;
}

NearField near_field(const RadiatingSurface& surface, const std::vector<char>& tested) {
  const Grid grid(surface);
  const auto n = static_cast<std::size_t>(surface.n_triangles());
  NearField field;
  field.pairs.resize(n);
  std::vector<FlatTriangle> triangles;
  triangles.reserve(n);
  for (int t = 0; t < surface.n_triangles(); ++t) triangles.push_back(flat(surface, t));
  parallel_for(n, 64, [&](std::size_t begin, std::size_t end) {
    for (std::size_t t = begin; t < end; ++t) {
      if (tested[t] == 0) continue;
      const std::vector<int> others = grid.near(static_cast<int>(t));
      field.pairs[t].reserve(others.size());
      for (const int other : others)
        field.pairs[t].push_back(
            near_pair(surface, triangles[t], triangles[static_cast<std::size_t>(other)], static_cast<int>(t), other));
    }
  });
  return field;
}

std::complex<double> wave_less_one(double z) {
  const double s = std::sin(0.5 * z), c = std::cos(0.5 * z);
  return {-2.0 * s * s, -2.0 * s * c};
}

std::complex<double> slope_less_one(double z) {
  if (z < 0.05) {
    const double z2 = z * z;
    return {z2 * (0.5 - z2 * (1.0 / 8 - z2 / 144)), -z2 * z * (1.0 / 3 - z2 * (1.0 / 30 - z2 / 840))};
  }
  const double s = std::sin(z), c = std::cos(z);
  return {c - 1.0 + z * s, z * c - s};
}

namespace {

/// wave_less_one and slope_less_one from one sine and cosine.
struct WaveAndSlope {
  explicit WaveAndSlope(double z) {
    const double s = std::sin(0.5 * z), c = std::cos(0.5 * z), fall = 2.0 * s * s, sine = 2.0 * s * c;
    wave = {-fall, -sine};
    slope = z < 0.05 ? slope_less_one(z) : std::complex<double>(z * sine - fall, z * (1.0 - fall) - sine);
  }
  std::complex<double> wave, slope;
};

}  // namespace

SmoothPart smooth_part(const RadiatingSurface& surface, int test, int other, double wavenumber_per_m) {
  SmoothPart part;
  part.single.setZero();
  part.twice.setZero();
  part.adjoint.setZero();
  const auto points = touch(surface, test, other) ? seven_points() : three_points();
  std::array<Vector3d, 7> at_other;
  for (std::size_t q = 0; q < points.size(); ++q)
    at_other[q] = points[q].at[0] * surface.corner(other, 0) + points[q].at[1] * surface.corner(other, 1) +
                  points[q].at[2] * surface.corner(other, 2);
  const Vector3d nx = surface.normals.col(test), ny = surface.normals.col(other);
  const double scale = surface.areas_m2[test] * surface.areas_m2[other];
  for (const TrianglePoint& point : points) {
    const Eigen::Map<const Vector3d> hats(point.at.data());
    const Vector3d x =
        hats[0] * surface.corner(test, 0) + hats[1] * surface.corner(test, 1) + hats[2] * surface.corner(test, 2);
    Eigen::Vector3cd single = Eigen::Vector3cd::Zero(), twice = single, adjoint = single;
    for (std::size_t q = 0; q < points.size(); ++q) {
      const Eigen::Map<const Vector3d> other_hats(points[q].at.data());
      const double weight = points[q].weight;
      const Vector3d d = x - at_other[q];
      const double r = d.norm();
      if (!(r > 0.0)) {
        single += std::complex<double>(0.0, -wavenumber_per_m * weight) * other_hats;
        continue;
      }
      const double z = wavenumber_per_m * r;
      const WaveAndSlope at(z);
      single += (at.wave * (weight / r)) * other_hats;
      const std::complex<double> slope = at.slope * (weight / (r * r * r));
      twice += (slope * ny.dot(d)) * other_hats;
      adjoint -= (slope * nx.dot(d)) * other_hats;
    }
    const Vector3d left = (point.weight * scale) * hats;
    part.single += left.cast<std::complex<double>>() * single.transpose();
    part.twice += left.cast<std::complex<double>>() * twice.transpose();
    part.adjoint += left.cast<std::complex<double>>() * adjoint.transpose();
  }
  return part;
}

}  // namespace klang::acoustics::detail
