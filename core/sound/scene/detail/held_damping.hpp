#pragma once
#include <Eigen/Core>
#include <functional>
#include <vector>

#include "core/sound/scene/detail/modal_body.hpp"

namespace klang::scene::detail {

/// Damping of a body that is held: each of its motions that the holds leave decays as the material says at the frequency that it has as held. A body's own
/// coordinates are rigid motions and modes of its frame; a clamped mode is mostly the former, which decay by nothing, and moves the latter far below their
/// own frequencies, so that these would decay by something else. What decays vanishes where the body is held: holds take no part.
class HeldDamping {
 public:
  /// @param held  places that holds move; places that joints tie to the world. @param decay_per_s  by angular frequency [rad/s]
  HeldDamping(const ModalBody& body, const std::vector<ModalPlace>& held,
              const std::function<double(double)>& decay_per_s);
  /// Over dt: speeds relative to what the body does while its holds move as they do now, slowly.
  /// @param held_m_s  of the held places in the world, as they were given
  void apply(ModalBody& body, double dt, const Eigen::VectorXd& held_m_s) const;
  std::size_t n_places() const { return static_cast<std::size_t>(follow_.cols() / 3); }

 private:
  Eigen::Matrix3d turning_;  ///< spin of unit coordinates: turning turning^T = inertia^-1
  Eigen::MatrixXd motions_;  ///< that decay: translation, turn, modes, each scaled to mass 1; orthonormal
  Eigen::MatrixXd follow_;   ///< what the body does for each speed of a held place
  Eigen::VectorXd omega_, decay_per_s_;
};

}  // namespace klang::scene::detail
