#include "core/sound/liquid_scene/liquid_transfer.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "core/foundation/base/check.hpp"
#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/physics/bubble/bubble_physics.hpp"
#include "core/sound/dual_domain/reciprocal.hpp"
#include "core/sound/dual_domain/tank_modes.hpp"
#include "core/sound/dual_domain/transfer_series.hpp"
#include "core/sound/liquid_scene/detail/cell_ear.hpp"
#include "core/sound/liquid_scene/thick_part.hpp"

namespace klang::liquid_scene {
namespace {

using bubble::LiquidBoundary;
using Complex = std::complex<double>;
using Eigen::Index;
using Eigen::Vector3d;
using entrainment::BubblePath;
using Row = bubble::TransferSeries::Row;

constexpr double kLowestBin_hz = 20.0, kEarStep_s = 0.04, kHalfSpaceStep_s = 0.004;
constexpr int kAirVertices = 500, kFluidSources = 40, kAirSources = 60, kMostSamples = 8000;
constexpr std::int64_t kSolvesPerCheck = 64;
constexpr int kChecksPerAir = 2, kFirstChecks = 8;

/// Share and the later sample of a time.
std::pair<std::size_t, double> between(const std::vector<double>& times, double time_s) {
  const auto after = static_cast<std::size_t>(std::upper_bound(times.begin(), times.end(), time_s) - times.begin());
  if (after == 0) return {0, 0.0};
  if (after == times.size()) return {times.size() - 1, 0.0};
  return {after - 1, (time_s - times[after - 1]) / (times[after] - times[after - 1])};
}

double bin_hz(int bin, int per_octave) { return kLowestBin_hz * std::exp2(static_cast<double>(bin) / per_octave); }
int bin_below(double frequency_hz, int per_octave) {
  return static_cast<int>(std::floor(per_octave * std::log2(frequency_hz / kLowestBin_hz)));
}

/// All that one call needs.
class TransferFinder {
 public:
  TransferFinder(const liquid::LiquidFrames* frames, const std::vector<BubblePath>& paths, const LiquidScene& scene,
                 std::uint64_t seed, Monitor& monitor, TransferKeep keep);
  LiquidTransfer find();

 private:
  std::vector<std::size_t> alive_in(std::size_t k) const;
  void frame(std::size_t k);
  void solve_frames();
  std::size_t go_on();
  TransferCheckpoint checkpoint(std::size_t next_frame) const;
  bool by_cells(std::size_t k, std::vector<std::size_t> alive);
  std::map<int, std::vector<std::size_t>> bins_of(double time_s, const std::vector<std::size_t>& alive) const;
  std::optional<LiquidBoundary> boundary_of(const bubble::BoundaryMesh& mesh);
  void look_around(const LiquidBoundary& boundary, double time_s);
  void make_air(std::size_t k, const LiquidBoundary& boundary);
  void reciprocal(std::size_t k, const LiquidBoundary& boundary, const std::vector<std::size_t>& alive);
  void forward(const LiquidBoundary& boundary, double time_s, const std::vector<std::size_t>& alive);
  Row half_space(std::size_t i, double time_s, double frequency_hz) const;
  void half_space(std::size_t i);
  void check_cells(std::size_t k, const LiquidBoundary& boundary, const std::vector<std::size_t>& alive);
  double error(const LiquidBoundary& boundary, const bubble::EarField& both, Complex found, std::size_t i,
               double time_s) const;
  bool in_body(const LiquidBoundary& boundary, std::size_t i, double time_s) const;
  bubble::SwingingBubble swinging(std::size_t i, double time_s) const {
    return {place_at(paths_[i], time_s), heard_[i]->radius_m};
  }

