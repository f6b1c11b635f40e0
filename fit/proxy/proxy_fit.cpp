#include "fit/proxy/proxy_fit.hpp"

#include <ceres/ceres.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "core/base/conventions.hpp"
#include "core/base/errors.hpp"
#include "core/mesh/inertia.hpp"
#include "fit/damping.hpp"
#include "fit/proxy/proxy_cost.hpp"

namespace klang::fit {
namespace {

struct Point {
  std::array<double, 2> square;
  double ln_scale = 0.0;
};

class Fit {
 public:
  Fit(const soundbank::Soundbank& bank, const ProxyTarget& target, const ProxyFitOptions& options)
      : bank_(bank), target_(target), options_(options), speed_(target.shear_speed_m_s > 0.0 ? target.shear_speed_m_s : bank.material.shear_speed_m_s()) {
    n_ = std::min(static_cast<std::size_t>(options.n_partials), target.voice.size());
    for (std::size_t k = 0; k < n_; ++k) hz_.push_back(target.voice[k].frequency_hz);
  }

  ProxyFitResult run();

 private:
  Point start_of_axes(const Eigen::Vector3d& axes) const {
    const double depth = -std::log(bank_.thinnest);
    Eigen::Vector3d sorted = axes.cwiseMax(1e-12);
    std::sort(sorted.begin(), sorted.end());
    const double u = std::clamp(std::log(sorted[0] / sorted[2]), -depth, 0.0), v = std::clamp(std::log(sorted[1] / sorted[2]), u, 0.0);
    return at_lowest({{-u / depth, u < 0.0 ? v / u : 0.5}, 0.0});
  }
  /// Equi-frequency: the scale from the lowest partial alone.
  Point at_lowest(Point p) const {
    const auto place = soundbank::locate(bank_, shape_of_square(bank_, p.square[0], p.square[1]));
    p.ln_scale = std::log(soundbank::lowest_frequency(bank_, place) * speed_ / (2.0 * kPi * hz_[0]));
    return p;
  }
  Eigen::VectorXd frequencies_hz(const Point& p, int count) const {
    soundbank::Proxy proxy;
    proxy.place = soundbank::locate(bank_, shape_of_square(bank_, p.square[0], p.square[1]));
    proxy.scale = std::exp(p.ln_scale);
    return soundbank::proxy_frequencies_hz(bank_, proxy, count, speed_);
  }
  double rms_cents(const Point& p) const {
    const Eigen::VectorXd f = frequencies_hz(p, static_cast<int>(n_));
    double sum = 0.0;
    for (std::size_t k = 0; k < n_; ++k) sum += std::pow(1200.0 * std::log2(f[static_cast<Eigen::Index>(k)] / hz_[k]), 2);
    return std::sqrt(sum / static_cast<double>(n_));
  }
  /// As many partials as the target has, with damping and amplitudes 1 / omega times a gain.
  Voice voice(const Point& p, double alpha, double beta, double gain) const {
    Voice out;
    const Eigen::VectorXd f = frequencies_hz(p, static_cast<int>(target_.voice.size()));
    for (const double hz : f) {
      const double omega = 2.0 * kPi * hz;
      out.push_back({hz, 0.5 * (alpha + beta * omega * omega), gain / omega});
    }
    return out;
  }
  static double energy(const Voice& voice) {
    double sum = 0.0;
    for (const VoicePartial& p : voice) sum += p.amplitude * p.amplitude / p.decay_per_s;
    return sum;
  }
  Point solve_shape(Point p, bool keep_lowest) const;
  void solve_damping(const Point& p, double& alpha, double& beta) const;
  ProxyParameters parameters(const Point& p, double alpha, double beta, double gain) const {
    return {soundbank::unit_axes(shape_of_square(bank_, p.square[0], p.square[1])), std::exp(p.ln_scale), alpha, beta, gain};
  }

