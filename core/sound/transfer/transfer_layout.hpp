#pragma once
#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "core/sound/transfer/transfer_model.hpp"

namespace klang::acoustics {

/// Modes side by side in one vector; the same on every processor, so that every processor sums in the same order.
inline constexpr int kModeLanes = 8;
/// Eight doubles on a cache line of their own: coefficients are streamed through the whole of them.
struct alignas(64) ModeLanes {
  double values[kModeLanes];
};

/// Modes of one transfer model in the layout of the evaluators: grouped by centre, within a centre by order, in groups of
/// up to eight of like order; coefficients for real harmonics (M^m and M^-m folded together).
struct TransferLayout {
  struct Group {
    int order = 0;
    std::size_t first_coefficient = 0;  ///< real parts there, imaginary parts after them, and so on: 2 (order + 1)^2
    int modes[kModeLanes] = {};         ///< -1: empty lane
    double wavenumbers_per_m[kModeLanes] = {};  ///< of an empty lane: that of the first
  };
  struct Centre {
    Eigen::Vector3d position_m;
    int order = 0;  ///< highest of its groups
    std::vector<Group> groups;
  };
  std::vector<Centre> centres;
  std::vector<ModeLanes> coefficients;
  int n_modes = 0;
  int highest_order = 0;
  explicit TransferLayout(const TransferModel& model);
};

/// InputError unless every listener is finite and away from every centre.
void check_listeners(const TransferLayout& layout, const Eigen::Ref<const Eigen::Matrix3Xd>& listeners_m);

}  // namespace klang::acoustics
