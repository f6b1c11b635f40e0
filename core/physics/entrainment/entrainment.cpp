#include "core/physics/entrainment/entrainment.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/parallel.hpp"
#include "core/foundation/config/fields_csv.hpp"
#include "core/physics/bubble/bubble_physics.hpp"

namespace klang::entrainment {
namespace {

using Eigen::Index;
using Eigen::Vector3d;

constexpr double kSeedsPerCellFace = 16.0;  // 8 particles per voxel in a layer of two
constexpr double kPaperRadius = 0.22;       // of a particle, in cells (section B)
constexpr std::uint64_t kAttemptStream = 0x617474656d707473ULL, kPatchStream = 0x7061746368ULL;

/// The whole part and, by chance, one more.
std::size_t chance_rounded(double mean, RandomStream& random) {
  const double whole = std::floor(mean);
  return static_cast<std::size_t>(whole) + (random.uniform() < mean - whole ? 1 : 0);
}

struct LiveSeed {
  Vector3d position_m, velocity_m_s;
  double start_s;
  std::array<std::int64_t, 4> patch;  ///< h by h of the surface, by the axis that it faces
};

/// The patch of the surface that a place below it belongs to.
std::array<std::int64_t, 4> patch_of(const liquid::LiquidFrames& frames, double time_s, const Vector3d& x) {
  const double h = frames.cell_m();
  Vector3d out;
  for (int axis = 0; axis < 3; ++axis) {
    const Vector3d d = 0.5 * h * Vector3d::Unit(axis);
    out[axis] = liquid::phi_m(frames, time_s, x + d) - liquid::phi_m(frames, time_s, x - d);
  }
  Index facing = 2;
  if (out.norm() > 0.0) out.cwiseAbs().maxCoeff(&facing);
  const Vector3d on =
      x - liquid::phi_m(frames, time_s, x) * (out.norm() > 0.0 ? Vector3d(out.normalized()) : Vector3d::Zero());
  std::array<std::int64_t, 4> patch{facing, 0, 0, 0};
  for (Index axis = 0; axis < 3; ++axis)  // across the surface it is enough to tell sheets apart
    patch[static_cast<std::size_t>(axis) + 1] =
        static_cast<std::int64_t>(axis == facing ? std::round(on[axis] / (8.0 * h)) : std::floor(on[axis] / h));
  return patch;
}

/// A polygon cut to a box.
std::vector<Vector3d> clipped(std::vector<Vector3d> polygon, const Patch& box) {
  for (int axis = 0; axis < 3; ++axis)
    for (const double sign : {1.0, -1.0}) {
      const double limit = sign > 0.0 ? box.high_m[axis] : -box.low_m[axis];
      std::vector<Vector3d> kept;
      for (std::size_t i = 0; i < polygon.size(); ++i) {
        const Vector3d &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
        const double da = sign * a[axis] - limit, db = sign * b[axis] - limit;
        if (da <= 0.0) kept.push_back(a);
        if ((da < 0.0 && db > 0.0) || (da > 0.0 && db < 0.0)) kept.push_back(a + da / (da - db) * (b - a));
      }
      polygon = std::move(kept);
    }
  return polygon;
}

/// Triangles of the free surface within a box, with the sum of areas so far.
struct SurfacePart {
  struct Piece {
    Vector3d a, b, c;
    double area_to_here_m2;
  };
  std::vector<Piece> pieces;
  double area_m2() const { return pieces.empty() ? 0.0 : pieces.back().area_to_here_m2; }
};

SurfacePart free_part(const liquid::LiquidSurface& boundary, const Patch& box) {
  SurfacePart part;
  double area = 0.0;
  for (Index t = 0; t < boundary.surface.triangles.rows(); ++t) {
    if (boundary.region[static_cast<std::size_t>(t)] != 0) continue;
    std::vector<Vector3d> corners;
    for (int c = 0; c < 3; ++c)
      corners.emplace_back(boundary.surface.vertices_m.row(boundary.surface.triangles(t, c)).transpose());
    const std::vector<Vector3d> polygon = clipped(corners, box);
    for (std::size_t i = 2; i < polygon.size(); ++i) {
      const double piece = 0.5 * (polygon[i - 1] - polygon[0]).cross(polygon[i] - polygon[0]).norm();
      if (!(piece > 0.0)) continue;
      area += piece;
      part.pieces.push_back({polygon[0], polygon[i - 1], polygon[i], area});
    }
  }
  return part;
}

class BirthFinder {
 public:
  BirthFinder(const liquid::LiquidFrames& frames, const EntrainmentOptions& options, std::uint64_t seed)
      : frames_(frames), options_(options), seed_(seed), h_(frames.cell_m()) {}
  Births find(Monitor& monitor);

