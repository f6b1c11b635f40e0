#pragma once
#include <Eigen/Core>
#include <complex>
#include <optional>
#include <string>
#include <vector>

#include "core/foundation/config/fields.hpp"
#include "core/sound/waves/multipole.hpp"

namespace klang::acoustics {

/// The exterior field of a body by multipoles of low order at one point or several inside it (source simulation: Ochmann
/// 1995, Acustica 81, 512-527; several points: James, Barbic and Pai 2006), fitted to the Neumann data in the sense of least squares:
///   minimise integral |sum_s sum_nm c_s,nm dS_n^m/dn(y - x_s) - dp/dn|^2 dS + (regularisation |c|)^2,  columns scaled to length 1.
/// The alternative to the integral of multipole_from_surface; needs no surface pressure.
struct EquivalentSourceOptions {
  int order = 1;                  ///< of each source, 0 to 40
  double regularisation = 1e-10;  ///< of the longest column, 0 to 1
  void validate() const;          ///< InputError

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"order", "Order of each source", between(0.0, 40.0)}, self.order);
    visit({"regularisation", "Of the longest column", between(0.0, 1.0)}, self.regularisation);
  }
};

struct EquivalentSources {
  enum class Status { kNotRun, kDone, kNumericalFailure };
  Status status = Status::kNotRun;
  std::string message;
  std::vector<Multipole> sources;
  double velocity_residual = 0.0;  ///< rms of the normal-velocity error over rms of the velocity, on the surface
  std::optional<double> pressure_residual;  ///< the same of the pressure, where the field has one
  double radiated_power_w = 0.0;            ///< of the sources together, from the far field
  std::optional<double>
      lost_power_fraction;  ///< 1 - power / power that leaves the surface; negative where they radiate more
  /// rms over all directions of the far-field error over rms of the far field, against the integral's multipoles carried to
  /// convergence; needs the pressure
  std::optional<double> far_field_error;
};

/// @param field     quadrature on the closed surface; pressure_pa may be empty (then only what needs none is reported)
/// @param points_m  where the sources stand, all inside the body
EquivalentSources fit_equivalent_sources(const SurfaceField& field, double wavenumber_per_m, const Medium& medium,
                                         const std::vector<Eigen::Vector3d>& points_m,
                                         const EquivalentSourceOptions& options = {});

/// Up to count points inside the surface, far from it and from each other: below surface points along the inward normal,
/// inside by the winding number, then farthest-point sampling. The first is the deepest. Deterministic.
std::vector<Eigen::Vector3d> inner_points(const SurfaceField& field, int count);

/// Field of several multipoles, x at none of their centres.
std::complex<double> pressure_pa(const std::vector<Multipole>& sources, const Eigen::Vector3d& x_m);
/// Far field about the origin: D(s) in p(r s) -> D(s) e^{-ikr} / r.
std::complex<double> far_field_pa_m(const std::vector<Multipole>& sources, const Eigen::Vector3d& direction);

}  // namespace klang::acoustics
