#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/parallel.hpp"
#include "core/foundation/base/stopwatch.hpp"
#include "core/physics/modal/box_modes.hpp"
#include "core/physics/modal/expected_modes.hpp"

namespace klang::modal {
namespace {

constexpr double kFreeError = 1e-5, kHeldError = 2e-4, kMostWanted = 240.0;
constexpr Eigen::Index kMostFreeUnknowns = 1000, kMostHeldUnknowns = 3200;  // of a system: about 0.1 and 1 s to solve
constexpr Eigen::Index kMostUnknowns = 8000;  // half a GB a matrix, minutes to solve: a length typed in another unit
constexpr double kThin = 0.3;

bool is_held(const HeldFaces& held) {
  return std::any_of(held.begin(), held.end(), [](bool is) { return is; });
}

/// A mode's place: system and number there.
struct Place {
  std::size_t system = 0;
  Eigen::Index index = 0;
};

std::vector<Place> by_frequency(const std::vector<HarmonicModes>& modes) {
  std::vector<Place> places;
  for (std::size_t s = 0; s < modes.size(); ++s)
    for (Eigen::Index i = 0; i < modes[s].angular_frequency_sq.size(); ++i) places.push_back({s, i});
  std::stable_sort(places.begin(), places.end(), [&](const Place& a, const Place& b) {
    return modes[a.system].angular_frequency_sq[a.index] < modes[b.system].angular_frequency_sq[b.index];
  });
  return places;
}

/// Where to look first for the lowest modes: a free beam's first bending frequency, and no more than the first shear wave.
double first_guess_hz(const Eigen::Vector3d& half_m, const solid::Material& material) {
  const double size_m = 2.0 * half_m.maxCoeff();
  const double shear_hz = std::sqrt(material.lame_mu_pa / material.density_kg_m3) / (2.0 * size_m);
  return std::min(shear_hz, 4.0 * shear_hz * half_m.minCoeff() / half_m.maxCoeff());
}

Eigen::Index largest_system(const BoxBody& body) {
  Eigen::Index largest = 0;
  for (std::size_t s = 0; s < body.n_systems(); ++s) largest = std::max(largest, body.size(s));
  return largest;
}

BodySize size_of_box(const Eigen::Vector3d& half_m) {
  const Eigen::Vector3d side_m = 2.0 * half_m;
  return {side_m.prod(), 2.0 * (side_m[0] * side_m[1] + side_m[1] * side_m[2] + side_m[2] * side_m[0])};
}

/// How many modes of each system were found: about as many as with other degrees.
std::vector<int> numbers_of(const std::vector<HarmonicModes>& modes) {
  std::vector<int> numbers;
  for (const HarmonicModes& system : modes) numbers.push_back(static_cast<int>(system.angular_frequency_sq.size()));
  return numbers;
}

/// The eigenvalues of each system at some degrees.
struct Level {
  double degree = 0.0;  ///< the highest
  std::vector<Eigen::VectorXd> eigenvalues;
};

/// The power p of the degrees with which f = f_infinity + C n^-p goes through three levels; none where what was taken off does not fall.
std::optional<double> observed_power(const std::array<double, 3>& degree, double first_off, double last_off) {
  if (!(first_off > last_off) || !(last_off > 0.0)) return std::nullopt;
  double low = 0.5, high = 8.0;
  for (int i = 0; i < 50; ++i) {
    const double p = 0.5 * (low + high);
    const double ratio =
        (std::pow(degree[0], -p) - std::pow(degree[1], -p)) / (std::pow(degree[1], -p) - std::pow(degree[2], -p));
    (ratio < first_off / last_off ? low : high) = p;
  }
  return low;
}

/// With a held face errors fall with a power of the degrees that differs from mode to mode and rises with the degrees: on a clamped plate of 100 x
/// 80 x 0.8 mm from 2 to 2.5 (stress at the corners) and from 2 to 5 (at the edges, later). What is left by a range of powers that
/// begins a little below the observed one is taken off in the mean; half of what the range's two ends differ by is the bound.
void extrapolate(BoxModes& solved, const std::vector<Level>& levels) {
  constexpr double kLeast = 2.0, kMost = 4.0, kBelow = 0.3, kRange = 2.3;
  const Level& last = levels.back();
  const Level &middle = levels[levels.size() - 2], &first = levels[levels.size() - 3];
  for (std::size_t s = 0; s < solved.modes.size(); ++s) {
    auto& eigenvalues = solved.modes[s].angular_frequency_sq;
    solved.bound.emplace_back(Eigen::VectorXd::Ones(eigenvalues.size()));  // not there before: nothing is known
    for (Eigen::Index i = 0; i < std::min(first.eigenvalues[s].size(), eigenvalues.size()); ++i) {
      if (i >= middle.eigenvalues[s].size()) continue;
      const auto logarithm = [&](const Level& level) { return 0.5 * std::log(level.eigenvalues[s][i]); };
      const double off = logarithm(middle) - logarithm(last);
      const double power = std::clamp(
          observed_power({first.degree, middle.degree, last.degree}, logarithm(first) - logarithm(middle), off)
                  .value_or(kLeast) -
              kBelow,
          kLeast, kMost);
      const auto left = [&](double p) { return std::abs(off) / (std::pow(last.degree / middle.degree, p) - 1.0); };
      eigenvalues[i] *= std::exp(-(left(power) + left(power + kRange)));
      solved.bound[s][i] = 0.5 * (left(power) - left(power + kRange));
    }
  }
}

double highest_error(const BoxModes& solved, double low_hz) {
  double highest = 0.0;
  for (std::size_t s = 0; s < solved.modes.size(); ++s)
    for (Eigen::Index i = 0; i < solved.bound[s].size(); ++i)
      if (solved.modes[s].angular_frequency_sq[i] >= std::pow(2.0 * kPi * low_hz, 2))
        highest = std::max(highest, solved.bound[s][i]);
  return highest;
}

/// box_modes() with a held face.
BoxModes held_modes(const Eigen::Vector3d& half_m, const HeldFaces& held, const solid::Material& material,
                    const Band& band, Monitor& monitor) {
  const BoxDegrees start = box_degrees(half_m, material, band.high_hz);
  const auto raised = [&](int raises) {
    BoxDegrees degrees{};
    for (std::size_t d = 0; d < 3; ++d) {
      const double side = half_m[static_cast<Eigen::Index>(d)] / half_m.maxCoeff();
      // The thinner, the less its own degree adds: from 6 to 10 through a plate of 1:100 it is 2e-5.
      degrees[d] = std::min(60, start[d] + (side < kThin ? 1 + static_cast<int>(4.0 * side * raises) : 4 * raises));
    }
    return degrees;
  };
  std::vector<Level> levels;
  std::vector<int> numbers;
  for (int raises = 0;; ++raises) {
    monitor.throw_if_stopped();
    const BoxDegrees degrees = raised(raises), next = raised(raises + 1);
    BoxModes solved{degrees, BoxBody(half_m, degrees, held).modes_up_to(material, band.high_hz, numbers), {}};
    numbers = numbers_of(solved.modes);
    Level& level = levels.emplace_back();
    level.degree = *std::max_element(degrees.begin(), degrees.end());
    for (const HarmonicModes& system : solved.modes) level.eigenvalues.push_back(system.angular_frequency_sq);
    if (levels.size() < 3) continue;
    extrapolate(solved, levels);
    const bool is_last = next == degrees || largest_system(BoxBody(half_m, next, held)) > kMostHeldUnknowns;
    if (is_last || highest_error(solved, band.low_hz) <= kHeldError) return solved;
  }
}

/// Where the band of so many modes ends, by few polynomials, and a little more.
double end_of_band_hz(const Eigen::Vector3d& half_m, const HeldFaces& held, const solid::Material& material,
                      const EigenOptions& options, Monitor& monitor) {
  const BodySize size = size_of_box(half_m);
  // Half as many as wanted by the estimate, which may be off by a factor of two: too far up is dearer than once more.
  double high_hz = std::max(first_guess_hz(half_m, material), options.band.low_hz);
  while (expected_modes(size, material, high_hz) < 0.5 * options.count) high_hz *= 1.1;
  std::vector<int> numbers;
  for (;; high_hz *= 1.5) {
    monitor.throw_if_stopped();
    const auto modes =
        BoxBody(half_m, box_degrees(half_m, material, high_hz), held).modes_up_to(material, high_hz, numbers);
    numbers = numbers_of(modes);
    std::vector<double> found;
    for (const auto& system : modes)
      for (const double omega_sq : system.angular_frequency_sq)
        if (omega_sq >= std::pow(2.0 * kPi * options.band.low_hz, 2))
          found.push_back(std::sqrt(omega_sq) / (2.0 * kPi));
    if (found.size() < static_cast<std::size_t>(options.count)) continue;
    std::sort(found.begin(), found.end());
    return 1.0001 * found[static_cast<std::size_t>(options.count - 1)];
  }
}

/// What resolves the shortest wave of a band along each axis.
Eigen::Vector3d wanted_degrees(const Eigen::Vector3d& half_lengths_m, const solid::Material& material,
                               double highest_hz) {
  const double omega = 2.0 * kPi * highest_hz, ratio = material.poissons_ratio();
  const double plate = material.youngs_modulus_pa() / (12.0 * material.density_kg_m3 * (1.0 - ratio * ratio));
  const double bending = std::pow(omega * omega / (plate * std::pow(2.0 * half_lengths_m.minCoeff(), 2)), 0.25);
  const double shear = omega / (0.9 * std::sqrt(material.lame_mu_pa / material.density_kg_m3));
  Eigen::Vector3d degrees;
  for (Eigen::Index d = 0; d < 3; ++d) {
    const double half_m = half_lengths_m[d];
    const bool is_thinnest = half_m <= 1.0001 * half_lengths_m.minCoeff();
    const double waves = half_m * (is_thinnest ? shear : std::max(shear, bending));  // kL/2
    degrees[d] = std::ceil(1.1 * waves + (half_m < kThin * half_lengths_m.maxCoeff() ? 5.0 : 9.0));
  }
  return degrees;
}

}  // namespace

std::optional<HeldFaces> held_faces(const solid::Support& support, const Eigen::Vector3d& half_lengths_m) {
  HeldFaces held{};
  if (support.kind == solid::SupportKind::kFree) return held;
  const std::string& where = support.where;
  if (where.size() < 3 || where[0] < 'x' || where[0] > 'z' || where[1] != '=') return std::nullopt;
  const int axis = where[0] - 'x';
  const std::string place = where.substr(2);
  if (place == "min" || place == "max") {
    held[static_cast<std::size_t>(2 * axis + (place == "max" ? 1 : 0))] = true;
    return held;
  }
  const double at_m = std::strtod(place.c_str(), nullptr), slack_m = 1e-6 * 2.0 * half_lengths_m.maxCoeff();
  for (const int side : {0, 1})
    if (std::abs(at_m - (side == 1 ? 1.0 : -1.0) * half_lengths_m[axis]) <= slack_m) {
      held[static_cast<std::size_t>(2 * axis + side)] = true;
      return held;
    }
  return std::nullopt;
}

BoxDegrees box_degrees(const Eigen::Vector3d& half_lengths_m, const solid::Material& material, double highest_hz) {
  const Eigen::Vector3d wanted = wanted_degrees(half_lengths_m, material, highest_hz);
  BoxDegrees degrees{};
  for (std::size_t d = 0; d < 3; ++d)
    degrees[d] = static_cast<int>(std::clamp(wanted[static_cast<Eigen::Index>(d)], 4.0, 60.0));
  return degrees;
}

BoxDegrees box_degrees_raised(const Eigen::Vector3d& half_lengths_m, BoxDegrees degrees, int raises) {
  for (std::size_t d = 0; d < 3; ++d) {
    const bool is_thin = half_lengths_m[static_cast<Eigen::Index>(d)] < kThin * half_lengths_m.maxCoeff();
    degrees[d] = std::clamp(degrees[d] + raises * (is_thin ? 1 : 2), 2, 60);
  }
  return degrees;
}

Eigen::Vector3d box_half_lengths_m(const mesh::ShapeSpec& shape) {
  if (shape.kind != "box") throw InputError("modes", "polynomials need a box", shape.kind, "box");
  return 0.5 * Eigen::Vector3d(shape.dims.at("length_m"), shape.dims.at("width_m"), shape.dims.at("height_m"));
}

BoxModes box_modes(const Eigen::Vector3d& half_lengths_m, const HeldFaces& held, const solid::Material& material,
                   const Band& band, Monitor& monitor) {
  const std::string place = "box of " + to_text(2.0 * half_lengths_m.maxCoeff()) + " m";
  check_expected_modes(place, expected_modes(size_of_box(half_lengths_m), material, band.high_hz), band.high_hz);
  // With a quarter of what the shortest wave asks for nothing near the band's end is right, and there is no end to it.
  if (const double wanted = wanted_degrees(half_lengths_m, material, band.high_hz).maxCoeff(); wanted > kMostWanted)
    throw InputError(place, "is too long for waves up to " + to_text(std::round(band.high_hz)) + " Hz",
                     "polynomials of degree " + to_text(wanted),
                     "up to " + to_text(kMostWanted) + ": a lower band, or lengths in metres");
  const BoxDegrees start = box_degrees(half_lengths_m, material, band.high_hz);
  if (const Eigen::Index n = largest_system(BoxBody(half_lengths_m, start, held)); n > kMostUnknowns)
    throw InputError(place, "has too many modes up to " + to_text(std::round(band.high_hz)) + " Hz",
                     std::to_string(n) + " unknowns of a kind",
                     "up to " + std::to_string(kMostUnknowns) + ": a lower band, or lengths in metres");
  if (is_held(held)) return held_modes(half_lengths_m, held, material, band, monitor);
  BoxModes solved;
  solved.degrees = start;
  solved.modes = BoxBody(half_lengths_m, solved.degrees, held).modes_up_to(material, band.high_hz);
  for (;;) {
    monitor.throw_if_stopped();
    const std::vector<HarmonicModes> before = std::move(solved.modes);
    solved.degrees = box_degrees_raised(half_lengths_m, solved.degrees);
    solved.modes =
        BoxBody(half_lengths_m, solved.degrees, held).modes_up_to(material, band.high_hz, numbers_of(before));
    solved.bound = box_error_bound(before, solved.modes, solved.degrees, held);
    if (highest_error(solved, band.low_hz) <= kFreeError) return solved;
    if (largest_system(BoxBody(half_lengths_m, box_degrees_raised(half_lengths_m, solved.degrees), held)) >
        kMostFreeUnknowns)
      return solved;
  }
}

SampledModes sample_box_modes(const BoxBody& body, const std::vector<HarmonicModes>& modes, const mesh::TetMesh& mesh,
                              const solid::Material& material, const solid::Support& support) {
  const std::vector<Place> places = by_frequency(modes);
  const auto n = static_cast<Eigen::Index>(places.size());
  SampledModes sampled;
  sampled.model.mesh = mesh;
  sampled.model.material = material;
  sampled.model.support = support;
  sampled.model.angular_frequency_rad_s.resize(n);
  sampled.model.shapes.resize(3 * mesh.n_nodes(), n);
  sampled.relative_residual.resize(n);
  std::vector<Eigen::MatrixXd> moved;
  for (std::size_t s = 0; s < modes.size(); ++s) moved.push_back(body.displacements(s, modes[s].vectors, mesh.nodes_m));
  for (Eigen::Index k = 0; k < n; ++k) {
    const Place& place = places[static_cast<std::size_t>(k)];
    sampled.system.push_back(static_cast<int>(place.system));
    sampled.index.push_back(static_cast<int>(place.index));
    sampled.model.angular_frequency_rad_s[k] = std::sqrt(modes[place.system].angular_frequency_sq[place.index]);
    sampled.relative_residual[k] = modes[place.system].relative_residual[place.index];
    sampled.model.shapes.col(k) = moved[place.system].col(place.index);
  }
  return sampled;
}

std::vector<Eigen::VectorXd> box_error_bound(const std::vector<HarmonicModes>& before,
                                             const std::vector<HarmonicModes>& raised, const BoxDegrees& degrees,
                                             const HeldFaces& held) {
  const double n = *std::max_element(degrees.begin(), degrees.end());
  const double left =
      1.0 / (std::pow(n / (n - 2.0), is_held(held) ? 2 : 4) - 1.0);  // of the error, by what was taken off
  std::vector<Eigen::VectorXd> bounds;
  for (std::size_t s = 0; s < raised.size(); ++s) {
    const auto& now = raised[s].angular_frequency_sq;
    const auto& then = before[s].angular_frequency_sq;
    Eigen::VectorXd bound = Eigen::VectorXd::Ones(now.size());  // a mode that was not there before: nothing is known
    const Eigen::Index both = std::min(now.size(), then.size());
    bound.head(both) = left * (0.5 * (then.head(both).array() / now.head(both).array()).log()).abs();
    bounds.push_back(std::move(bound));
  }
  return bounds;
}

EigenResult solve_box_modes(const mesh::ShapeSpec& shape, const mesh::TetMesh& mesh, const solid::Material& material,
                            const solid::Support& support, const EigenOptions& options, Monitor& monitor) {
  options.validate();
  const Stopwatch total;
  const Eigen::Vector3d half_m = box_half_lengths_m(shape);
  const auto held = held_faces(support, half_m);
  if (!held) throw InputError("modes", "polynomials need a box that is free or held at a whole face", support.where);
  EigenResult result;
  result.method_used = EigenMethod::kPolynomials;
  monitor.progress("modes", 0.0);
  Band band = options.band;
  if (options.count > 0) band.high_hz = end_of_band_hz(half_m, *held, material, options, monitor);
  if (is_held(*held)) band.high_hz *= 1.001;  // those that come down into it
  BoxModes solved = box_modes(half_m, *held, material, band, monitor);
  result.wall_time_s["iterate"] = total.seconds();
  const BoxBody body(half_m, solved.degrees, *held);
  for (std::size_t s = 0; s < body.n_systems(); ++s) result.n_rigid_modes += body.n_rigid(s);

  const std::vector<Place> places = by_frequency(solved.modes);
  const double lowest_sq = std::pow(2.0 * kPi * options.band.low_hz, 2);
  const auto below = std::count_if(places.begin(), places.end(), [&](const Place& place) {
    return solved.modes[place.system].angular_frequency_sq[place.index] < lowest_sq;
  });
  const double highest_sq = options.count > 0 ? INFINITY : std::pow(2.0 * kPi * options.band.high_hz, 2);
  const auto n_all = std::count_if(places.begin(), places.end(),
                                   [&](const Place& place) {
                                     return solved.modes[place.system].angular_frequency_sq[place.index] <= highest_sq;
                                   }) -
                     below;
  const auto most = options.count > 0 ? options.count : options.most > 0 ? options.most : n_all;
  const auto n = std::min<std::ptrdiff_t>(most, n_all);
  result.n_below_band = static_cast<int>(below);
  if (options.count == 0) result.n_left_out = static_cast<int>(n_all - n);
  if (options.prove_none_missing) {
    const BlasThreads one(1);
    std::vector<int> counts(body.n_systems());
    for_each_job(
        counts.size(), [&](std::size_t s) { counts[s] = body.count_below(s, material, band.high_hz); }, "count",
        monitor);
    result.sturm_count = std::accumulate(counts.begin(), counts.end(), 0L);
    result.none_missing = *result.sturm_count == static_cast<long>(places.size()) + result.n_rigid_modes;
  }

  const Stopwatch watch;
  SampledModes sampled = sample_box_modes(body, solved.modes, mesh, material, support);
  result.model = std::move(sampled.model);
  result.model.angular_frequency_rad_s = result.model.angular_frequency_rad_s.segment(below, n).eval();
  result.model.shapes = result.model.shapes.middleCols(below, n).eval();
  result.relative_residual = sampled.relative_residual.segment(below, n);
  if (options.estimate_mesh_error) {
    result.mesh_relative_error.emplace(n);
    for (Eigen::Index k = 0; k < n; ++k) {
      const Place& place = places[static_cast<std::size_t>(below + k)];
      (*result.mesh_relative_error)[k] = solved.bound[place.system][place.index];
    }
  }
  result.wall_time_s["sample"] = watch.seconds();
  result.status = EigenStatus::kConverged;
  result.wall_time_s["total"] = total.seconds();
  return result;
}

}  // namespace klang::modal
