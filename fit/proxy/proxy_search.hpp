#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/foundation/base/monitor.hpp"
#include "core/foundation/config/fields.hpp"
#include "fit/proxy/proxy_model.hpp"
#include "fit/proxy/proxy_sound.hpp"

namespace klang::fit {

struct ProxySearchOptions {
  int grid = 64;
  int parts = 24;  ///< at most grid
  int n_scan = 800;
  int n_generations = 8;  ///< thrice as many while cents have not fallen by 40 %
  int n_children = 48;
  std::uint64_t seed = 1;
  void validate() const;  ///< InputError

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"grid", "Shapes along each side of the square", between(10.0, 512.0)}, self.grid);
    visit({"parts", "The square is scanned by so many parts each way", between(1.0, 512.0)}, self.parts);
    visit({"n_scan", "Candidates of the grid whose sound is compared", between(16.0, 100000.0)}, self.n_scan);
    visit({"n_generations", "Of the search around the best: more are slower and may find a better one",
           between(0.0, 1000.0)},
          self.n_generations);
    visit({"n_children", "Candidates of each generation", between(4.0, 1000.0)}, self.n_children);
  }
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

/// The proxy that the search starts from.
struct ProxyStart {
  RayleighDamping damping;
  double gain = 1.0;
  ProxyErrors errors;  ///< no measure may become worse than here
};

/// Minimises the rms error of the partials over shape, scale and damping under the condition that no other measure is worse than at
/// the start.
/// 1. The error of the partials (microseconds) on a grid of the shape square, at the best scale, at those that keep one of the lowest
///    partials, and half-way; the grid's local minima are refined by Ceres.
/// 2. Of each part of the square and each kind of scale the best is heard: all other measures at the best gain.
/// 3. Normally distributed children around the best of ln(error) + penalty * excess and around the best admissible ones; only
///    children with fewer cents than the best admissible one are heard.
/// The measures are not smooth (lines pass bins of the spectrum), hence no slopes in 3. Same bits for any number of threads.
ProxySearchResult search_proxy(const ProxyModel& model, const TargetSound& target, const ProxyStart& start,
                               const ProxySearchOptions& options = {}, Monitor& monitor = silent_monitor());

}  // namespace klang::fit
