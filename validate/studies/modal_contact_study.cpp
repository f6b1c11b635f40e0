#include <array>
#include <cmath>

#include "core/foundation/base/stopwatch.hpp"
#include "core/physics/modal/constraints/touching_body.hpp"
#include "validate/studies/registry.hpp"

namespace klang::validate {
namespace {

Series rebound_series(bool flexible, std::size_t n_levels, Study& study, Monitor& monitor) {
  Series series;
  series.id = flexible ? "residual-flexibility" : "kept-modes";
  series.title = flexible ? "Bar on a wall, discarded modes as a spring" : "Bar on a wall, the kept modes alone";
  series.reference = "the bar of the continuum rebounds as fast as it came";
  series.step_words = "elastic modes";
  series.error_words = "1 - restitution of the centre";
  series.expected_order = flexible ? std::nan("") : 1.0;
  series.error_tolerance = 0.04;
  series.exact_value = 1.0;
  series.counts = !flexible;
  // tests/reference/modal_contact.json: bar_on_wall
  constexpr std::array<int, 5> kModes{1, 2, 4, 8, 16};
  constexpr std::array<double, 5> kRebounds{0.6666666666666667, 0.7999012625313421, 0.8887345975423172,
                                            0.941046439135414, 0.9696144065469819};
  if (!flexible) series.error_tolerance *= static_cast<double>(kModes.back()) / kModes[n_levels - 1];
  for (std::size_t i = 0; i < n_levels; ++i) {
    monitor.throw_if_stopped();
    const Stopwatch watch;
    modal::BarOnWall bar;
    bar.n_modes = kModes[i];
    bar.residual_flexibility = flexible;
    const modal::Rebound rebound = modal::bar_on_wall(bar);
    Level level;
    level.n = kModes[i];
    level.value = rebound.restitution;
    level.exact = 1.0;
    level.error = std::abs(1.0 - rebound.restitution);
    level.n_unknowns = kModes[i] + 1;
    level.wall_time_s = watch.seconds();
    series.levels.push_back(level);
    if (flexible) continue;
    const std::string modes = std::to_string(kModes[i]);
    study.claims.push_back(judged({"modal-contact.rebound-" + modes,
                                   "restitution of a bar with " + modes + " modes",
                                   rebound.restitution,
                                   kRebounds[i],
                                   1e-4,
                                   {},
                                   false}));
    study.claims.push_back(judged({"modal-contact.shock-" + modes,
                                   "share of the energy that the touch takes, 1/(1 + 2n), with " + modes + " modes",
                                   rebound.energy_lost,
                                   1.0 / (1 + 2 * kModes[i]),
                                   1e-12,
                                   {},
                                   false}));
  }
  return series;
}

}  // namespace

/// Restitution of a free bar of n modes that flies at a wall.
Study modal_contact_study(const StudyOptions& options, Monitor& monitor) {
  Study study;
  study.title = "Contact of modal bodies";
  study.question = "How does the rebound of a bar from a wall depend on how many modes are kept (H03, erratum 72)?";
  for (const bool flexible : {false, true})
    if (wanted(options, flexible ? "residual-flexibility" : "kept-modes"))
      study.series.push_back(rebound_series(flexible, level_count(options, 5), study, monitor));
  return study;
}

}  // namespace klang::validate
