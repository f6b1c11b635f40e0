#pragma once
#include <ceres/cost_function.h>
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace klang::tests {

/// Compares a cost function's Jacobian with central differences of two steps (Richardson). Asserts first that the
/// Jacobian is not zero, so that a cost that ignores its parameters cannot pass.
/// @param tolerance  relative to the largest entry of the same row block
inline void expect_gradient(const ceres::CostFunction& cost, const std::vector<std::vector<double>>& point,
                            double tolerance = 1e-6, double relative_step = 1e-4) {
  const auto& sizes = cost.parameter_block_sizes();
  ASSERT_EQ(sizes.size(), point.size());
  const auto n = static_cast<std::size_t>(cost.num_residuals());
  auto blocks = point;
  std::vector<double*> pointers;
  for (auto& block : blocks) pointers.push_back(block.data());
  const auto residuals_at = [&] {
    std::vector<double> residuals(n);
    EXPECT_TRUE(cost.Evaluate(pointers.data(), residuals.data(), nullptr));
    return residuals;
  };
  std::vector<std::vector<double>> jacobian;
  std::vector<double*> jacobian_pointers;
  for (const int size : sizes) jacobian.emplace_back(n * static_cast<std::size_t>(size), 0.0);
  for (auto& block : jacobian) jacobian_pointers.push_back(block.data());
  std::vector<double> residuals(n);
  ASSERT_TRUE(cost.Evaluate(pointers.data(), residuals.data(), jacobian_pointers.data()));
  double largest = 0.0;
  for (const auto& block : jacobian) {
    for (const double entry : block) largest = std::max(largest, std::abs(entry));
  }
  ASSERT_GT(largest, 0.0) << "the cost does not depend on its parameters";
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    const auto size = static_cast<std::size_t>(sizes[b]);
    for (std::size_t j = 0; j < size; ++j) {
      const double x = point[b][j], h = relative_step * std::max(1.0, std::abs(x));
      const auto difference = [&](double step) {
        blocks[b][j] = x + step;
        const auto high = residuals_at();
        blocks[b][j] = x - step;
        const auto low = residuals_at();
        blocks[b][j] = x;
        std::vector<double> slope(n);
        for (std::size_t i = 0; i < n; ++i) slope[i] = (high[i] - low[i]) / (2.0 * step);
        return slope;
      };
      const auto coarse = difference(h), fine = difference(0.5 * h);
      double column = 0.0;
      for (std::size_t i = 0; i < n; ++i) column = std::max(column, std::abs(jacobian[b][i * size + j]));
      EXPECT_GT(column, 0.0) << "block " << b << " parameter " << j << " has no effect";
      for (std::size_t i = 0; i < n; ++i) {
        const double expected = (4.0 * fine[i] - coarse[i]) / 3.0;
        EXPECT_LE(std::abs(jacobian[b][i * size + j] - expected), tolerance * std::max(column, 1e-300))
            << "residual " << i << " block " << b << " parameter " << j;
      }
    }
  }
}

}  // namespace klang::tests
