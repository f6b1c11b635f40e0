#pragma once
#include <Eigen/Core>
#include <complex>
#include <vector>

#include "core/foundation/base/monitor.hpp"
#include "core/sound/dual_domain/liquid_boundary.hpp"

namespace klang::validate::detail {

/// Box of liquid [0, size] in x and y, [-depth, 0] in z; free top, rigid walls and floor.
struct ClosedTank {
  Eigen::Vector3d size_m{0.30, 0.20, 0.15};
  bubble::BoundaryMesh mesh(double h_m) const;
  /// dP/dz on the top at x, y of a unit source, (nabla^2 + k^2) P = delta: the field of all its images. Summed over horizontal modes
  ///   sum eps_m eps_n / (Lx Ly) cos cos cos cos cosh(kappa (H - d)) / cosh(kappa H),  kappa^2 = (m pi/Lx)^2 + (n pi/Ly)^2 - k^2
  /// with d the source's depth, which holds for any k (complex too); terms fall as exp(-kappa d), to 1e-14.
  std::complex<double> top_slope(double x, double y, const Eigen::Vector3d& source_m,
                                 std::complex<double> wavenumber_per_m) const;
};

/// Pressure in the air [per unit source] by boundary elements of size h_m, driven by that slope: another way than reciprocity in both
/// media. Water of 1000 kg/m3 and 1497 m/s, air of 1.2041 and 343.
std::vector<std::complex<double>> forward_from_images(const ClosedTank& tank, double h_m, double frequency_hz,
                                                      const Eigen::Vector3d& source_m,
                                                      const std::vector<Eigen::Vector3d>& points_m, Monitor& monitor);

}  // namespace klang::validate::detail
