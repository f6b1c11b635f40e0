#include "core/sound/transfer/radiate.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <mutex>
#include <span>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/packed.hpp"
#include "core/foundation/base/parallel.hpp"
#include "core/foundation/base/shared_jobs.hpp"
#include "core/foundation/base/stopwatch.hpp"
#include "core/foundation/config/fields.hpp"
#include "core/geometry/mesh/mirrored_surface.hpp"
#include "core/sound/transfer/modal_surface.hpp"

namespace klang::acoustics {
namespace {

/// Larger systems use all threads for one mode instead of one for each.
constexpr int kManyUnknowns = 4000;

/// Element sizes per factor of two: a mode's mesh has up to 2^(2/4) times the elements it needs, its time grows with their
/// square.
constexpr double kLevelsPerOctave = 4.0;

/// Equilateral triangles of this edge cover the area count times.
double edge_for_count(double area_m2, int count) { return std::sqrt(4.0 / std::sqrt(3.0) * area_m2 / count); }

struct Level {
  double edge_m = 0.0;
  std::vector<int> modes;
  RadiatingSurface elements;
};

std::string packed(const ModeTransfer& mode) {
  const Multipole& m = mode.multipole;
  Packer to;
  to.add(mode.mode).add(mode.frequency_hz).add_list(m.centre_m).add(m.wavenumber_per_m).add(m.order);
  to.add_list(m.coefficients_pa).add(mode.radiated_power_w).add(mode.decay_radiation_per_s);
  return to.add(mode.kept_power_fraction).add(mode.n_bem_elements).add(mode.residual).take();
}

ModeTransfer unpacked(std::string_view bytes) {
  Unpacker from(bytes);
  ModeTransfer mode;
  mode.mode = from.take<int>();
  mode.frequency_hz = from.take<double>();
  mode.multipole.centre_m = from.take_list<Eigen::Vector3d>();
  mode.multipole.wavenumber_per_m = from.take<double>();
  mode.multipole.order = from.take<int>();
  mode.multipole.coefficients_pa = from.take_list<Eigen::VectorXcd>();
  mode.radiated_power_w = from.take<double>();
  mode.decay_radiation_per_s = from.take<double>();
  mode.kept_power_fraction = from.take<double>();
  mode.n_bem_elements = from.take<int>();
  mode.residual = from.take<std::optional<double>>();
  return mode;
}

/// Two images of a body may differ by this share of the tolerance of its wall, a fortieth of the wall.
constexpr double kMirrorTolerance = 0.25;

/// Mirror planes of the body are planes of its elements, where they can be.
RadiatingSurface elements_of(const ModalSurface& surface, const mesh::MirrorPlanes& planes,
                             const mesh::CoarseningOptions& options) {
  const std::optional<mesh::MirroredSurface> mirrored = mesh::mirrored_coarsened(surface.triangles(), options, planes);
  return surface.settled(mirrored ? radiating_surface(*mirrored)
                                  : radiating_surface(mesh::checked_coarsened(surface.triangles(), options)));
}

class Radiation {
 public:
  Radiation(const modal::ModalModel& model, const RadiateOptions& options, Monitor& monitor,
            const std::function<void(const ModeTransfer&)>& done)
      : model_(model), options_(options), monitor_(monitor), done_(done) {}

  RadiateResult run(const std::vector<ModeTransfer>& known);

 private:
  std::vector<Level> levels(const ModalSurface& surface, const std::vector<bool>& is_known) const;
  std::vector<std::vector<int>> of_one_frequency(const std::vector<int>& modes) const;
  void solve_level(const Level& level, const ModalSurface& surface, const HelmholtzBem& solver);
  std::vector<ModeTransfer> solve_modes(std::span<const int> modes, bool alone, const ModalSurface& surface,
                                        const HelmholtzBem& solver, const ModalSurface::Carrier& carrier) const;

