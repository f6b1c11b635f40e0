#include "core/physics/entrainment/seeds.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/foundation/base/parallel.hpp"
#include "core/foundation/base/random.hpp"

namespace klang::entrainment {
namespace {

using Eigen::Index;
using Eigen::Vector3d;

constexpr int kPerCell = 8;
constexpr double kLayerCells = 2.0;
constexpr std::uint64_t kFillStream = 0x6c61796572ULL;

Vector3d gradient(const liquid::LiquidFrames& frames, double time_s, const Vector3d& x, double h) {
  Vector3d g;
  for (int axis = 0; axis < 3; ++axis) {
    const Vector3d d = 0.5 * h * Vector3d::Unit(axis);
    g[axis] = (liquid::phi_m(frames, time_s, x + d) - liquid::phi_m(frames, time_s, x - d)) / h;
  }
  return g;
}

}  // namespace

double regression_slope(std::span<const double> times_s, std::span<const double> values) {
  const std::size_t n = std::min(times_s.size(), values.size());
  if (n < 2) return 0.0;
  double time = 0.0, value = 0.0;
  for (std::size_t i = 0; i < n; ++i) {
    time += times_s[i] / static_cast<double>(n);
    value += values[i] / static_cast<double>(n);
  }
  double across = 0.0, square = 0.0;
  for (std::size_t i = 0; i < n; ++i) {
    across += (times_s[i] - time) * (values[i] - value);
    square += (times_s[i] - time) * (times_s[i] - time);
  }
  return square > 0.0 ? across / square : 0.0;
}

double seed_strength(double tau) {
  if (!(tau >= 0.0 && tau < 1.0)) return 0.0;
  return tau < 0.5 ? 1.0 - 4.0 * tau * tau * tau : 4.0 * std::pow(1.0 - tau, 3);
}

SeedFinder::SeedFinder(const liquid::LiquidFrames& frames, const SeedOptions& options, std::uint64_t seed)
    : frames_(frames), options_(options), seed_(seed), cell_m_(frames.cell_m()) {}

std::uint64_t SeedFinder::cell_of(const Vector3d& x_m) const {
  std::uint64_t key = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const auto at = static_cast<std::int64_t>(std::floor(x_m[axis] / cell_m_)) + (1 << 20);
    key = key << 21 | (static_cast<std::uint64_t>(at) & ((1U << 21) - 1U));
  }
  key ^= key >> 31;
  return key * 0x9e3779b97f4a7c15ULL;  // places that follow each other are spread
}

void SeedFinder::fill_layer(const liquid::LiquidFrames& frames, std::size_t frame) {
  std::unordered_map<std::uint64_t, int> count;
  count.reserve(markers_.size() / 4);
  for (const Marker& marker : markers_) ++count[cell_of(marker.position_m)];
  const liquid::LiquidSurface boundary = frames.boundary(frame);
  const double time = frames.time_s()[frame];
  RandomStream random(seed_ ^ kFillStream, frame);
  double owed = 0.0;
  for (Index t = 0; t < boundary.surface.triangles.rows(); ++t) {
    if (boundary.region[static_cast<std::size_t>(t)] != 0) continue;
    const auto corner = [&](int c) {
      return Vector3d(boundary.surface.vertices_m.row(boundary.surface.triangles(t, c)).transpose());
    };
    const Vector3d a = corner(0), b = corner(1), c = corner(2), cross = (b - a).cross(c - a);
    if (!(cross.norm() > 0.0)) continue;
    owed += 0.5 * cross.norm() * kPerCell * kLayerCells / (cell_m_ * cell_m_);
    for (; owed >= 1.0; owed -= 1.0) {
      double u = random.uniform(), w = random.uniform();
      if (u + w > 1.0) {
        u = 1.0 - u;
        w = 1.0 - w;
      }
      const double depth = kLayerCells * cell_m_ * random.uniform();
      const Vector3d x = a + u * (b - a) + w * (c - a) - depth * cross.normalized();
      int& here = count[cell_of(x)];
      if (here >= kPerCell) continue;
      const double phi = frames.phi_m(frame, x);
      if (!(phi < 0.0 && phi > -kLayerCells * cell_m_)) continue;
      ++here;
      Marker marker;
      marker.id = next_id_++;
      marker.position_m = x;
      marker.velocity_m_s = frames.velocity_m_s(frame, x).value_or(Vector3d::Zero());
      marker.left_layer_s = time;
      marker.time_s = {time};
      marker.phi = {phi};
      markers_.push_back(std::move(marker));
    }
  }
}

