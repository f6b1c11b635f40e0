#include "fit/judge/judge.hpp"

#include <algorithm>
#include <cmath>

#include "fit/judge/detail/reasons.hpp"

namespace klang::fit {
namespace detail {
namespace {

constexpr double kRivalOdds = 3.0;    // 20 to 1
constexpr double kHintOdds = 3.5;     // 33 to 1 for a dimension's error of a few per cent
constexpr double kLeastHint = 0.001;  // of a dimension: below it no caliper is right

void judge_dimensions(const JudgeInput& input, std::vector<Reason>& reasons) {
  const std::vector<DimensionHint> hints = dimension_hints(input.residuals, input.model_std_cents);
  if (hints.empty()) return;
  const double best = hints.front().log_odds;
  for (const DimensionHint& hint : hints) {
    if (hint.log_odds < kHintOdds || hint.log_odds < best - 2.5 || std::abs(hint.log_error) < kLeastHint ||
        std::abs(hint.log_error) < 2.5 * hint.log_error_std)
      continue;
    const GivenDimension& dimension = input.residuals.dimensions[hint.dimension];
    const double fits_m = dimension.value_m * std::exp(hint.log_error);
    const bool grave = hint.log_odds > 25.0 && std::abs(hint.log_error) > 0.015;
    const bool mm = dimension.value_m < 1.0;
    const double unit = mm ? 1e3 : 1.0;
    reasons.push_back({ReasonKind::kDimension, grave ? Verdict::kContradicted : Verdict::kDoubtful, dimension.specimen,
                       dimension.name,
                       hint.ring + " speaks against " + dimension.name + ": " + shown("%.4g", unit * fits_m) +
                           (mm ? " mm" : " m") + " would fit, " + shown("%.4g", unit * dimension.value_m) +
                           " is given (" + shown("%+.2f", 100.0 * (std::exp(hint.log_error) - 1.0)) + " +- " +
                           shown("%.2f %%", 100.0 * hint.log_error_std) + ")",
                       dimension.value_m, fits_m * (1.0 - 2.0 * hint.log_error_std),
                       fits_m * (1.0 + 2.0 * hint.log_error_std)});
  }
}

void judge_rival(const JudgeInput& input, std::vector<Reason>& reasons) {
  if (!input.rival || input.rival->log_odds > kRivalOdds) return;
  double young = input.found.youngs_modulus_pa(), young_std = 0.0, poisson_std = 0.0;
  bool poisson_known = false;
  for (const FitParameter& parameter : input.parameters) {
    if (parameter.name == "youngs_modulus_pa") young_std = parameter.std.value_or(0.0);
    if (parameter.name == "poissons_ratio" && parameter.std) poisson_known = true, poisson_std = *parameter.std;
  }
  const double young_off = std::abs(input.rival->youngs_modulus_pa - young);
  const double poisson_off = std::abs(input.rival->poissons_ratio - input.found.poissons_ratio());
  const bool other = young_off > std::max(0.01 * young, 3.0 * young_std) ||
                     (poisson_known && poisson_off > std::max(0.01, 3.0 * poisson_std));
  if (!other) return;
  reasons.push_back({ReasonKind::kRival,
                     Verdict::kDoubtful,
                     "",
                     "",
                     "another matching explains the partials nearly as well (odds 1 to " +
                         shown("%.2g", std::exp(std::max(0.0, input.rival->log_odds))) +
                         "), with E = " + shown("%.4g GPa", input.rival->youngs_modulus_pa / 1e9) +
                         " and Poisson's ratio " + shown("%.3f", input.rival->poissons_ratio),
                     input.rival->log_odds,
                     kRivalOdds,
                     {}});
}

}  // namespace

void judge_agreement(const JudgeInput& input, std::vector<Reason>& reasons) {
  const int left = input.n_data - input.n_free;
  if (left <= 0)
    reasons.push_back({ReasonKind::kUntested,
                       Verdict::kDoubtful,
                       "",
                       "",
                       std::to_string(input.n_data) + " matched frequencies and " + std::to_string(input.n_free) +
                           " free numbers: nothing is left over that could contradict the model",
                       static_cast<double>(left),
                       1.0,
                       {}});
  const double doubtful = std::max(6.0, 3.0 * input.model_std_cents);
  if (left > 0 && input.rms_cents > doubtful)
    reasons.push_back({ReasonKind::kScatter,
                       input.rms_cents > 4.0 * doubtful && left >= 2 ? Verdict::kContradicted : Verdict::kDoubtful, "",
                       "",
                       "partials lie " + shown("%.1f", input.rms_cents) +
                           " cents from their modes (rms per degree of freedom), more than a homogeneous body of these "
                           "dimensions leaves",
                       input.rms_cents, 0.0, doubtful});
  judge_rival(input, reasons);
  judge_dimensions(input, reasons);
}

}  // namespace detail

Judgement judge_fit(const JudgeInput& input) {
  Judgement judgement;
  judgement.reasons = input.given;
  detail::judge_material(input, judgement.reasons);
  detail::judge_partials(input, judgement.reasons);
  detail::judge_agreement(input, judgement.reasons);
  std::stable_sort(judgement.reasons.begin(), judgement.reasons.end(),
                   [](const Reason& a, const Reason& b) { return a.weight > b.weight; });
  judgement.verdict = judgement.reasons.empty() ? Verdict::kTrusted : judgement.reasons.front().weight;
  return judgement;
}

}  // namespace klang::fit
