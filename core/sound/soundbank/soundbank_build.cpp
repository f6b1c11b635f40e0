#include "core/sound/soundbank/soundbank_build.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/packed.hpp"
#include "core/foundation/base/parallel.hpp"
#include "core/foundation/base/shared_jobs.hpp"
#include "core/foundation/base/stopwatch.hpp"
#include "core/foundation/config/fields.hpp"

namespace klang::soundbank {
namespace {

constexpr int kPerClass = 12;
constexpr double kSafety = 0.6;

/// Halton's sequence in the triangle: the same shapes in every run, none twice.
ShapePoint check_shape(int index, double depth) {
  const auto radical = [](int i, int base) {
    double value = 0.0, scale = 1.0 / base;
    for (; i > 0; i /= base, scale /= base) value += scale * (i % base);
    return value;
  };
  double p = radical(index + 1, 2), q = radical(index + 1, 3);
  if (p < q) std::swap(p, q);
  return {-depth * p, -depth * q};  // u <= v
}

class Builder {
 public:
  Builder(const BuildOptions& options, Monitor& monitor, BuildProgress progress,
          const std::function<void(const BuildProgress&)>& saved)
      : options_(options),
        monitor_(monitor),
        progress_(std::move(progress)),
        saved_(saved),
        depth_(-std::log(options.thinnest)) {}

  BuildResult run();

 private:
  using Edge = std::pair<int, int>;
  static Edge edge(int a, int b) { return {std::min(a, b), std::max(a, b)}; }

  EllipsoidModes solve(const ShapePoint& shape) const {
    return EllipsoidModes(unit_axes(shape), options_.material, {options_.degree, kPerClass});
  }
  int node(const ShapePoint& at);
  int middle(int a, int b) {
    const ShapePoint p = bank_.nodes[a], q = bank_.nodes[b];
    return node({0.5 * (p.u + q.u), 0.5 * (p.v + q.v)});
  }
  int add_triangle(int apex, int left, int right, int level);
  void halve(int triangle);
  void make_frequencies(const std::vector<ShapePoint>& shapes, const char* stage);
  void fill_nodes(const char* stage);
  /// Largest |ln ratio| of the first count modes of the direct solution, interpolated in a triangle known by its place.
  double error_at(const ShapePoint& shape, const ShapePlace& place, int count) const;
  std::vector<ShapePlace> probes(int triangle) const;
  ShapePoint shape_of(const ShapePlace& place) const;
  void refine_by_probes();
  void refine_by_checks();
  Cell make_cell(const ShapePoint& shape) const;
  void make_cells();
  void save(bool now = false);

