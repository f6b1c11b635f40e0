#include "fit/judge/judge.hpp"

#include <algorithm>
#include <cmath>

#include "fit/judge/detail/reasons.hpp"

namespace klang::fit {
namespace detail {
namespace {

constexpr double kRivalOdds = 3.0;     // 20 to 1
constexpr double kHintOdds = 3.5;      // 33 to 1 for a dimension's error of a few per cent
constexpr double kConstantOdds = 1.5;  // 4.5 to 1 for a constant's: it was read in a table, not measured
// Errors below these no caliper and no handbook excludes; above the grave ones another body or material was meant.
constexpr double kLeastError = 0.001, kLeastModulusError = 0.005, kLeastPoissonError = 0.005;
constexpr double kGraveError = 0.015, kGraveModulusError = 0.2, kGravePoissonError = 0.06;

/// Of kind's unit: what is shown is value times this.
struct Shown {
  double scale = 1.0;
  const char* unit = "";
};

Shown shown_as(const GivenValue& given) {
  if (given.kind == GivenKind::kPoissonsRatio) return {};
  if (given.kind == GivenKind::kModulus) return {1e-9, " GPa"};
  return given.value < 1.0 ? Shown{1e3, " mm"} : Shown{1.0, " m"};
}

double value_with(const GivenValue& given, double error) {
  return given.kind == GivenKind::kPoissonsRatio ? given.value + error : given.value * std::exp(error);
}

std::string error_words(const GivenValue& given, const GivenHint& hint) {
  if (given.kind == GivenKind::kPoissonsRatio)
    return shown("%+.4f", hint.error) + " +- " + shown("%.4f", hint.error_std);
  return shown("%+.2f", 100.0 * (std::exp(hint.error) - 1.0)) + " +- " + shown("%.2f %%", 100.0 * hint.error_std);
}

/// The log odds of the likeliest error that its stated tolerance allows: it is in the interval already, and what explains the rings no
/// better is no news.
double explained_by_tolerances(const std::vector<GivenHint>& hints, const JudgedResiduals& residuals) {
  double most = -1e300;
  for (const GivenHint& hint : hints)
    if (std::abs(hint.error) <= 2.0 * std::hypot(residuals.given[hint.given].relative_tolerance, hint.error_std) &&
        residuals.given[hint.given].relative_tolerance > 0.0)
      most = std::max(most, hint.log_odds);
  return most;
}

void judge_given(const JudgeInput& input, std::vector<Reason>& reasons) {
  const std::vector<GivenHint> hints = given_hints(input.residuals, input.model_std_cents);
  if (hints.empty()) return;
  const double best = hints.front().log_odds, explained = explained_by_tolerances(hints, input.residuals);
  for (const GivenHint& hint : hints) {
    if (hint.log_odds <= explained + 2.5) continue;
    const GivenValue& given = input.residuals.given[hint.given];
    const auto of_kind = [&](double dimension, double modulus, double poisson) {
      return given.kind == GivenKind::kDimension ? dimension : given.kind == GivenKind::kModulus ? modulus : poisson;
    };
    const double error = std::abs(hint.error);
    if (hint.log_odds < of_kind(kHintOdds, kConstantOdds, kConstantOdds) || hint.log_odds < best - 2.5 ||
        error < 2.5 * hint.error_std || error < of_kind(kLeastError, kLeastModulusError, kLeastPoissonError))
      continue;
    const bool grave = hint.log_odds > 25.0 && error > of_kind(kGraveError, kGraveModulusError, kGravePoissonError);
    const double fits = value_with(given, hint.error);
    const auto [scale, unit] = shown_as(given);
    reasons.push_back({given.kind == GivenKind::kDimension ? ReasonKind::kDimension : ReasonKind::kGuess,
                       grave ? Verdict::kContradicted : Verdict::kDoubtful, given.specimen, given.name,
                       hint.ring + " speaks against " + given.name + ": " + shown("%.4g", scale * fits) + unit +
                           " would fit, " + shown("%.4g", scale * given.value) + unit + " is given (" +
                           error_words(given, hint) + ")",
                       given.value, value_with(given, hint.error - 2.0 * hint.error_std),
                       value_with(given, hint.error + 2.0 * hint.error_std)});
  }
}

/// "7169.8 Hz on mode 2 instead of 1": the first ring that the rival takes for another mode; empty where there is none.
std::string ring_elsewhere(const JudgeInput& input) {
  std::size_t at = 0;
  for (const JudgedSpecimen& specimen : input.specimens) {
    for (std::size_t i = 0; i < specimen.mode_of_partial.size(); ++i, ++at) {
      if (at >= input.rival->modes.size()) return {};
      const int own = specimen.mode_of_partial[i], rival = input.rival->modes[at];
      if (own < 0 || rival < 0 || own == rival || i >= specimen.partials.partials.size()) continue;
      const auto hz = [&](int mode) { return mode < specimen.frequency_hz.size() ? specimen.frequency_hz[mode] : 0.0; };
      // Of one line, whatever the modes' numbers.
      if (std::abs(hz(own) - hz(rival)) < 1e-4 * hz(own)) continue;
      return shown("%.1f Hz", specimen.partials.partials[i].frequency_hz) + " on mode " + std::to_string(rival) +
             " instead of " + std::to_string(own);
    }
  }
  return {};
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
  const std::string elsewhere = other ? std::string() : ring_elsewhere(input);
  if (!other && elsewhere.empty()) return;
  reasons.push_back({ReasonKind::kRival,
                     Verdict::kDoubtful,
                     "",
                     "",
                     "another matching explains the partials nearly as well (odds 1 to " +
                         shown("%.2g", std::exp(std::max(0.0, input.rival->log_odds))) + "), with E = " +
                         shown("%.4g GPa", input.rival->youngs_modulus_pa / 1e9) + " and Poisson's ratio " +
                         shown("%.3f", input.rival->poissons_ratio) + (other ? "" : ": " + elsewhere),
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
  judge_given(input, reasons);
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
