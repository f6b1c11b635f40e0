#include "core/physics/modal/ellipsoid_solve.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/stopwatch.hpp"
#include "core/physics/modal/ellipsoid_modes.hpp"

namespace klang::modal {
namespace {

constexpr double kError = 1e-5, kUseful = 0.02;
constexpr int kFirstDegree = 10, kLastDegree = 24, kMostPerClass = 1000;

/// Modes asked for, ascending, and how many elastic ones lie below them.
struct Listed {
  std::vector<ModeId> ids;
  std::size_t n_below = 0, n_left_out = 0;
  bool complete = false;  ///< no class ran out before the list's end
};

Listed listed(const EllipsoidModes& modes, const EigenOptions& options) {
  const double low = 2.0 * kPi * options.band.low_hz, high = 2.0 * kPi * options.band.high_hz;
  std::vector<ModeId> all = modes.lowest(std::numeric_limits<int>::max());
  const auto omega = [&](const ModeId& id) { return modes.angular_frequency_rad_s(id); };
  Listed list;
  list.n_below =
      static_cast<std::size_t>(std::count_if(all.begin(), all.end(), [&](auto& id) { return omega(id) < low; }));
  const std::size_t n_from = all.size() - list.n_below;
  std::size_t n = static_cast<std::size_t>(options.count);
  if (options.count > 0) {
    list.complete = n_from >= n;
    n = std::min(n, n_from);
  } else {
    list.complete = !all.empty() && omega(all.back()) > high;
    const auto in_band = static_cast<std::size_t>(
        std::count_if(all.begin(), all.end(), [&](auto& id) { return omega(id) >= low && omega(id) <= high; }));
    n = options.most > 0 ? std::min(in_band, static_cast<std::size_t>(options.most)) : in_band;
    list.n_left_out = in_band - n;
  }
  const auto begin = all.begin() + static_cast<std::ptrdiff_t>(list.n_below);
  list.ids.assign(begin, begin + static_cast<std::ptrdiff_t>(n));
  return list;
}

struct Solved {
  EllipsoidModes modes;
  Listed list;
};

/// With as many modes per class as the list needs; it starts with per_class and leaves there what it took.
Solved solved(const Eigen::Vector3d& axes_m, const solid::Material& material, int degree, int& per_class,
              const EigenOptions& options) {
  for (;;) {
    EllipsoidModes modes(axes_m, material, {degree, per_class, true});
    Listed list = listed(modes, options);
    bool whole = true;  // all that the polynomials have
    for (int c = 0; c < kModeClasses; ++c) whole = whole && modes.angular_frequency_rad_s(c).size() < per_class;
    if (list.complete || whole || per_class >= kMostPerClass) return {std::move(modes), std::move(list)};
    per_class = std::min(2 * per_class, kMostPerClass);
  }
}

/// Twice what the rise of the degree took off; 1 where the mode was not there.
Eigen::VectorXd bounds(const EllipsoidModes& before, const Solved& after) {
  Eigen::VectorXd bound(static_cast<Eigen::Index>(after.list.ids.size()));
  for (Eigen::Index k = 0; k < bound.size(); ++k) {
    const ModeId& id = after.list.ids[static_cast<std::size_t>(k)];
    const bool was_there = id.index < before.angular_frequency_rad_s(id.mode_class).size();
    bound[k] =
        was_there
            ? 2.0 * std::abs(std::log(before.angular_frequency_rad_s(id) / after.modes.angular_frequency_rad_s(id)))
            : 1.0;
  }
  return bound;
}

ModalModel sampled(const EllipsoidModes& modes, const std::vector<ModeId>& ids, const mesh::TetMesh& mesh,
                   const solid::Material& material) {
  const auto n = static_cast<Eigen::Index>(ids.size());
  ModalModel model;
  model.mesh = mesh;
  model.material = material;
  model.angular_frequency_rad_s.resize(n);
  const Eigen::Matrix3Xd xi = modes.axes_m().cwiseInverse().asDiagonal() * mesh.nodes_m.transpose();
  for (Eigen::Index k = 0; k < n; ++k) {
    const ModeId& id = ids[static_cast<std::size_t>(k)];
    model.angular_frequency_rad_s[k] = modes.angular_frequency_rad_s(id);
  }
  model.shapes = modes.shapes_at(ids, xi);
  return model;
}

}  // namespace

std::optional<Eigen::Vector3d> ellipsoid_axes_m(const mesh::ShapeSpec& shape) {
  if (shape.kind == "ellipsoid")
    return Eigen::Vector3d(shape.dims.at("a_m"), shape.dims.at("b_m"), shape.dims.at("c_m"));
  if (shape.kind == "sphere") return Eigen::Vector3d::Constant(shape.dims.at("radius_m"));
  return std::nullopt;
}

EigenResult solve_ellipsoid_modes(const mesh::ShapeSpec& shape, const mesh::TetMesh& mesh,
                                  const solid::Material& material, const EigenOptions& options, Monitor& monitor) {
  options.validate();
  const Stopwatch total;
  const auto axes_m = ellipsoid_axes_m(shape);
  if (!axes_m) throw InputError("modes", "polynomials of a ball need an ellipsoid", shape.kind, "ellipsoid, sphere");
  int per_class = std::clamp(options.count / 6 + 4, 8, 100);
  EigenResult result;
  result.method_used = EigenMethod::kPolynomials;
  monitor.progress("modes", 0.0);
  Solved now = solved(*axes_m, material, kFirstDegree, per_class, options);
  Eigen::VectorXd bound;
  for (int degree = kFirstDegree + 2; degree <= kLastDegree; degree += 2) {
    monitor.throw_if_stopped();
    monitor.progress("modes", static_cast<double>(degree) / kLastDegree);
    const EllipsoidModes before = std::move(now.modes);
    now = solved(*axes_m, material, degree, per_class, options);
    bound = bounds(before, now);
    if (now.list.complete && (bound.size() == 0 || bound.maxCoeff() <= kError)) break;
  }
  if (bound.size() > 0 && !(bound.maxCoeff() <= kUseful)) now.list.complete = false;
  if (!now.list.complete) {
    result.status = EigenStatus::kNotConverged;
    result.message = "polynomials of degree " + std::to_string(kLastDegree) +
                     " do not give all modes asked for within 2 %: ask for fewer, or take tetrahedra";
    return result;
  }
  result.wall_time_s["iterate"] = total.seconds();
  result.n_rigid_modes = 6;
  result.n_below_band = static_cast<int>(now.list.n_below);
  result.n_left_out = static_cast<int>(now.list.n_left_out);
  if (options.prove_none_missing) result.none_missing = true;
  const Stopwatch watch;
  result.model = sampled(now.modes, now.list.ids, mesh, material);
  result.relative_residual.resize(result.model.n_modes());
  for (Eigen::Index k = 0; k < result.model.n_modes(); ++k) {
    const ModeId& id = now.list.ids[static_cast<std::size_t>(k)];
    result.relative_residual[k] = now.modes.relative_residual(id.mode_class)[id.index];
  }
  if (options.estimate_mesh_error) result.mesh_relative_error = bound;
  result.wall_time_s["sample"] = watch.seconds();
  result.status = EigenStatus::kConverged;
  result.wall_time_s["total"] = total.seconds();
  return result;
}

}  // namespace klang::modal
