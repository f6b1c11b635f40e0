#pragma once
#include <cmath>
#include <cstddef>
#include <vector>

#include "core/foundation/base/memory.hpp"
#include "core/foundation/base/parallel.hpp"
#include "core/foundation/la/ridge.hpp"
#include "core/sound/dual_domain/dual_domain.hpp"

namespace klang::bubble::detail {

inline constexpr std::size_t kSamplesPerRange = 256;

/// A matrix of boundary conditions, its rows weighted, and the scale of its columns.
template <class Scalar>
struct Conditions {
  la::Matrix<Scalar> adjoint;    // n_unknowns (padded) x n_samples
  Eigen::VectorXd column_scale;  // coefficients = scale * solution
  double frobenius = 0.0;        // of the scaled matrix
};

/// fill(begin, end, adjoint, squares) writes the weighted, conjugated rows of samples and adds up the squares of the columns.
template <class Scalar, class Fill>
Conditions<Scalar> assemble(Eigen::Index n_unknowns, Eigen::Index n_samples, bool scale_columns, const Fill& fill) {
  using Eigen::Index;
  Conditions<Scalar> result;
  constexpr Index kMultiple = la::kMultiple<Scalar>;
  result.adjoint.resize((n_unknowns + kMultiple - 1) / kMultiple * kMultiple, n_samples);
  prefer_huge_pages(result.adjoint.data(), static_cast<std::size_t>(result.adjoint.size()) * sizeof(Scalar));
  std::vector<Eigen::VectorXd> squares((static_cast<std::size_t>(n_samples) + kSamplesPerRange - 1) / kSamplesPerRange);
  parallel_for(static_cast<std::size_t>(n_samples), kSamplesPerRange, [&](std::size_t begin, std::size_t end) {
    const auto first = static_cast<Index>(begin), last = static_cast<Index>(end);
    result.adjoint.middleCols(first, last - first).bottomRows(result.adjoint.rows() - n_unknowns).setZero();
    squares[begin / kSamplesPerRange].setZero(result.adjoint.rows());
    fill(first, last, result.adjoint, squares[begin / kSamplesPerRange]);
  });
  Eigen::VectorXd square = squares[0];
  for (std::size_t r = 1; r < squares.size(); ++r) square += squares[r];
  result.column_scale = Eigen::VectorXd::Ones(square.size());
  if (scale_columns) {
    for (Index j = 0; j < square.size();
         ++j)  // a high order that underflows on the whole boundary counts as no function
      result.column_scale[j] = square[j] > 1e-280 ? 1.0 / std::sqrt(square[j]) : 0.0;
    square.array() *= result.column_scale.array().square();
  }
  result.frobenius = std::sqrt(square.sum());
  return result;
}

inline la::RidgeMethod method(LeastSquares solver) {
  return solver == LeastSquares::kDirect ? la::RidgeMethod::kDirect : la::RidgeMethod::kSketch;
}

}  // namespace klang::bubble::detail
