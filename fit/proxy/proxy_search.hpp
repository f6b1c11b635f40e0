#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/foundation/base/monitor.hpp"
#include "fit/proxy/proxy_model.hpp"
#include "fit/proxy/proxy_sound.hpp"

namespace klang::fit {

struct ProxySearchOptions {
  int grid = 64;     ///< shapes along each side of the square, 10 to 512
  int parts = 24;    ///< the square is scanned by parts x parts parts, 1 to grid
  int n_scan = 800;  ///< candidates of the grid whose sound is heard, 16 to 100000
  int n_generations =
      8;  ///< of the search around the best, 0 to 1000; thrice as many while cents have not fallen by 40 %
  int n_children = 48;  ///< heard in each, 4 to 1000
  std::uint64_t seed = 1;
  void validate() const;  ///< InputError
};

/// A proxy that was heard.
struct ProxyCandidate {
  ProxyPoint point;
  double cents = 0.0;  ///< rms of the first partials
  RayleighDamping damping;
  TargetSound::Level level;
  bool admissible() const { return level.excess == 0.0; }
};

struct ProxySearchResult {
  std::optional<ProxyCandidate> best;  ///< least error of the partials with no measure worse; empty: none was found
  double least_cents = 0.0;            ///< least error of the partials at all: the bound without conditions
  int n_heard = 0, n_admissible = 0;
  std::array<int, 5>
      n_worse{};  ///< of those heard to the end, in order: log-spectral, mel, third octaves, loudness, decays
};

/// Minimises the rms error of the partials over shape, scale and damping under the condition that no other measure is worse than
/// `before`.
/// 1. The error of the partials (microseconds) on a grid of the shape square, at the best scale, at those that keep one of the lowest
///    partials, and half-way; the grid's local minima are refined by Ceres.
/// 2. Of each part of the square and each kind of scale the best is heard: all other measures at the best gain.
/// 3. Normally distributed children around the best of ln(error) + penalty * excess and around the best admissible ones; only
///    children with fewer cents than the best admissible one are heard.
/// The measures are not smooth (lines pass bins of the spectrum), hence no slopes in 3. Same bits for any number of threads.
ProxySearchResult search_proxy(const ProxyModel& model, const TargetSound& target, const RayleighDamping& kept,
                               double start_gain, const ProxyErrors& before, const ProxySearchOptions& options = {},
                               Monitor& monitor = silent_monitor());

}  // namespace klang::fit
