#pragma once
#include <optional>
#include <string>
#include <vector>

#include "core/modal/modal_model.hpp"
#include "core/soundbank/proxy.hpp"
#include "fit/partial_table.hpp"
#include "fit/proxy/proxy_sound.hpp"

namespace klang::fit {

/// What a proxy is to sound like: a model's modes from the lowest up, or the partials of a recording.
struct ProxyTarget {
  Voice voice;                             ///< by frequency
  std::optional<Eigen::Vector3d> moments;  ///< principal moments over density, of a model
  double shear_speed_m_s = 0.0;            ///< of its material; 0: the bank's
  double rayleigh_mass_per_s = 0.0, rayleigh_stiffness_s = 0.0;  ///< a model's damping: decay = (mass + stiffness omega^2) / 2
};

/// A struck body on the average over all places of strike and microphone: mode k rings with amplitude 1 / (m omega_k), its mean square shape
/// being 1 / m.
ProxyTarget target_of_model(const modal::ModalModel& model, double rayleigh_mass_per_s, double rayleigh_stiffness_s);
/// @throws InputError for partials without decay or amplitude
ProxyTarget target_of_partials(const PartialTable& table);

struct ProxyFitOptions {
  int n_partials = 10;            ///< first partials that are fitted and compared, 3 to 40
  double duration_s = 1.0;        ///< of the sounds that are compared, 0.05 to 20
  double sample_rate_hz = 48000;  ///< 8000 to 192000
  void validate() const;          ///< InputError
};

struct ProxyParameters {
  Eigen::Vector3d axes;  ///< |axes| = 1
  double scale_m = 0.0, rayleigh_mass_per_s = 0.0, rayleigh_stiffness_s = 0.0, gain = 1.0;
};

enum class ProxyFitStatus { kNotRun, kImproved, kKept };
struct ProxyFitResult {
  ProxyFitStatus status = ProxyFitStatus::kNotRun;
  std::string message;
  ProxyErrors before, after;
  ProxyParameters start, fitted;
  Voice target, start_voice, fitted_voice;
  bool start_clamped = false;
  int n_candidates = 0, n_refused = 0;  ///< fits that ended, and those refused because one measure had become worse
};

/// The best ellipsoid for a target. Start: shape from the moments (a recording: the sample whose ratios of frequencies lie nearest), scale from
/// the lowest partial. Then Ceres over two shape numbers, ln scale, ln Rayleigh alpha and beta, ln gain from several starts. Of the fits the
/// one with the smallest error of the partials is taken among those in which no measure is worse than at the start; where there is none
/// the start is kept.
ProxyFitResult fit_proxy(const soundbank::Soundbank& bank, const ProxyTarget& target, const ProxyFitOptions& options = {});

}  // namespace klang::fit