  const soundbank::Soundbank& bank_;
  const ProxyTarget& target_;
  const ProxyFitOptions& options_;
  const double speed_;
  std::size_t n_ = 0;
  std::vector<double> hz_;
};

Point Fit::solve_shape(Point p, bool keep_lowest) const {
  ceres::Problem problem;
  if (keep_lowest)
    problem.AddResidualBlock(proxy_frequency_cost(bank_, {hz_[0]}, speed_).release(), new ceres::ScaledLoss(nullptr, 1e4, ceres::TAKE_OWNERSHIP),
                             p.square.data(), &p.ln_scale);
  problem.AddResidualBlock(proxy_frequency_cost(bank_, hz_, speed_).release(), nullptr, p.square.data(), &p.ln_scale);
  for (int i = 0; i < 2; ++i) {
    problem.SetParameterLowerBound(p.square.data(), i, 0.0);
    problem.SetParameterUpperBound(p.square.data(), i, 1.0);
  }
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_QR;
  options.max_num_iterations = 60;
  options.num_threads = 1;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  return p;
}

void Fit::solve_damping(const Point& p, double& alpha, double& beta) const {
  const Eigen::VectorXd f = frequencies_hz(p, static_cast<int>(n_));
  std::vector<DecayPoint> decays;
  for (std::size_t k = 0; k < n_; ++k)
    decays.push_back({f[static_cast<Eigen::Index>(k)], target_.voice[k].decay_per_s});
  std::vector<std::string> unheard;
  const DampingResult damping = fit_damping(decays, unheard);
  const DampingCandidate* rayleigh = find_candidate(damping, DampingKind::kRayleigh);
  if (!rayleigh) return;
  beta = rayleigh->parameters[0].value;
  alpha = rayleigh->parameters[1].value;
}

ProxyFitResult Fit::run() {
  ProxyFitResult result;
  result.target = target_.voice;
  const auto errors = [&](const Voice& v) {
    return proxy_errors(target_.voice, v, static_cast<int>(n_), options_.duration_s, options_.sample_rate_hz);
  };
  // Samples by the error of their frequencies at the best scale.
  std::vector<std::pair<double, Point>> samples;
  for (const soundbank::ShapePoint& node : bank_.nodes) {
    Point p = start_of_axes(soundbank::unit_axes(node));
    const Eigen::VectorXd f = frequencies_hz(p, static_cast<int>(n_));
    double mean = 0.0;
    for (std::size_t k = 0; k < n_; ++k) mean += std::log(f[static_cast<Eigen::Index>(k)] / hz_[k]) / static_cast<double>(n_);
    p.ln_scale += mean;
    samples.emplace_back(rms_cents(p), p);
  }
  std::stable_sort(samples.begin(), samples.end(), [](const auto& a, const auto& b) { return a.first < b.first; });

  const Point start = target_.moments ? start_of_axes(soundbank::axes_of_moments(*target_.moments)) : at_lowest(samples[0].second);
  if (target_.moments) {
    const Eigen::Vector3d axes = soundbank::axes_of_moments(*target_.moments);
    result.start_clamped = !(axes.minCoeff() >= bank_.thinnest * axes.maxCoeff());
  }
  double alpha = target_.rayleigh_mass_per_s, beta = target_.rayleigh_stiffness_s;
  if (!(alpha + beta > 0.0)) solve_damping(start, alpha, beta);  // a recording has no given damping
  // A model's own amplitudes hold for the proxy of its own mass; a recording's level is arbitrary.
  double gain = 2.0 * kPi * target_.voice[0].frequency_hz * target_.voice[0].amplitude;
  result.start = parameters(start, alpha, beta, gain);
  result.start_voice = voice(start, alpha, beta, gain);
  result.before = errors(result.start_voice);
  result.after = result.before;
  result.fitted = result.start;
  result.fitted_voice = result.start_voice;
  result.status = ProxyFitStatus::kKept;

  std::vector<Point> starts{start}, points;
  for (std::size_t i = 0; i < std::min<std::size_t>(samples.size(), 3); ++i) starts.push_back(samples[i].second);
  for (const Point& from : starts) {
    // All partials alike; and with the lowest one kept, which sounds longest and loudest. Also part of the way there.
    points.push_back(solve_shape(from, false));
    const Point kept = solve_shape(from, true);
    for (const double part : {1.0, 0.75, 0.5, 0.25})
      points.push_back(at_lowest({{start.square[0] + part * (kept.square[0] - start.square[0]),
                                   start.square[1] + part * (kept.square[1] - start.square[1])}, 0.0}));
  }
  std::stable_sort(points.begin(), points.end(), [&](const Point& p, const Point& q) { return rms_cents(p) < rms_cents(q); });
  // By rising error of the partials: the first that is no worse in any measure is the best.
  for (const Point& p : points) {
    if (result.status == ProxyFitStatus::kImproved || !(rms_cents(p) < result.before.partial_rms_cents)) break;
    for (const bool refit_damping : {true, false}) {
      double a = alpha, b = beta;
      if (refit_damping) solve_damping(p, a, b);
      const double equal_energy = std::sqrt(energy(target_.voice) / energy(voice(p, a, b, 1.0)));
      // The gain that makes the A-weighted energies equal, that of the energies, and the start's.
      const audio::SpectralDistance level =
          audio::spectral_distance(voice_sound(target_.voice, options_.duration_s, options_.sample_rate_hz),
                                   voice_sound(voice(p, a, b, equal_energy), options_.duration_s, options_.sample_rate_hz));
      const double equal_loudness = equal_energy * std::pow(10.0, -level.loudness_difference_db / 20.0);
      for (const double g : {equal_loudness, equal_energy, gain}) {
        ++result.n_candidates;
        const Voice found = voice(p, a, b, g);
        const ProxyErrors now = errors(found);
        if (!no_worse(now, result.before)) {
          ++result.n_refused;
          continue;
        }
        if (result.status == ProxyFitStatus::kImproved && !(now.log_spectral_distance_db < result.after.log_spectral_distance_db)) continue;
        result.status = ProxyFitStatus::kImproved;
        result.after = now;
        result.fitted = parameters(p, a, b, g);
        result.fitted_voice = found;
      }
    }
  }
  if (result.status == ProxyFitStatus::kKept) result.message = "no fit is better in one measure and no worse in all: the start is kept";
  return result;
}

}  // namespace

ProxyTarget target_of_model(const modal::ModalModel& model, double rayleigh_mass_per_s, double rayleigh_stiffness_s) {
  if (model.n_modes() < 3) throw InputError("target", "a proxy needs at least 3 modes", std::to_string(model.n_modes()));
  checked("target", "rayleigh_mass_per_s", rayleigh_mass_per_s, 0.0, 1e6);
  checked("target", "rayleigh_stiffness_s", rayleigh_stiffness_s, 0.0, 1.0);
  if (!(rayleigh_mass_per_s + rayleigh_stiffness_s > 0.0)) throw InputError("target", "a model needs damping to sound", {}, "Rayleigh's two, not both 0");
  ProxyTarget target;
  target.moments = mesh::principal_moments(mesh::mass_properties(model.mesh));
  target.shear_speed_m_s = model.material.shear_speed_m_s();
  target.rayleigh_mass_per_s = rayleigh_mass_per_s;
  target.rayleigh_stiffness_s = rayleigh_stiffness_s;
  const double lowest = model.angular_frequency_rad_s[0];
  for (const double omega : model.angular_frequency_rad_s)
    target.voice.push_back({omega / (2.0 * kPi), 0.5 * (rayleigh_mass_per_s + rayleigh_stiffness_s * omega * omega), lowest / omega});
  return target;
}

ProxyTarget target_of_partials(const PartialTable& table) {
  ProxyTarget target;
  for (const Partial& p : table.partials) {
    if (!p.decay_per_s || !p.amplitude || !(*p.decay_per_s > 0.0) || !(*p.amplitude > 0.0)) continue;
    target.voice.push_back({p.frequency_hz, *p.decay_per_s, *p.amplitude});
  }
  if (target.voice.size() < 3)
    throw InputError(table.origin, "a proxy needs at least 3 partials with decay and amplitude", std::to_string(target.voice.size()));
  return target;
}

void ProxyFitOptions::validate() const {
  if (n_partials < 3 || n_partials > 40) throw InputError("proxy fit", "n_partials", std::to_string(n_partials), "3 to 40");
  checked("proxy fit", "duration_s", duration_s, 0.05, 20.0);
  checked("proxy fit", "sample_rate_hz", sample_rate_hz, 8000.0, 192000.0);
}

ProxyFitResult fit_proxy(const soundbank::Soundbank& bank, const ProxyTarget& target, const ProxyFitOptions& options) {
  options.validate();
  if (target.voice.size() < 3) throw InputError("target", "a proxy needs at least 3 partials", std::to_string(target.voice.size()));
  if (!(target.voice[0].frequency_hz < 0.4 * options.sample_rate_hz))
    throw InputError("target", "its lowest partial cannot be heard at this sample rate", klang::to_text(target.voice[0].frequency_hz) + " Hz",
                     "below " + klang::to_text(0.4 * options.sample_rate_hz) + " Hz");
  return Fit(bank, target, options).run();
}

}  // namespace klang::fit
