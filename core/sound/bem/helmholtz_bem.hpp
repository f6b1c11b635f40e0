#pragma once
#include <Eigen/Core>
#include <complex>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include "core/foundation/base/monitor.hpp"
#include "core/foundation/config/fields.hpp"
#include "core/foundation/opencl/session.hpp"
#include "core/sound/bem/radiating_surface.hpp"
#include "core/sound/waves/medium.hpp"
#include "core/sound/waves/multipole.hpp"

namespace klang::acoustics {

enum class BemStatus { kNotRun, kSolved, kFailed };

struct BemOptions {
  Medium medium;
  double min_elements_per_wavelength = 4.0;  ///< 0.5 to 100: a coarser surface is refused
  bool allow_coarse = false;                 ///< solve it all the same
  double tolerance = 1e-9;                   ///< relative residual of the linear system, 1e-13 to 1e-3
  int max_refinements = 30;                  ///< steps of iterative refinement, 1 to 1000
  int n_blas_threads = 0;                    ///< 0: all of thread_count(); 1 where several solves run at once
  bool alone = true;                         ///< false where several solves run at once: rows are not cut into
                                             ///< blocks, at whose borders triangles count twice; same bits
  /// Where the matrix is made and kept. On a device the system is solved by GMRES; in single precision to 3e-6 at best, and the
  /// pressure is then within some 1e-5 of the processor's. What the device cannot do, the processor does: device_message.
  opencl::DeviceChoice device;
  void validate() const;  ///< InputError

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"medium", "The air or liquid around the surface"}, self.medium);
    visit({"min_elements_per_wavelength", "Elements per wavelength of sound at least; a coarser surface is refused",
           between(0.5, 100.0)},
          self.min_elements_per_wavelength);
    visit({"allow_coarse", "Solve a coarser surface all the same"}, self.allow_coarse);
    visit({"tolerance", "Relative residual of the linear system", between(1e-13, 1e-3)}, self.tolerance);
    visit({"max_refinements", "Steps of iterative refinement at most", between(1.0, 1000.0)}, self.max_refinements);
    visit({"n_blas_threads", "Threads of the factorisation; 0: all", between(0.0, 1024.0)}, self.n_blas_threads);
  }
};

struct BemResult {
  BemStatus status = BemStatus::kNotRun;
  std::string message;
  double frequency_hz = 0.0;
  double wavenumber_per_m = 0.0;
  Medium medium;
  Eigen::MatrixXcd pressure_pa;      ///< n_vertices x n_columns, on the surface
  Eigen::MatrixXcd velocity_m_s;     ///< 3 n_triangles x n_columns as given
  Eigen::VectorXd radiated_power_w;  ///< n_columns: 1/2 Re int p conj(v_n) dS
  /// n_columns: 1/2 int |p v_n| dS. The power loses its digits in the part of the pressure that swings to and fro
  /// where it is much smaller than this; radiated_power then comes from the far field.
  Eigen::VectorXd power_scale_w;
  std::optional<double> relative_residual;  ///< largest of the columns
  double elements_per_wavelength = 0.0;
  int n_elements = 0;
  int n_unknowns = 0;
  int n_refinements = 0;
  bool double_factor = false;        ///< single precision did not do
  int n_products = 0;                ///< with the matrix, on a device
  std::string device = "processor";  ///< or the device's name
  std::string device_message;        ///< one line: why the device that was asked for did not do it
  std::map<std::string, double>
      wall_time_s;  ///< "assemble", "factor", "refine", "total"; of a device "near", "assemble", "solve"
  bool usable() const { return status == BemStatus::kSolved; }
};

/// Sound outside closed bodies that move: the exterior Neumann problem of the Helmholtz equation, e^{+i omega t},
///   G = e^{-ikR} / (4 pi R), dp/dn = -i omega rho v_n =: q, n out of the solid,
/// by the combined equation of Burton and Miller (1971) on the surface,
///   (1/2 - K + i eta N) p = -S q + i eta (1/2 + K') q,  eta = 1 / max(k, 1 / radius of the body),
/// S, K, K', N: single layer, double layer, its adjoint, hypersingular operator. It has one solution at every
/// frequency (no spurious results at resonances of the inside); with e^{+i omega t} the sign of eta must be plus.
///
/// Galerkin with continuous linear pressure on flat triangles (an unknown a vertex); velocity linear on each triangle,
/// free to jump at edges. N is integrated by parts (Maue 1949), so that every kernel is 1/R at worst and thin bodies,
/// edges and corners need nothing special: the 1/R parts of near pairs are integrated in closed form over one triangle,
/// the rest by Gauss points. The pressure error falls with the square of the element size.
/// The dense matrix is factored in single precision and refined with the double one.
/// On a device it stays there and GMRES solves it, preconditioned by the blocks of neighbours on its diagonal.
/// Memory 24 n_vertices^2 bytes (device: 16, or 8 in single precision, and up to 2 GB); time n_triangles^2 (assembly) + n_vertices^3 (factor).
/// Docs: docs/boundary-elements.md.
class HelmholtzBem {
 public:
  /// Does all that no frequency changes. The surface must close (checked_radiating_surface).
  explicit HelmholtzBem(RadiatingSurface surface);
  ~HelmholtzBem();
  HelmholtzBem(HelmholtzBem&&) noexcept;

  const RadiatingSurface& surface() const;

  /// Velocities to the form solve() wants: row 3 t + c is the corner c of triangle t.
  Eigen::MatrixXcd from_triangles(const Eigen::MatrixXcd& velocity_m_s) const;  ///< n_triangles x n_columns
  Eigen::MatrixXcd from_vertices(const Eigen::MatrixXcd& velocity_m_s) const;   ///< n_vertices x n_columns

  /// @param frequency_hz  1e-3 to 1e7
  /// @param velocity_m_s  normal velocity, 3 n_triangles x n_columns
  /// @throws InputError when the surface is too coarse for the frequency and allow_coarse is not set
  BemResult solve(double frequency_hz, const Eigen::MatrixXcd& velocity_m_s, const BemOptions& options = {},
                  Monitor& monitor = silent_monitor()) const;

  /// Throws InputError naming the first point that is not finite or lies inside the body (by the winding number).
  void check_outside(const Eigen::Matrix3Xd& points_m) const;

  /// Pressure [Pa] at points outside (3 x n_points) of one column of a solution, from
  /// p(x) = int (p dG/dn - G q) dS; near the surface as exact as on it. Points inside give about 0: check_outside first.
  Eigen::VectorXcd pressure_at(const BemResult& result, const Eigen::Matrix3Xd& points_m, int column = 0) const;

  /// The solution at 3 points of each triangle, for multipoles and far fields. The weights carry the volume flow of
  /// the velocity exactly.
  SurfaceField field(const BemResult& result, int column = 0) const;

 private:
  struct Data;
  std::unique_ptr<const Data> data_;
};

/// Throws InputError with the element size that is needed unless the surface has enough elements per wavelength.
/// @return elements per wavelength: wavelength / surface.largest_edge_m
double check_resolution(const RadiatingSurface& surface, double frequency_hz, const BemOptions& options);

}  // namespace klang::acoustics
