#include "fit/proxy/proxy_search.hpp"

#include <ceres/ceres.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/parallel.hpp"
#include "core/foundation/base/random.hpp"
#include "core/foundation/config/fields.hpp"
#include "fit/least_squares/least_squares.hpp"
#include "fit/proxy/proxy_cost.hpp"

namespace klang::fit {
namespace {

constexpr int kRefined = 12;         // minima of the grid that Ceres refines
constexpr double kPenalty = 4.0;     // of ln(measure) against ln(cents)
constexpr double kHard = 0.6;        // of the start's cents
constexpr std::size_t kParents = 8;  // of each kind

class Search {
 public:
  Search(const ProxyModel& model, const TargetSound& target, const ProxyStart& start, const ProxySearchOptions& options,
         Monitor& monitor)
      : model_(model), target_(target), start_(start), options_(options), monitor_(monitor) {}
  ProxySearchResult run();

 private:
  struct Guess {
    ProxyPoint point;
    double cents = 0.0;
  };
  std::vector<Guess> scan() const;
  ProxyPoint refined(ProxyPoint point, bool keep_lowest) const;
  void hear(const std::vector<Guess>& guesses);
  std::vector<Guess> children(int generation) const;
  double limit_cents() const { return result_.best ? result_.best->cents : start_.errors.partial_rms_cents; }

  const ProxyModel& model_;
  const TargetSound& target_;
  const ProxyStart& start_;
  const ProxySearchOptions& options_;
  Monitor& monitor_;
  std::vector<ProxyCandidate> heard_;
  ProxySearchResult result_;
};

ProxyPoint Search::refined(ProxyPoint p, bool keep_lowest) const {
  std::array<double, 2> square{p.s, p.t};
  ceres::Problem problem;
  const auto add = [&](std::vector<double> hz, double weight) {
    problem.AddResidualBlock(
        proxy_frequency_cost(model_.first_frequencies(), std::move(hz), model_.shear_speed_m_s()).release(),
        new ceres::ScaledLoss(nullptr, weight, ceres::TAKE_OWNERSHIP), square.data(), &p.ln_scale);
  };
  add(model_.target_hz(), 1.0);
  if (keep_lowest) add({model_.target_hz().front()}, 1e4);
  for (int i = 0; i < 2; ++i) {
    problem.SetParameterLowerBound(square.data(), i, 0.0);
    problem.SetParameterUpperBound(square.data(), i, 1.0);
  }
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_QR;
  options.max_num_iterations = 60;
  least_squares(options, problem);
  p.s = square[0];
  p.t = square[1];
  return p;
}

/// Guesses with fewer cents than the start: of each part of the square and each kind of scale the best, by rising cents.
std::vector<Search::Guess> Search::scan() const {
  const int n = options_.grid, parts = options_.parts, n_kinds = 1 + 2 * std::min(4, model_.n_partials());
  std::vector<std::vector<Guess>> rows(static_cast<std::size_t>(n));  // by s; guesses by kind and t
  parallel_for(static_cast<std::size_t>(n), 1, [&](std::size_t begin, std::size_t end) {
    std::vector<double> ratios;
    for (std::size_t i = begin; i < end; ++i)
      for (int j = 0; j < n; ++j) {
        const double s = (static_cast<double>(i) + 0.5) / n, t = (j + 0.5) / n;
        model_.log_ratios(s, t, ratios);
        double mean = 0.0;
        for (const double ratio : ratios) mean += ratio / static_cast<double>(ratios.size());
        for (int kind = 0; kind < n_kinds; ++kind) {
          Guess guess{{s, t, mean, 1.0, 1.0, {}}, HUGE_VAL};
          if (kind == 1)
            guess.point.refitted_mass = guess.point.refitted_stiffness =
                0.0;  // what sounds longest and loudest stays as it is
          if (kind > 0 && !ratios.empty()) {
            const double aligned = ratios[static_cast<std::size_t>((kind - 1) / 2)];
            guess.point.ln_scale = kind % 2 == 1 ? aligned : 0.5 * (aligned + mean);
          }
          if (!ratios.empty()) guess.cents = model_.rms_cents(guess.point);
          rows[i].push_back(guess);
        }
      }
  });
  const auto at = [&](int i, int j, int kind) -> const Guess& {
    return rows[static_cast<std::size_t>(i)][static_cast<std::size_t>(j * n_kinds + kind)];
  };
  std::vector<Guess> minima, guesses;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) {
      bool lowest = std::isfinite(at(i, j, 0).cents);
      for (int a = std::max(i - 1, 0); a <= std::min(i + 1, n - 1); ++a)
        for (int b = std::max(j - 1, 0); b <= std::min(j + 1, n - 1); ++b)
          lowest = lowest && at(i, j, 0).cents <= at(a, b, 0).cents;
      if (lowest) minima.push_back(at(i, j, 0));
    }
  const auto by_cents = [](const Guess& a, const Guess& b) { return a.cents < b.cents; };
  std::stable_sort(minima.begin(), minima.end(), by_cents);
  if (minima.size() > kRefined) minima.resize(kRefined);
  std::vector<Guess> fine(2 * minima.size());
  parallel_for(fine.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      fine[k].point = refined(minima[k / 2].point, k % 2 == 1);
      if (k % 2 == 1) fine[k].point.refitted_mass = fine[k].point.refitted_stiffness = 0.0;
      fine[k].cents = model_.rms_cents(fine[k].point);
    }
  });
  guesses = fine;
  const auto add = [&](const Guess& guess) {
    if (!(guess.cents < start_.errors.partial_rms_cents)) return;
    guesses.push_back(guess);
    // Kept damping and the best fit to all: each has bodies where only it is admissible.
    guesses.push_back(guess);
    for (double* refitted : {&guesses.back().point.refitted_mass, &guesses.back().point.refitted_stiffness})
      *refitted = 1.0 - *refitted;
  };
  for (int kind = 0; kind < n_kinds; ++kind)
    for (int a = 0; a < parts; ++a)
      for (int b = 0; b < parts; ++b) {
        Guess best{{}, HUGE_VAL};
        for (int i = a * n / parts; i < (a + 1) * n / parts; ++i)
          for (int j = b * n / parts; j < (b + 1) * n / parts; ++j)
            if (at(i, j, kind).cents < best.cents) best = at(i, j, kind);
        add(best);
      }
  std::erase_if(guesses, [&](const Guess& g) { return !(g.cents < start_.errors.partial_rms_cents); });
  std::stable_sort(guesses.begin(), guesses.end(), by_cents);
  const std::size_t n_scan = std::min(guesses.size(), static_cast<std::size_t>(options_.n_scan));
  // All the way up to the start's cents, the lowest ones more densely.
  std::vector<Guess> chosen;
  for (std::size_t k = 0; k < n_scan; ++k) {
    const double x = static_cast<double>(k) / static_cast<double>(n_scan);
    const auto rank = static_cast<std::size_t>(x * x * static_cast<double>(guesses.size()));
    chosen.push_back(guesses[std::max(rank, k)]);
  }
  return chosen;
}

