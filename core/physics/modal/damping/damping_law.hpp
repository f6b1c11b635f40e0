#pragma once
#include <Eigen/Core>
#include <span>
#include <string_view>
#include <vector>

/// Damping laws of materials: how fast a mode of angular frequency omega decays, amplitude ~ exp(-decay_per_s t). One file pair
/// per law, one line in damping_laws.cpp.
namespace klang::damping {

/// A number of a law: all that files, options, fits and reports need to know of it.
struct LawParameter {
  std::string_view name;            ///< with its unit: in recipes, in fit.json, as "--name" on the command line
  double low = 0.0, high = 1.0;     ///< both included
  bool required = true;             ///< in a recipe of the law; otherwise 0
  double fit_reach = 1e9;           ///< a fit looks from start / this to start * this
  std::string_view meaning;         ///< in the tables of docs
  std::string_view option_meaning;  ///< in --help
  std::string_view words, symbol;   ///< in reports: "loss factor", "η"
};

/// Most parameters that a law may have.
inline constexpr std::size_t kMostLawParameters = 4;

class DampingLaw {
 public:
  virtual ~DampingLaw() = default;
  virtual std::string_view name() const = 0;   ///< in files
  virtual std::string_view words() const = 0;  ///< in reports
  virtual std::span<const LawParameter> parameters() const = 0;

  /// @param p  the parameters in their order, each > 0 where derivatives are asked for
  virtual double decay_per_s(double omega_rad_s, const double* p) const = 0;
  virtual Eigen::VectorXd decay_per_s(const Eigen::VectorXd& omega_rad_s, const double* p) const;
  /// d ln(decay) / d p_j, one per parameter.
  virtual void log_gradient(double omega_rad_s, const double* p, double* gradient) const = 0;
  /// Where a fit starts, by moments of decays [1/s] > 0 that were measured; several places where the surface has several
  /// valleys.
  virtual std::vector<Eigen::VectorXd> starts(const Eigen::ArrayXd& omega_rad_s, const Eigen::ArrayXd& decay) const = 0;
};

/// exp(mean(ln values)) of positive values.
double geometric_mean(const Eigen::ArrayXd& values);

}  // namespace klang::damping