 private:
  void add_seeds(const std::vector<liquid::SeedEvent>& events);
  void move_seeds(double from_s, double to_s);
  void end_seeds(double to_s);
  void attempt(std::size_t frame, double from_s, double to_s);
  void patch_births(std::size_t frame, double from_s, double to_s);
  bool covered(const Vector3d& x, double radius_m, double time_s) const;
  double strength(const LiveSeed& seed, double time_s) const {
    return seed_strength((time_s - seed.start_s) / options_.seeds.life_s);
  }

  const liquid::LiquidFrames& frames_;
  const EntrainmentOptions& options_;
  const std::uint64_t seed_;
  const double h_;
  std::vector<LiveSeed> seeds_;
  Births result_;
};

void BirthFinder::add_seeds(const std::vector<liquid::SeedEvent>& events) {
  std::map<std::array<std::int64_t, 4>, int> count;
  for (const LiveSeed& s : seeds_) ++count[s.patch];
  for (const liquid::SeedEvent& e : events) {
    const std::array<std::int64_t, 4> patch = patch_of(frames_, e.time_s, e.position_m);
    int& here = count[patch];
    if (here >= static_cast<int>(kSeedsPerCellFace)) continue;
    ++here;
    ++result_.n_seeds;
    seeds_.push_back({e.position_m, e.velocity_m_s, e.time_s, patch});
  }
}

void BirthFinder::move_seeds(double from_s, double to_s) {
  parallel_for(seeds_.size(), 256, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      LiveSeed& s = seeds_[i];
      const double step = to_s - std::max(from_s, s.start_s);
      if (!(step > 0.0)) continue;
      const Vector3d half = s.position_m + 0.5 * step * s.velocity_m_s;
      const auto u = liquid::velocity_m_s(frames_, to_s - 0.5 * step, half).value_or(s.velocity_m_s);
      s.position_m += step * u;
      s.velocity_m_s = u;
    }
  });
}

void BirthFinder::end_seeds(double to_s) {
  std::erase_if(seeds_, [&](const LiveSeed& s) {
    return to_s - s.start_s >= options_.seeds.life_s * (1.0 - 1e-9) ||
           !(liquid::phi_m(frames_, to_s, s.position_m) < 0.0);
  });
}

bool BirthFinder::covered(const Vector3d& x, double radius_m, double time_s) const {
  if (options_.coverage == 0.0) return true;
  const bool paper = options_.form == EntrainmentForm::kPaper;
  const double reach = paper ? radius_m : std::max(radius_m, 1.5 * h_);
  double sum = 0.0;
  for (const LiveSeed& s : seeds_)
    if ((s.position_m - x).squaredNorm() <= reach * reach) sum += strength(s, time_s);
  if (paper) {
    const double printed = 2.43 * options_.coverage;  // tau_rej
    return kPaperRadius * kPaperRadius * h_ * h_ * sum >= printed * radius_m * radius_m;
  }
  return sum * h_ * h_ / kSeedsPerCellFace >= options_.coverage * kPi * reach * reach;
}

void BirthFinder::attempt(std::size_t frame, double from_s, double to_s) {
  std::vector<double> sums;
  double sum = 0.0;
  const double middle = 0.5 * (from_s + to_s);
  for (const LiveSeed& s : seeds_) sums.push_back(sum += strength(s, std::max(middle, s.start_s)));
  RandomStream random(seed_ ^ kAttemptStream, frame);
  const double mean = options_.attempts_per_m2_s * h_ * h_ / kSeedsPerCellFace * (to_s - from_s) * sum;
  for (std::size_t n = chance_rounded(mean, random); n > 0 && !seeds_.empty(); --n) {
    ++result_.n_attempts;
    const double at = random.uniform() * sums.back();
    const auto chosen = static_cast<std::size_t>(std::upper_bound(sums.begin(), sums.end(), at) - sums.begin());
    const LiveSeed seed = seeds_[std::min(chosen, seeds_.size() - 1)];
    const double time = random.uniform(from_s, to_s), radius = options_.radii.draw(random);
    if (!covered(seed.position_m, radius, middle)) {
      ++result_.n_rejected;
      continue;
    }
    // The seed stands where it is at the step's end.
    result_.births.push_back({radius, time, seed.position_m - (to_s - time) * seed.velocity_m_s, seed.velocity_m_s});
    if (!options_.consume) continue;
    std::erase_if(seeds_, [&](const LiveSeed& s) {
      return (s.position_m - seed.position_m).squaredNorm() <= 2.25 * radius * radius;
    });
    sums.clear();
    sum = 0.0;
    for (const LiveSeed& s : seeds_) sums.push_back(sum += strength(s, std::max(middle, s.start_s)));
  }
}

