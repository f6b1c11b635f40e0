#pragma once
#include <Eigen/Core>
#include <array>
#include <vector>

#include "core/foundation/config/fields.hpp"
#include "core/physics/solid/material.hpp"

namespace klang::modal {

/// An ellipsoid keeps its shape under the reflections of x, y and z, and each mode is even or odd in each: eight classes.
/// Bit d of a class is set where the normal displacement (and so the sound) is odd in axis d; the displacement along axis d
/// has the opposite parity in d. Within a class frequencies avoid each other when the shape changes, between classes they cross.
inline constexpr int kModeClasses = 8;

struct ModeId {
  int mode_class = 0;  ///< 0 to 7
  int index = 0;       ///< within the class, by frequency
  bool operator==(const ModeId&) const = default;
  auto operator<=>(const ModeId&) const = default;
};

struct EllipsoidModeOptions {
  int degree = 12;     ///< of the polynomials, 3 to 24
  int per_class = 12;  ///< modes kept in each class, 1 to 1000
  bool residuals = false;
  void validate() const;  ///< InputError

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"degree", "Degree of the polynomials", between(3.0, 24.0)}, self.degree);
    visit({"per_class", "Modes kept in each symmetry class", between(1.0, 1000.0)}, self.per_class);
    visit({"residuals", "Compute the modes' residuals"}, self.residuals);
  }
};

/// Elastic modes of a free isotropic ellipsoid by the Rayleigh-Ritz method: displacements are polynomials in xi = (x/a, y/b, z/c),
/// orthonormal on the unit ball, so that the mass matrix is the unit matrix and the eight classes are dense problems of a few
/// hundred unknowns. Frequencies are upper bounds that fall geometrically with the degree.
/// Source: Visscher, Migliori, Bell and Reinert 1991, J. Acoust. Soc. Am. 90, 2154-2162 (there with plain powers).
class EllipsoidModes {
 public:
  /// @param axes_m  semi-axes along x, y, z, > 0; any order
  /// @throws InputError
  EllipsoidModes(const Eigen::Vector3d& axes_m, const solid::Material& material,
                 const EllipsoidModeOptions& options = {});
  /// From stored coefficients (mass-normalised as shapes() gives them).
  EllipsoidModes(const Eigen::Vector3d& axes_m, int degree, std::array<Eigen::VectorXd, kModeClasses> omega,
                 std::array<Eigen::MatrixXd, kModeClasses> coefficients);

  const Eigen::Vector3d& axes_m() const { return axes_m_; }
  int degree() const { return degree_; }
  /// Elastic modes of a class, ascending [rad/s].
  const Eigen::VectorXd& angular_frequency_rad_s(int mode_class) const { return omega_[mode_class]; }
  /// ||K u - omega^2 M u|| / (omega^2 ||M u||) of a class's modes; empty where it was not asked for.
  const Eigen::VectorXd& relative_residual(int mode_class) const { return residual_[mode_class]; }
  double angular_frequency_rad_s(const ModeId& mode) const { return omega_[mode.mode_class][mode.index]; }
  /// The lowest modes of all classes, ascending; fewer where a class might hide one that was not kept.
  std::vector<ModeId> lowest(int count) const;

  /// Mass-normalised displacement [1/sqrt(kg)] of a mode at points xi (3 x n_points, the unit ball): 3 x n_points.
  Eigen::Matrix3Xd shape_at(const ModeId& mode, const Eigen::Matrix3Xd& xi) const;
  /// Of several modes: 3 n_points x n_modes, (x, y, z) by point. What the modes share at a point is computed once.
  Eigen::MatrixXd shapes_at(const std::vector<ModeId>& modes, const Eigen::Matrix3Xd& xi) const;
  /// Coefficients of a mode: those of u_x, u_y, u_z in turn.
  auto coefficients(const ModeId& mode) const { return coefficients_[mode.mode_class].col(mode.index); }
  const Eigen::MatrixXd& coefficients(int mode_class) const { return coefficients_[mode_class]; }

 private:
  Eigen::Vector3d axes_m_;
  int degree_;
  std::array<Eigen::VectorXd, kModeClasses> omega_, residual_;
  std::array<Eigen::MatrixXd, kModeClasses> coefficients_;
};

/// Coefficients of a mode's shape: those of the three displacements.
Eigen::Index mode_shape_size(int degree, int mode_class);

/// Rigid motions in a class: a translation (one odd axis), a rotation (two) or none.
int rigid_motions(int mode_class);

/// Sorted merge of frequencies by class: the lowest count ids; classes hold ascending values.
std::vector<ModeId> lowest_modes(const std::array<Eigen::VectorXd, kModeClasses>& by_class, int count);

}  // namespace klang::modal
