#pragma once
#include <Eigen/Core>
#include <string>
#include <vector>

namespace klang::fit {

/// Where a spectrum is wanted.
struct SpectrumPoint {
  double lame_lambda_pa = 0.0;
  double lame_mu_pa = 0.0;
  double density_kg_m3 = 0.0;      ///< unused by a specimen whose mass is given
  std::vector<double> dimensions;  ///< the specimen's free dimensions, in its order [m]
};

struct Spectrum {
  Eigen::VectorXd log_angular_frequency_sq;  ///< ln(omega^2), n_modes; ascending at the model's start
  Eigen::MatrixXd derivative;                ///< of it by lambda, mu [1/Pa], ln rho, each free dimension [1/m]
};

/// What a fit needs to know of a body: its lowest eigenvalues as smooth functions of material and dimensions. The finite
/// elements stand behind ReducedSpectrum; tests use closed forms.
class SpectrumModel {
 public:
  virtual ~SpectrumModel() = default;
  virtual Eigen::Index n_modes() const = 0;
  virtual Spectrum spectrum(const SpectrumPoint& point) const = 0;
  /// Names of the dimensions that are given, not fitted, and d ln f / d ln dimension of each mode (n_modes x names) at a point
  /// of the model: for what errors of them do. Empty: not known.
  virtual std::vector<std::string> given_dimensions() const { return {}; }
  virtual Eigen::MatrixXd given_slopes(const SpectrumPoint&) const { return {}; }
  /// Whether the mass is given, so that ln f falls by half of what ln mass rises.
  virtual bool mass_is_given() const { return false; }
  /// How loud a strike makes each mode relative to the loudest, 0 to 1; empty: all alike.
  virtual Eigen::VectorXd visibility() const { return {}; }
  /// How far each mode's own frequency may be off (relative, >= 0; mesh): such errors go together, so that no scatter shows
  /// them, and are added to intervals apart. Empty: nothing.
  virtual Eigen::VectorXd relative_error() const { return {}; }
};

}  // namespace klang::fit
