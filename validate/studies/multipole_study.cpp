#include <cmath>
#include <cstdio>
#include <memory>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/parallel.hpp"
#include "core/foundation/base/stopwatch.hpp"
#include "core/foundation/math/sphere_quadrature.hpp"
#include "core/sound/bem/equivalent_sources.hpp"
#include "core/sound/waves/helmholtz_basis.hpp"
#include "core/sound/waves/multipole.hpp"
#include "validate/studies/detail/pressure_slice.hpp"
#include "validate/studies/registry.hpp"

namespace klang::validate {
namespace {

using acoustics::Multipole;
using Complex = std::complex<double>;

constexpr double kDistance_m = 0.1;  ///< of the monopole from the expansion's centre
constexpr int kHighestOrder = 60;
const Eigen::Vector3d kPlace_m = kDistance_m * Eigen::Vector3d(0.6, 0.0, 0.8);

/// p = e^{-ikR} / (4 pi R) of a monopole at kPlace_m, Pa at 1 m times 4 pi.
Complex monopole_pa(double k, const Eigen::Vector3d& x) {
  const double distance = (x - kPlace_m).norm();
  return std::polar(1.0 / (4.0 * kPi * distance), -k * distance);
}

/// Its exact coefficients about the origin: G = -ik sum S_n^m(x) conj(R_n^m(y)).
Multipole expansion(double k, int order) {
  Eigen::VectorXcd regular;
  acoustics::HelmholtzBasis(order).values(acoustics::Wave::kRegular, k, kPlace_m, regular);
  return {Eigen::Vector3d::Zero(), k, order, Complex(0.0, -k) * regular.conjugate()};
}

/// rms error of the truncated series over the sphere |x| = radius, relative, for each order in orders.
std::vector<double> truncation_errors(double k, double radius_m, const std::vector<int>& orders) {
  const int highest = orders.back();
  const Multipole series = expansion(k, highest);
  const SphereQuadrature rule = sphere_quadrature(2 * highest + 20);
  const auto n = static_cast<std::size_t>(rule.directions.cols());
  Eigen::MatrixXd squares =
      Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(n), static_cast<Eigen::Index>(orders.size()) + 1);
  parallel_for(n, 64, [&](std::size_t begin, std::size_t end) {
    const acoustics::HelmholtzBasis basis(highest);
    Eigen::VectorXcd values;
    for (std::size_t q = begin; q < end; ++q) {
      const auto row = static_cast<Eigen::Index>(q);
      const Eigen::Vector3d x = radius_m * rule.directions.col(row);
      basis.values(acoustics::Wave::kSingular, k, x, values);
      const Complex exact = monopole_pa(k, x);
      squares(row, 0) = rule.weights[row] * std::norm(exact);
      for (std::size_t i = 0; i < orders.size(); ++i) {
        const Eigen::Index m = acoustics::basis_size(orders[i]);
        const Complex p = (values.head(m).array() * series.coefficients_pa.head(m).array()).sum();
        squares(row, static_cast<Eigen::Index>(i) + 1) = rule.weights[row] * std::norm(p - exact);
      }
    }
  });
  std::vector<double> errors;
  for (std::size_t i = 0; i < orders.size(); ++i)
    errors.push_back(std::sqrt(squares.col(static_cast<Eigen::Index>(i) + 1).sum() / squares.col(0).sum()));
  return errors;
}

double lost_power(double kd, int order) {
  const Multipole whole = expansion(kd / kDistance_m, kHighestOrder);
  const acoustics::Medium air;
  return 1.0 -
         acoustics::radiated_power_w(acoustics::truncated(whole, order), air) / acoustics::radiated_power_w(whole, air);
}

// Independent values of the lost power of SB's order max(kL/4, 4) and of the orders that 1 % and 1e-4 take.
struct Truncation {
  double kd;
  int paper_order;
  double lost_fraction;
  int order_for_1_percent, order_for_1e_4;
};
constexpr Truncation kTruncations[] = {{1.0, 4, 9.491258693522482e-08, 2, 3},
                                       {2.0, 4, 7.866187731719792e-05, 3, 4},
                                       {5.0, 4, 0.16082704154668712, 6, 8},
                                       {10.0, 5, 0.8030080713315463, 11, 14},
                                       {20.0, 10, 0.8248489824407119, 22, 25}};

void add_truncation_claims(Study& study) {
  for (const Truncation& row : kTruncations) {
    char kd[16];
    std::snprintf(kd, sizeof kd, "kd%g", row.kd);
    char words[160];
    acoustics::OrderOptions paper;
    paper.paper_rule = true;
    const int order = acoustics::lowest_order(row.kd, paper);
    std::snprintf(words, sizeof words, "Power lost by the paper’s order %d at ka = %g", order, row.kd);
    study.claims.push_back(judged({std::string(kd) + ".lost-power",
                                   words,
                                   lost_power(row.kd, order),
                                   row.lost_fraction,
                                   1e-9 + 1e-6 * row.lost_fraction,
                                   {},
                                   false}));
    for (const auto& [fraction, wanted_order, name] :
         {std::tuple{1e-2, row.order_for_1_percent, "1 %"}, std::tuple{1e-4, row.order_for_1e_4, "0.01 %"}}) {
      int needed = 0;
      while (needed < kHighestOrder && !(lost_power(row.kd, needed) <= fraction)) ++needed;
      std::snprintf(words, sizeof words, "Order that loses %s of the power at ka = %g", name, row.kd);
      study.claims.push_back(judged({std::string(kd) + (fraction < 1e-3 ? ".order-1e-4" : ".order-1e-2"),
                                     words,
                                     static_cast<double>(needed),
                                     static_cast<double>(wanted_order),
                                     0.0,
                                     {},
                                     false}));
    }
  }
}

/// The monopole's field on a sphere around it: Neumann data of a body that is not centred on its source.
acoustics::SurfaceField surface_field(double k, double radius_m, const acoustics::Medium& medium) {
  const SphereQuadrature rule = sphere_quadrature(70);
  acoustics::SurfaceField field;
  field.normals = rule.directions;
  field.points_m = radius_m * rule.directions;
  field.weights_m2 = radius_m * radius_m * rule.weights;
  field.pressure_pa.resize(rule.directions.cols());
  field.normal_velocity_m_s.resize(rule.directions.cols());
  const double omega = k * medium.sound_speed_m_s;
  for (Eigen::Index i = 0; i < rule.directions.cols(); ++i) {
    const Eigen::Vector3d x = field.points_m.col(i), r = x - kPlace_m;
    const Complex p = monopole_pa(k, x);
    const Complex slope = p * (Complex(0.0, -k) - 1.0 / r.norm()) * r.normalized().dot(field.normals.col(i));
    field.pressure_pa[i] = p;
    field.normal_velocity_m_s[i] = slope * Complex(0.0, 1.0) / (omega * medium.density_kg_m3);
  }
  return field;
}

void add_coefficient_series(const StudyOptions& options, Study& study, Monitor& monitor) {
  const double k = 5.0 / kDistance_m, radius_m = 1.5 * kDistance_m;
  const acoustics::Medium air;
  const acoustics::SurfaceField field = surface_field(k, radius_m, air);
  const Multipole whole{Eigen::Vector3d::Zero(), k, 30,
                        acoustics::multipole_coefficients(field, k, air, Eigen::Vector3d::Zero(), 30)};
  const auto series = [&](const char* id, const char* title) {
    Series s;
    s.id = id;
    s.title = title;
    s.reference = "the monopole’s far field";
    s.step_words = "number of coefficients";
    s.error_words = "root-mean-square error of the far field, relative";
    s.error_tolerance = 2.0;
    s.expected_order = std::nan("");  // faster than any power
    s.counts = false;
    return s;
  };
  const SphereQuadrature far = sphere_quadrature(60);
  if (wanted(options, "coefficients-one-point")) {
    Series one = series("coefficients-one-point", "One point, rising order (ka = 7.5)");
    const std::vector<int> orders = {1, 3, 5, 7, 9, 11, 13};
    for (std::size_t i = 0; i < level_count(options, orders.size()); ++i) {
      monitor.throw_if_stopped();
      Multipole part{Eigen::Vector3d::Zero(), k, orders[i],
                     whole.coefficients_pa.head(acoustics::basis_size(orders[i]))};
      double error = 0.0, all = 0.0;
      for (Eigen::Index q = 0; q < far.directions.cols(); ++q) {
        const Eigen::Vector3d s = far.directions.col(q);
        const Complex exact = std::polar(1.0 / (4.0 * kPi), k * s.dot(kPlace_m));
        error += far.weights[q] * std::norm(acoustics::far_field_pa_m(part, s) - exact);
        all += far.weights[q] * std::norm(exact);
      }
      Level level;
      level.n = static_cast<double>(acoustics::basis_size(orders[i]));
      level.error = std::sqrt(error / all);
      level.n_unknowns = *level.n;
      one.levels.push_back(level);
    }
    study.series.push_back(std::move(one));
  }
  if (wanted(options, "coefficients-many-points")) {
    Series many = series("coefficients-many-points", "Equivalent sources at many points, order 1 (ka = 7.5)");
    const std::vector<int> counts = {1, 4, 9, 16, 25, 36, 49};
    for (std::size_t i = 0; i < level_count(options, counts.size()); ++i) {
      monitor.throw_if_stopped();
      monitor.progress("equivalent sources", static_cast<double>(i) / static_cast<double>(counts.size()));
      const auto fit = acoustics::fit_equivalent_sources(field, k, air, acoustics::inner_points(field, counts[i]), {});
      Level level;
      level.n = 4.0 * counts[i];
      level.error = fit.far_field_error.value_or(std::nan(""));
      level.n_unknowns = *level.n;
      many.levels.push_back(level);
    }
    study.series.push_back(std::move(many));
  }
}

SliceField slice_of(double k, int order, const char* name, const std::string& title, const std::string& caption) {
  const Multipole series = expansion(k, std::max(order, 0));
  const bool exact = order < 0;
  SliceField slice = detail::pressure_slice(3.0 * kDistance_m, 512, [&]() -> detail::PointValue {
    auto basis = std::make_shared<acoustics::HelmholtzBasis>(series.order);
    auto values = std::make_shared<Eigen::VectorXcd>();
    return [&, basis, values](const Eigen::Vector3d& x) {
      if (x.norm() <= kDistance_m) return std::nan("");  // the series holds outside only
      const Complex p = monopole_pa(k, x);
      if (exact) return std::min(std::abs(p), 1.0 / (4.0 * kPi * 0.25 * kDistance_m));
      basis->values(acoustics::Wave::kSingular, k, x, *values);
      return std::abs((values->array() * series.coefficients_pa.array()).sum() - p) / std::abs(p);
    };
  });
  slice.name = name;
  slice.title = title;
  slice.caption = caption;
  slice.decibels = exact;
  if (!exact) slice.quantity = "relative_error", slice.floor = 1e-4;
  return slice;
}

void add_fields(Study& study) {
  const double k = 10.0 / kDistance_m;
  study.fields.slices.push_back(slice_of(
      k, -1, "pressure", "|p| of a monopole off the centre, ka = 10",
      "Exact, in dB re the level a quarter of a away from the source, which the grey ball (|x| ≤ a) touches."));
  study.fields.slices.push_back(slice_of(k, 5, "error-paper-order", "Relative error, the paper’s order 5",
                                         "|p − exact| / |p|: SB section 4 takes order max(kL/4, 4)."));
  study.fields.slices.push_back(
      slice_of(k, 14, "error-order-14", "Relative error, order 14",
               "The order that loses 0.01 % of the power; near the source the series converges slowly."));
  for (const auto& [order, name] : {std::pair{5, "directivity-paper-order"}, std::pair{14, "directivity-order-14"}}) {
    const Multipole series = expansion(k, order);
    BalloonField field = detail::balloon(
        [&, s = &series](const Eigen::Vector3d& d) { return std::abs(acoustics::far_field_pa_m(*s, d)); });
    field.name = name;
    field.title = "Directivity at order " + std::to_string(order) + ", ka = 10";
    field.caption =
        "The true one is a ball: a monopole is equally loud in all directions. 30 dB from the unit ball to its centre.";
    study.fields.balloons.push_back(std::move(field));
  }
}

}  // namespace