void Search::hear(const std::vector<Guess>& guesses) {
  std::vector<ProxyCandidate> found(guesses.size());
  parallel_for(guesses.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      found[i].point = guesses[i].point;
      found[i].cents = guesses[i].cents;
      found[i].damping = model_.damping(guesses[i].point, start_.damping);
      found[i].level = target_.at_level(model_.voice(guesses[i].point, found[i].damping), start_.errors,
                                        guesses[i].point.level, start_.gain);
      found[i].point.level = found[i].level.level;
    }
  });
  for (ProxyCandidate& candidate : found) {
    ++result_.n_heard;
    if (!std::isfinite(candidate.level.excess)) continue;
    if (!candidate.level.rough) {
      const std::array<bool, 5> worse = worse_measures(candidate.level.errors, start_.errors);
      for (std::size_t m = 0; m < worse.size(); ++m) result_.n_worse[m] += worse[m] ? 1 : 0;
    }
    if (candidate.admissible()) {
      ++result_.n_admissible;
      if (candidate.cents < limit_cents()) result_.best = candidate;
    }
    heard_.push_back(std::move(candidate));
  }
}

std::vector<Search::Guess> Search::children(int generation) const {
  std::vector<std::size_t> order(heard_.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  const double progress = std::min(1.0, static_cast<double>(generation) / std::max(options_.n_generations, 1));
  // Of each kind the best that lie apart: the admissible ones are islands, and one valley must not take all places.
  const double apart = 0.08 * std::pow(0.1, progress);
  std::vector<std::size_t> parents;
  const auto take = [&](const auto& worth) {
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return worth(heard_[a]) < worth(heard_[b]); });
    const std::size_t first = parents.size();
    for (std::size_t k = 0; k < order.size() && parents.size() < first + kParents; ++k) {
      const ProxyPoint& p = heard_[order[k]].point;
      const bool alone =
          std::none_of(parents.begin() + static_cast<std::ptrdiff_t>(first), parents.end(), [&](std::size_t other) {
            const ProxyPoint& q = heard_[other].point;
            return std::hypot(p.s - q.s, p.t - q.t) < apart && std::abs(p.ln_scale - q.ln_scale) < apart;
          });
      if (alone) parents.push_back(order[k]);
    }
  };
  take([](const ProxyCandidate& c) { return std::log(c.cents) + kPenalty * c.level.excess; });
  take([](const ProxyCandidate& c) { return 0.1 * std::log(c.cents) + c.level.excess; });
  take([](const ProxyCandidate& c) { return c.admissible() ? std::log(c.cents) : HUGE_VAL; });
  RandomStream random(options_.seed, static_cast<std::uint64_t>(generation));
  std::vector<Guess> guesses;
  const int n_tries = 200 * options_.n_children;
  for (int i = 0; i < n_tries && static_cast<int>(guesses.size()) < options_.n_children; ++i) {
    const ProxyCandidate& parent = heard_[parents[random.below(static_cast<std::uint32_t>(parents.size()))]];
    // From a tenth of the square down to a thousandth, every size at any time, smaller ones more and more.
    const double width = std::pow(10.0, -1.0 - 2.0 * random.uniform() * std::sqrt(progress));
    Guess child{parent.point, 0.0};
    child.point.s = std::clamp(child.point.s + width * random.normal(), 0.0, 1.0);
    child.point.t = std::clamp(child.point.t + width * random.normal(), 0.0, 1.0);
    // Half of them keep the parent's lowest partial where it is, or move it by a little.
    std::vector<double> old_ratios, ratios;
    model_.log_ratios(parent.point.s, parent.point.t, old_ratios);
    model_.log_ratios(child.point.s, child.point.t, ratios);
    if (ratios.empty()) continue;
    const std::size_t anchor =
        random.uniform() < 0.5 ? 0 : random.below(static_cast<std::uint32_t>(std::min<std::size_t>(4, ratios.size())));
    child.point.ln_scale += ratios[anchor] - old_ratios[anchor];
    if (random.uniform() < 0.5) child.point.ln_scale += 0.3 * width * random.normal();
    const auto shaken = [&](double& value, double chance, double low, double high) {
      if (random.uniform() < chance)
        value = std::clamp(value + 10.0 * width * (high - low) * 0.3 * random.normal(), low, high);
    };
    shaken(child.point.refitted_mass, 0.3, -0.5, 1.5);
    shaken(child.point.refitted_stiffness, 0.3, -0.5, 1.5);
    if (random.uniform() < 0.2) {
      child.point.level.reset();
    } else {
      shaken(*child.point.level, 0.3, -1.0, 1.0);
    }
    child.cents = model_.rms_cents(child.point);
    if (child.cents < limit_cents()) guesses.push_back(child);
  }
  return guesses;
}

