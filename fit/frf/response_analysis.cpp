#include "fit/frf/response_analysis.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/config/fields.hpp"
#include "fit/frf/detail/pole_estimators.hpp"
#include "fit/frf/detail/pole_polish.hpp"
#include "fit/ringdown/ringdown.hpp"

namespace klang::fit {
namespace {

using detail::OrderPoles;
using detail::Pole;
using Eigen::Index;

constexpr double kSameFrequency = 0.01, kSameDecay = 0.05;
constexpr std::size_t kMostModes = 40;

double hz_of(const Pole& pole) { return pole.imag() / (2 * std::numbers::pi); }

bool stable_after(const Pole& pole, const OrderPoles* before) {
  return before && std::any_of(before->poles.begin(), before->poles.end(), [&](const Pole& other) {
           return std::abs(other.imag() / pole.imag() - 1) < kSameFrequency &&
                  std::abs(other.real() / pole.real() - 1) < kSameDecay;
         });
}

std::vector<StabilityPole> stability_chart(const std::vector<OrderPoles>& orders) {
  std::vector<StabilityPole> chart;
  const OrderPoles* before = nullptr;
  for (const OrderPoles& order : orders) {
    for (const Pole& pole : order.poles)
      chart.push_back({order.order, hz_of(pole), -pole.real(), stable_after(pole, before)});
    before = &order;
  }
  return chart;
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Poles that stand in a chart: stable ones that lie together, at least four orders or a fifth of those that could hold them.
std::vector<Pole> standing(const std::vector<StabilityPole>& chart, int n_orders) {
  std::vector<StabilityPole> stable;
  std::copy_if(chart.begin(), chart.end(), std::back_inserter(stable), [](const StabilityPole& p) { return p.stable; });
  std::sort(stable.begin(), stable.end(),
            [](const StabilityPole& a, const StabilityPole& b) { return a.frequency_hz < b.frequency_hz; });
  const auto least = static_cast<std::size_t>(std::max(4, n_orders / 5));
  std::vector<Pole> poles;
  for (std::size_t first = 0; first < stable.size();) {
    std::size_t last = first + 1;
    const auto near = [&](const StabilityPole& a, const StabilityPole& b) {
      return 2 * std::numbers::pi * (b.frequency_hz - a.frequency_hz) <
             0.3 * std::min(a.decay_per_s, b.decay_per_s) + 6e-4 * a.frequency_hz;
    };
    while (last < stable.size() && near(stable[last - 1], stable[last])) ++last;
    if (last - first >= least) {
      std::vector<double> frequency, decay;
      for (std::size_t i = first; i < last; ++i)
        frequency.push_back(stable[i].frequency_hz), decay.push_back(stable[i].decay_per_s);
      poles.emplace_back(-median(decay), 2 * std::numbers::pi * median(frequency));
    }
    first = last;
  }
  return poles;
}

/// Of a chart: poles that stand in it. ERA's chart ends where the data hold no more poles: a short one is taken by its end.
std::vector<Pole> best_of(const std::string& estimator, const std::vector<OrderPoles>& chart) {
  constexpr std::size_t kShortChart = 8;
  if (chart.empty()) return {};
  if (estimator == "era" && chart.size() < kShortChart) return chart.back().poles;
  return standing(stability_chart(chart), static_cast<int>(chart.size()));
}

/// Decays from where they have begun.
ResponseSet after_strike(const ResponseSet& set) {
  const Eigen::RowVectorXd energy = set.values.cwiseAbs2().colwise().sum();
  Index first = 0;
  while (energy[first] < 0.05 * energy.maxCoeff()) ++first;
  ResponseSet cut = set;
  const Index n = set.n_lines() - first;
  cut.abscissa = set.abscissa.tail(n);
  cut.values = set.values.rightCols(n);
  return cut;
}

/// Steps of a set in time. @throws InputError where they are not even
double even_step_s(const ResponseSet& set) {
  const double step = (set.abscissa[set.n_lines() - 1] - set.abscissa[0]) / static_cast<double>(set.n_lines() - 1);
  for (Index i = 0; i < set.n_lines(); ++i) {
    if (std::abs(set.abscissa[i] - set.abscissa[0] - step * static_cast<double>(i)) > 0.02 * step)
      throw InputError(set.origin, "time_s is not even", to_text(set.abscissa[i]));
  }
  return step;
}

/// Every stride-th sample behind a low-pass (windowed sinc, only where all of it lies on the data: sums of exponentials stay such, and
/// what lies above the new band does not fold into it).
Eigen::MatrixXcd thinned(const Eigen::MatrixXcd& values, Index stride, Index most) {
  if (stride == 1) return values.leftCols(std::min(most, values.cols()));
  const Index half = std::min(8 * stride, (values.cols() - 1) / 4);
  Eigen::VectorXd tap(2 * half + 1);
  for (Index i = -half; i <= half; ++i) {
    const double x = static_cast<double>(i) / static_cast<double>(stride);
    const double sinc = i == 0 ? 1.0 : std::sin(std::numbers::pi * x) / (std::numbers::pi * x);
    const double t = static_cast<double>(i) / static_cast<double>(half + 1);
    tap[i + half] = sinc * (0.42 + 0.5 * std::cos(std::numbers::pi * t) + 0.08 * std::cos(2 * std::numbers::pi * t));
  }
  tap /= tap.sum();
  const Index n = std::min(most, (values.cols() - tap.size()) / stride + 1);
  Eigen::MatrixXcd thin(values.rows(), n);
  for (Index i = 0; i < n; ++i) thin.col(i) = values.middleCols(i * stride, tap.size()) * tap;
  return thin;
}

/// The charts of a set's estimators: the first is the stability chart.
struct Charts {
  std::vector<std::pair<std::string, std::vector<OrderPoles>>> all;
};

Charts charts_of(const ResponseSet& set, const ResponseOptions& options, Monitor& monitor) {
  constexpr Index kMostPulses = 2048;
  Charts charts;
  if (set.in_time) {
    const double step_s = even_step_s(set);
    // Long decays are thinned to twice the band, so that a matrix of some hundred samples sees their lowest partials turn.
    const double highest = std::min(options.band.high_hz, 0.5 / step_s);
    const Index stride = std::max<Index>(1, static_cast<Index>(std::floor(0.4 / (step_s * highest))));
    const Eigen::MatrixXcd pulses = thinned(set.values, stride, kMostPulses);
    const Band band{std::max(options.band.low_hz, 1e-3),
                    std::min(highest, 0.5 / (step_s * static_cast<double>(stride)))};
    charts.all.emplace_back(
        "era", detail::era_poles(pulses, step_s * static_cast<double>(stride), 0.0, band, options.most_order));
    return charts;
  }
  const detail::BandLines lines = detail::band_lines(set, options.band);
  const int most = std::min<int>(options.most_order, static_cast<int>(lines.values.cols() / 4) / 2 * 2);
  charts.all.emplace_back("lscf", detail::lscf_poles(lines, std::max(2, most)));
  monitor.progress("poles", 0.4);
  const double width_hz = lines.step_hz * static_cast<double>(lines.values.cols());
  charts.all.emplace_back("era", detail::era_poles(detail::pulse_responses(lines, kMostPulses), 1.0 / width_hz,
                                                   2 * std::numbers::pi * lines.first_hz,
                                                   {lines.first_hz, lines.first_hz + width_hz}, std::max(2, most)));
  return charts;
}

/// Whether the data carry a pole: its decay and frequency are known to less than its decay.
bool carried(const detail::PolishedPoles& fit, std::size_t k) {
  if (fit.covariance.size() == 0) return true;
  const auto i = static_cast<Index>(2 * k);
  const double decay = -fit.poles[k].real();
  return std::sqrt(std::max(0.0, fit.covariance(i, i))) < 0.3 * decay &&
         std::sqrt(std::max(0.0, fit.covariance(i + 1, i + 1))) < 0.3 * decay;
}

detail::PolishedPoles polished_modes(const ResponseSet& set, const Band& band, std::vector<Pole> start) {
  detail::PolishedPoles fit = detail::polished(set, band, start);
  for (int round = 0; round < 3; ++round) {
    std::vector<Pole> kept;
    for (std::size_t k = 0; k < fit.poles.size(); ++k) {
      const double hz = hz_of(fit.poles[k]);
      const bool twice = k > 0 && std::abs(fit.poles[k] - fit.poles[k - 1]) < 1e-3 * std::abs(fit.poles[k].real());
      if (carried(fit, k) && !twice && hz >= band.low_hz && hz <= band.high_hz) kept.push_back(fit.poles[k]);
    }
    if (kept.size() == fit.poles.size()) return fit;
    if (kept.empty()) return {};
    fit = detail::polished(set, band, kept);
  }
  return fit;
}

AnalysisPartial partial_of(const detail::PolishedPoles& fit, std::size_t k, const ResponseSet& set) {
  AnalysisPartial p;
  const auto i = static_cast<Index>(2 * k);
  const Pole pole = fit.poles[k];
  p.frequency_hz = hz_of(pole);
  p.decay_per_s = -pole.real();
  if (fit.covariance.size() > 0) {
    p.frequency_std_hz = std::sqrt(std::max(1e-300, fit.covariance(i + 1, i + 1))) / (2 * std::numbers::pi);
    p.decay_std_per_s = std::sqrt(std::max(1e-300, fit.covariance(i, i)));
  }
  const Eigen::VectorXcd residues = fit.residues.col(static_cast<Index>(k));
  Index loudest = 0;
  residues.cwiseAbs().maxCoeff(&loudest);
  std::complex<double> heard = 2.0 * residues[loudest];
  if (!set.in_time)
    for (int d = 0; d < set.derivative; ++d) heard *= pole;
  p.amplitude = std::abs(heard);
  p.phase_rad = std::arg(heard);
  for (const std::complex<double>& residue : residues) {
    const std::complex<double> share = residue / residues[loudest];
    p.shape.push_back({share.real(), share.imag()});
  }
  return p;
}

Eigen::VectorXcd vector_of(const AnalysisPartial& partial) {
  Eigen::VectorXcd shape(static_cast<Index>(partial.shape.size()));
  for (Index i = 0; i < shape.size(); ++i)
    shape[i] = {partial.shape[static_cast<std::size_t>(i)][0], partial.shape[static_cast<std::size_t>(i)][1]};
  return shape;
}

/// What the other estimators say of each partial: the standing pole nearest to it, within its own decay.
void add_estimates(const std::string& name, const std::vector<Pole>& poles, ResponseAnalysis& result) {
  for (std::size_t k = 0; k < result.partials.size(); ++k) {
    const AnalysisPartial& partial = result.partials[k];
    const Pole here(-*partial.decay_per_s, 2 * std::numbers::pi * partial.frequency_hz);
    const Pole* nearest = nullptr;
    for (const Pole& pole : poles)
      if (!nearest || std::abs(pole - here) < std::abs(*nearest - here)) nearest = &pole;
    if (!nearest || std::abs(*nearest - here) > 2 * *partial.decay_per_s + 1e-3 * here.imag()) continue;
    result.record.estimates.push_back({static_cast<int>(k), name, hz_of(*nearest), -nearest->real()});
    const double off = std::abs(nearest->imag() - here.imag());
    if (off > std::max(0.5 * *partial.decay_per_s, 2e-4 * here.imag()))
      result.warnings.push_back("estimators disagree: " + to_text(std::round(100 * partial.frequency_hz) / 100) +
                                " Hz is " + to_text(std::round(100 * hz_of(*nearest)) / 100) + " Hz by " + name);
  }
}

void add_ringdown(const ResponseSet& set, const Band& band, ResponseAnalysis& result) {
  if (set.n_responses() > kMaxChannels) return;
  audio::Signal signal;
  signal.sample_rate_hz = 1.0 / even_step_s(set);
  signal.samples = set.values.real().transpose() / set.values.cwiseAbs().maxCoeff();
  std::vector<Pole> poles;
  try {
    RingdownOptions options;
    options.band = {band.low_hz, std::min(band.high_hz, 0.48 * signal.sample_rate_hz)};
    for (const Partial& p : identify_ringdown(signal, options).partials.partials)
      if (p.decay_per_s) poles.emplace_back(-*p.decay_per_s, 2 * std::numbers::pi * p.frequency_hz);
  } catch (const InputError&) {
    return;  // made for sounds: not every decay is one
  }
  add_estimates("ringdown", poles, result);
}

}  // namespace

void ResponseOptions::validate() const {
  std::vector<Violation> violations = violations_of(*this);
  if (!(band.high_hz > band.low_hz))
    violations.push_back(out_of_range("band.high_hz", band.high_hz, inside(band.low_hz, 1e12)));
  throw_violations("responses", std::move(violations));
}

double assurance(const Eigen::VectorXcd& a, const Eigen::VectorXcd& b) {
  const double size = a.squaredNorm() * b.squaredNorm();
  return size > 0 ? std::norm(a.dot(b)) / size : 0.0;
}

namespace {

/// The responses' rms over frequency, in so few points as a page shows.
void add_curve(const ResponseSet& set, const Band& band, ResponseRecord& record) {
  constexpr Index kMost = 600;
  const Index n = set.n_lines(), per_point = (n + kMost - 1) / kMost;
  for (Index first = 0; first < n; first += per_point) {
    const Index count = std::min(per_point, n - first);
    Index at = 0;
    const double square = set.values.middleCols(first, count).colwise().squaredNorm().maxCoeff(&at);
    const double hz = set.abscissa[first + at];
    if (hz < band.low_hz || hz > band.high_hz || !(square > 0.0)) continue;
    record.curve_hz.push_back(hz);
    record.curve_db.push_back(0.01 * std::round(1000.0 * std::log10(square / static_cast<double>(set.n_responses()))));
  }
}

}  // namespace

ResponseAnalysis analyse_responses(const ResponseSet& given, const ResponseOptions& options, Monitor& monitor) {
  options.validate();
  const ResponseSet set = given.in_time ? after_strike(given) : given;
  if (set.n_lines() < 16) throw InputError(set.origin, "fewer than 16 samples after the strike");
  ResponseAnalysis result;
  result.warnings = given.warnings;
  result.record.kind = set.in_time ? ResponseKind::kDecay : ResponseKind::kFrf;
  result.record.unit = set.unit;
  for (const ResponsePoint& point : set.points) result.record.places.push_back({point.node, point.direction});
  if (!set.in_time) add_curve(set, options.band, result.record);
  monitor.progress("poles", 0.0);
  const Charts charts = charts_of(set, options, monitor);
  monitor.throw_if_stopped();
  const std::vector<OrderPoles>& first_chart = charts.all.front().second;
  result.record.stability = stability_chart(first_chart);
  std::vector<Pole> start = best_of(charts.all.front().first, first_chart);
  if (start.empty()) {
    result.status = ResponseStatus::kNothingFound;
    result.message = "no pole stands in the stability chart: nothing rings in this band above the noise";
    return result;
  }
  if (start.size() > kMostModes) {
    result.warnings.push_back("the lowest " + std::to_string(kMostModes) + " of " + std::to_string(start.size()) +
                              " poles are taken: narrow the band");
    start.resize(kMostModes);
  }
  monitor.progress("poles", 0.6);
  const detail::PolishedPoles fit = polished_modes(set, options.band, start);
  if (fit.poles.empty()) {
    result.status = ResponseStatus::kNothingFound;
    result.message = "the data carry no pole of this band: each is less sure than its own decay";
    return result;
  }
  if (!fit.converged) result.warnings.push_back("the poles' least squares have not converged: take them with care");
  result.explained_energy = fit.explained;
  for (std::size_t k = 0; k < fit.poles.size(); ++k) result.partials.push_back(partial_of(fit, k, set));
  std::sort(result.partials.begin(), result.partials.end(),
            [](const AnalysisPartial& a, const AnalysisPartial& b) { return a.frequency_hz < b.frequency_hz; });
  if (!(fit.explained >= kLeastExplained)) {
    result.status = ResponseStatus::kNothingFound;
    result.message = "the poles found explain less than " + to_text(100 * kLeastExplained) + " % of the responses";
    return result;
  }
  if (fit.explained < kMostlyExplained)
    result.warnings.insert(result.warnings.begin(), "the poles explain " +
                                                        to_text(std::round(1000 * fit.explained) / 10) +
                                                        " % of the responses: the rest is not explained");
  std::vector<Pole> refined;
  for (const AnalysisPartial& p : result.partials)
    refined.emplace_back(-*p.decay_per_s, 2 * std::numbers::pi * p.frequency_hz);
  add_estimates("least_squares", refined, result);
  for (const auto& [name, chart] : charts.all) add_estimates(name, best_of(name, chart), result);
  if (set.in_time) add_ringdown(set, options.band, result);
  for (const AnalysisPartial& a : result.partials) {
    std::vector<double> row;
    for (const AnalysisPartial& b : result.partials) row.push_back(assurance(vector_of(a), vector_of(b)));
    result.record.auto_mac.push_back(row);
  }
  result.status = ResponseStatus::kOk;
  return result;
}

void compare_with_model(const ResponseSet& set, const modal::ModalModel& model, ResponseAnalysis& analysis) {
  const Eigen::RowVector3d size = model.mesh.nodes_m.colwise().maxCoeff() - model.mesh.nodes_m.colwise().minCoeff();
  Eigen::MatrixXcd shapes(set.n_responses(), model.n_modes());
  for (Index i = 0; i < set.n_responses(); ++i) {
    const ResponsePoint& point = set.points[static_cast<std::size_t>(i)];
    const auto node = set.nodes_m.find(point.node);
    if (node == set.nodes_m.end() || point.direction == 0)
      throw InputError(set.origin, "does not say where and in which direction a response was measured",
                       "node " + std::to_string(point.node),
                       "datasets 15 or 2411 and response directions; in MATLAB files points_m and direction");
    Index nearest = 0;
    const double away =
        std::sqrt((model.mesh.nodes_m.rowwise() - node->second.transpose()).rowwise().squaredNorm().minCoeff(&nearest));
    if (!(away <= 0.05 * size.maxCoeff()))
      throw InputError(set.origin, "a place lies outside the model", "node " + std::to_string(point.node),
                       "within 5 % of the body's size of its mesh, in the same axes");
    const int axis = std::abs(point.direction) - 1;
    shapes.row(i) =
        (model.shapes.row(3 * nearest + axis) * (point.direction > 0 ? 1.0 : -1.0)).cast<std::complex<double>>();
  }
  const Eigen::VectorXd hz = model.frequency_hz();
  analysis.record.model_hz.assign(hz.begin(), hz.end());
  for (AnalysisPartial& partial : analysis.partials) {
    const Eigen::VectorXcd measured = vector_of(partial);
    std::vector<double> row;
    for (Index j = 0; j < shapes.cols(); ++j) row.push_back(assurance(measured, shapes.col(j)));
    partial.model_mode = static_cast<int>(std::max_element(row.begin(), row.end()) - row.begin());
    analysis.record.mac.push_back(std::move(row));
  }
}

}  // namespace klang::fit