  const modal::ModalModel& model_;
  const RadiateOptions& options_;
  Monitor& monitor_;
  const std::function<void(const ModeTransfer&)>& done_;
  RadiateResult result_;
  mutable std::mutex device_mutex_;
  mutable std::string device_ = "processor", device_message_;
  std::size_t n_done_ = 0;
};

std::vector<Level> Radiation::levels(const ModalSurface& surface, const std::vector<bool>& is_known) const {
  const Eigen::VectorXd frequency_hz = model_.frequency_hz();
  const double coarsest = edge_for_count(surface.area_m2(), options_.min_elements);
  const double finest = edge_for_count(surface.area_m2(), options_.max_elements);
  std::map<int, Level> by_number;
  for (int mode = 0; mode < static_cast<int>(model_.n_modes()); ++mode) {
    if (is_known[mode]) continue;
    const double wanted =
        std::min(options_.medium.sound_speed_m_s / frequency_hz[mode] / options_.elements_per_wavelength,
                 surface.pattern_wavelength_m(mode) / options_.elements_per_pattern);
    const double edge_m = std::clamp(wanted, finest, std::max(coarsest, finest));
    const int number = static_cast<int>(std::ceil(kLevelsPerOctave * std::log2(coarsest / edge_m) - 1e-9));
    Level& level = by_number[std::max(number, 0)];
    level.edge_m = coarsest * std::exp2(-std::max(number, 0) / kLevelsPerOctave);
    level.modes.push_back(mode);
  }
  std::vector<Level> list;
  for (auto& [number, level] : by_number) list.push_back(std::move(level));
  return list;
}

/// Modes of one frequency share the matrix, a column each: bodies of revolution have most of theirs twice.
std::vector<ModeTransfer> Radiation::solve_modes(std::span<const int> modes, bool alone, const ModalSurface& surface,
                                                 const HelmholtzBem& solver,
                                                 const ModalSurface::Carrier& carrier) const {
  const RadiatingSurface& s = solver.surface();
  BemOptions options;
  options.medium = options_.medium;
  options.allow_coarse = options_.allow_coarse;
  options.n_blas_threads = s.n_vertices() < kManyUnknowns ? 1 : 0;
  options.alone = alone;
  options.device = options_.device;
  Eigen::MatrixXcd velocity(3 * s.n_triangles(), static_cast<Eigen::Index>(modes.size()));
  for (std::size_t c = 0; c < modes.size(); ++c)
    velocity.col(static_cast<Eigen::Index>(c)) =
        surface.corner_velocity_m_s(modes[c], carrier, s).cast<std::complex<double>>();
  const BemResult bem = solver.solve(model_.frequency_hz()[modes[0]], velocity, options);
  if (!bem.usable()) throw NumericalError("transfer: mode " + std::to_string(modes[0]) + ": " + bem.message);
  {
    const std::lock_guard lock(device_mutex_);
    device_ = bem.device;
    device_message_ = bem.device_message;
  }
  const Eigen::Vector3d centre = 0.5 * (s.vertices_m.rowwise().minCoeff() + s.vertices_m.rowwise().maxCoeff());
  std::vector<ModeTransfer> transfers;
  for (std::size_t c = 0; c < modes.size(); ++c) {
    ModeTransfer transfer;
    transfer.mode = modes[c];
    transfer.frequency_hz = model_.frequency_hz()[modes[c]];
    transfer.n_bem_elements = bem.n_elements;
    transfer.residual = bem.relative_residual;
    MultipoleResult multipole = multipole_from_surface(solver.field(bem, static_cast<int>(c)), bem.wavenumber_per_m,
                                                       options_.medium, centre, options_.order);
    transfer.multipole = std::move(multipole.multipole);
    transfer.radiated_power_w = multipole.series_power_w;
    transfer.decay_radiation_per_s = multipole.series_power_w;  // / (2 x 1/2 J)
    transfer.kept_power_fraction = multipole.kept_power_fraction;
    transfers.push_back(std::move(transfer));
  }
  return transfers;
}

/// Neighbours in the list whose frequencies are the same but for round-off.
std::vector<std::vector<int>> Radiation::of_one_frequency(const std::vector<int>& modes) const {
  constexpr double kSame = 1e-7;
  const Eigen::VectorXd hz = model_.frequency_hz();
  std::vector<std::vector<int>> groups;
  for (const int mode : modes) {
    if (groups.empty() || std::abs(hz[mode] - hz[groups.back()[0]]) > kSame * hz[mode]) groups.emplace_back();
    groups.back().push_back(mode);
  }
  return groups;
}

void Radiation::solve_level(const Level& level, const ModalSurface& surface, const HelmholtzBem& solver) {
  const ModalSurface::Carrier carrier = surface.carrier(solver.surface());
  const auto take_in = [&](ModeTransfer transfer) {
    if (done_) done_(transfer);
    result_.transfer.modes.push_back(std::move(transfer));
    ++n_done_;
    monitor_.progress("transfer", static_cast<double>(n_done_) / static_cast<double>(model_.n_modes()));
  };
  // Progress is of all modes, not of this mesh's.
  struct StopOnly : Monitor {
    explicit StopOnly(Monitor& m) : monitor(m) {}
    bool stop_requested() const override { return monitor.stop_requested(); }
    Monitor& monitor;
  } stop(monitor_);
  const bool many_unknowns = solver.surface().n_vertices() >= kManyUnknowns;
  std::optional<BlasThreads> one;
  if (!many_unknowns) one.emplace(1);
  const std::vector<std::vector<int>> groups = of_one_frequency(level.modes);
  const bool alone = many_unknowns || groups.size() < static_cast<std::size_t>(thread_count());
  for_each_shared_job(
      groups.size(),
      [&](std::size_t i) {
        std::string bytes;
        for (const ModeTransfer& mode : solve_modes(groups[i], alone, surface, solver, carrier))
          bytes += Packer().add_list(packed(mode)).take();
        return bytes;
      },
      [&](std::size_t, std::string_view result) {
        for (Unpacker from(result); !from.done();) take_in(unpacked(from.take_list<std::string>()));
      },
      "transfer", stop, many_unknowns ? JobThreads::kAllForOneJob : JobThreads::kOneForEachJob);
}

RadiateResult Radiation::run(const std::vector<ModeTransfer>& known) {
  const Stopwatch total;
  result_.transfer.medium = options_.medium;
  std::vector<bool> is_known(static_cast<std::size_t>(model_.n_modes()), false);
  for (const ModeTransfer& mode : known) {
    if (mode.mode < 0 || mode.mode >= model_.n_modes() || is_known[mode.mode]) continue;
    is_known[mode.mode] = true;
    result_.transfer.modes.push_back(mode);
  }
  n_done_ = result_.transfer.modes.size();
  const double highest_hz = model_.frequency_hz().maxCoeff();
  const double finest_m = options_.medium.sound_speed_m_s / highest_hz / options_.elements_per_wavelength;
  // Enough pieces for the finest mesh, and no more than the samples need.
  const ModalSurface surface(model_, finest_m, std::min(4 * options_.max_elements, 200000));
  const double wall_m = mesh::wall_tolerance_m(surface.triangles());
  const mesh::MirrorPlanes planes = mesh::mirror_planes(surface.triangles(), kMirrorTolerance * wall_m);
  result_.wall_time_s["surface"] = total.seconds();
  // All meshes first: a frequency that none resolves is refused before any time goes into the others.
  std::vector<Level> list = levels(surface, is_known);
  Stopwatch watch;
  BemOptions options;
  options.medium = options_.medium;
  options.allow_coarse = options_.allow_coarse;
  for (Level& level : list) {
    monitor_.throw_if_stopped();
    level.elements = elements_of(surface, planes, {level.edge_m, std::min(0.05 * level.edge_m, wall_m)});
    if (options_.leave_out_coarse) {
      BemOptions any = options;
      any.allow_coarse = true;
      result_.n_left_out += static_cast<int>(std::erase_if(level.modes, [&](int mode) {
        return check_resolution(level.elements, model_.frequency_hz()[mode], any) < any.min_elements_per_wavelength;
      }));
    }
    for (const int mode : level.modes) check_resolution(level.elements, model_.frequency_hz()[mode], options);
  }
  std::erase_if(list, [](const Level& level) { return level.modes.empty(); });
  result_.wall_time_s["coarsen"] = watch.seconds();
  for (Level& level : list) {
    monitor_.throw_if_stopped();
    watch.restart();
    const HelmholtzBem solver(std::move(level.elements));
    result_.n_elements_of_level.push_back(solver.surface().n_triangles());
    result_.wall_time_s["static"] += watch.seconds();
    watch.restart();
    try {
      solve_level(level, surface, solver);
    } catch (const NumericalError& error) {
      result_.status = RadiateStatus::kFailed;
      result_.message = error.what();
      return std::move(result_);
    }
    result_.wall_time_s["solve"] += watch.seconds();
  }
  std::sort(result_.transfer.modes.begin(), result_.transfer.modes.end(),
            [](const ModeTransfer& a, const ModeTransfer& b) { return a.mode < b.mode; });
  result_.device = device_;
  result_.device_message = device_message_;
  result_.status = RadiateStatus::kDone;
  result_.wall_time_s["total"] = total.seconds();
  return std::move(result_);
}

}  // namespace

void RadiateOptions::validate() const {
  std::vector<Violation> violations = violations_of(*this);
  if (min_elements > max_elements)
    violations.push_back(out_of_range("min_elements", min_elements, between(20.0, max_elements)));
  throw_violations("transfer", std::move(violations));
}

RadiateResult radiate(const modal::ModalModel& model, const RadiateOptions& options, Monitor& monitor,
                      const std::vector<ModeTransfer>& known, const std::function<void(const ModeTransfer&)>& done) {
  options.validate();
  if (model.n_modes() == 0) throw InputError("transfer", "the modal model has no modes");
  return Radiation(model, options, monitor, done).run(known);
}

}  // namespace klang::acoustics