void BirthFinder::patch_births(std::size_t frame, double from_s, double to_s) {
  std::uint64_t number = 0;
  for (const Patch& patch : options_.patches) {
    ++number;
    const double from = std::max(from_s, patch.start_s), to = std::min(to_s, patch.end_s);
    if (!(to > from)) continue;
    const SurfacePart part = free_part(frames_.boundary(frame), patch);
    RandomStream random(seed_ ^ kPatchStream, number << 40 | frame);
    const double mean = 0.5 * options_.attempts_per_m2_s * part.area_m2() * (to - from);
    for (std::size_t n = chance_rounded(mean, random); n > 0 && !part.pieces.empty(); --n) {
      ++result_.n_attempts;
      const double at = random.uniform() * part.area_m2();
      const auto piece = std::upper_bound(part.pieces.begin(), part.pieces.end(), at,
                                          [](double a, const SurfacePart::Piece& p) { return a < p.area_to_here_m2; });
      const SurfacePart::Piece& on = piece == part.pieces.end() ? part.pieces.back() : *piece;
      double u = random.uniform(), w = random.uniform();
      if (u + w > 1.0) {
        u = 1.0 - u;
        w = 1.0 - w;
      }
      const Vector3d out = (on.b - on.a).cross(on.c - on.a).normalized();
      const Vector3d x = on.a + u * (on.b - on.a) + w * (on.c - on.a) - 2.0 * h_ * random.uniform() * out;
      const double time = random.uniform(from, to), radius = options_.radii.draw(random);
      result_.births.push_back({radius, time, x, liquid::velocity_m_s(frames_, time, x).value_or(Vector3d::Zero())});
    }
  }
}

Births BirthFinder::find(Monitor& monitor) {
  const std::span<const double> times = frames_.time_s();
  const std::vector<liquid::SeedEvent>* recorded = frames_.seeds();
  SeedFinder finder(frames_, options_.seeds, seed_);
  std::size_t next = 0;
  const bool seeded = options_.attempts_per_m2_s > 0.0;
  for (std::size_t frame = 0; frame + 1 < times.size(); ++frame) {
    monitor.throw_if_stopped();
    monitor.progress("bubbles", static_cast<double>(frame) / static_cast<double>(times.size()));
    const double from = times[frame], to = times[frame + 1];
    if (seeded) {
      std::vector<liquid::SeedEvent> events;
      if (recorded != nullptr) {
        for (; next < recorded->size() && (*recorded)[next].time_s <= to; ++next) events.push_back((*recorded)[next]);
      } else if (options_.seeds.life_s > 0.0) {
        events = finder.advance(frame);
      }
      move_seeds(from, to);
      attempt(frame, from, to);
      end_seeds(to);
      add_seeds(events);  // of this step's end
    }
    patch_births(frame, from, to);
  }
  std::stable_sort(result_.births.begin(), result_.births.end(),
                   [](const Birth& a, const Birth& b) { return a.time_s < b.time_s; });
  return std::move(result_);
}

}  // namespace

void EntrainmentOptions::validate() const {
  checked("entrainment", "attempts_per_m2_s", attempts_per_m2_s, 0.0, 1e12);
  checked("entrainment", "seed_life_s", seeds.life_s, 1e-4, 10.0);
  checked("entrainment", "window_s", seeds.window_s, 1e-4, 1.0);
  checked("entrainment", "threshold_m_s", seeds.threshold_m_s, -1e3, 0.0);
  checked("entrainment", "coverage", coverage, 0.0, 10.0);
  radii.validate();
}

Births find_births(const liquid::LiquidFrames& frames, const EntrainmentOptions& options, std::uint64_t seed,
                   Monitor& monitor) {
  options.validate();
  return BirthFinder(frames, options, seed).find(monitor);
}

std::vector<BubbleRow> bubble_rows(const std::vector<BubblePath>& paths, const bubble::BubbleMedium& medium,
                                   bubble::BubbleTheory theory, const bubble::PitchModel& pitch) {
  std::vector<BubbleRow> rows;
  for (const BubblePath& path : paths) {
    BubbleRow row;
    row.id = path.id;
    row.birth_s = path.birth_s();
    row.end_s = path.end_s();
    row.end_kind = path.end;
    row.radius_m = path.radius_m;
    row.x_m = path.position_m.front().x();
    row.y_m = path.position_m.front().y();
    row.z_m = path.position_m.front().z();
    row.depth_m = std::max(0.0, -path.phi_m.front());
    if (path.frequency_hz.empty()) {
      row.frequency_start_hz = bubble::bubble_oscillation(path.radius_m, medium, theory).undamped_frequency_hz;
      // The law holds below the surface.
      const double start = std::min(path.phi_m.front(), -1e-6), end = std::min(path.phi_m.back(), -1e-6);
      row.frequency_end_hz = row.frequency_start_hz * bubble::pitch_factor(pitch, path.radius_m, end, start);
    } else {
      row.frequency_start_hz = path.frequency_hz.front();
      row.frequency_end_hz = path.frequency_hz.back();
    }
    rows.push_back(row);
  }
  return rows;
}

std::string bubbles_csv(const std::vector<BubbleRow>& rows) { return csv_table(rows); }

}  // namespace klang::entrainment
