#include "core/sound/dual_domain/reciprocal.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <queue>

#include "core/foundation/base/check.hpp"
#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/parallel.hpp"
#include "core/foundation/base/stopwatch.hpp"
#include "core/geometry/mesh/surface_coarsening.hpp"
#include "core/sound/bem/helmholtz_bem.hpp"
#include "core/sound/dual_domain/detail/closest_point.hpp"
#include "core/sound/dual_domain/detail/liquid_solver.hpp"

namespace klang::bubble {
namespace {

using Complex = std::complex<double>;
using Eigen::Index;
using Eigen::MatrixXcd;
using Eigen::Vector3d;

/// The triangles that the air sees.
std::vector<Index> dry_triangles(const LiquidBoundary& boundary) {
  std::vector<Index> kept;
  for (Index t = 0; t < boundary.surface().triangles.rows(); ++t)
    if (boundary.region()[static_cast<std::size_t>(t)] != static_cast<int>(BoundaryRegion::kWetSolid))
      kept.push_back(t);
  return kept;
}

mesh::SurfaceMesh air_surface(const LiquidBoundary& boundary, const std::vector<Index>& kept) {
  mesh::SurfaceMesh result;
  result.vertices_m = boundary.surface().vertices_m;
  result.triangles.resize(static_cast<Index>(kept.size()), 3);
  for (std::size_t i = 0; i < kept.size(); ++i)
    result.triangles.row(static_cast<Index>(i)) = boundary.surface().triangles.row(kept[i]);
  return result;
}

/// From each vertex along edges to the free surface.
std::vector<double> way_to_free_surface_m(const LiquidBoundary& boundary, const mesh::SurfaceMesh& surface,
                                          const std::vector<Index>& kept) {
  std::vector<std::vector<std::pair<int, double>>> edges(static_cast<std::size_t>(surface.vertices_m.rows()));
  std::vector<double> way(edges.size(), HUGE_VAL);
  using Reached = std::pair<double, int>;
  std::priority_queue<Reached, std::vector<Reached>, std::greater<>> queue;
  for (Index t = 0; t < surface.triangles.rows(); ++t) {
    const bool is_free = boundary.region()[static_cast<std::size_t>(kept[static_cast<std::size_t>(t)])] ==
                         static_cast<int>(BoundaryRegion::kFreeSurface);
    for (int c = 0; c < 3; ++c) {
      const int a = surface.triangles(t, c), b = surface.triangles(t, (c + 1) % 3);
      edges[static_cast<std::size_t>(a)].emplace_back(b,
                                                      (surface.vertices_m.row(a) - surface.vertices_m.row(b)).norm());
      if (is_free && way[static_cast<std::size_t>(a)] != 0.0) {
        way[static_cast<std::size_t>(a)] = 0.0;
        queue.emplace(0.0, a);
      }
    }
  }
  while (!queue.empty()) {
    const auto [length, v] = queue.top();
    queue.pop();
    if (length > way[static_cast<std::size_t>(v)]) continue;
    for (const auto& [other, edge] : edges[static_cast<std::size_t>(v)]) {
      if (!(length + edge < way[static_cast<std::size_t>(other)])) continue;
      way[static_cast<std::size_t>(other)] = length + edge;
      queue.emplace(length + edge, other);
    }
  }
  return way;
}

/// Fewer triangles: small ones on the free surface, where the field is asked for, larger ones away from it.
/// @param edge_m  becomes the length of edges on the free surface, in the mean
mesh::SurfaceMesh with_triangles(const mesh::SurfaceMesh& surface, const std::vector<double>& way_m, Index n_triangles,
                                 double& edge_m) {
  constexpr double kGrowth = 0.4, kLargest = 4.0;
  std::vector<double> area_m2;
  for (Index t = 0; t < surface.triangles.rows(); ++t) {
    const Vector3d a = surface.vertices_m.row(surface.triangles(t, 0)),
                   b = surface.vertices_m.row(surface.triangles(t, 1)),
                   c = surface.vertices_m.row(surface.triangles(t, 2));
    area_m2.push_back(0.5 * (b - a).cross(c - a).norm());
  }
  const double all_m2 = std::accumulate(area_m2.begin(), area_m2.end(), 0.0);
  if (surface.triangles.rows() <= n_triangles) {
    edge_m = std::sqrt(2.31 * all_m2 / static_cast<double>(surface.triangles.rows()));
    return surface;
  }
  edge_m = std::sqrt(2.31 * all_m2 / static_cast<double>(n_triangles));  // of equilateral ones
  std::vector<double> times_larger(way_m.size(), 1.0);
  for (int pass = 0; pass < 8; ++pass) {  // the smaller the edge is, the sooner the others are larger
    for (std::size_t v = 0; v < way_m.size(); ++v)
      times_larger[v] = std::min(kLargest, 1.0 + kGrowth * std::min(way_m[v], 1e3) / edge_m);
    double counted_m2 = 0.0;
    for (Index t = 0; t < surface.triangles.rows(); ++t) {
      const double times = (times_larger[static_cast<std::size_t>(surface.triangles(t, 0))] +
                            times_larger[static_cast<std::size_t>(surface.triangles(t, 1))] +
                            times_larger[static_cast<std::size_t>(surface.triangles(t, 2))]) /
                           3.0;
      counted_m2 += area_m2[static_cast<std::size_t>(t)] / (times * times);
    }
    edge_m = std::sqrt(2.31 * counted_m2 / static_cast<double>(n_triangles));
  }
  mesh::CoarseningOptions options;
  options.edge_m = 1.3 * edge_m;  // room
  options.tolerance_m = 0.2 * options.edge_m;
  options.stop_at_triangles = static_cast<int>(n_triangles);
  return mesh::coarsened(surface, options, {}, times_larger);
}

Eigen::Matrix3Xd columns(const std::vector<Vector3d>& points) {
  Eigen::Matrix3Xd result(3, static_cast<Index>(points.size()));
  for (std::size_t i = 0; i < points.size(); ++i) result.col(static_cast<Index>(i)) = points[i];
  return result;
}

/// What a field asks of the liquid's functions: q on the free surface, nothing on walls.
MatrixXcd ear_data(const LiquidBoundary& boundary, const EarField& air, const Eigen::VectorXd& weights) {
  const auto& samples = boundary.samples();
  MatrixXcd data = MatrixXcd::Zero(static_cast<Index>(samples.size()), air.q.cols());
  for (Index i = 0; i < data.rows(); ++i) {
    const BoundarySample& s = samples[static_cast<std::size_t>(i)];
    if (s.region == BoundaryRegion::kFreeSurface) data.row(i) = weights[i] * air.q.row(s.vertex);
  }
  return data;
}

}  // namespace

void ReciprocalOptions::validate() const { validate_fields("reciprocal transfer", *this); }

struct EarElements::Data {
  acoustics::HelmholtzBem solver;
  double edge_m = 0.0;  ///< on the free surface, in the mean
};

EarElements::EarElements(const LiquidBoundary& boundary, int most_vertices) {
  const std::vector<Index> kept = dry_triangles(boundary);
  const mesh::SurfaceMesh whole = air_surface(boundary, kept);
  double edge_m = 0.0;
  const mesh::SurfaceMesh surface = with_triangles(whole, way_to_free_surface_m(boundary, whole, kept),
                                                   2 * static_cast<Index>(most_vertices) - 4, edge_m);
  data_ = std::make_unique<const Data>(Data{acoustics::HelmholtzBem(acoustics::radiating_surface(surface)), edge_m});
}
EarElements::~EarElements() = default;
EarElements::EarElements(EarElements&&) noexcept = default;

int EarElements::n_elements() const { return data_->solver.surface().n_triangles(); }

double EarElements::elements_per_wavelength(double frequency_hz, const acoustics::Medium& air) const {
  return air.sound_speed_m_s / (frequency_hz * data_->edge_m);
}

MatrixXcd EarElements::field(double frequency_hz, const std::vector<Vector3d>& ears_m, const acoustics::Medium& air,
                             Monitor& monitor, const opencl::DeviceChoice& device, std::string* device_message) const {
  const acoustics::RadiatingSurface& s = data_->solver.surface();
  const Eigen::Matrix3Xd ears = columns(ears_m);
  const double k = air.wavenumber_per_m(frequency_hz);
  const Complex to_velocity(0.0, 1.0 / (2.0 * kPi * frequency_hz * air.density_kg_m3));  // dp/dn = -i omega rho v
  MatrixXcd velocity(3 * static_cast<Index>(s.n_triangles()), ears.cols());
  for (Index e = 0; e < ears.cols(); ++e)
    for (int t = 0; t < s.n_triangles(); ++t)
      for (int c = 0; c < 3; ++c)
        velocity(3 * t + c, e) =
            -to_velocity * detail::monopole_slope(k, s.corner(t, c) - ears.col(e), s.normals.col(t));
  acoustics::BemOptions options;
  options.medium = air;
  options.allow_coarse = true;
  options.device = device;
  options.n_blas_threads = 1;  // the same bits on any number of threads
  const acoustics::BemResult result = data_->solver.solve(frequency_hz, velocity, options, monitor);
  if (device_message != nullptr) *device_message = result.device_message;
  if (!result.usable()) throw NumericalError("ear's field: " + result.message);
  MatrixXcd q = result.pressure_pa;
  for (Index e = 0; e < ears.cols(); ++e)
    for (Index v = 0; v < q.rows(); ++v) q(v, e) += detail::monopole(k, s.vertices_m.col(v) - ears.col(e));
  return q;
}

MatrixXcd EarElements::Carrier::operator()(const MatrixXcd& q) const {
  MatrixXcd result(static_cast<Index>(vertex.size()), q.cols());
  for (std::size_t v = 0; v < vertex.size(); ++v)
    result.row(static_cast<Index>(v)) =
        weight[v][0] * q.row(vertex[v][0]) + weight[v][1] * q.row(vertex[v][1]) + weight[v][2] * q.row(vertex[v][2]);
  return result;
}

EarElements::Carrier EarElements::carrier(const LiquidBoundary& boundary) const {
  return carrier(Eigen::Matrix3Xd(boundary.surface().vertices_m.transpose()));
}

EarElements::Carrier EarElements::carrier(const Eigen::Matrix3Xd& points_m) const {
  const auto n = static_cast<std::size_t>(points_m.cols());
  Carrier result{std::vector<std::array<int, 3>>(n, {0, 0, 0}), std::vector<std::array<double, 3>>(n, {1.0, 0.0, 0.0})};
  const acoustics::RadiatingSurface& s = data_->solver.surface();
  parallel_for(n, 16, [&](std::size_t begin, std::size_t end) {
    for (std::size_t v = begin; v < end; ++v) {
      const Vector3d x = points_m.col(static_cast<Index>(v));
      double best = HUGE_VAL;
      int nearest = 0;
      Vector3d at = x;
      for (int t = 0; t < s.n_triangles(); ++t) {
        const double reach = (x - s.centroids_m.col(t)).norm() - s.radii_m[t];
        if (reach > 0.0 && reach * reach >= best) continue;
        const Vector3d point = detail::closest_point(x, s.corner(t, 0), s.corner(t, 1), s.corner(t, 2));
        const double distance_sq = (point - x).squaredNorm();
        if (distance_sq < best) {
          best = distance_sq;
          nearest = t;
          at = point;
        }
      }
      const Vector3d a = s.corner(nearest, 0), b = s.corner(nearest, 1), c = s.corner(nearest, 2);
      const Vector3d normal = (b - a).cross(c - a);
      const double size = normal.squaredNorm(), u = (b - at).cross(c - at).dot(normal) / size,
                   w = (c - at).cross(a - at).dot(normal) / size;
      result.vertex[v] = {s.triangles(0, nearest), s.triangles(1, nearest), s.triangles(2, nearest)};
      result.weight[v] = {u, w, 1.0 - u - w};
    }
  });
  return result;
}

EarField ear_field(const LiquidBoundary& boundary, double frequency_hz, const std::vector<Vector3d>& ears_m,
                   const ReciprocalOptions& options, Monitor& monitor) {
  options.validate();
  checked("ear's field", "frequency_hz", frequency_hz, 1.0, 1e5);
  const Stopwatch lap;
  for (std::size_t i = 0; i < ears_m.size(); ++i)
    if (!ears_m[i].allFinite() || boundary.inside_air_boundary(ears_m[i]))
      throw InputError("listener " + std::to_string(i), "is not in the air around " + boundary.name());
  EarField result;
  result.frequency_hz = frequency_hz;
  const EarElements fine(boundary, options.air_vertices);
  result.n_elements = fine.n_elements();
  result.elements_per_wavelength = fine.elements_per_wavelength(frequency_hz, options.pass.air);
  result.q = fine.carrier(boundary)(
      fine.field(frequency_hz, ears_m, options.pass.air, monitor, options.device, &result.device_message));
  if (options.estimate_air) {
    monitor.throw_if_stopped();
    const EarElements coarse(boundary, std::max(fine.n_elements() / 8, 22));
    result.q_coarse =
        coarse.carrier(boundary)(coarse.field(frequency_hz, ears_m, options.pass.air, monitor, options.device));
  }
  result.wall_time_s = lap.seconds();
  return result;
}

EarInLiquid ear_in_liquid(const LiquidBoundary& boundary, const EarField& air, const SourcePoints& given_points,
                          const ReciprocalOptions& options, Monitor& monitor) {
  options.validate();
  monitor.throw_if_stopped();
  const SourcePoints points = detail::supported_points(boundary, given_points, options.pass.literature);
  const detail::LiquidSolver solver(boundary, air.frequency_hz, points, options.pass);
  const MatrixXcd data = ear_data(boundary, air, solver.weights());
  const detail::LiquidSolver::Solution solution = solver.solve(data);
  if (!solution.solved) throw NumericalError("the ear's field in the liquid: " + solution.message);
  EarInLiquid result;
  result.frequency_hz = air.frequency_hz;
  result.liquid_density_kg_m3 = options.pass.liquid.density_kg_m3;
  result.density_ratio = options.pass.air.density_kg_m3 / options.pass.liquid.density_kg_m3;
  result.field.wavenumber_per_m = solver.wavenumber_per_m();
  result.field.order = solver.order();
  result.field.points_m = solver.points_m();
  result.field.solid_m = points.solid_m;
  result.coefficients = solution.coefficients;
  for (Index e = 0; e < data.cols(); ++e) result.fit_error.push_back(solution.error.col(e).norm() / data.col(e).norm());
  result.wall_time_s = {{"air", air.wall_time_s}, {"assemble", solution.assemble_s}, {"solve", solution.solve_s}};
  return result;
}

Complex EarInLiquid::w(const Vector3d& x_m, std::size_t ear) const {
  const detail::FluidFunctions functions(field.wavenumber_per_m, field.order, field.points_m, field.solid_m);
  auto scratch = functions.scratch();
  Eigen::VectorXcd row(functions.size());
  functions.row(x_m, nullptr, scratch, row.data());
  return row.cwiseProduct(coefficients.col(static_cast<Index>(ear))).sum();
}

Complex EarInLiquid::pressure(const SwingingBubble& bubble, std::size_t ear) const {
  return density_ratio * bubble_source_strength(bubble.radius_m, frequency_hz, liquid_density_kg_m3) *
         w(bubble.position_m, ear);
}

std::vector<ReciprocalTransfer> checked_transfer(const LiquidBoundary& boundary, const EarField& air,
                                                 const EarInLiquid& liquid, const SourcePoints& given_points,
                                                 const SwingingBubble& bubble, const ReciprocalOptions& options) {
  boundary.check_bubble(bubble.position_m, 0.1 * bubble.radius_m);
  const SourcePoints points = detail::supported_points(boundary, given_points, options.pass.literature);
  const detail::LiquidSolver solver(boundary, air.frequency_hz, points, options.pass);
  const auto& samples = boundary.samples();
  const auto n = static_cast<Index>(samples.size());
  FluidField own = liquid.field;
  own.bubble_m = bubble.position_m;
  if (options.pass.images) detail::add_images(boundary, own);
  MatrixXcd data = MatrixXcd::Zero(n, 1);
  parallel_for(samples.size(), 256, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const BoundarySample& s = samples[i];
      const auto row = static_cast<Index>(i);
      if (s.region != BoundaryRegion::kDrySolid)
        data(row, 0) = -solver.weights()[row] * solver.incident_condition(own, s);
    }
  });
  const detail::LiquidSolver::Solution solution = solver.solve(data);
  if (!solution.solved) throw NumericalError("the bubble's own field: " + solution.message);

  // Per sample: the bubble's slope on the free surface and value on rigid parts; w there.
  const Index n_ears = air.q.cols();
  MatrixXcd correction = MatrixXcd::Zero(n, n_ears), change = MatrixXcd::Zero(n, n_ears);
  parallel_for(samples.size(), 32, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const BoundarySample& s = samples[i];
      const auto row = static_cast<Index>(i);
      if (s.region == BoundaryRegion::kDrySolid || !solver.counts(row)) continue;
      const bool free = s.region == BoundaryRegion::kFreeSurface;
      const Complex bubble_here = detail::incident(own, s.point_m, free ? &s.normal : nullptr) +
                                  solver.at_sample(s, free, solution.coefficients)[0];
      const Eigen::RowVectorXcd w = solver.at_sample(s, !free, liquid.coefficients).transpose();
      if (free) {
        correction.row(row) = -s.area_m2 * bubble_here * (w - air.q.row(s.vertex));
        if (air.q_coarse.size() != 0)
          change.row(row) = s.area_m2 * bubble_here * (air.q_coarse.row(s.vertex) - air.q.row(s.vertex));
      } else {
        const Complex give = solver.give(s);
        correction.row(row) = s.area_m2 * bubble_here * w;
        if (give != 0.0)
          correction.row(row) +=
              s.area_m2 * bubble_here * give * solver.at_sample(s, false, liquid.coefficients).transpose();
      }
    }
  });
  const double strength =
      liquid.density_ratio * bubble_source_strength(bubble.radius_m, liquid.frequency_hz, liquid.liquid_density_kg_m3);
  std::vector<ReciprocalTransfer> result(static_cast<std::size_t>(n_ears));
  for (Index e = 0; e < n_ears; ++e) {
    ReciprocalTransfer& one = result[static_cast<std::size_t>(e)];
    one.device_message = air.device_message;
    const Complex correct = strength * correction.col(e).sum();
    one.plain = liquid.pressure(bubble, static_cast<std::size_t>(e));
    one.pressure = one.plain + correct;
    one.error_liquid = std::abs(correct) / std::abs(one.pressure);
    if (air.q_coarse.size() != 0)
      one.error_air = std::abs(strength * change.col(e).sum()) / (3.0 * std::abs(one.pressure));
  }
  return result;
}

std::vector<std::vector<ReciprocalTransfer>> reciprocal_transfer(const LiquidBoundary& boundary, double frequency_hz,
                                                                 const SourcePoints& points,
                                                                 const BubblesAndEars& between,
                                                                 const ReciprocalOptions& options, Monitor& monitor) {
  const EarField air = ear_field(boundary, frequency_hz, between.ears_m, options, monitor);
  const EarInLiquid liquid = ear_in_liquid(boundary, air, points, options, monitor);
  std::vector<std::vector<ReciprocalTransfer>> result;
  for (const SwingingBubble& bubble : between.bubbles) {
    monitor.throw_if_stopped();
    checked("bubble", "radius_m", bubble.radius_m, 1e-6, 0.1);
    result.push_back(checked_transfer(boundary, air, liquid, points, bubble, options));
  }
  return result;
}

}  // namespace klang::bubble
