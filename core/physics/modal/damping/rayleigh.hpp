#pragma once
#include "core/physics/modal/damping/damping_law.hpp"

namespace klang::damping {

/// Rayleigh damping, C = stiffness_s K + mass_per_s M: decay = (stiffness_s omega^2 + mass_per_s) / 2. The order of the two is
/// that of the law's parameters everywhere.
struct RayleighDamping {
  double stiffness_s = 0.0;  ///< [s], >= 0
  double mass_per_s = 0.0;   ///< [1/s], >= 0
  double decay_per_s(double omega_rad_s) const;
  Eigen::VectorXd decay_per_s(const Eigen::VectorXd& omega_rad_s) const;
};

/// "rayleigh", of rayleigh_stiffness_s and rayleigh_mass_per_s.
const DampingLaw& rayleigh_law();

/// Names and ranges of the two, for laws that have one of them.
const LawParameter& rayleigh_stiffness_parameter();
const LawParameter& rayleigh_mass_parameter();

}  // namespace klang::damping