ProxySearchResult Search::run() {
  std::vector<Guess> guesses = scan();
  result_.least_cents = guesses.empty() ? start_.errors.partial_rms_cents : guesses.front().cents;
  const std::size_t batch = static_cast<std::size_t>(options_.n_children);
  for (std::size_t begin = 0; begin < guesses.size(); begin += batch) {
    monitor_.throw_if_stopped();
    monitor_.progress("proxy fit", 0.3 * static_cast<double>(begin) / static_cast<double>(guesses.size()));
    hear({guesses.begin() + static_cast<std::ptrdiff_t>(begin),
          guesses.begin() + static_cast<std::ptrdiff_t>(std::min(begin + batch, guesses.size()))});
  }
  // Bodies with few admissible proxies get more.
  const auto n_generations = [&] {
    return options_.n_generations * (limit_cents() > kHard * start_.errors.partial_rms_cents ? 3 : 1);
  };
  for (int generation = 0; generation < n_generations() && !heard_.empty(); ++generation) {
    monitor_.throw_if_stopped();
    monitor_.progress("proxy fit", 0.3 + 0.7 * static_cast<double>(generation) / n_generations());
    hear(children(generation));
  }
  if (result_.best) result_.least_cents = std::min(result_.least_cents, result_.best->cents);
  monitor_.progress("proxy fit", 1.0);
  return std::move(result_);
}

}  // namespace

void ProxySearchOptions::validate() const {
  std::vector<Violation> violations = violations_of(*this);
  if (parts > grid) violations.push_back(out_of_range("parts", parts, between(1, grid)));
  throw_violations("proxy search", std::move(violations));
}

ProxySearchResult search_proxy(const ProxyModel& model, const TargetSound& target, const ProxyStart& start,
                               const ProxySearchOptions& options, Monitor& monitor) {
  options.validate();
  return Search(model, target, start, options, monitor).run();
}

}  // namespace klang::fit
