#pragma once
#include <Eigen/Core>
#include <complex>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/foundation/base/monitor.hpp"
#include "core/sound/dual_domain/liquid_boundary.hpp"
#include "core/sound/dual_domain/source_points.hpp"
#include "core/sound/waves/medium.hpp"

namespace klang::bubble {

/// Functions that pass 1 is made of.
enum class FluidSpace {
  /// The space that n quadrupole sources span as k times their distances goes to 0: all regular waves about one centre to order
  /// floor(3 sqrt n) - 1. The sources themselves are then so nearly dependent that double precision, or the ridge on their
  /// coefficients, leaves few of them; about one centre none is lost. For kernels that flatten out this is known as the flat
  /// limit (Fornberg and Piret 2007, SIAM J. Sci. Comput. 30, 60-80). Where the points stand no longer matters.
  kFlatLimit,
  /// j_l(k r) Y_l^m, l <= 2, about each of the random points, ridge on their own coefficients: HF eqs. 21-26 to the letter.
  kSources
};
constexpr auto words_of(FluidSpace) {
  return std::array{Word{FluidSpace::kFlatLimit, "flat"}, Word{FluidSpace::kSources, "sources"}};
}

enum class LeastSquares {
  kSketch,  ///< conjugate gradients behind a random sketch: the same answer, several times faster
  kDirect   ///< QR of (34) by LAPACK
};
constexpr auto words_of(LeastSquares) {
  return std::array{Word{LeastSquares::kSketch, "sketch"}, Word{LeastSquares::kDirect, "direct"}};
}

enum class Literature {
  kCorrected,
  kPaper  ///< HF as printed: S_b = -4 pi rho omega^2 r^2 (eq. 10), air driven without the density ratio (16), alpha without a length (26)
};
constexpr auto words_of(Literature) {
  return std::array{Word{Literature::kCorrected, "right"}, Word{Literature::kPaper, "paper"}};
}

struct DualDomainOptions {
  acoustics::Medium liquid{1000.0, 1497.0};
  acoustics::Medium air;
  FluidSpace fluid_space = FluidSpace::kFlatLimit;
  LeastSquares solver = LeastSquares::kSketch;
  Literature literature = Literature::kCorrected;
  double liquid_loss_factor =
      0.0;  ///< eta of the liquid: k^2 = k_0^2 (1 - i eta); a rigid tank without loss rings for ever
  /// beta of walls: rho_f c_f times the speed at which a wall gives way over the pressure there, dP/dn = -i k_0 beta P. 0: rigid.
  double wall_admittance = 0.0;
  double ridge = 1e-8;        ///< epsilon over the Frobenius norm of the matrix (HF section 5.6)
  bool scale_columns = true;  ///< functions scaled to length 1 on the boundary before the ridge is put on
  bool images = true;         ///< pass 1 starts from the bubble and its images in surfaces that are close
  bool wall_slopes = false;   ///< dP/dn of the liquid on rigid walls too, where it should be 0: to look at
  std::optional<double>
      wall_length_m;     ///< the length in alpha = length * rigid area / free area; default radius / sqrt(unknowns)
  int most_samples = 0;  ///< pass 1 and B take every nth sample so that no more remain; 0: all
  /// Pressure on the free surface for a unit source, one per sample (others count 0); empty: none, the one-way answer. With the
  /// air's own pressure there, found in turn, pass 1 is the two-way one.
  Eigen::VectorXcd surface_pressure;
  /// 1, or 0 where a sample counts for nothing in the liquid (a thin jet's, say: what few waves can follow); empty: all count.
  Eigen::VectorXd sample_counts;
  void validate() const;                                                    ///< InputError
  std::complex<double> liquid_wavenumber_per_m(double frequency_hz) const;  ///< with the loss
  /// Everything as HF prints it: sources, ridge on unscaled coefficients, no images, printed formulas.
  static DualDomainOptions as_printed();

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"liquid", "The liquid"}, self.liquid);
    visit({"air", "The air"}, self.air);
    visit({"fluid_space",
           "flat: the space that the sources of pass 1 span as k goes to 0; sources: their own coefficients"},
          self.fluid_space);
    visit({"solver", "sketch, or direct: QR by LAPACK"}, self.solver);
    visit({"literature",
           "right, or paper: formulas as printed (sign of the source, no density ratio, wall weight without a length)"},
          self.literature);
    visit({"liquid_loss_factor",
           "Loss factor η of the liquid, k² = k₀² (1 − iη); 0: a rigid tank's modes are not damped", between(0.0, 0.5)},
          self.liquid_loss_factor);
    visit({"wall_admittance",
           "Admittance of walls, ρc of the liquid times their speed over the pressure: 0 rigid, 1 swallows what comes "
           "straight on",
           between(0.0, 10.0)},
          self.wall_admittance);
    visit({"ridge", "Ridge over the norm of the matrix", between(1e-15, 1.0)}, self.ridge);
    visit({"scale_columns", "Functions scaled to length 1 before the ridge is put on"}, self.scale_columns);
    visit({"images", "Pass 1 with images of the bubble in surfaces close to it"}, self.images);
    visit({"wall_slopes", "Slopes of the pressure on rigid walls, too"}, self.wall_slopes);
    visit({"wall_length_m", "Length in the weight of rigid walls; default from size and sources", between(1e-9, 1e6)},
          self.wall_length_m);
  }
};

