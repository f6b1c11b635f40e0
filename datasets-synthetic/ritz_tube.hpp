#pragma once
#include <Eigen/Core>
#include <vector>

#include "core/physics/solid/material.hpp"

namespace klang::datasets {

/// Vibration of a free isotropic hollow cylinder (axis z, centred) in three-dimensional elasticity by the
/// Rayleigh-Ritz method: cos or sin of n times the angle, polynomials through the wall and along the axis.
/// Exact in the angle; blocks of one n and one parity in z. Nothing is shared with the finite elements of
/// core/solid.
struct RitzTubeOptions {
  int axial_order = 0;          ///< highest degree along the axis, 4 to 120; 0: from the shortest wave in the band
  int wall_order = 4;           ///< through the wall, 1 to 12
  double highest_hz = 20000.0;  ///< modes above are dropped (> 0)
};

class RitzTube {
 public:
  /// @throws InputError  lengths not positive, wall not below the radius, material not admissible
  RitzTube(double length_m, double outer_radius_m, double wall_m, const solid::Material& material,
           const RitzTubeOptions& options = {});

  struct Label {
    int circumferential = 0;  ///< n: waves around
    bool odd_in_z = false;    ///< parity of u_r and u_theta in z; u_z has the other
    bool torsion = false;     ///< n = 0 and u_theta alone
    int orientation = 0;      ///< n > 0: 0 for cos n theta, 1 for sin n theta
  };

  /// Elastic modes, ascending; with n > 0 each frequency comes twice, orientation 0 then 1.
  const Eigen::VectorXd& angular_frequency_rad_s() const { return omega_; }
  Eigen::Index n_modes() const { return omega_.size(); }
  int axial_order() const { return axial_order_; }
  const Label& label(Eigen::Index mode) const { return modes_[static_cast<std::size_t>(mode)].label; }

  /// Mass-normalised displacement (x, y, z) of every mode at a point of the wall, 3 x n_modes [1/sqrt(kg)].
  Eigen::MatrixXd shapes_at(const Eigen::Vector3d& point_m) const;

 private:
  struct Mode {
    Label label;
    Eigen::MatrixXd radial, around, axial;  // coefficients (wall function x axial function); empty where zero
  };
  void solve(int n, bool odd, bool torsion, const solid::Material& material, double highest_hz,
             std::vector<std::pair<double, Mode>>& found) const;
  double length_m_, inner_m_, outer_m_;
  int axial_order_, wall_order_;
  Eigen::MatrixXd wall_basis_;  // rows: orthonormal wall functions in Legendre polynomials of the wall
  Eigen::VectorXd omega_;
  std::vector<Mode> modes_;
};

}  // namespace klang::datasets
