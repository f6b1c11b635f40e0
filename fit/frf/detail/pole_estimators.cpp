#include "fit/frf/detail/pole_estimators.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/foundation/base/errors.hpp"
#include "core/sound/audio/fft.hpp"

namespace klang::fit::detail {
namespace {

using Eigen::Index;
using Eigen::MatrixXcd;
using Eigen::VectorXcd;

constexpr double kMostDamping = 0.3;  // beyond it a pole is no ringing mode

/// Roots of sum_k a[k] z^k by the companion matrix.
VectorXcd roots_of(const VectorXcd& a) {
  const Index n = a.size() - 1;
  MatrixXcd companion = MatrixXcd::Zero(n, n);
  companion.bottomLeftCorner(n - 1, n - 1).setIdentity();
  companion.col(n - 1) = -a.head(n) / a[n];
  return Eigen::ComplexEigenSolver<MatrixXcd>(companion, false).eigenvalues();
}

void keep_if_ringing(Pole pole, const Band& band, std::vector<Pole>& poles) {
  const double hz = pole.imag() / (2 * std::numbers::pi);
  if (!(pole.real() < 0) || hz < band.low_hz || hz > band.high_hz || -pole.real() > kMostDamping * std::abs(pole))
    return;
  poles.push_back(pole);
}

void sort_by_frequency(std::vector<Pole>& poles) {
  std::sort(poles.begin(), poles.end(), [](const Pole& a, const Pole& b) { return a.imag() < b.imag(); });
}

/// sum_k weight_k z_k^m for m = 0 .. most, z on the unit circle.
VectorXcd power_sums(const VectorXcd& weights, const VectorXcd& z, int most) {
  VectorXcd sums(most + 1), power = weights;
  for (int m = 0; m <= most; ++m) {
    sums[m] = power.sum();
    power = power.cwiseProduct(z);
  }
  return sums;
}

/// T(j, k) = s(k - j), with s(-m) given apart.
MatrixXcd toeplitz(const VectorXcd& forward, const VectorXcd& backward) {
  const Index n = forward.size();
  MatrixXcd matrix(n, n);
  for (Index j = 0; j < n; ++j)
    for (Index k = 0; k < n; ++k) matrix(j, k) = k >= j ? forward[k - j] : backward[j - k];
  return matrix;
}

}  // namespace

BandLines band_lines(const ResponseSet& set, const Band& band) {
  Index first = 0, last = set.n_lines();
  while (first < last && (set.abscissa[first] < band.low_hz || set.abscissa[first] <= 0)) ++first;
  while (last > first && set.abscissa[last - 1] > band.high_hz) --last;
  const Index n = last - first;
  if (n < 16) throw InputError(set.origin, "fewer than 16 lines in the band", std::to_string(n));
  BandLines lines;
  lines.first_hz = set.abscissa[first];
  lines.step_hz = (set.abscissa[last - 1] - lines.first_hz) / static_cast<double>(n - 1);
  for (Index i = 0; i < n; ++i) {
    if (std::abs(set.abscissa[first + i] - lines.first_hz - lines.step_hz * static_cast<double>(i)) >
        0.02 * lines.step_hz)
      throw InputError(set.origin, "frequency_hz is not even", to_text(set.abscissa[first + i]));
  }
  lines.values = set.values.middleCols(first, n);
  return lines;
}

std::vector<OrderPoles> lscf_poles(const BandLines& lines, int most) {
  const Index n_lines = lines.values.cols();
  const double width_hz = lines.step_hz * static_cast<double>(n_lines);
  VectorXcd z(n_lines);
  for (Index k = 0; k < n_lines; ++k)
    z[k] = std::polar(1.0, -2 * std::numbers::pi * static_cast<double>(k) / static_cast<double>(n_lines));
  const VectorXcd ones = VectorXcd::Ones(n_lines);
  const VectorXcd plain = power_sums(ones, z, most);
  std::vector<std::pair<VectorXcd, VectorXcd>> cross;  // with z and with its conjugate
  VectorXcd squares = VectorXcd::Zero(most + 1);
  for (Index o = 0; o < lines.values.rows(); ++o) {
    const VectorXcd h = lines.values.row(o).transpose();
    const double scale = 1.0 / std::max(h.norm(), 1e-300);  // every response counts alike
    cross.emplace_back(power_sums(-scale * h, z, most), power_sums(-scale * h, z.conjugate(), most));
    squares += power_sums((scale * scale * h.cwiseAbs2()).cast<std::complex<double>>(), z, most);
  }
  const Band band{lines.first_hz, lines.first_hz + width_hz};
  std::vector<OrderPoles> chart;
  for (int order = 2; order <= most; order += 2) {
    const Index n = order + 1;
    const VectorXcd r = plain.head(n), t = squares.head(n);
    const MatrixXcd R = toeplitz(r, r.conjugate());
    const Eigen::LDLT<MatrixXcd> solver(R);
    MatrixXcd M = MatrixXcd::Zero(n, n);
    for (const auto& [with, against] : cross) {
      const MatrixXcd S = toeplitz(with.head(n), against.head(n));
      M -= S.adjoint() * solver.solve(S);
    }
    M += toeplitz(t, t.conjugate());
    VectorXcd a(n);
    a.head(n - 1) = M.topLeftCorner(n - 1, n - 1).ldlt().solve(-M.topRightCorner(n - 1, 1));
    a[n - 1] = 1.0;
    OrderPoles found{order, {}};
    if (a.allFinite()) {
      const VectorXcd roots = roots_of(a);
      for (const std::complex<double>& root : roots) {
        if (std::abs(root) == 0) continue;
        const std::complex<double> rate = -std::log(root) * width_hz;  // z = exp(-s / B)
        double omega = rate.imag();
        if (omega < 0) omega += 2 * std::numbers::pi * width_hz;
        keep_if_ringing({rate.real(), omega + 2 * std::numbers::pi * lines.first_hz}, band, found.poles);
      }
    }
    sort_by_frequency(found.poles);
    chart.push_back(std::move(found));
  }
  return chart;
}

MatrixXcd pulse_responses(const BandLines& lines, Index most_samples) {
  const Index n = lines.values.cols();
  MatrixXcd pulses(lines.values.rows(), std::min(n / 2, most_samples));
  for (Index o = 0; o < pulses.rows(); ++o)
    pulses.row(o) = audio::complex_from_spectrum(lines.values.row(o).transpose()).head(pulses.cols()).transpose();
  return pulses;
}

std::vector<OrderPoles> era_poles(const MatrixXcd& pulses, double step_s, double shift_rad_s, const Band& band,
                                  int most) {
  const Index p = pulses.rows(), n = pulses.cols() - 1;  // the first sample holds what is quicker than the band
  const Index columns = std::max<Index>(2, std::min<Index>(n / 2, 300));
  const Index blocks = std::max<Index>(
      1, std::min((n - columns - 1), std::max<Index>(2 * most / p + 2, std::min<Index>(n / 2, 240 / p + 1))));
  MatrixXcd h0(blocks * p, columns), h1(blocks * p, columns);
  for (Index i = 0; i < blocks; ++i) {
    for (Index j = 0; j < columns; ++j) {
      h0.block(i * p, j, p, 1) = pulses.col(1 + i + j);
      h1.block(i * p, j, p, 1) = pulses.col(std::min(n, 2 + i + j));
    }
  }
  const Eigen::BDCSVD<MatrixXcd> svd(h0, Eigen::ComputeThinU | Eigen::ComputeThinV);
  const Eigen::VectorXd& s = svd.singularValues();
  std::vector<OrderPoles> chart;
  for (int order = 2; order <= most && order <= s.size(); order += 2) {
    if (!(s[order - 1] > 1e-11 * s[0])) break;
    const Eigen::VectorXcd root = s.head(order).cwiseSqrt().cwiseInverse().cast<std::complex<double>>();
    const MatrixXcd a = root.asDiagonal() *
                        (svd.matrixU().leftCols(order).adjoint() * h1 * svd.matrixV().leftCols(order)) *
                        root.asDiagonal();
    OrderPoles found{order, {}};
    const VectorXcd values = Eigen::ComplexEigenSolver<MatrixXcd>(a, false).eigenvalues();
    for (const std::complex<double>& value : values) {
      if (std::abs(value) == 0) continue;
      std::complex<double> rate = std::log(value) / step_s;
      if (shift_rad_s > 0 && rate.imag() < 0) rate += std::complex<double>(0, 2 * std::numbers::pi / step_s);
      keep_if_ringing({rate.real(), rate.imag() + shift_rad_s}, band, found.poles);
    }
    sort_by_frequency(found.poles);
    chart.push_back(std::move(found));
  }
  return chart;
}

}  // namespace klang::fit::detail