/// The liquid's pressure of a unit source: s(x) + images + regular waves.
struct FluidField {
  std::complex<double> wavenumber_per_m = 0.0;  ///< with the loss
  Eigen::Vector3d bubble_m = Eigen::Vector3d::Zero();
  struct Image {
    Eigen::Vector3d position_m;
    double amplitude;
  };
  std::vector<Image> images;  ///< of the bubble, outside the liquid
  int order = -1;             ///< of the waves about points_m[0], or -1: quadrupoles at all points_m
  std::vector<Eigen::Vector3d> points_m;
  std::vector<Eigen::Vector3d> solid_m;  ///< of singular standing waves y_l(k r) Y, l <= 2, within wet solids
  Eigen::VectorXcd coefficients;         ///< of the regular waves, then 9 per point of solid_m
};

/// The air's pressure: h_l^(2) Y, l <= 2, about each point.
struct AirField {
  double wavenumber_per_m = 0.0;
  std::vector<Eigen::Vector3d> points_m;
  Eigen::VectorXcd coefficients;  ///< 9 per point
};

struct DualDomainResult {
  enum class Status { kNotRun, kSolved, kFailed };
  Status status = Status::kNotRun;
  std::string message;
  double frequency_hz = 0.0;
  std::complex<double>
      source_strength;           ///< S_b [Pa m per m of bubble vibration = kg / (m s^2)], HF eq. 10 with the right sign
  double fit_error_fluid = 0.0;  ///< ||A c - b|| / ||b|| of pass 1 (HF Table 1), b: the bubble alone
  double fit_error_air = 0.0;    ///< the same of pass 2
  double fluid_residual = 0.0, air_residual = 0.0;  ///< sqrt(||A c - b||^2 + ||eps c||^2) / ||b||: what (34) minimises
  Eigen::VectorXcd
      normal_derivative;  ///< n_samples: dP/dn in the liquid [Pa/m per m]; 0 on dry solids, and on walls unless wall_slopes is set
  FluidField fluid;                            ///< times source_strength
  AirField air;                                ///< source strength and density ratio in it
  double alpha_m = 0.0;                        ///< weight of the rigid rows
  int n_fluid_sources = 0, n_air_sources = 0;  ///< used
  int n_fluid_unknowns = 0, n_air_unknowns = 0;
  int n_fluid_steps = 0, n_air_steps = 0;
  std::map<std::string, double>
      wall_time_s;  ///< "assemble_fluid", "solve_fluid", "assemble_air", "solve_air", "total"; of all bubbles
  bool usable() const { return status == Status::kSolved; }
};

/// S_b = 4 pi rho omega^2 r0^2: volume acceleration times density of a bubble whose radius swings by 1 m (HF eq. 10; the sign
/// printed there turns the pressure round: an expanding bubble pushes).
double bubble_source_strength(double radius_m, double frequency_hz, double liquid_density_kg_m3);

/// A bubble whose wall swings by 1 m at the frequency of the call.
struct SwingingBubble {
  Eigen::Vector3d position_m;
  double radius_m = 0.0;  ///< 1e-6 to 0.1, for the source strength
};

/// Sound of bubbles in a liquid, heard in the air around it (Zheng and James 2009, section 5). One-way coupling:
///   pass 1, liquid: (nabla^2 + k_f^2) P = S_b delta,  P = 0 on the free surface, dP/dn = 0 on walls and wet solids
///   pass 2, air:    (nabla^2 + k_a^2) P = 0 outside,  dP/dn = (rho_a / rho_f) dP_f/dn on the free surface, 0 on walls
/// with e^{+i omega t} and n out of the liquid. Each by least squares over the samples of the boundary, weighted with
/// sqrt(area), rigid rows of pass 1 with alpha, and a ridge (eq. 34).
/// Wet solids: what they throw back into the liquid is singular within them, so that no regular wave makes it; pass 1 takes
/// standing waves y_l(k r) Y_l^m, l <= 2, about points within them as well (not with the paper's formulas).
/// Sources beyond a ninth of half the samples (pass 2: of a third) are left out: more would fit the samples and swing between.
/// The matrices depend on boundary, frequency and points alone: bubbles of one call share assembly and preconditioner.
/// @param frequency_hz  1 to 1e5
/// @return one per bubble; kFailed with a message where the least-squares problem cannot be solved
/// @throws InputError: a bubble outside or on the boundary, too few samples for a single source
std::vector<DualDomainResult> solve_dual_domain(const LiquidBoundary& boundary, double frequency_hz,
                                                const SourcePoints& points, const std::vector<SwingingBubble>& bubbles,
                                                const DualDomainOptions& options = {},
                                                Monitor& monitor = silent_monitor());

/// Pressure in the liquid [Pa per m] at points inside, and its derivative along a direction.
std::complex<double> liquid_pressure(const DualDomainResult& result, const Eigen::Vector3d& x_m);
std::complex<double> liquid_pressure_slope(const DualDomainResult& result, const Eigen::Vector3d& x_m,
                                           const Eigen::Vector3d& direction);

/// Pressure in the air [Pa per m of bubble vibration] at points outside.
std::complex<double> air_pressure(const DualDomainResult& result, const Eigen::Vector3d& x_m);
std::complex<double> air_pressure_slope(const DualDomainResult& result, const Eigen::Vector3d& x_m,
                                        const Eigen::Vector3d& direction);

}  // namespace klang::bubble
