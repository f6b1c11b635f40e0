#pragma once
#include <Eigen/Core>
#include <array>
#include <vector>

#include "core/physics/solid/material.hpp"

namespace klang::datasets {

/// Vibration of a free isotropic box by the Rayleigh-Ritz method: displacements are products of Legendre
/// polynomials in x, y and z, which split into eight blocks by parity. Nothing is shared with the finite
/// elements of core/solid. Frequencies are upper bounds that fall geometrically with the order. Source:
/// Visscher, Migliori, Bell & Reinert 1991, J. Acoust. Soc. Am. 90, 2154 (there with plain powers).
struct RitzBoxOptions {
  std::array<int, 3> orders{};  ///< highest degree along x, y, z, 3 to 40; 0: from the shortest wave in the band
  double highest_hz = 20000.0;  ///< modes above are dropped (> 0)
};

class RitzBox {
 public:
  /// @param size_m length, width, height [m], > 0
  /// @throws InputError
  RitzBox(const Eigen::Vector3d& size_m, const solid::Material& material, const RitzBoxOptions& options = {});

  const Eigen::VectorXd& angular_frequency_rad_s() const { return omega_; }  ///< elastic modes, ascending
  Eigen::Index n_modes() const { return omega_.size(); }
  /// Parity of u_x in (x, y, z), 0 even, 1 odd; u_y and u_z follow (the own direction and x flip).
  std::array<int, 3> parity(Eigen::Index mode) const { return modes_[static_cast<std::size_t>(mode)].parity; }
  std::array<int, 3> orders() const { return orders_; }

  /// Mass-normalised displacement of every mode at a point, 3 x n_modes [1/sqrt(kg)]; the centre is the
  /// origin.
  Eigen::MatrixXd shapes_at(const Eigen::Vector3d& point_m) const;

 private:
  struct Mode {
    std::array<int, 3> parity;
    std::vector<double> coefficients;  // over the block's basis in the order of block_basis
  };
  Eigen::Vector3d size_m_;
  std::array<int, 3> orders_;
  Eigen::VectorXd omega_;
  std::vector<Mode> modes_;
};

}  // namespace klang::datasets