  const liquid::LiquidFrames* frames_;
  const std::vector<BubblePath>& paths_;
  const LiquidScene& scene_;
  const std::uint64_t seed_;
  Monitor& monitor_;
  TransferKeep keep_;
  std::vector<std::optional<HeardBubble>> heard_;
  bubble::ReciprocalOptions options_;
  std::optional<bubble::EarElements> elements_;
  Vector3d ear_m_ = Vector3d::Zero();
  std::map<int, Eigen::MatrixXcd> ear_of_bin_;
  std::optional<CellEar> cells_;          ///< none: the surface is not one for cells
  std::optional<std::size_t> air_frame_;  ///< from whose surface the air's elements are
  LiquidTransfer result_;
};

TransferFinder::TransferFinder(const liquid::LiquidFrames* frames, const std::vector<BubblePath>& paths,
                               const LiquidScene& scene, std::uint64_t seed, Monitor& monitor, TransferKeep keep)
    : frames_(frames), paths_(paths), scene_(scene), seed_(seed), monitor_(monitor), keep_(std::move(keep)) {
  for (const BubblePath& path : paths) heard_.push_back(heard(path, scene.sound));
  options_.pass.liquid = {scene.sound.medium.liquid_density_kg_m3, scene.sound.medium.liquid_sound_speed_m_s};
  options_.pass.air = {scene.sound.air_density_kg_m3, scene.sound.air_sound_speed_m_s};
  options_.pass.liquid_loss_factor = scene.transfer.liquid_loss_factor;
  options_.pass.wall_admittance = scene.transfer.wall_admittance;
  options_.pass.most_samples = kMostSamples;
  options_.air_vertices = kAirVertices;
  options_.estimate_air = false;
  result_.rows.resize(paths.size());
}

bool TransferFinder::in_body(const LiquidBoundary& boundary, std::size_t i, double time_s) const {
  const Vector3d x = place_at(paths_[i], time_s);
  return boundary.inside_liquid(x) && boundary.distance_m(x) > 0.1 * heard_[i]->radius_m;
}

/// Of a pressure that was found: against waves about the centre on all samples with what their dual-weighted residual corrects.
double TransferFinder::error(const LiquidBoundary& boundary, const bubble::EarField& both, Complex found, std::size_t i,
                             double time_s) const {
  const bubble::SourcePoints points = bubble::random_source_points(boundary, kFluidSources, 1, seed_);
  // Between the samples that a solve takes its functions are free: it is held against one that takes all of them.
  bubble::ReciprocalOptions all = options_;
  all.pass.most_samples = 0;
  const bubble::EarInLiquid whole = bubble::ear_in_liquid(boundary, both, points, all, monitor_);
  return bubble::error_estimate(found,
                                bubble::checked_transfer(boundary, both, whole, points, swinging(i, time_s), all)[0]);
}

std::map<int, std::vector<std::size_t>> TransferFinder::bins_of(double time_s,
                                                                const std::vector<std::size_t>& alive) const {
  std::map<int, std::vector<std::size_t>> of_bin;
  for (const std::size_t i : alive) {
    const int below = bin_below(pitch_at(paths_[i], time_s), scene_.transfer.bins_per_octave);
    of_bin[below].push_back(i);
    of_bin[below + 1].push_back(i);
  }
  return of_bin;
}

std::optional<LiquidBoundary> TransferFinder::boundary_of(const bubble::BoundaryMesh& mesh) {
  try {
    return LiquidBoundary(mesh);
  } catch (
      const InputError& error) {  // one frame of a splash that cannot be meshed is no reason to lose all the others
    if (result_.n_bad_frames++ == 0) result_.bad_frame = error.what();
    return std::nullopt;
  }
}

void TransferFinder::look_around(const LiquidBoundary& boundary, double time_s) {
  if (boundary.inside_air_boundary(scene_.sound.listener.centre_m(time_s)))
    throw InputError("listener", "is in the liquid at " + to_text(time_s) + " s");
  if (result_.n_solves == 0 && result_.modes_hz.empty())
    for (const auto& mode : bubble::tank_modes(boundary, options_.pass.liquid.sound_speed_m_s, 0.0, 2e4))
      result_.modes_hz.push_back(mode.frequency_hz);
}

/// Some bubbles of a frame in which the air is new.
void TransferFinder::check_cells(std::size_t k, const LiquidBoundary& boundary, const std::vector<std::size_t>& alive) {
  const double time = frames_->time_s()[k];
  const ThickPart thick(*frames_, k, boundary);
  options_.pass.sample_counts = thick.sample_counts();
  const std::size_t first = 7919 * result_.errors.size();  // any of them, no two runs of neighbours
  int n_checked = 0;
  for (std::size_t n = 0; n < alive.size(); ++n) {
    const std::size_t i = alive[(first + n) % alive.size()];
    if (!in_body(boundary, i, time) || (thick.is_body() && !thick.holds(place_at(paths_[i], time)))) continue;
    monitor_.throw_if_stopped();
    const double pitch = pitch_at(paths_[i], time);
    if (const auto found = cells_->error(i, swinging(i, time), boundary, k)) {
      result_.errors.push_back({pitch, found->all(), found->bins, found->air, found->cells, found->age});
    } else {
      result_.errors.push_back(
          {pitch, error(boundary, cells_->air_field(i, boundary), cells_->pressure(i, swinging(i, time)), i, time)});
    }
    if (++n_checked == (result_.n_airs == 1 ? kFirstChecks : kChecksPerAir)) return;
  }
}

bool TransferFinder::by_cells(std::size_t k, std::vector<std::size_t> alive) {
  const double time = frames_->time_s()[k];
  std::optional<LiquidBoundary> made;
  if (cells_->due(time)) {
    const liquid::LiquidSurface whole = frames_->boundary(k);
    bubble::BoundaryMesh mesh = main_body(whole, frames_->cell_m());
    made = boundary_of(mesh);
    if (!made) return true;
    look_around(*made, time);
    const CellBody body{{std::move(mesh.surface), std::move(mesh.region)}, has_solids(whole)};
    if (!cells_->renew(*made, body, scene_.sound.listener.centre_m(time), time)) {
      cells_.reset();
      air_frame_.reset();
      return false;
    }
    air_frame_ = k;
    ++result_.n_airs;
  }
  cells_->enter(k);
  std::erase_if(alive, [&](std::size_t i) {
    const Vector3d x = place_at(paths_[i], time);
    return !cells_->holds(x) || !(frames_->phi_m(k, x) < -0.1 * heard_[i]->radius_m);
  });
  std::map<std::size_t, double> pitches;
  for (const std::size_t i : alive) pitches[i] = pitch_at(paths_[i], time);
  cells_->solve(pitches);
  result_.n_solves += static_cast<std::int64_t>(alive.size());
  for (const auto& [i, pitch] : pitches) result_.n_iterations += cells_->iterations(i);
  for (const auto& [i, pitch] : pitches) {
    if (cells_->converged(i)) {
      result_.rows[i].push_back({time, pitch, cells_->pressure(i, swinging(i, time))});
    } else {  // no reason to lose all the others
      result_.rows[i].push_back(half_space(i, time, pitch));
      ++result_.n_not_converged;
    }
  }
  if (made) check_cells(k, *made, alive);
  return true;
}

void TransferFinder::make_air(std::size_t k, const LiquidBoundary& boundary) {
  elements_.emplace(boundary, kAirVertices);
  air_frame_ = k;
  ear_m_ = scene_.sound.listener.centre_m(frames_->time_s()[k]);
  ear_of_bin_.clear();
}

void TransferFinder::reciprocal(std::size_t k, const LiquidBoundary& boundary, const std::vector<std::size_t>& alive) {
  const int per_octave = scene_.transfer.bins_per_octave;
  const double time_s = frames_->time_s()[k];
  if (!air_frame_ || time_s - frames_->time_s()[*air_frame_] >= kEarStep_s * (1.0 - 1e-9)) {
    make_air(k, boundary);
    ++result_.n_airs;
  }
  const bubble::EarElements::Carrier carried = elements_->carrier(boundary);
  const bubble::SourcePoints points = bubble::random_source_points(boundary, kFluidSources, 1, seed_);
  for (const auto& [bin, bubbles] : bins_of(time_s, alive)) {
    monitor_.throw_if_stopped();
    const double frequency = bin_hz(bin, per_octave);
    Eigen::MatrixXcd& q = ear_of_bin_[bin];
    if (q.size() == 0) q = elements_->field(frequency, {ear_m_}, options_.pass.air, monitor_);
    bubble::EarField air;
    air.frequency_hz = frequency;
    air.q = carried(q);
    const bubble::EarInLiquid liquid = bubble::ear_in_liquid(boundary, air, points, options_, monitor_);
    for (const std::size_t i : bubbles)
      result_.rows[i].push_back({time_s, frequency, liquid.pressure(swinging(i, time_s), 0)});
    if (result_.n_solves++ % kSolvesPerCheck != 0) continue;
    const bubble::EarElements coarse(boundary, std::max(elements_->n_elements() / 8, 22));
    air.q_coarse = coarse.carrier(boundary)(coarse.field(frequency, {ear_m_}, options_.pass.air, monitor_));
    result_.errors.push_back({frequency, error(boundary, air, liquid.pressure(swinging(bubbles.front(), time_s), 0),
                                               bubbles.front(), time_s)});
  }
}

void TransferFinder::forward(const LiquidBoundary& boundary, double time_s, const std::vector<std::size_t>& alive) {
  const bubble::SourcePoints points = bubble::random_source_points(boundary, kFluidSources, kAirSources, seed_);
  const Vector3d ear = scene_.sound.listener.centre_m(time_s);
  for (const std::size_t i : alive) {
    monitor_.throw_if_stopped();
    const double frequency = pitch_at(paths_[i], time_s);
    const bubble::SwingingBubble one = swinging(i, time_s);
    const bubble::DualDomainResult solved =
        bubble::solve_dual_domain(boundary, frequency, points, {one}, options_.pass, monitor_)[0];
    if (!solved.usable()) throw NumericalError("transfer: " + solved.message);
    const Complex pressure = bubble::air_pressure(solved, ear);
    result_.rows[i].push_back({time_s, frequency, pressure});
    if (result_.n_solves++ % kSolvesPerCheck != 0) continue;
    bubble::ReciprocalOptions both = options_;
    both.estimate_air = true;
    const bubble::ReciprocalTransfer reference =
        bubble::reciprocal_transfer(boundary, frequency, points, {{one}, {ear}}, both, monitor_)[0][0];
    result_.errors.push_back({frequency, bubble::error_estimate(pressure, reference)});
  }
}

Row TransferFinder::half_space(std::size_t i, double time_s, double frequency_hz) const {
  const BubblePath& path = paths_[i];
  const auto [sample, share] = between(path.time_s, time_s);
  double phi = path.phi_m[sample];
  if (share > 0.0) phi += share * (path.phi_m[sample + 1] - phi);
  const double depth = std::isfinite(phi) ? std::max(0.0, -phi) : 0.0;
  Vector3d place = place_at(path, time_s), ear = scene_.sound.listener.centre_m(time_s);
  ear.z() = std::max(ear.z() - (place.z() + depth), 1e-3);  // over the surface above the bubble
  place.z() = -depth;
  const double omega = 2.0 * kPi * frequency_hz, way_m = std::hypot(ear.x() - place.x(), ear.y() - place.y(), ear.z());
  // With the phase of its way through the air, as rows by cells have it: rows of one bubble are joined along straight lines.
  return {time_s, frequency_hz,
          stage::half_space_transfer(scene_.sound, heard_[i]->radius_m, place, ear, Complex(0.0, omega)) *
              std::polar(1.0, -omega / scene_.sound.air_sound_speed_m_s * way_m)};
}

void TransferFinder::half_space(std::size_t i) {
  const BubblePath& path = paths_[i];
  const HeardBubble& bubble = *heard_[i];
  const int per_octave = scene_.transfer.bins_per_octave;
  const double end_s = std::min(bubble.faded_s, path.end_s());
  for (double time = bubble.birth_s;; time = std::min(time + kHalfSpaceStep_s, end_s)) {
    const int below = bin_below(pitch_at(path, time), per_octave);
    for (const int bin : {below, below + 1}) result_.rows[i].push_back(half_space(i, time, bin_hz(bin, per_octave)));
    if (!(time < end_s)) break;
  }
}

std::vector<std::size_t> TransferFinder::alive_in(std::size_t k) const {
  const std::span<const double> times = frames_->time_s();
  const double time = times[k], step = times.size() > 1 ? times[1] - times[0] : 0.0;
  std::vector<std::size_t> alive;
  for (std::size_t i = 0; i < paths_.size(); ++i)
    if (heard_[i] && time > heard_[i]->birth_s - step && time < heard_[i]->quiet_s + step) alive.push_back(i);
  return alive;
}

void TransferFinder::frame(std::size_t k) {
  const double time = frames_->time_s()[k];
  std::vector<std::size_t> alive = alive_in(k);
  if (alive.empty()) return;
  if (cells_ && by_cells(k, alive)) return;
  const std::optional<LiquidBoundary> made = boundary_of(main_body(frames_->boundary(k), frames_->cell_m()));
  if (!made) return;
  const LiquidBoundary& boundary = *made;
  const ThickPart thick(*frames_, k, boundary);
  options_.pass.sample_counts = thick.sample_counts();
  std::erase_if(alive, [&](std::size_t i) {
    return !in_body(boundary, i, time) || (thick.is_body() && !thick.holds(place_at(paths_[i], time)));
  });
  if (alive.empty()) return;
  look_around(boundary, time);
  if (scene_.transfer.method == TransferMethod::kForward) {
    forward(boundary, time, alive);
  } else {
    reciprocal(k, boundary, alive);
  }
}

TransferCheckpoint TransferFinder::checkpoint(std::size_t next_frame) const {
  TransferCheckpoint now;
  now.next_frame = next_frame;
  now.found = result_;
  now.by_cells = cells_.has_value();
  now.air_frame = air_frame_;
  if (cells_ && air_frame_) now.cells = cells_->state();
  return now;
}

/// @return the frame to begin with
std::size_t TransferFinder::go_on() {
  if (!keep_.from) return 0;
  TransferCheckpoint from = std::move(*keep_.from);
  KLANG_CHECK(from.found.rows.size() == paths_.size(), "a checkpoint of these bubbles");
  result_ = std::move(from.found);
  if (!from.by_cells) cells_.reset();
  if (!from.air_frame) return from.next_frame;
  const std::size_t k = *from.air_frame;
  const liquid::LiquidSurface surface = frames_->boundary(k);
  bubble::BoundaryMesh mesh = main_body(surface, frames_->cell_m());
  const LiquidBoundary boundary(mesh);
  if (cells_) {
    const CellBody body{{std::move(mesh.surface), std::move(mesh.region)}, has_solids(surface)};
    const bool whole =
        cells_->restore(std::move(from.cells), boundary, body, scene_.sound.listener.centre_m(frames_->time_s()[k]));
    KLANG_CHECK(whole, "a surface that had cells has them again");
  } else {
    make_air(k, boundary);
  }
  air_frame_ = k;
  return from.next_frame;
}

void TransferFinder::solve_frames() {
  if (scene_.transfer.method == TransferMethod::kReciprocal)
    cells_.emplace(*frames_, options_, scene_.transfer.bins_per_octave, monitor_);
  const std::size_t n = frames_->time_s().size();
  std::vector<std::size_t> work(n + 1, 0);  // bubbles in all frames before
  for (std::size_t k = 0; k < n; ++k) work[k + 1] = work[k] + alive_in(k).size();
  for (std::size_t k = go_on(); k < n; ++k) {
    monitor_.throw_if_stopped();
    monitor_.progress("transfer, " + std::to_string(result_.n_solves) + " solves of about " + std::to_string(work[n]),
                      static_cast<double>(work[k]) / static_cast<double>(std::max<std::size_t>(work[n], 1)));
    frame(k);
    if (keep_.due()) keep_.keep(checkpoint(k + 1));
  }
}

LiquidTransfer TransferFinder::find() {
  const bool solved =
      scene_.transfer.method == TransferMethod::kReciprocal || scene_.transfer.method == TransferMethod::kForward;
  if (solved) {
    KLANG_CHECK(frames_ != nullptr, "the transfer needs frames");
    solve_frames();
  }
  for (std::size_t i = 0; i < paths_.size(); ++i) {
    if (!heard_[i] || !result_.rows[i].empty() || scene_.transfer.method == TransferMethod::kUnit) continue;
    half_space(i);
    if (solved) ++result_.n_half_space;
  }
  return std::move(result_);
}

}  // namespace

std::optional<HeardBubble> heard(const BubblePath& path, const stage::BubbleScene& sound) {
  if (path.phi_m.front() >= 0.0) return std::nullopt;
  try {
    HeardBubble bubble{path.id, bubble::bubble_radius_m(path.frequency_hz.front(), sound.medium, sound.theory),
                       path.birth_s(), 0.0, 0.0};
    const double decay_per_s = bubble::bubble_oscillation(bubble.radius_m, sound.medium, sound.theory).decay_per_s;
    bubble.quiet_s = bubble.birth_s + std::log(100.0) / decay_per_s;
    bubble.faded_s = bubble.birth_s + std::log(1000.0) / decay_per_s;
    return bubble;
  } catch (const InputError&) {
    return std::nullopt;
  }
}

double pitch_at(const BubblePath& path, double time_s) {
  const auto [sample, share] = between(path.time_s, time_s);
  const double here = path.frequency_hz[sample];
  return share == 0.0 ? here : here + share * (path.frequency_hz[sample + 1] - here);
}

Vector3d place_at(const BubblePath& path, double time_s) {
  const auto [sample, share] = between(path.time_s, time_s);
  const Vector3d here = path.position_m[sample];
  return share == 0.0 ? here : Vector3d(here + share * (path.position_m[sample + 1] - here));
}

bubble::BoundaryMesh main_body(const liquid::LiquidSurface& surface, double cell_m) {
  const mesh::IndexRows& triangles = surface.surface.triangles;
  const mesh::Points& x = surface.surface.vertices_m;
  std::vector<int> root(static_cast<std::size_t>(x.rows()));
  std::iota(root.begin(), root.end(), 0);
  const auto find = [&](int v) {
    while (root[static_cast<std::size_t>(v)] != v)
      v = root[static_cast<std::size_t>(v)] = root[static_cast<std::size_t>(root[static_cast<std::size_t>(v)])];
    return v;
  };
  for (Index t = 0; t < triangles.rows(); ++t)
    for (int c = 1; c < 3; ++c) root[static_cast<std::size_t>(find(triangles(t, c)))] = find(triangles(t, 0));
  std::map<int, double> volume;  // of the liquid; 0: a dry solid alone
  for (Index t = 0; t < triangles.rows(); ++t) {
    const Vector3d a = x.row(triangles(t, 0)), b = x.row(triangles(t, 1)), c = x.row(triangles(t, 2));
    volume[find(triangles(t, 0))] += surface.region[static_cast<std::size_t>(t)] == 3 ? 0.0 : a.dot(b.cross(c)) / 6.0;
  }
  const auto main =
      std::max_element(volume.begin(), volume.end(), [](const auto& a, const auto& b) { return a.second < b.second; });
  const double least = 27.0 * cell_m * cell_m * cell_m;
  bubble::BoundaryMesh body;
  body.name = "liquid";
  body.surface.vertices_m = x;
  std::vector<Index> kept;
  for (Index t = 0; t < triangles.rows(); ++t) {
    const int part = find(triangles(t, 0));
    if (part == main->first || volume[part] == 0.0 || volume[part] < -least) kept.push_back(t);
  }
  body.surface.triangles.resize(static_cast<Index>(kept.size()), 3);
  for (std::size_t i = 0; i < kept.size(); ++i) {
    body.surface.triangles.row(static_cast<Index>(i)) = triangles.row(kept[i]);
    body.region.push_back(surface.region[static_cast<std::size_t>(kept[i])]);
  }
  return body;
}

LiquidTransfer find_transfer(const liquid::LiquidFrames* frames, const std::vector<BubblePath>& paths,
                             const LiquidScene& scene, std::uint64_t seed, Monitor& monitor, TransferKeep keep) {
  return TransferFinder(frames, paths, scene, seed, monitor, std::move(keep)).find();
}

}  // namespace klang::liquid_scene