void SeedFinder::move(const liquid::LiquidFrames& frames, Marker& marker, double from_s, double to_s) const {
  const auto n = static_cast<int>(std::ceil((to_s - from_s) / (0.25 * options_.window_s) - 1e-9));
  const double step = (to_s - from_s) / n;
  for (int i = 0; i < n; ++i) {
    const double time = from_s + i * step;
    const auto u = liquid::velocity_m_s(frames, time, marker.position_m).value_or(marker.velocity_m_s);
    const Vector3d half = marker.position_m + 0.5 * step * u;
    marker.velocity_m_s = liquid::velocity_m_s(frames, time + 0.5 * step, half).value_or(u);
    marker.position_m += step * marker.velocity_m_s;
    const double now = i + 1 == n ? to_s : time + step, phi = liquid::phi_m(frames, now, marker.position_m);
    marker.time_s.push_back(now);
    marker.phi.push_back(phi);
    if (phi > -kLayerCells * cell_m_) marker.left_layer_s = now;
  }
  const auto first = std::lower_bound(marker.time_s.begin(), marker.time_s.end(), to_s - options_.window_s - 1e-9);
  const auto n_old = first - marker.time_s.begin();
  marker.time_s.erase(marker.time_s.begin(), first);
  marker.phi.erase(marker.phi.begin(), marker.phi.begin() + n_old);
}

bool SeedFinder::falls(const liquid::LiquidFrames& frames, const Marker& marker, double time_s) const {
  const bool whole = time_s - marker.time_s.front() >= options_.window_s * (1.0 - 1e-6);
  if (!whole || time_s < marker.seed_until_s) return false;
  if (!(regression_slope(marker.time_s, marker.phi) < options_.threshold_m_s)) return false;
  if (options_.criterion == SeedCriterion::kSlope) return true;
  const Vector3d out = gradient(frames, time_s, marker.position_m, cell_m_);
  const Vector3d surface = marker.position_m - marker.phi.back() * out;
  const auto at_surface = liquid::velocity_m_s(frames, time_s, surface).value_or(Vector3d::Zero());
  return (marker.velocity_m_s - at_surface).dot(out) <= 0.5 * options_.threshold_m_s;
}

std::vector<liquid::SeedEvent> SeedFinder::advance(std::size_t frame) {
  const liquid::HeldFrames held(frames_, frame, frame + 1);
  fill_layer(*held, frame);
  const double from = frames_.time_s()[frame], to = frames_.time_s()[frame + 1];
  std::vector<char> seeds(markers_.size(), 0);
  parallel_for(markers_.size(), 256, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      move(*held, markers_[i], from, to);
      seeds[i] = markers_[i].phi.back() < 0.0 && falls(*held, markers_[i], to) ? 1 : 0;
    }
  });
  std::vector<liquid::SeedEvent> events;
  for (std::size_t i = 0; i < markers_.size(); ++i) {
    if (seeds[i] == 0) continue;
    Marker& m = markers_[i];
    m.seed_until_s = to + options_.life_s;
    events.push_back({to, m.id, m.position_m, m.velocity_m_s, regression_slope(m.time_s, m.phi)});
  }
  std::erase_if(markers_, [&](const Marker& m) {
    return !(m.phi.back() < 0.0) || to - m.left_layer_s > options_.window_s || frames_.in_outlet(m.position_m);
  });
  return events;
}

}  // namespace klang::entrainment
