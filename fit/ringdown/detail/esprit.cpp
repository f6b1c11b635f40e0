#include "fit/ringdown/detail/esprit.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "core/foundation/base/conventions.hpp"
#include "core/sound/audio/fft.hpp"

namespace klang::fit::detail {
namespace {

constexpr Eigen::Index kEdge = 4;  ///< decimated samples at both ends that the taper smears
constexpr Eigen::Index kMaxSamples = 160;

}  // namespace

EspritSubspace::EspritSubspace(const SubBand& band) {
  if (band.blocks.empty()) return;
  // The longest windows; shorter ones have another decimated step.
  const BinBlock* first = &band.blocks.front();
  for (const BinBlock& block : band.blocks) {
    if (block.n > first->n) first = &block;
  }
  const Eigen::Index n_bins = first->y.size();
  const Eigen::Index n_samples = std::min(n_bins - 2 * kEdge, kMaxSamples);
  if (n_samples < 6) return;
  const Eigen::Index rows = n_samples / 2;
  const Eigen::Index cols = n_samples - rows + 1;
  step_s_ = first->duration_s() / static_cast<double>(n_bins);
  low_hz_ = first->frequency_hz(0);
  const auto taper_bins = std::max<Eigen::Index>(1, n_bins / 8);
  Eigen::MatrixXcd gram = Eigen::MatrixXcd::Zero(rows, rows);
  for (const BinBlock& block : band.blocks) {
    if (block.n != first->n || block.y.size() != n_bins) continue;
    Eigen::VectorXcd bins = block.y;
    for (Eigen::Index i = 0; i < taper_bins; ++i) {
      const double w =
          std::pow(std::sin(0.5 * kPi * (static_cast<double>(i) + 0.5) / static_cast<double>(taper_bins)), 2);
      bins[i] *= w;
      bins[n_bins - 1 - i] *= w;
    }
    const Eigen::VectorXcd samples = audio::complex_from_spectrum(bins);
    Eigen::MatrixXcd hankel(rows, cols);
    for (Eigen::Index c = 0; c < cols; ++c) hankel.col(c) = samples.segment(kEdge + c, rows);
    gram += hankel * hankel.adjoint();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXcd> eigen(gram);
  if (eigen.info() != Eigen::Success) return;
  vectors_ = eigen.eigenvectors().rowwise().reverse();
  max_order_ = rows / 2;
}

std::vector<Pole> EspritSubspace::poles(Eigen::Index order) const {
  if (order < 1 || order > max_order_) return {};
  const Eigen::Index rows = vectors_.rows();
  Eigen::MatrixXcd both(rows - 1, 2 * order);
  both.leftCols(order) = vectors_.topRows(rows - 1).leftCols(order);
  both.rightCols(order) = vectors_.bottomRows(rows - 1).leftCols(order);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXcd> right(both.adjoint() * both);
  if (right.info() != Eigen::Success) return {};
  // Ascending eigenvalues: the first `order` vectors span the noise part of [upper, lower].
  const Eigen::MatrixXcd v = right.eigenvectors().leftCols(order);
  const Eigen::MatrixXcd rotation = -(v.topRows(order) * v.bottomRows(order).partialPivLu().inverse());
  if (!rotation.allFinite()) return {};
  const Eigen::ComplexEigenSolver<Eigen::MatrixXcd> eigen(rotation, false);
  if (eigen.info() != Eigen::Success) return {};
  const double band_hz = 1 / step_s_;
  std::vector<Pole> result;
  for (const std::complex<double>& z : eigen.eigenvalues()) {
    double turns = std::arg(z) / (2 * kPi);
    if (turns < 0) turns += 1;  // the band's bins are frequencies from low_hz upwards
    result.push_back({low_hz_ + turns * band_hz, -std::log(std::max(std::abs(z), 1e-12)) / step_s_});
  }
  return result;
}

}  // namespace klang::fit::detail
