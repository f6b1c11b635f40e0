#pragma once
#include <memory>
#include <optional>
#include <vector>

#include "core/sound/soundbank/proxy.hpp"
#include "fit/proxy/proxy_frequencies.hpp"
#include "fit/proxy/proxy_target.hpp"

namespace klang::fit {

/// Where a search stands.
struct ProxyPoint {
  double s = 0.0, t = 0.5;  ///< shape square, 0 to 1 each (shape_of_square)
  double ln_scale = 0.0;    ///< of |axes| in metres
  /// Damping's mass and stiffness: 0 the start's, 1 the one of the best fit to the target's decays, else in proportion.
  double refitted_mass = 0.0, refitted_stiffness = 0.0;
  /// Level: -1 to 1 times the start's difference of loudness away from equal loudness; empty: the best of a few.
  std::optional<double> level;
};

using damping::RayleighDamping;

/// What a proxy of a target sounds like, by its parameters. Constant after construction, so one object serves all threads.
class ProxyModel {
 public:
  /// Bank and target must outlive it.
  /// @throws InputError for a target with radiation where the bank has no sound, or that of another ratio of shear to sound speed
  ProxyModel(const soundbank::Soundbank& bank, const ProxyTarget& target, int n_partials);

  int n_partials() const { return static_cast<int>(ln_hz_.size()); }
  const ProxyFrequencies& first_frequencies() const { return first_; }
  double shear_speed_m_s() const { return speed_; }
  const std::vector<double>& target_hz() const { return hz_; }

  /// At these axes, in any order and of any length, with the lowest partial kept.
  ProxyPoint at_axes(const Eigen::Vector3d& axes) const;
  /// Where ln(f_proxy / f_target) of the first partials lie at ln_scale = 0; empty where the bank does not know enough modes.
  void log_ratios(double s, double t, std::vector<double>& ratios) const;
  /// rms of the first partials [cents]; infinite where the bank does not know enough modes. Microseconds.
  double rms_cents(const ProxyPoint& point) const;

  /// Damping at a point: the kept one moved towards the least rms of (decay / target's - 1) over the first partials.
  RayleighDamping damping(const ProxyPoint& point, const RayleighDamping& kept) const;
  /// By klang fit's own damping models, for a target that names none (a recording).
  RayleighDamping measured_damping(const ProxyPoint& point) const;
  /// As many partials as the target has, if the bank knows them. Amplitude 1 / omega; with radiation that of the power of the
  /// nearest cell's mode of the same class and rank (one that the cell lacks: of its nearest in frequency), at this size and density.
  Voice voice(const ProxyPoint& point, const RayleighDamping& damping) const;

 private:
  std::vector<double> ln_hz_, hz_;
  const soundbank::Soundbank& bank_;
  const ProxyTarget& target_;
  double speed_, ln_speed_;  // ln(c_s / 2 pi)
  ProxyFrequencies first_, all_;
  std::unique_ptr<const soundbank::ProxyFinder> cells_;  // with radiation
  double power_factor_ = 1.0;                            // of rho c of the gas and the solid's density
};

}  // namespace klang::fit
