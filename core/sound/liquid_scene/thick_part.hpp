#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "core/physics/liquid/frames.hpp"
#include "core/sound/dual_domain/liquid_boundary.hpp"

namespace klang::liquid_scene {

/// The liquid of a frame less its jets, sheets and drops: what lies within 3 cells of its core, the largest connected part deeper than
/// 2 cells below the surface. Waves about one centre follow a body of liquid, but no jet that leaves it: their fit to a jet spoils
/// them everywhere, while in truth a field that enters a jet of radius a dies out within a / 2.4.
class ThickPart {
 public:
  /// @param boundary  of that frame's main body
  ThickPart(const liquid::LiquidFrames& frames, std::size_t frame, const bubble::LiquidBoundary& boundary);
  bool holds(const Eigen::Vector3d& x_m) const;
  /// 1 or 0 per sample: bubble::DualDomainOptions::sample_counts. Empty: all count, too, where the core has less than half of the volume
  /// (a film, a spray), since then there is no body to speak of.
  const Eigen::VectorXd& sample_counts() const { return sample_counts_; }
  bool is_body() const { return is_body_; }

 private:
  std::size_t index(int i, int j, int k) const {
    return static_cast<std::size_t>(i + n_[0] * (j + static_cast<std::int64_t>(n_[1]) * k));
  }
  void keep_largest();

  double cell_m_ = 0.0;
  Eigen::Vector3d low_m_ = Eigen::Vector3d::Zero();
  Eigen::Vector3i n_ = Eigen::Vector3i::Zero();
  std::vector<std::uint8_t> core_;
  bool is_body_ = false;
  Eigen::VectorXd sample_counts_;
};

}  // namespace klang::liquid_scene