/// Multipole series of a source off the centre: error over the order, lost power, and equivalent sources beside it.
Study multipole_study(const StudyOptions& options, Monitor& monitor) {
  Study study;
  study.title = "Truncation of multipole series";
  study.question =
      "How many orders does the field of a source off the centre take? A monopole at distance a from the expansion’s "
      "centre, "
      "compared on a sphere of twice that radius: once the order exceeds k r the error must fall by a / r = 1/2 an "
      "order "
      "(rate ln 2 = 0.693), and before that nothing is gained.";
  struct Plan {
    const char* id;
    const char* title;
    double kd;
    std::vector<int> orders;
    double error_tolerance;
  };
  const std::vector<Plan> plans = {{"kd5", "Monopole off the centre, ka = 5", 5.0, {16, 20, 24, 28, 32, 36}, 1e-11},
                                   {"kd1", "Monopole off the centre, ka = 1", 1.0, {6, 10, 14, 18, 22, 26}, 5e-9},
                                   {"kd10", "Monopole off the centre, ka = 10", 10.0, {28, 32, 36, 40, 44, 48}, 1e-13}};
  for (std::size_t p = 0; p < plans.size(); ++p) {
    const Plan& plan = plans[p];
    if (!wanted(options, plan.id)) continue;
    monitor.throw_if_stopped();
    monitor.progress("multipoles", static_cast<double>(p) / static_cast<double>(plans.size() + 2));
    const std::vector<int> orders(plan.orders.begin(), plan.orders.begin() + static_cast<std::ptrdiff_t>(level_count(
                                                                                 options, plan.orders.size())));
    Series series;
    series.id = plan.id;
    series.title = plan.title;
    series.reference = "e^{−ikR} / 4πR in closed form";
    series.step_words = "order of the expansion";
    series.error_words = "root-mean-square error at r = 2 a, relative";
    series.kind = Convergence::kGeometric;
    series.expected_order = std::log(2.0);
    series.order_tolerance = 0.1;
    series.error_floor = 1e-13;
    series.floor_words = "round-off";
    series.error_tolerance = plan.error_tolerance * std::pow(2.0, plan.orders.back() - orders.back());
    const Stopwatch watch;
    const std::vector<double> errors = truncation_errors(plan.kd / kDistance_m, 2.0 * kDistance_m, orders);
    const double seconds = watch.seconds();
    for (std::size_t i = 0; i < orders.size(); ++i) {
      Level level;
      level.n = orders[i];
      level.error = errors[i];
      level.n_unknowns = static_cast<double>(acoustics::basis_size(orders[i]));
      level.wall_time_s = seconds / static_cast<double>(orders.size());
      series.levels.push_back(level);
    }
    study.series.push_back(std::move(series));
  }
  add_coefficient_series(options, study, monitor);
  monitor.throw_if_stopped();
  if (options.only.empty()) add_truncation_claims(study);
  if (options.fields && options.only.empty()) add_fields(study);
  return study;
}

}  // namespace klang::validate
