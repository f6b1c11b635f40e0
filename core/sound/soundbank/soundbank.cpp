#include "core/sound/soundbank/soundbank.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "core/foundation/base/check.hpp"
#include "core/sound/waves/spherical_harmonics.hpp"

namespace klang::soundbank {
namespace {

template <typename Visit>
void for_each_allowed(int order, int mode_class, const Visit& visit) {
  const bool sine = (mode_class & 2) != 0;
  for (int m = ((mode_class & 1) ^ (mode_class >> 1 & 1)); m <= order; m += 2) {
    if (sine && m == 0) continue;
    for (int n = m + (mode_class >> 2 & 1); n <= order; n += 2) visit(n, m);
  }
}

}  // namespace

Eigen::Vector3d unit_axes(const ShapePoint& shape) {
  return Eigen::Vector3d(std::exp(shape.u), std::exp(shape.v), 1.0).normalized();
}

ShapePoint shape_point(const Eigen::Vector3d& axes) {
  std::array<double, 3> sorted{axes[0], axes[1], axes[2]};
  std::sort(sorted.begin(), sorted.end());
  return {std::log(sorted[0] / sorted[2]), std::log(sorted[1] / sorted[2])};
}

ShapePlace locate(const Soundbank& bank, const ShapePoint& shape) {
  const double depth = -std::log(bank.thinnest);
  const double u = std::clamp(shape.u, -depth, 0.0), v = std::clamp(shape.v, u, 0.0);
  ShapePlace place;
  place.clamped = shape.u < -depth * (1.0 + 1e-12);
  // Corners of the whole: 0 pancake (-depth, 0), 1 sphere (0, 0), 2 cigar (-depth, -depth).
  const double cigar = -v / depth, sphere = 1.0 + u / depth;
  Eigen::Vector3d w(std::max(1.0 - cigar - sphere, 0.0), sphere, cigar);
  const ShapeTriangle* at = &bank.triangles[0];
  while (at->children[0] >= 0) {
    // Halves: (middle of the base; corner 0; corner 1) and (middle; corner 2; corner 0).
    if (w[1] >= w[2]) {
      place.triangle = at->children[0];
      w = Eigen::Vector3d(2.0 * w[2], w[0], w[1] - w[2]);
    } else {
      place.triangle = at->children[1];
      w = Eigen::Vector3d(2.0 * w[1], w[2] - w[1], w[0]);
    }
    at = &bank.triangles[static_cast<std::size_t>(place.triangle)];
  }
  place.weights = w;
  return place;
}

Eigen::Matrix<double, 6, 1> node_weights(const Eigen::Vector3d& w) {
  Eigen::Matrix<double, 6, 1> n;
  n << w[0] * (2.0 * w[0] - 1.0), w[1] * (2.0 * w[1] - 1.0), w[2] * (2.0 * w[2] - 1.0), 4.0 * w[1] * w[2],
      4.0 * w[2] * w[0], 4.0 * w[0] * w[1];
  return n;
}

Eigen::Matrix<double, 6, 2> node_weight_slopes(const Soundbank& bank, const ShapePlace& place) {
  const ShapeTriangle& t = bank.triangles[static_cast<std::size_t>(place.triangle)];
  const Eigen::Vector3d& w = place.weights;
  Eigen::Matrix<double, 6, 3> by_weight = Eigen::Matrix<double, 6, 3>::Zero();
  for (int i = 0; i < 3; ++i) {
    by_weight(i, i) = 4.0 * w[i] - 1.0;
    by_weight(3 + i, (i + 1) % 3) = 4.0 * w[(i + 2) % 3];
    by_weight(3 + i, (i + 2) % 3) = 4.0 * w[(i + 1) % 3];
  }
  Eigen::Matrix3d corners;
  for (int i = 0; i < 3; ++i) {
    const ShapePoint& p = bank.nodes[static_cast<std::size_t>(t.nodes[i])];
    corners.col(i) = Eigen::Vector3d(p.u, p.v, 1.0);
  }
  return by_weight * corners.inverse().leftCols<2>();
}

ClassFrequencies interpolated_frequencies(const Soundbank& bank, const ShapePlace& place) {
  const ShapeTriangle& t = bank.triangles[static_cast<std::size_t>(place.triangle)];
  const auto weights = node_weights(place.weights);
  ClassFrequencies result;
  for (int c = 0; c < kModeClasses; ++c) {
    Eigen::VectorXd log_sum =
        Eigen::VectorXd::Zero(bank.node_frequencies[static_cast<std::size_t>(t.nodes[0])][c].size());
    for (int i = 0; i < 6; ++i)
      log_sum += weights[i] * bank.node_frequencies[static_cast<std::size_t>(t.nodes[i])][c].array().log().matrix();
    result[c] = log_sum.array().exp();
    std::sort(result[c].begin(), result[c].end());  // where two nearly meet the parabolas may cross
  }
  return result;
}

double lowest_frequency(const Soundbank& bank, const ShapePlace& place) {
  const ShapeTriangle& t = bank.triangles[static_cast<std::size_t>(place.triangle)];
  const auto weights = node_weights(place.weights);
  double lowest = HUGE_VAL;
  for (int c = 0; c < kModeClasses; ++c) {
    double sum = 0.0;
    for (int i = 0; i < 6; ++i)
      sum += weights[i] * std::log(bank.node_frequencies[static_cast<std::size_t>(t.nodes[i])][c][0]);
    lowest = std::min(lowest, sum);
  }
  return std::exp(lowest);
}

std::size_t packed_size(int order, int mode_class) {
  std::size_t n = 0;
  for_each_allowed(order, mode_class, [&](int, int) { ++n; });
  return n;
}

std::vector<std::complex<float>> packed_multipole(const Eigen::VectorXcd& coefficients, int order, int mode_class) {
  std::vector<std::complex<float>> packed;
  for_each_allowed(order, mode_class, [&](int n, int m) {
    packed.push_back(static_cast<std::complex<float>>(coefficients[acoustics::basis_index(n, m)]));
  });
  return packed;
}

Eigen::VectorXcd unpacked_multipole(const std::vector<std::complex<float>>& packed, int order, int mode_class) {
  KLANG_CHECK(packed.size() == packed_size(order, mode_class), "coefficients of a packed multipole");
  Eigen::VectorXcd coefficients = Eigen::VectorXcd::Zero(acoustics::basis_size(order));
  std::size_t at = 0;
  for_each_allowed(order, mode_class, [&](int n, int m) {
    const std::complex<double> value = packed[at++];
    const double sign = (m % 2 == 0 ? 1.0 : -1.0) * ((mode_class & 2) != 0 ? -1.0 : 1.0);
    coefficients[acoustics::basis_index(n, m)] = value;
    if (m > 0) coefficients[acoustics::basis_index(n, -m)] = sign * value;
  });
  return coefficients;
}

}  // namespace klang::soundbank
