#pragma once
#include <Eigen/Core>
#include <array>
#include <complex>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/foundation/opencl/session.hpp"
#include "core/sound/dual_domain/dual_domain.hpp"

namespace klang::bubble {

struct ReciprocalOptions {
  DualDomainOptions pass;            ///< of the liquid
  int air_vertices = 1000;           ///< the air's boundary elements take a surface of no more vertices: 100 to 20000
  bool estimate_air = true;          ///< also on a surface of a quarter of the triangles
  opencl::DeviceChoice device = {};  ///< of the air's boundary elements: BemOptions
  void validate() const;             ///< InputError

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"pass", "How the liquid is solved"}, self.pass);
    visit({"air_vertices", "Vertices of the air's boundary elements at most", between(100.0, 20000.0)},
          self.air_vertices);
    visit({"estimate_air", "Solve the air on a coarser surface, too, for its error"}, self.estimate_air);
  }
};

/// Boundary elements of the air around one surface, for any number of frequencies and for surfaces that have changed little since.
class EarElements {
 public:
  EarElements(const LiquidBoundary& boundary, int most_vertices);
  ~EarElements();
  EarElements(EarElements&&) noexcept;
  /// q of the ears at the elements' own vertices, n_vertices x n_ears.
  /// @throws NumericalError where the system was not solved
  /// @param device_message  when given: one line where the device that was asked for did not do it
  Eigen::MatrixXcd field(double frequency_hz, const std::vector<Eigen::Vector3d>& ears_m, const acoustics::Medium& air,
                         Monitor& monitor = silent_monitor(), const opencl::DeviceChoice& device = {},
                         std::string* device_message = nullptr) const;
  /// That, carried to the vertices of a boundary: linear on the nearest element.
  struct Carrier {
    std::vector<std::array<int, 3>> vertex;  ///< of the elements, for each vertex of the boundary
    std::vector<std::array<double, 3>> weight;
    Eigen::MatrixXcd operator()(const Eigen::MatrixXcd& q) const;
  };
  Carrier carrier(const LiquidBoundary& boundary) const;
  Carrier carrier(const Eigen::Matrix3Xd& points_m) const;  ///< to points near the surface
  int n_elements() const;
  /// On the free surface, by the mean edge; away from it elements are up to four times as long.
  double elements_per_wavelength(double frequency_hz, const acoustics::Medium& air) const;

 private:
  struct Data;
  std::unique_ptr<const Data> data_;
};

/// Pass A of reciprocity: (nabla^2 + k_a^2) q = delta(x - ear) in the air around the liquid, dq/dn = 0 on free surface, walls
/// and dry solids, by boundary elements (acoustics::HelmholtzBem). It knows nothing of bubbles or of the liquid's waves.
struct EarField {
  double frequency_hz = 0.0;
  Eigen::MatrixXcd q;          ///< vertices of the boundary x ears [1/m]
  Eigen::MatrixXcd q_coarse;   ///< the same by a quarter of the elements; empty: not asked for
  std::string device_message;  ///< one line: why the device that was asked for did not do it
  int n_elements = 0;
  double elements_per_wavelength = 0.0;
  double wall_time_s = 0.0;
};
/// @param frequency_hz  1 to 1e5
/// @throws InputError: an ear in the liquid or not finite; NumericalError where the boundary elements were not solved
EarField ear_field(const LiquidBoundary& boundary, double frequency_hz, const std::vector<Eigen::Vector3d>& ears_m,
                   const ReciprocalOptions& options = {}, Monitor& monitor = silent_monitor());

/// Pass B: (nabla^2 + k_f^2) w = 0 in the liquid, w = q on the free surface, dw/dn = 0 on walls and wet solids. By Green's
/// identity in the liquid and in the air the pressure at the ear of any bubble is
///   P = (rho_a / rho_f) S_b w(x_b),  S_b = 4 pi rho_f omega^2 r^2
/// (one-way, as solve_dual_domain), so that one solution per ear, frame and frequency serves all bubbles. w is regular: it needs
/// no images, and is smooth as a bubble moves.
struct EarInLiquid {
  double frequency_hz = 0.0;
  double density_ratio = 0.0, liquid_density_kg_m3 = 0.0;
  FluidField field;               ///< wave number, order, points of the functions
  Eigen::MatrixXcd coefficients;  ///< n_functions x n_ears
  std::vector<double> fit_error;  ///< of each ear: ||w - q|| on the free surface with walls' slopes, over ||q||
  std::map<std::string, double> wall_time_s;
  std::complex<double> w(const Eigen::Vector3d& x_m, std::size_t ear) const;
  std::complex<double> pressure(const SwingingBubble& bubble, std::size_t ear) const;  ///< [Pa per m]
};
/// @throws InputError as solve_dual_domain; NumericalError where the least-squares problem was not solved
EarInLiquid ear_in_liquid(const LiquidBoundary& boundary, const EarField& air, const SourcePoints& points,
                          const ReciprocalOptions& options = {}, Monitor& monitor = silent_monitor());

/// Transfer of one bubble to one ear by reciprocity, with what is known of its error.
struct ReciprocalTransfer {
  std::complex<double> pressure;    ///< corrected [Pa per m]
  std::complex<double> plain;       ///< (rho_a / rho_f) S_b w(x_b)
  double error_liquid = 0.0;        ///< |correction| over |pressure|
  std::string device_message;       ///< EarField
  std::optional<double> error_air;  ///< a third of the change between both surfaces of the air; none: not asked for
  double error_estimate() const { return error_liquid + error_air.value_or(0.0); }
};
struct BubblesAndEars {
  std::vector<SwingingBubble> bubbles;
  std::vector<Eigen::Vector3d> ears_m;
};
/// Passes A and B and, for the error, pass 1 (the bubble's own field P, of a unit source) with the same matrix:
///   w(x_b) - int_free (w - q) dP/dn + int_rigid P dw/dn
/// has the product of both solutions' errors where w(x_b) alone has that of w (dual-weighted residual, Becker and Rannacher
/// 2001, Acta Numerica 10). What it changes is the estimate.
/// @return bubbles x ears
std::vector<std::vector<ReciprocalTransfer>> reciprocal_transfer(const LiquidBoundary& boundary, double frequency_hz,
                                                                 const SourcePoints& points,
                                                                 const BubblesAndEars& between,
                                                                 const ReciprocalOptions& options = {},
                                                                 Monitor& monitor = silent_monitor());

/// The same where passes A and B are there already.
/// @return one per ear
std::vector<ReciprocalTransfer> checked_transfer(const LiquidBoundary& boundary, const EarField& air,
                                                 const EarInLiquid& liquid, const SourcePoints& points,
                                                 const SwingingBubble& bubble, const ReciprocalOptions& options = {});

}  // namespace klang::bubble
