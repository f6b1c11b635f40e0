#include "core/sound/dual_domain/transfer_series.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/foundation/base/check.hpp"
#include "core/foundation/base/errors.hpp"

namespace klang::bubble {
namespace {

Eigen::Vector3d position(const BubblePath& path, double time_s) {
  const auto after = std::upper_bound(path.time_s.begin(), path.time_s.end(), time_s) - path.time_s.begin();
  if (after == 0) return path.position_m.front();
  if (static_cast<std::size_t>(after) == path.time_s.size()) return path.position_m.back();
  const auto i = static_cast<std::size_t>(after);
  const double t = (time_s - path.time_s[i - 1]) / (path.time_s[i] - path.time_s[i - 1]);
  return (1.0 - t) * path.position_m[i - 1] + t * path.position_m[i];
}

struct FrameBubble {
  SwingingBubble bubble;
  Eigen::Vector3d listener_m;
  double time_s = 0.0;
};

/// Adds the transfer in one frame; false: the result says why there is none.
bool solve_frame(const LiquidBoundary& liquid, const SourcePoints& points, const FrameBubble& at,
                 const TransferSeriesOptions& options, TransferSeriesResult& result) {
  const bool first = result.n_solves++ == 0, paper = options.solver.literature == Literature::kPaper;
  ReciprocalOptions reciprocal{options.solver, options.air_vertices, first};
  std::optional<ReciprocalTransfer> reference;
  if (first && !paper) {
    try {
      reference =
          reciprocal_transfer(liquid, options.frequency_hz, points, {{at.bubble}, {at.listener_m}}, reciprocal)[0][0];
    } catch (const NumericalError&) {
      if (options.method == TransferMethod::kReciprocal) throw;
    }
  }
  if (options.method == TransferMethod::kReciprocal) {
    const EarField air = ear_field(liquid, options.frequency_hz, {at.listener_m}, reciprocal);
    const EarInLiquid ear = ear_in_liquid(liquid, air, points, reciprocal);
    const std::complex<double> pressure = ear.pressure(at.bubble, 0);
    if (reference) result.error_estimate = error_estimate(pressure, *reference);
    result.n_fluid_sources = static_cast<int>(points.fluid_m.size());
    result.n_air_sources = static_cast<int>(points.air_m.size());
    result.steps.push_back({at.time_s, pressure, ear.fit_error[0], std::nullopt, false});
    return true;
  }
  const DualDomainResult solved =
      solve_dual_domain(liquid, options.frequency_hz, points, {at.bubble}, options.solver)[0];
  if (!solved.usable()) {
    result.status = TransferSeriesResult::Status::kFailed;
    result.message = "at " + to_text(at.time_s) + " s: " + solved.message;
    return false;
  }
  result.n_fluid_sources = first ? solved.n_fluid_sources : std::min(result.n_fluid_sources, solved.n_fluid_sources);
  result.n_air_sources = first ? solved.n_air_sources : std::min(result.n_air_sources, solved.n_air_sources);
  const std::complex<double> pressure = air_pressure(solved, at.listener_m);
  if (reference) result.error_estimate = error_estimate(pressure, *reference);
  result.steps.push_back({at.time_s, pressure, solved.fit_error_fluid, solved.fit_error_air, false});
  return true;
}

}  // namespace

double error_estimate(std::complex<double> pressure, const ReciprocalTransfer& reference) {
  return std::abs(pressure - reference.pressure) / std::abs(reference.pressure) + reference.error_estimate();
}

void TransferSeriesOptions::validate() const { validate_fields("transfer series", *this); }

TransferSeriesResult transfer_series(const std::vector<double>& frame_time_s,
                                     const std::function<LiquidBoundary(std::size_t)>& boundary, const BubblePath& path,
                                     const Eigen::Vector3d& listener_m, const TransferSeriesOptions& options,
                                     Monitor& monitor) {
  options.validate();
  KLANG_CHECK(!path.time_s.empty() && path.time_s.size() == path.position_m.size(), "a path has a position a time");
  for (std::size_t i = 1; i < path.time_s.size(); ++i)
    if (!(path.time_s[i] > path.time_s[i - 1]))
      throw InputError("bubble path", "times do not rise at point " + std::to_string(i), to_text(path.time_s[i]));
  const double birth_s = path.time_s.front();
  if (frame_time_s.empty() || birth_s < frame_time_s.front() || birth_s > frame_time_s.back())
    throw InputError(
        "bubble path", "starts outside the frames", to_text(birth_s),
        frame_time_s.empty() ? "" : to_text(frame_time_s.front()) + " to " + to_text(frame_time_s.back()) + " s");
  const double step_s = frame_time_s.size() > 1 ? (frame_time_s.back() - frame_time_s.front()) /
                                                      static_cast<double>(frame_time_s.size() - 1)
                                                : 0.0;
  const double life_s = options.decay_per_s > 0.0 ? std::log(1000.0) / options.decay_per_s : HUGE_VAL;

  TransferSeriesResult result;
  std::optional<SourcePoints> points;
  double next_s = birth_s, before_s = birth_s;
  // The frame in force at birth is the last one that is not later.
  std::size_t first = 0;
  while (first + 1 < frame_time_s.size() && frame_time_s[first + 1] <= birth_s) ++first;
  for (std::size_t i = first; i < frame_time_s.size(); ++i) {
    monitor.throw_if_stopped();
    monitor.progress("transfer", static_cast<double>(i - first) / static_cast<double>(frame_time_s.size() - first));
    const double time_s = std::max(frame_time_s[i], birth_s);
    if (time_s - birth_s > life_s) break;
    const bool frozen = !result.steps.empty() && (result.steps.back().frozen || time_s > path.time_s.back());
    if (frozen) {
      if (!result.steps.back().frozen || i + 1 == frame_time_s.size()) {
        TransferAtTime held = result.steps.back();
        held.time_s = time_s;
        held.frozen = true;
        result.steps.push_back(held);
      }
      continue;
    }
    const LiquidBoundary liquid = boundary(i);
    if (!points) {
      points = random_source_points(liquid, options.fluid_sources, options.air_sources, options.seed);
    } else {
      advect(*points, liquid, time_s - before_s);
    }
    before_s = time_s;
    if (time_s < next_s) continue;
    const Eigen::Vector3d at = position(path, time_s);
    if (!result.steps.empty() && (liquid.distance_m(at) <= 0.1 * options.radius_m || !liquid.inside_liquid(at))) {
      TransferAtTime held = result.steps.back();
      held.time_s = time_s;
      held.frozen = true;
      result.steps.push_back(held);
      continue;
    }
    if (liquid.inside_air_boundary(listener_m))
      throw InputError("listener", "lies inside the liquid (" + liquid.name() + ")");
    if (!solve_frame(liquid, *points, {{at, options.radius_m}, listener_m, time_s}, options, result)) return result;
    // Half a step of slack: frames do not fall on the grown steps exactly.
    next_s = time_s + step_s * (std::exp(options.decay_per_s * (time_s - birth_s)) - 0.5);
  }
  result.n_replaced_sources = points ? points->n_replaced : 0;
  result.status = TransferSeriesResult::Status::kDone;
  monitor.progress("transfer", 1.0);
  return result;
}

std::string transfer_series_csv(const TransferSeriesResult& result, double frequency_hz) {
  std::string text = "time_s,frequency_hz,re,im\n";
  for (const TransferAtTime& step : result.steps)
    text += to_text(step.time_s) + "," + to_text(frequency_hz) + "," + to_text(step.pressure.real()) + "," +
            to_text(step.pressure.imag()) + "\n";
  return text;
}

}  // namespace klang::bubble
