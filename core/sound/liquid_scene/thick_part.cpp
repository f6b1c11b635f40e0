#include "core/sound/liquid_scene/thick_part.hpp"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/parallel.hpp"

namespace klang::liquid_scene {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3i;

constexpr double kCore_cells = 2.0, kReach_cells = 3.0, kLeastShare = 0.5;

}  // namespace

ThickPart::ThickPart(const liquid::LiquidFrames& frames, std::size_t frame, const bubble::LiquidBoundary& boundary)
    : cell_m_(frames.cell_m()) {
  const auto& x = boundary.surface().vertices_m;
  low_m_ = x.colwise().minCoeff().transpose();
  const Vector3d extent = x.colwise().maxCoeff().transpose() - low_m_;
  for (int axis = 0; axis < 3; ++axis) n_[axis] = std::max(1, static_cast<int>(std::ceil(extent[axis] / cell_m_)));
  core_.assign(static_cast<std::size_t>(n_[0]) * static_cast<std::size_t>(n_[1]) * static_cast<std::size_t>(n_[2]), 0);
  parallel_for(static_cast<std::size_t>(n_[2]), 1, [&](std::size_t begin, std::size_t end) {
    for (int k = static_cast<int>(begin); k < static_cast<int>(end); ++k)
      for (int j = 0; j < n_[1]; ++j)
        for (int i = 0; i < n_[0]; ++i) {
          const Vector3d centre = low_m_ + cell_m_ * Vector3d(i + 0.5, j + 0.5, k + 0.5);
          core_[index(i, j, k)] = frames.phi_m(frame, centre) < -kCore_cells * cell_m_ ? 1 : 0;
        }
  });
  keep_largest();
  // The core of a body of depth d is d less two cells.
  const auto n_core = static_cast<double>(std::count(core_.begin(), core_.end(), 1));
  const double lost = kCore_cells * cell_m_ * boundary.free_area_m2();
  is_body_ = n_core * cell_m_ * cell_m_ * cell_m_ + lost >= kLeastShare * boundary.volume_m3() && n_core > 0.0;
  if (!is_body_) return;
  const auto& samples = boundary.samples();
  sample_counts_.resize(static_cast<Eigen::Index>(samples.size()));
  parallel_for(samples.size(), 256, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      sample_counts_[static_cast<Eigen::Index>(i)] = holds(samples[i].point_m) ? 1.0 : 0.0;
  });
}

void ThickPart::keep_largest() {
  std::vector<std::uint8_t> part(core_.size(), 0);  // 0: not visited
  std::vector<Vector3i> stack, here, largest;
  for (int k = 0; k < n_[2]; ++k)
    for (int j = 0; j < n_[1]; ++j)
      for (int i = 0; i < n_[0]; ++i) {
        if (core_[index(i, j, k)] == 0 || part[index(i, j, k)] != 0) continue;
        here.clear();
        stack.assign(1, {i, j, k});
        part[index(i, j, k)] = 1;
        while (!stack.empty()) {
          const Vector3i cell = stack.back();
          stack.pop_back();
          here.push_back(cell);
          for (int axis = 0; axis < 3; ++axis)
            for (const int step : {-1, 1}) {
              Vector3i next = cell;
              next[axis] += step;
              if (next[axis] < 0 || next[axis] >= n_[axis]) continue;
              const std::size_t at = index(next[0], next[1], next[2]);
              if (core_[at] == 0 || part[at] != 0) continue;
              part[at] = 1;
              stack.push_back(next);
            }
        }
        if (here.size() > largest.size()) largest.swap(here);
      }
  std::fill(core_.begin(), core_.end(), 0);
  for (const Vector3i& cell : largest) core_[index(cell[0], cell[1], cell[2])] = 1;
}

bool ThickPart::holds(const Vector3d& x_m) const {
  const Vector3d at = (x_m - low_m_) / cell_m_;
  Vector3i first, last;
  for (int axis = 0; axis < 3; ++axis) {
    first[axis] = std::max(0, static_cast<int>(std::floor(at[axis] - kReach_cells)));
    last[axis] = std::min(n_[axis] - 1, static_cast<int>(std::floor(at[axis] + kReach_cells)));
  }
  for (int k = first[2]; k <= last[2]; ++k)
    for (int j = first[1]; j <= last[1]; ++j)
      for (int i = first[0]; i <= last[0]; ++i)
        if (core_[index(i, j, k)] != 0 &&
            (Vector3d(i + 0.5, j + 0.5, k + 0.5) - at).squaredNorm() <= kReach_cells * kReach_cells)
          return true;
  return false;
}

}  // namespace klang::liquid_scene
