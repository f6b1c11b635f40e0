#pragma once
#include <string>

#include "core/foundation/base/monitor.hpp"
#include "core/sound/soundbank/soundbank.hpp"
#include "fit/proxy/proxy_search.hpp"
#include "fit/proxy/proxy_target.hpp"

namespace klang::fit {

struct ProxyFitOptions {
  int n_partials = 10;          ///< first partials that are fitted and compared at most, 3 to 40
  double highest_hz = 20000.0;  ///< partials above it cannot be heard and are not fitted (three always are), 100 to 1e6
  double duration_s = 1.0;      ///< of the sounds that are compared, 0.05 to 20
  double sample_rate_hz = 48000;  ///< 8000 to 192000
  ProxySearchOptions search;
  void validate() const;  ///< InputError
};

struct ProxyParameters {
  Eigen::Vector3d axes;  ///< |axes| = 1
  double scale_m = 0.0, rayleigh_mass_per_s = 0.0, rayleigh_stiffness_s = 0.0, gain = 1.0;
};

enum class ProxyFitStatus { kNotRun, kImproved, kKept };
struct ProxyFitResult {
  ProxyFitStatus status = ProxyFitStatus::kNotRun;
  std::string message;
  int n_partials = 0;  ///< that were fitted and compared
  ProxyErrors before, after;
  double least_cents = 0.0;  ///< least error of the partials, whatever it costs in the other measures
  ProxyParameters start, fitted;
  Voice target, start_voice, fitted_voice;
  bool start_clamped = false;
  int n_candidates = 0,
      n_refused = 0;  ///< proxies that were heard, and those refused because a measure had become worse
  std::array<int, 5>
      n_worse{};  ///< how many were worse in: log-spectral, mel, third octaves, loudness, decays (of those heard to the end)
};

/// The best ellipsoid for a target. Start: shape from the moments (a recording: the sample whose ratios of frequencies lie nearest), scale from
/// the lowest partial, damping as given (a recording: fitted). Then search_proxy: the least error of the partials under the condition
/// that no other measure is worse than at the start; where there is none the start is kept.
ProxyFitResult fit_proxy(const soundbank::Soundbank& bank, const ProxyTarget& target,
                         const ProxyFitOptions& options = {}, Monitor& monitor = silent_monitor());

}  // namespace klang::fit
