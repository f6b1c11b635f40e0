#pragma once
#include <Eigen/Core>
#include <memory>
#include <vector>

#include "core/sound/soundbank/soundbank.hpp"
#include "core/sound/transfer/transfer_model.hpp"

namespace klang::soundbank {

/// Axes with |a| = 1, a <= b <= c, of the ellipsoid of these principal moments of inertia in any order (SB eq. 12).
/// Their unit does not matter. A flat body (I1 = I2 + I3) gives a = 0.
/// @throws InputError for moments that are not positive and finite or that violate I1 <= I2 + I3
Eigen::Vector3d axes_of_moments(const Eigen::Vector3d& moments);

/// A body's principal moments and the rotation from its frame to the proxy's: rows are the principal axes, the one of the largest
/// moment first (it is the proxy's x, its shortest axis); det +1 (errata 40: V_I^T alone may be a reflection).
struct PrincipalFrame {
  Eigen::Vector3d moments;  ///< I1 >= I2 >= I3
  Eigen::Matrix3d rotation;
};
/// @throws InputError for a matrix that is not symmetric, finite and positive
PrincipalFrame principal_frame(const Eigen::Matrix3d& inertia);

/// The point of an ellipsoid where the outward normal is n: (a^2 n_x, b^2 n_y, c^2 n_z) / sqrt(a^2 n_x^2 + b^2 n_y^2 + c^2 n_z^2).
/// Closed form of SB eqs. 23, 24 (errata 44). The contact of a force f is at n = -f / |f|. n of any length but 0.
Eigen::Vector3d point_of_normal(const Eigen::Vector3d& axes, const Eigen::Vector3d& normal);

/// The same by the place of the contact instead of its force: r from the body's centre of mass, in the proxy's frame, divided by the
/// semi-axes of the ellipsoid that has the body's volume's inertia, and pushed to the unit sphere. A blow on the middle of a face stays in the
/// middle however its force leans; SB's point then lies near a thin ellipsoid's rim.
/// @param moments   principal, of density 1 [m^5], largest first (PrincipalFrame of mesh::mass_properties)
/// @param volume_m3 > 0
/// @return on the ellipsoid of `axes`; its longest axis's end for r = 0
Eigen::Vector3d point_of_place(const Eigen::Vector3d& axes, const Eigen::Vector3d& r_m, const Eigen::Vector3d& moments,
                               double volume_m3);

/// An ellipsoid that stands for a body.
struct Proxy {
  Eigen::Vector3d axes;  ///< |axes| = 1; the body's are scale times these [m]
  double scale = 1.0;    ///< gamma, |axes| of the proxy [m]
  bool clamped = false;  ///< the body is thinner than the bank's thinnest: its nearest shape was taken
  ShapePlace place;
  int cell = 0;  ///< nearest sample with sound, by |a' - a| (SB section 5.4)
  double cell_distance = 0.0;
};

/// Retrieval from a bank. Constant after construction, so one object serves all threads.
class ProxyFinder {
 public:
  /// The bank must outlive it.
  explicit ProxyFinder(const Soundbank& bank);
  ~ProxyFinder();

  /// The proxy of a body: shape from its moments, scale gamma = omega_p0 / omega_0 from its lowest mode alone (equi-frequency).
  /// @param shear_speed_m_s  of the body's material, 0: the bank's
  /// @throws InputError
  Proxy find(const Eigen::Vector3d& moments, double lowest_frequency_hz, double shear_speed_m_s = 0.0) const;
  /// The same of axes that are known.
  Proxy of_axes(const Eigen::Vector3d& axes, double lowest_frequency_hz, double shear_speed_m_s = 0.0) const;
  /// The nearest cell to axes of length 1, and its distance.
  int nearest_cell(const Eigen::Vector3d& unit_axes, double& distance) const;

  const Soundbank& bank() const { return bank_; }

 private:
  struct Tree;
  const Soundbank& bank_;
  std::unique_ptr<const Tree> tree_;
};

/// The lowest frequencies of a proxy, interpolated [Hz].
Eigen::VectorXd proxy_frequencies_hz(const Soundbank& bank, const Proxy& proxy, int count,
                                     double shear_speed_m_s = 0.0);

/// A cell as a body of its own: modes at |axes| = scale in the bank's material, and their radiation in the bank's medium.
EllipsoidModes cell_modes(const Soundbank& bank, int cell, double scale);
acoustics::TransferModel cell_transfer(const Soundbank& bank, int cell, double scale);

}  // namespace klang::soundbank
