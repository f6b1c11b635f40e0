#pragma once
// Frames of liquids with known phi and velocity.
#include <cmath>
#include <functional>

#include "core/physics/liquid/frames.hpp"

namespace klang::test {

/// A pool over [0, size] x [0, size] whose surface stands at height(t), moved by u(t, x). The surface is a square of 2 n^2 triangles.
class PoolFrames : public liquid::LiquidFrames {
 public:
  using Height = std::function<double(double t)>;
  using Flow = std::function<Eigen::Vector3d(double t, const Eigen::Vector3d& x)>;
  PoolFrames(double size_m, double cell_m, double step_s, int n_frames, Height height, Flow flow)
      : size_m_(size_m), cell_m_(cell_m), height_(std::move(height)), flow_(std::move(flow)) {
    for (int i = 0; i < n_frames; ++i) times_.push_back(step_s * i);
  }
  static PoolFrames at_rest(double seconds, double depth_m = 0.5) {
    return {1.0,
            0.01,
            0.004,
            static_cast<int>(std::lround(seconds / 0.004)) + 1,
            [=](double) { return depth_m; },
            [](double, const Eigen::Vector3d&) { return Eigen::Vector3d(0, 0, 0); }};
  }
  std::span<const double> time_s() const override { return times_; }
  double cell_m() const override { return cell_m_; }
  double phi_m(std::size_t frame, const Eigen::Vector3d& x) const override { return x.z() - height_(times_[frame]); }
  std::optional<Eigen::Vector3d> velocity_m_s(std::size_t frame, const Eigen::Vector3d& x) const override {
    return flow_(times_[frame], x);
  }
  bool in_outlet(const Eigen::Vector3d& x) const override { return outlet_ && x.x() > *outlet_; }
  liquid::LiquidSurface boundary(std::size_t frame) const override {
    constexpr int kSide = 20;
    liquid::LiquidSurface result;
    result.surface.vertices_m.resize((kSide + 1) * (kSide + 1), 3);
    for (int j = 0; j <= kSide; ++j)
      for (int i = 0; i <= kSide; ++i)
        result.surface.vertices_m.row(j * (kSide + 1) + i) =
            Eigen::RowVector3d(size_m_ * i / kSide, size_m_ * j / kSide, height_(times_[frame]));
    result.surface.triangles.resize(2 * kSide * kSide, 3);
    for (int j = 0, t = 0; j < kSide; ++j)
      for (int i = 0; i < kSide; ++i) {
        const int a = j * (kSide + 1) + i, b = a + 1, c = a + kSide + 1, d = c + 1;
        result.surface.triangles.row(t++) << a, b, d;
        result.surface.triangles.row(t++) << a, d, c;
      }
    result.region.assign(2 * kSide * kSide, 0);
    return result;
  }
  std::optional<double> outlet_;  ///< liquid beyond this x leaves

 private:
  double size_m_, cell_m_;
  Height height_;
  Flow flow_;
  std::vector<double> times_;
};

}  // namespace klang::test