  const BuildOptions& options_;
  Monitor& monitor_;
  BuildProgress progress_;
  const std::function<void(const BuildProgress&)>& saved_;
  const double depth_;
  Stopwatch since_save_;
  Soundbank bank_;
  std::map<ShapePoint, int> node_of_;
  std::vector<int> level_;
  std::map<Edge, std::vector<int>> leaves_of_;
  int n_solves_ = 0;
  bool reached_ = true;
};

void Builder::save(bool now) {
  if (!saved_ || (!now && since_save_.seconds() < 5.0)) return;
  saved_(progress_);
  since_save_.restart();
}

int Builder::node(const ShapePoint& at) {
  const auto [found, is_new] = node_of_.try_emplace(at, static_cast<int>(bank_.nodes.size()));
  if (is_new) bank_.nodes.push_back(at);
  return found->second;
}

int Builder::add_triangle(int apex, int left, int right, int level) {
  const int index = static_cast<int>(bank_.triangles.size());
  bank_.triangles.push_back(
      {{apex, left, right, middle(left, right), middle(right, apex), middle(apex, left)}, {-1, -1}});
  level_.push_back(level);
  for (const Edge& e : {edge(apex, left), edge(left, right), edge(right, apex)}) leaves_of_[e].push_back(index);
  return index;
}

void Builder::halve(int triangle) {
  if (bank_.triangles[triangle].children[0] >= 0) return;
  const auto [apex, left, right, base_middle, unused_a, unused_b] = bank_.triangles[triangle].nodes;
  const Edge base = edge(left, right);
  // The neighbour across the base must have the same base: halve it first where it has not.
  int neighbour = -1;
  for (const int other : leaves_of_[base])
    if (other != triangle) neighbour = other;
  if (neighbour >= 0) {
    const auto& n = bank_.triangles[neighbour].nodes;
    if (edge(n[1], n[2]) != base) {
      halve(neighbour);
      neighbour = -1;
      for (const int other : leaves_of_[base])
        if (other != triangle) neighbour = other;
    }
  }
  const auto split = [&](int t) {
    const auto nodes = bank_.triangles[t].nodes;
    for (const Edge& e : {edge(nodes[0], nodes[1]), edge(nodes[1], nodes[2]), edge(nodes[2], nodes[0])})
      std::erase(leaves_of_[e], t);
    const int first = add_triangle(nodes[3], nodes[0], nodes[1], level_[t] + 1);
    const int second = add_triangle(nodes[3], nodes[2], nodes[0], level_[t] + 1);
    bank_.triangles[t].children = {first, second};
  };
  split(triangle);
  if (neighbour >= 0) split(neighbour);
}

void Builder::make_frequencies(const std::vector<ShapePoint>& shapes, const char* stage) {
  std::vector<ShapePoint> missing;
  for (const ShapePoint& shape : shapes)
    if (!progress_.frequencies.contains(shape)) missing.push_back(shape);
  std::sort(missing.begin(), missing.end());
  missing.erase(std::unique(missing.begin(), missing.end()), missing.end());
  for_each_shared_job(
      missing.size(),
      [&](std::size_t i) {
        const EllipsoidModes modes = solve(missing[i]);
        Packer frequencies;
        for (int c = 0; c < kModeClasses; ++c) {
          const Eigen::VectorXd of_class = modes.angular_frequency_rad_s(c) / options_.material.shear_speed_m_s();
          frequencies.add_list(of_class);
        }
        return frequencies.take();
      },
      [&](std::size_t i, std::string_view result) {
        Unpacker from(result);
        ClassFrequencies frequencies;
        for (Eigen::VectorXd& of_class : frequencies) of_class = from.take_list<Eigen::VectorXd>();
        progress_.frequencies.emplace(missing[i], std::move(frequencies));
        ++n_solves_;
        save();
      },
      stage, monitor_);
}

void Builder::fill_nodes(const char* stage) {
  make_frequencies(bank_.nodes, stage);
  bank_.node_frequencies.clear();
  for (const ShapePoint& shape : bank_.nodes) bank_.node_frequencies.push_back(progress_.frequencies.at(shape));
}

double Builder::error_at(const ShapePoint& shape, const ShapePlace& place, int count) const {
  const ClassFrequencies& direct = progress_.frequencies.at(shape);
  const ClassFrequencies found = interpolated_frequencies(bank_, place);
  double worst = 0.0;
  for (const ModeId& id : lowest_modes(direct, count))
    worst = std::max(worst, std::abs(found[id.mode_class][id.index] / direct[id.mode_class][id.index] - 1.0));
  return worst;
}

ShapePoint Builder::shape_of(const ShapePlace& place) const {
  ShapePoint at;
  for (int i = 0; i < 3; ++i) {
    const ShapePoint& corner = bank_.nodes[bank_.triangles[place.triangle].nodes[i]];
    at.u += place.weights[i] * corner.u;
    at.v += place.weights[i] * corner.v;
  }
  return at;
}

std::vector<ShapePlace> Builder::probes(int triangle) const {
  return {{triangle, {1.0 / 3, 1.0 / 3, 1.0 / 3}, false},
          {triangle, {0.625, 0.1875, 0.1875}, false},
          {triangle, {0.1875, 0.625, 0.1875}, false},
          {triangle, {0.1875, 0.1875, 0.625}, false}};
}

void Builder::refine_by_probes() {
  std::set<int> passed;
  for (;;) {
    fill_nodes("sampling shapes");
    std::vector<int> leaves;
    std::vector<ShapePoint> shapes;
    for (int t = 0; t < static_cast<int>(bank_.triangles.size()); ++t) {
      if (bank_.triangles[t].children[0] >= 0 || passed.contains(t)) continue;
      leaves.push_back(t);
      for (const ShapePlace& probe : probes(t)) shapes.push_back(shape_of(probe));
    }
    if (leaves.empty()) return;
    make_frequencies(shapes, "sampling shapes");
    std::vector<int> too_coarse;
    for (const int t : leaves) {
      double worst = 0.0;
      for (const ShapePlace& probe : probes(t))
        worst = std::max(worst, error_at(shape_of(probe), probe, options_.n_checked_modes));
      if (worst <= kSafety * options_.tolerance) {
        passed.insert(t);
      } else if (level_[t] >= options_.max_halvings) {
        reached_ = false;
        passed.insert(t);
      } else {
        too_coarse.push_back(t);
      }
    }
    for (const int t : too_coarse) halve(t);
  }
}

void Builder::refine_by_checks() {
  int next = 0;
  for (;;) {
    std::vector<ShapePoint> shapes;
    for (int i = 0; i < options_.check_shapes; ++i) shapes.push_back(check_shape(next++, depth_));
    make_frequencies(shapes, "checking unseen shapes");
    bank_.max_interpolation_error = bank_.max_interpolation_error_all = 0.0;
    bank_.n_check_shapes = options_.check_shapes;
    std::set<int> failed;
    for (const ShapePoint& shape : shapes) {
      const ShapePlace place = locate(bank_, shape);
      const double error = error_at(shape, place, options_.n_checked_modes);
      bank_.max_interpolation_error = std::max(bank_.max_interpolation_error, error);
      bank_.max_interpolation_error_all =
          std::max(bank_.max_interpolation_error_all, error_at(shape, place, options_.modes_per_cell));
      if (!(error <= options_.tolerance) && level_[place.triangle] < options_.max_halvings)
        failed.insert(place.triangle);
    }
    if (failed.empty()) {
      if (!(bank_.max_interpolation_error <= options_.tolerance)) reached_ = false;
      return;
    }
    for (const int t : failed) halve(t);
    refine_by_probes();
  }
}

Cell Builder::make_cell(const ShapePoint& shape) const {
  const EllipsoidModes modes = solve(shape);
  EllipsoidRadiationOptions radiation;
  radiation.medium = options_.medium;
  radiation.boundary_tolerance = options_.boundary_tolerance;
  Cell cell{shape, {}};
  for (const ModeId& id : modes.lowest(options_.modes_per_cell)) {
    monitor_.throw_if_stopped();
    CellMode mode;
    mode.id = id;
    mode.angular_frequency_rad_s = modes.angular_frequency_rad_s(id);
    mode.coefficients = modes.coefficients(id).cast<float>();
    if (options_.radiation) {
      const EllipsoidRadiation sound = radiate(modes, id, radiation);
      mode.order = sound.multipole.order;
      mode.packed_pa = packed_multipole(sound.multipole.coefficients_pa, mode.order, id.mode_class);
      mode.radiated_power_w = sound.radiated_power_w;
      mode.kept_power_fraction = sound.kept_power_fraction;
      mode.boundary_error = sound.boundary_error;
    }
    cell.modes.push_back(std::move(mode));
  }
  return cell;
}

std::string packed(const Cell& cell) {
  Packer to;
  to.add(cell.shape).add(cell.modes.size());
  for (const CellMode& mode : cell.modes) {
    to.add(mode.id).add(mode.angular_frequency_rad_s).add_list(mode.coefficients).add(mode.order);
    to.add_list(mode.packed_pa).add(mode.radiated_power_w).add(mode.kept_power_fraction).add(mode.boundary_error);
  }
  return to.take();
}

Cell unpacked_cell(std::string_view bytes) {
  Unpacker from(bytes);
  Cell cell{from.take<ShapePoint>(), {}};
  cell.modes.resize(from.take<std::size_t>());
  for (CellMode& mode : cell.modes) {
    mode.id = from.take<ModeId>();
    mode.angular_frequency_rad_s = from.take<double>();
    mode.coefficients = from.take_list<Eigen::VectorXf>();
    mode.order = from.take<int>();
    mode.packed_pa = from.take_list<std::vector<std::complex<float>>>();
    mode.radiated_power_w = from.take<double>();
    mode.kept_power_fraction = from.take<double>();
    mode.boundary_error = from.take<double>();
  }
  return cell;
}

void Builder::make_cells() {
  std::set<int> corners;
  for (const ShapeTriangle& t : bank_.triangles)
    if (t.children[0] < 0) corners.insert(t.nodes.begin(), t.nodes.begin() + 3);
  const std::vector<int> list(corners.begin(), corners.end());
  std::vector<std::size_t> missing;
  for (std::size_t i = 0; i < list.size(); ++i)
    if (!progress_.cells.contains(bank_.nodes[list[i]])) missing.push_back(i);
  for_each_shared_job(
      missing.size(), [&](std::size_t j) { return packed(make_cell(bank_.nodes[list[missing[j]]])); },
      [&](std::size_t j, std::string_view result) {
        progress_.cells.emplace(bank_.nodes[list[missing[j]]], unpacked_cell(result));
        save();
      },
      "sound of the cells", monitor_);
  for (const int i : list) bank_.cells.push_back(progress_.cells.at(bank_.nodes[i]));
}

BuildResult Builder::run() {
  const BlasThreads one(1);
  bank_.poissons_ratio = std::round(1e12 * options_.material.poissons_ratio()) / 1e12;  // 0.2, not 0.19999...
  bank_.material = options_.material;
  bank_.medium = options_.medium;
  bank_.thinnest = options_.thinnest;
  bank_.tolerance = options_.tolerance;
  bank_.n_checked_modes = options_.n_checked_modes;
  bank_.modes_per_cell = options_.modes_per_cell;
  bank_.degree = options_.degree;
  const int pancake = node({-depth_, 0.0}), sphere = node({0.0, 0.0}), cigar = node({-depth_, -depth_});
  const int whole = add_triangle(pancake, sphere, cigar, 0);
  halve(whole);
  try {
    refine_by_probes();
    refine_by_checks();
    make_cells();
  } catch (const Interrupted&) {
    save(true);
    throw;
  }
  BuildResult result;
  result.status = reached_ ? BuildStatus::kDone : BuildStatus::kToleranceNotReached;
  if (!reached_) result.message = "soundbank: the tolerance is not reached within the largest depth";
  result.bank = std::move(bank_);
  result.n_eigen_solves = n_solves_;
  return result;
}

}  // namespace

void BuildOptions::validate() const {
  solid::validate(material);
  std::vector<Violation> violations = violations_of(*this);
  if (n_checked_modes > modes_per_cell)
    violations.push_back(out_of_range("n_checked_modes", n_checked_modes, between(1, modes_per_cell)));
  throw_violations("soundbank", std::move(violations));
}

BuildResult build_soundbank(const BuildOptions& options, Monitor& monitor, BuildProgress progress,
                            const std::function<void(const BuildProgress&)>& saved) {
  options.validate();
  return Builder(options, monitor, std::move(progress), saved).run();
}

}  // namespace klang::soundbank
