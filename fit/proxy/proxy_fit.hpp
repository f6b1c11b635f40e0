#pragma once
#include <string>

#include "core/foundation/base/monitor.hpp"
#include "core/sound/soundbank/soundbank.hpp"
#include "fit/proxy/proxy_search.hpp"
#include "fit/proxy/proxy_target.hpp"

namespace klang::fit {

struct ProxyFitOptions {
  int n_partials = 10;
  double highest_hz = 20000.0;  ///< partials above it cannot be heard
  double duration_s = 1.0;
  double sample_rate_hz = 48000;
  ProxySearchOptions search;
  void validate() const;  ///< InputError

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"n_partials", "First partials that are fitted and compared, at most", between(3.0, 40.0)}, self.n_partials);
    visit({"highest_hz", "Partials above it are not fitted nor compared (three always are)", between(100.0, 1e6)},
          self.highest_hz);
    visit({"duration_s", "Length of the sounds that are compared", between(0.05, 20.0)}, self.duration_s);
    visit({"sample_rate_hz", "Their sample rate", between(8000.0, 192000.0)}, self.sample_rate_hz);
    visit({"search", "The search"}, self.search);
  }
};

struct ProxyParameters {
  Eigen::Vector3d axes;  ///< |axes| = 1
  double scale_m = 0.0;
  damping::RayleighDamping damping;
  double gain = 1.0;
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
