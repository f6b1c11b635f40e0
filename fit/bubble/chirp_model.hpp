#pragma once
#include <Eigen/Core>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

namespace klang::fit::bubble {

/// ln(omega / omega_onset) of a bubble as a function of the time since its onset and of two numbers.
class PitchLaw {
 public:
  struct Value {
    double log_ratio = 0.0;
    double by_time = 0.0;  ///< 1/s
    Eigen::Vector2d by_parameter{0.0, 0.0};
  };
  virtual ~PitchLaw() = default;
  /// @param time_s  since the onset, >= 0
  virtual Value at(double time_s, const Eigen::Vector2d& parameters) const = 0;
  /// Steps of like effect, as the solver counts the parameters, and what they may be.
  virtual Eigen::Vector2d unit() const = 0;
  virtual Eigen::Vector2d low() const = 0;
  virtual Eigen::Vector2d high() const = 0;
};

/// What the sound alone can tell: ln ratio = rate (e^(growth t) - 1) / growth, parameters (rate [1/s], growth [1/s]).
/// It is HF eq. (6), frequency updated each step, for a bubble that rises at an even speed v from depth d:
///   rate = K v e^(eta (1 - d / |phi0|)), growth = eta v / |phi0|.
class ExponentialPitch final : public PitchLaw {
 public:
  explicit ExponentialPitch(double max_factor = 3.0);
  Value at(double time_s, const Eigen::Vector2d& parameters) const override;
  Eigen::Vector2d unit() const override { return {10.0, 10.0}; }
  Eigen::Vector2d low() const override { return -high(); }
  Eigen::Vector2d high() const override { return {400.0, 400.0}; }  ///< three octaves in 5 ms

 private:
  double max_log_;
};

/// HF eq. (6) along a known depth d(t) [m, positive below the surface]: parameters (ln P, ln q),
///   ln ratio = P (e^(-q d(t)) - e^(-q d(0))), P = K e^eta / q, q = eta / |phi0| [1/m],
/// which is all of (K, eta, phi0) that pitch depends on.
class DepthPitch final : public PitchLaw {
 public:
  /// @param depth_m  by time since the onset; speed_m_s: how fast the depth falls there
  DepthPitch(std::function<double(double)> depth_m, std::function<double(double)> speed_m_s, double max_factor = 3.0);
  Value at(double time_s, const Eigen::Vector2d& parameters) const override;
  Eigen::Vector2d unit() const override { return {1.0, 1.0}; }
  Eigen::Vector2d low() const override { return {-6.9, 0.0}; }  ///< ln 1e-3, ln 1 per m
  Eigen::Vector2d high() const override { return {9.2, 9.2}; }  ///< ln 1e4

 private:
  std::function<double(double)> depth_m_, speed_m_s_;
  double max_log_;
};

/// How amplitude and decay follow the pitch, and how the sound begins.
struct ChirpLaw {
  std::shared_ptr<const PitchLaw> pitch;
  double amplitude_exponent =
      1.5;                      ///< |p| ~ omega^n: n = 2 of the volume's acceleration - 1/2 of the adiabatic invariant
  double decay_exponent = 1.5;  ///< beta ~ omega^m
  /// Attack window of HF eq. (39); 0: at the decay's own rate, as printed; > 0: at this rate, for what begins with a snap.
  double quick_attack_per_s = 0.0;
  /// Since the onset: when the bubble comes to rest (under the surface, at a wall) and keeps its pitch. Empty: while it is heard, never.
  std::optional<double> rest_s;
  bool soft_attack() const { return quick_attack_per_s == 0.0; }
  /// The pitch law up to the rest, and what it was there from then on.
  PitchLaw::Value pitch_at(double time_s, const Eigen::Vector2d& parameters) const;
};

/// Own parameters of one bubble, in the order in which the solver sees them (pitch law's two come first).
struct Chirp {
  Eigen::Vector2d pitch{0.0, 0.0};
  double onset_s = 0.0;
  double log_frequency = 0.0;       ///< ln of the damped frequency at the onset [Hz]
  double log_decay = 0.0;           ///< ln of the amplitude's decay at the onset [1/s]
  double cosine = 0.0, sine = 0.0;  ///< amplitudes at the onset, full scale = 1

  static constexpr int kParameters = 7;
  Eigen::Matrix<double, kParameters, 1> vector() const;
  static Chirp from(const Eigen::Matrix<double, kParameters, 1>& vector);
};

/// Samples of p(t) = w(t) (omega/omega_0)^n exp(-int beta) [c cos(int omega) + s sin(int omega)], t since the onset, zero
/// before it. Integrals by Simpson's rule on the sampling grid.
/// @param first_s   time of the first sample, on the clock of onset_s
/// @param jacobian  null, or n x 7
void evaluate_chirp(const ChirpLaw& law, const Chirp& chirp, double first_s, double sample_rate_hz,
                    Eigen::Ref<Eigen::VectorXd> value, Eigen::MatrixXd* jacobian = nullptr);

/// Frequency and amplitude along a chirp.
struct ChirpPoint {
  double time_s = 0.0;                                           ///< since the onset
  double frequency_hz = 0.0, envelope = 0.0, decay_per_s = 0.0;  ///< envelope: full scale = 1, without the attack
};
/// At times since the onset, ascending.
std::vector<ChirpPoint> chirp_track(const ChirpLaw& law, const Chirp& chirp, const std::vector<double>& times_s);

}  // namespace klang::fit::bubble
