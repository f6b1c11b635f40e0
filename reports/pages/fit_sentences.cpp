#include "reports/pages/fit_sentences.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/physics/modal/damping/damping_laws.hpp"
#include "reports/kit/text.hpp"
#include "reports/pages/body_facts.hpp"
#include "reports/pages/fit_tables.hpp"

namespace klang::reports::detail {
namespace {

std::string number_word(std::size_t n) {
  static constexpr std::array<std::string_view, 13> kWords = {
      "no", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine", "ten", "eleven", "twelve"};
  return n < kWords.size() ? std::string(kWords[n]) : std::to_string(n);
}

std::string plural_of(const std::string& kind) {
  if (kind.ends_with("x")) return kind + "es";  // box, shell box
  return kind + "s";
}

std::string bold(const std::string& text) { return "<b>" + escaped(text) + "</b>"; }

std::string list_of(const std::vector<std::string>& items) {
  std::string text;
  for (std::size_t i = 0; i < items.size(); ++i) {
    if (i > 0) text += i + 1 == items.size() ? (items.size() > 2 ? ", and " : " and ") : ", ";
    text += items[i];
  }
  return text;
}

/// "Young's modulus E = 68.40 ± 0.12 GPa (95 %: 68.16 to 68.63 GPa)".
std::string said(const fit::FitParameter& estimate) {
  const ShownEstimate text = shown(estimate);
  std::string words = escaped(text.quantity.words);
  if (!text.quantity.symbol.empty()) words += " <span class=\"sym\">" + text.quantity.symbol + "</span>";
  words += " = " + bold(text.value_with_std());
  if (estimate.ci95) words += " (95 %: " + escaped(text.interval()) + ")";
  return words;
}

bool elastic(const std::string& name) {
  return name == "youngs_modulus_pa" || name == "poissons_ratio" || name == "lame_lambda_pa" || name == "lame_mu_pa" ||
         name == "shear_modulus_pa" || name == "bulk_modulus_pa";
}
bool damping(const std::string& name) {
  return damping::is_law_parameter(name) || name.starts_with("zener_") || name.starts_with("relaxation_");
}

/// Those that were fitted.
std::string the_specimens(const fit::FitDocument& data) {
  std::vector<const fit::SpecimenRecord*> fitted;
  for (const fit::SpecimenRecord& specimen : data.specimens) {
    if (!specimen.predicted) fitted.push_back(&specimen);
  }
  std::string kind = fitted.empty() ? std::string() : shape_words(fitted[0]->shape).kind;
  for (const fit::SpecimenRecord* specimen : fitted) {
    if (shape_words(specimen->shape).kind != kind) kind.clear();
  }
  std::replace(kind.begin(), kind.end(), '_', ' ');
  if (fitted.size() == 1) {
    const std::string& name = fitted[0]->name;
    return "The " + (kind.empty() ? "specimen" : escaped(kind)) + (name.empty() ? "" : " " + escaped(name));
  }
  return "The " + number_word(fitted.size()) + " " + (kind.empty() ? "specimens" : escaped(plural_of(kind)));
}

void say_material(const fit::FitDocument& data, std::vector<std::string>& sentences) {
  std::vector<std::string> found;
  std::vector<std::pair<std::string, std::vector<std::string>>> missing;  // why, and what
  std::string caveat;
  for (const char* name :
       {"youngs_modulus_pa", "poissons_ratio", "shear_modulus_pa", "lame_mu_pa", "bulk_modulus_pa", "lame_lambda_pa"}) {
    for (const fit::FitParameter& parameter : data.parameters) {
      if (parameter.name != name || !parameter.identifiable || !measured(parameter.value)) continue;
      if (found.size() < 3) found.push_back(said(parameter));
    }
  }
  for (const fit::FitParameter& parameter : data.parameters) {
    if (!elastic(parameter.name) && !damping(parameter.name) && parameter.identifiable && measured(parameter.value) &&
        found.size() < 5) {
      found.push_back(said(parameter));
    }
    if (!parameter.caveat.empty()) caveat = parameter.caveat;
    if (parameter.identifiable || parameter.given || damping(parameter.name)) continue;
    const Quantity name = quantity(parameter.name, measured(parameter.value).value_or(1));
    std::string why = parameter.why;
    while (!why.empty() && (why.back() == '.' || why.back() == ' ')) why.pop_back();
    const std::string words =
        "the " + escaped(name.words) + (name.symbol.empty() ? "" : " <span class=\"sym\">" + name.symbol + "</span>");
    const auto same =
        std::find_if(missing.begin(), missing.end(), [&](const auto& entry) { return entry.first == why; });
    if (same == missing.end()) {
      missing.push_back({why, {words}});
    } else {
      same->second.push_back(words);
    }
  }
  const bool plural = std::count_if(data.specimens.begin(), data.specimens.end(),
                                    [](const fit::SpecimenRecord& s) { return !s.predicted; }) > 1;
  if (!found.empty()) {
    sentences.push_back(
        the_specimens(data) +
        (data.material_start.preset.empty() ? "" : ", taken as " + escaped(data.material_start.preset) + ",") +
        (plural ? " ring with " : " rings with ") + list_of(found) + (caveat.empty() ? "" : " (" + caveat + ")") + ".");
  }
  std::string open;
  for (const auto& [why, names] : missing) {
    open += (open.empty() ? "" : " ") + capitalised(list_of(names)) + (names.size() > 1 ? " are" : " is") +
            " not determined by these partials" + (why.empty() ? "" : ": " + escaped(why)) + ".";
  }
  if (!open.empty()) sentences.push_back(open);
}

/// The gravest reasons, where the numbers are not to be trusted.
void say_verdict(const fit::FitDocument& data, std::vector<std::string>& sentences) {
  const fit::Verdict verdict = data.judgement.verdict;
  if (verdict != fit::Verdict::kDoubtful && verdict != fit::Verdict::kContradicted) return;
  std::string text = verdict == fit::Verdict::kDoubtful ? "<b>These numbers are doubtful.</b>"
                                                        : "<b>These numbers are contradicted by the data.</b>";
  int n = 0;
  for (const fit::Reason& reason : data.judgement.reasons) {
    if (reason.weight != verdict || n == 3) continue;
    text +=
        " " + escaped(reason.specimen.empty() ? capitalised(reason.text) : reason.specimen + ": " + reason.text) + ".";
    ++n;
  }
  sentences.push_back(text);
}

void say_matches(const fit::FitDocument& data, bool predicted, std::vector<std::string>& sentences) {
  const MatchSummary summary = match_summary(data, predicted);
  if (!summary.worst) return;
  const fit::MatchRecord& worst = *summary.worst;
  const double percent = 100 * std::abs(worst.frequency_hz / worst.model_frequency_hz - 1);
  std::string names;
  for (const fit::SpecimenRecord& specimen : data.specimens) {
    if (specimen.predicted) names += (names.empty() ? "" : ", ") + escaped(specimen.name);
  }
  const std::string lead = predicted ? "A test: <b>" + names + "</b> took no part in the fit. Of " : "Of ";
  sentences.push_back(lead + counted(summary.n_partials, "measured partial", "measured partials") + ", " +
                      bold(std::to_string(summary.n_matched)) + (summary.n_matched == 1 ? " matches" : " match") +
                      (predicted ? " a mode that the fit predicts" : " a mode of the model") +
                      ", with a root-mean-square deviation of " + bold(rounded(summary.rms_cents, 2) + " cents") +
                      "; the largest is " + escaped(signed_cents(worst.deviation_cents)) + " cents (" +
                      rounded(percent, 2) + " %) at " + escaped(hertz(worst.frequency_hz, worst.frequency_std_hz)) +
                      (data.specimens.size() > 1 ? " of " + escaped(worst.specimen) : "") + ".");
}

void say_damping(const fit::FitDocument& data, std::vector<std::string>& sentences) {
  if (data.damping.model.empty()) return;
  const fit::DampingRecord* best = nullptr;
  for (const fit::DampingRecord& model : data.damping.candidates) {
    if (model.model == data.damping.model) best = &model;
  }
  if (!best) return;
  std::string sentence = "Of " + counted(data.damping.candidates.size(), "damping model", "damping models") + ", <b>" +
                         escaped(damping_words(best->model)) + "</b> explains the decays best";
  if (data.damping.candidates.size() == 1)
    sentence = "The decays are described by <b>" + escaped(damping_words(best->model)) + "</b> damping";
  if (best->aicc_weight && data.damping.candidates.size() > 1)
    sentence += " (AICc weight " + escaped(share(*best->aicc_weight)) + ")";
  std::vector<std::string> values;
  for (const fit::FitParameter& parameter : best->parameters) {
    if (measured(parameter.value) && parameter.identifiable) values.push_back(said(parameter));
  }
  if (!values.empty()) sentence += ", with " + list_of(values);
  if (best->rms_relative_residual)
    sentence +=
        "; its decays lie " + rounded(100 * *best->rms_relative_residual, 2) + " % (rms) from the measured ones";
  sentences.push_back(sentence + ".");
}

}  // namespace

MatchSummary match_summary(const fit::FitDocument& data, bool predicted) {
  MatchSummary summary;
  double sum_sq = 0.0;
  for (const fit::SpecimenRecord& specimen : data.specimens) {
    if (specimen.predicted != predicted) continue;
    summary.n_partials += specimen.partials.size();
    for (const fit::MatchRecord& match : data.matches) {
      if (match.specimen != specimen.name) continue;
      ++summary.n_matched;
      sum_sq += match.deviation_cents * match.deviation_cents;
      if (!summary.worst || std::abs(match.deviation_cents) > std::abs(summary.worst->deviation_cents))
        summary.worst = &match;
    }
  }
  summary.n_partials = std::max(summary.n_partials, summary.n_matched);
  if (summary.n_matched > 0) summary.rms_cents = std::sqrt(sum_sq / static_cast<double>(summary.n_matched));
  return summary;
}

std::vector<std::string> fit_sentences(const fit::FitDocument& data) {
  const std::string& status = data.header.status;
  if (status == "no_partials") return {"Nothing in the recordings stands out of the noise, so nothing was fitted."};
  if (status == "no_match") return {"No partial lies near a mode of the model, so nothing was fitted."};
  std::vector<std::string> sentences;
  if (status != "converged") {
    const std::string message = data.header.message.value_or("");
    sentences.push_back(
        std::string("The solver did not converge; the numbers on this page are its last state, not a result.") +
        (message.empty() ? "" : " " + escaped(message)));
  }
  say_verdict(data, sentences);
  say_material(data, sentences);
  say_matches(data, false, sentences);
  say_damping(data, sentences);
  say_matches(data, true, sentences);
  return sentences;
}

}  // namespace klang::reports::detail
