#include "core/sound/scene/scene_roughness.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/random.hpp"

namespace klang::scene {
namespace {

using Eigen::Vector3d;

constexpr double kSameStep = 1e-6;     // of a step
constexpr std::uint64_t kSeed = 0x52;  // roughness is of the bodies, not of a run

/// A lasting contact in one step, once for both bodies.
struct Touch {
  std::size_t row = 0;                  ///< of the log's impulses
  std::optional<std::size_t> opposite;  ///< the other body's row
  int a = 0, b = -1;
  double time_s = 0.0, duration_s = 0.0;
  Vector3d on_a_m, on_b_m;  ///< each in its frame, the floor's in the world
};

struct Surface {
  double roughness = 0.0;
  std::optional<RoughField> field;
  double mean(const Vector3d& from_m, const Vector3d& to_m) const {
    return field ? roughness * field->mean(from_m, to_m) : 0.0;
  }
};

/// Poses of each body, by time.
std::vector<std::vector<const events::Pose*>> poses_by_body(const events::EventLog& log) {
  std::vector<std::vector<const events::Pose*>> poses(log.bodies.size());
  for (const events::Pose& pose : log.poses) poses[static_cast<std::size_t>(pose.body)].push_back(&pose);
  return poses;
}

/// The pose at the end of the step that pushed the body: the first after the row.
Vector3d in_world(const std::vector<const events::Pose*>& poses, const events::Impulse& row) {
  const auto after = std::upper_bound(poses.begin(), poses.end(), row.time_s,
                                      [](double time, const events::Pose* pose) { return time < pose->time_s; });
  if (poses.empty()) return row.point_m;
  return (after == poses.end() ? poses.back() : *after)->to_world(row.point_m);
}

std::vector<Touch> touches_of(const events::EventLog& log) {
  const auto poses = poses_by_body(log);
  std::vector<Touch> touches;
  for (std::size_t i = 0; i < log.impulses.size(); ++i) {
    const events::Impulse& row = log.impulses[i];
    if (row.kind != events::ImpulseKind::kLasting || row.shape != events::PulseShape::kHeld) continue;
    Touch touch{i, {}, row.body, row.other, row.time_s, row.duration_s, row.point_m, row.point_m};
    if (row.other < 0) {
      touch.on_b_m = in_world(poses[static_cast<std::size_t>(row.body)], row);
    } else if (i + 1 < log.impulses.size() && log.impulses[i + 1].body == row.other &&
               log.impulses[i + 1].other == row.body && log.impulses[i + 1].time_s == row.time_s) {
      touch.opposite = i + 1;
      touch.on_b_m = log.impulses[i + 1].point_m;
      ++i;
    }
    touches.push_back(touch);
  }
  return touches;
}

/// Where each touch is a step later: of the same pair the nearest in both frames; itself where the contact ends.
std::vector<std::size_t> next_of(const std::vector<Touch>& touches) {
  std::map<std::pair<int, int>, std::vector<std::size_t>> by_pair;
  for (std::size_t i = 0; i < touches.size(); ++i) by_pair[{touches[i].a, touches[i].b}].push_back(i);
  std::vector<std::size_t> next(touches.size());
  for (const auto& [pair, rows] : by_pair) {
    std::size_t first = 0;
    for (const std::size_t i : rows) {
      const Touch& here = touches[i];
      const double later_s = here.time_s + here.duration_s, tolerance_s = kSameStep * here.duration_s;
      while (first < rows.size() && touches[rows[first]].time_s < later_s - tolerance_s) ++first;
      next[i] = i;
      double least = HUGE_VAL;
      for (std::size_t k = first; k < rows.size() && touches[rows[k]].time_s <= later_s + tolerance_s; ++k) {
        const Touch& there = touches[rows[k]];
        const double distance = (there.on_a_m - here.on_a_m).squaredNorm() + (there.on_b_m - here.on_b_m).squaredNorm();
        if (distance < least) least = distance, next[i] = rows[k];
      }
    }
  }
  return next;
}

/// Of each row of the log's bodies, by its name or that of what it broke off; the last is the floor's.
std::vector<Surface> surfaces_of(const Scene& scene, const events::EventLog& log) {
  std::vector<Surface> surfaces(log.bodies.size() + 1);
  const auto set = [](Surface& surface, const SceneMaterial& material, std::size_t row) {
    surface.roughness = material.roughness;
    if (material.roughness > 0.0) surface.field.emplace(material.roughness_length_m, row);
  };
  for (std::size_t row = 0; row < log.bodies.size(); ++row) {
    std::size_t root = row;
    while (log.bodies[root].parent >= 0) root = static_cast<std::size_t>(log.bodies[root].parent);
    for (const SceneBody& body : scene.bodies)
      if (body.name == log.bodies[root].name) set(surfaces[row], scene.material_of(body), root);
  }
  if (scene.floor_material)
    set(surfaces.back(), scene.materials[static_cast<std::size_t>(*scene.floor_material)], log.bodies.size());
  return surfaces;
}

}  // namespace

RoughField::RoughField(double length_m, std::uint64_t seed) {
  RandomStream random(kSeed, seed);
  for (int k = 0; k < kWaves; ++k) {
    for (int axis = 0; axis < 3; ++axis) wave_(k, axis) = random.normal() / length_m;
    phase_[k] = random.uniform(0.0, 2.0 * kPi);
  }
}

double RoughField::mean(const Vector3d& from_m, const Vector3d& to_m) const {
  const Vector3d middle = 0.5 * (from_m + to_m), half = 0.5 * (to_m - from_m);
  double sum = 0.0;
  for (int k = 0; k < kWaves; ++k) {
    const double angle = wave_.row(k).dot(half);
    sum += (angle == 0.0 ? 1.0 : std::sin(angle) / angle) * std::cos(wave_.row(k).dot(middle) + phase_[k]);
  }
  return std::sqrt(2.0 / kWaves) * sum;
}

events::EventLog with_roughness(const Scene& scene, const events::EventLog& log) {
  events::EventLog rough = log;
  const bool smooth = std::all_of(scene.materials.begin(), scene.materials.end(),
                                  [](const SceneMaterial& material) { return material.roughness == 0.0; });
  if (smooth) return rough;
  const std::vector<Surface> surfaces = surfaces_of(scene, log);
  const std::vector<Touch> touches = touches_of(log);
  const std::vector<std::size_t> next = next_of(touches);
  for (std::size_t i = 0; i < touches.size(); ++i) {
    const Touch &here = touches[i], &there = touches[next[i]];
    const Surface &a = surfaces[static_cast<std::size_t>(here.a)],
                  &b = here.b < 0 ? surfaces.back() : surfaces[static_cast<std::size_t>(here.b)];
    const double factor = std::max(0.0, 1.0 + a.mean(here.on_a_m, there.on_a_m) + b.mean(here.on_b_m, there.on_b_m));
    rough.impulses[here.row].impulse_n_s *= factor;
    if (here.opposite) rough.impulses[*here.opposite].impulse_n_s *= factor;
  }
  return rough;
}

}  // namespace klang::scene
