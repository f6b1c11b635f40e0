#include <algorithm>
#include <array>
#include <cmath>

#include "core/physics/modal/damping/damping_laws.hpp"
#include "reports/kit/text.hpp"
#include "reports/pages/bubble_page.hpp"
#include "reports/pages/page.hpp"
#include "reports/pages/papers_page.hpp"
#include "reports/pages/proxy_page.hpp"
#include "reports/pages/proxy_study_page.hpp"
#include "reports/pages/regression_page.hpp"

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
std::string said(const Estimate& estimate) {
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
std::string the_specimens(const ResultData& data) {
  std::vector<const Specimen*> fitted;
  for (const Specimen& specimen : data.specimens) {
    if (!specimen.predicted) fitted.push_back(&specimen);
  }
  std::string kind = fitted.empty() ? std::string() : fitted[0]->shape_kind;
  for (const Specimen* specimen : fitted) {
    if (specimen->shape_kind != kind) kind.clear();
  }
  std::replace(kind.begin(), kind.end(), '_', ' ');
  if (fitted.size() == 1) {
    const std::string& name = fitted[0]->name;
    return "The " + (kind.empty() ? "specimen" : escaped(kind)) + (name.empty() ? "" : " " + escaped(name));
  }
  return "The " + number_word(fitted.size()) + " " + (kind.empty() ? "specimens" : escaped(plural_of(kind)));
}

void say_material(const ResultData& data, std::vector<std::string>& sentences) {
  std::vector<std::string> found;
  std::vector<std::pair<std::string, std::vector<std::string>>> missing;  // why, and what
  for (const char* name :
       {"youngs_modulus_pa", "poissons_ratio", "shear_modulus_pa", "lame_mu_pa", "bulk_modulus_pa", "lame_lambda_pa"}) {
    for (const Estimate& parameter : data.parameters) {
      if (parameter.name != name || !parameter.identifiable || !parameter.value) continue;
      if (found.size() < 3) found.push_back(said(parameter));
    }
  }
  for (const Estimate& parameter : data.parameters) {
    if (!elastic(parameter.name) && !damping(parameter.name) && parameter.identifiable && parameter.value &&
        found.size() < 5) {
      found.push_back(said(parameter));
    }
    if (parameter.identifiable || damping(parameter.name)) continue;
    const Quantity name = quantity(parameter.name, parameter.value.value_or(1));
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
  const bool plural =
      std::count_if(data.specimens.begin(), data.specimens.end(), [](const Specimen& s) { return !s.predicted; }) > 1;
  if (!found.empty()) {
    sentences.push_back(the_specimens(data) +
                        (data.material.empty() ? "" : ", taken as " + escaped(data.material) + ",") +
                        (plural ? " ring with " : " rings with ") + list_of(found) + ".");
  }
  std::string open;
  for (const auto& [why, names] : missing) {
    open += (open.empty() ? "" : " ") + capitalised(list_of(names)) + (names.size() > 1 ? " are" : " is") +
            " not determined by these partials" + (why.empty() ? "" : ": " + escaped(why)) + ".";
  }
  if (!open.empty()) sentences.push_back(open);
}

void say_matches(const ResultData& data, bool predicted, std::vector<std::string>& sentences) {
  const MatchSummary summary = match_summary(data, predicted);
  if (!summary.worst) return;
  const Match& worst = *summary.worst;
  const double percent = 100 * std::abs(worst.frequency_hz / worst.model_frequency_hz - 1);
  std::string names;
  for (const Specimen& specimen : data.specimens) {
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

void say_damping(const ResultData& data, std::vector<std::string>& sentences) {
  if (data.damping_model.empty()) return;
  const DampingModel* best = nullptr;
  for (const DampingModel& model : data.damping) {
    if (model.model == data.damping_model) best = &model;
  }
  if (!best) return;
  std::string sentence = "Of " + counted(data.damping.size(), "damping model", "damping models") + ", <b>" +
                         escaped(damping_words(best->model)) + "</b> explains the decays best";
  if (data.damping.size() == 1)
    sentence = "The decays are described by <b>" + escaped(damping_words(best->model)) + "</b> damping";
  if (best->aicc_weight && data.damping.size() > 1)
    sentence += " (AICc weight " + escaped(share(*best->aicc_weight)) + ")";
  std::vector<std::string> values;
  for (const Estimate& parameter : best->parameters) {
    if (parameter.value && parameter.identifiable) values.push_back(said(parameter));
  }
  if (!values.empty()) sentence += ", with " + list_of(values);
  if (best->rms_relative_residual)
    sentence +=
        "; its decays lie " + rounded(100 * *best->rms_relative_residual, 2) + " % (rms) from the measured ones";
  sentences.push_back(sentence + ".");
}

}  // namespace

std::vector<std::string> summary_sentences(const ResultData& data) {
  if (data.kind == "study") return study_sentences(data.study);
  if (data.kind == "bubbles") return bubble_sentences(data);
  if (data.kind == "regression") return regression_sentences(data);
  if (data.kind == "papers") return papers_sentences(data.papers);
  if (data.kind == "proxy_study") return proxy_study_sentences(data.proxy_study);
  if (data.kind == "proxy_fit") return proxy_sentences(data.proxy);
  std::vector<std::string> sentences;
  if (data.kind == "fit") {
    if (data.status == "no_partials") {
      sentences.push_back("Nothing in the recordings stands out of the noise, so nothing was fitted.");
      return sentences;
    }
    if (data.status == "no_match") {
      sentences.push_back("No partial lies near a mode of the model, so nothing was fitted.");
      return sentences;
    }
    if (data.status != "converged") {
      sentences.push_back(
          std::string("The solver did not converge; the numbers on this page are its last state, not a result.") +
          (data.message.empty() ? "" : " " + escaped(data.message)));
    }
    say_material(data, sentences);
    say_matches(data, false, sentences);
    say_damping(data, sentences);
    say_matches(data, true, sentences);
    return sentences;
  }
  const Specimen& body = data.specimens.front();
  if (data.kind == "analysis") {
    if (body.partials.empty()) {
      sentences.push_back("No partial stands out of the noise." +
                          (data.message.empty() ? "" : " " + escaped(data.message)));
      return sentences;
    }
    const auto loudest = std::max_element(
        body.partials.begin(), body.partials.end(),
        [](const Partial& a, const Partial& b) { return a.amplitude.value_or(0) < b.amplitude.value_or(0); });
    const auto [lowest, highest] =
        std::minmax_element(body.partials.begin(), body.partials.end(),
                            [](const Partial& a, const Partial& b) { return a.frequency_hz < b.frequency_hz; });
    std::string sentence = "The recording holds " + bold(counted(body.partials.size(), "partial", "partials"));
    if (body.partials.size() > 1)
      sentence += " from " + escaped(hertz(lowest->frequency_hz, lowest->frequency_std_hz)) + " to " +
                  escaped(hertz(highest->frequency_hz, highest->frequency_std_hz));
    if (body.strikes_s.size() > 1) sentence += " and " + std::to_string(body.strikes_s.size()) + " strikes";
    sentences.push_back(sentence + ".");
    sentence = "The strongest lies at " + bold(hertz(loudest->frequency_hz, loudest->frequency_std_hz));
    if (loudest->decay_per_s && *loudest->decay_per_s > 0) {
      sentence += " and falls by 60 dB in " + rounded(std::log(1000.0) / *loudest->decay_per_s, 3) + " s";
    }
    sentences.push_back(sentence + ".");
    if (body.explained_energy) {
      sentences.push_back("Together they explain " + bold(rounded(100 * *body.explained_energy, 4) + " %") +
                          " of the recording’s energy in band after the first strike.");
    }
    return sentences;
  }
  if (!body.modes.empty()) {
    sentences.push_back(
        "The body has " + bold(counted(body.modes.size(), "elastic mode", "elastic modes")) + " from " +
        escaped(hertz(body.modes.front().frequency_hz)) + " to " + escaped(hertz(body.modes.back().frequency_hz)) +
        (body.none_missing.value_or(false) ? "; a Sturm count proves that none between them is missing." : "."));
  }
  return sentences;
}

std::string fitted_words(const ResultData& data) {
  return data.kind == "fit" ? "Fitted model" : data.kind == "bubbles" ? "Fitted chirps" : "Resynthesis";
}

Verdict verdict(const ResultData& data) {
  Verdict result;
  if (data.kind == "study") {
    result = data.study.passed ? Verdict{"Passed", "good", {}} : Verdict{"Not passed", "bad", {}};
    const auto missed = static_cast<std::size_t>(std::count_if(data.study.claims.begin(), data.study.claims.end(),
                                                               [](const StudyClaim& claim) { return !claim.passed; }));
    if (missed > 0) {
      result.details =
          std::to_string(missed) + " of " + counted(data.study.claims.size(), "claim", "claims") + " not met";
    } else if (!data.study.series.empty()) {
      result.details = data.study.series.front().verdict;
    }
    return result;
  }
  if (data.kind == "proxy_study") return {"Done", "good", counted(data.proxy_study.pieces.size(), "piece", "pieces")};
  if (data.kind == "papers")
    return {data.status == "passed" ? "Passed" : "Not passed", data.status == "passed" ? "good" : "bad", data.message};
  if (data.kind == "proxy_fit")
    return {data.proxy.improved ? "Improved" : "Start kept", data.proxy.improved ? "good" : "fair", data.message};
  if (data.kind == "regression") {
    return {data.status == "passed"           ? "Passed"
            : data.status == "nothing_judged" ? "Nothing could be judged"
                                              : "Not passed",
            data.status == "passed" ? "good" : "bad", data.message};
  }
  if (data.kind == "bubbles") {
    const auto n = static_cast<std::size_t>(std::count_if(data.bubbles.rows.begin(), data.bubbles.rows.end(),
                                                          [](const BubbleRow& row) { return row.is_bubble; }));
    return {n > 0 ? capitalised(counted(n, "bubble", "bubbles")) : "No bubble", n > 0 ? "good" : "fair", ""};
  }
  if (data.kind == "fit") {
    if (data.status == "converged") {
      result = {"Converged", "good", {}};
    } else if (data.status == "not_converged") {
      result = {"Not converged", "fair", {}};
    } else if (data.status == "no_partials") {
      result = {"No partials found", "bad", {}};
    } else if (data.status == "no_match") {
      result = {"No partial matches", "bad", {}};
    } else {
      result = {data.status.empty() ? "No status" : data.status, "bad", {}};
    }
    if (data.status != "converged" && data.matches.empty()) {
      result.details = data.message;
      return result;
    }
    const MatchSummary summary = match_summary(data, false);
    result.details =
        std::to_string(summary.n_matched) + " of " + std::to_string(summary.n_partials) + " partials matched";
    if (summary.worst)
      result.details += ", none further than " + rounded(std::abs(summary.worst->deviation_cents), 2) + " cents";
    if (data.n_iterations)
      result.details +=
          "; " + counted(static_cast<std::size_t>(std::max(0.0, *data.n_iterations)), "solver step", "solver steps");
    return result;
  }
  const bool good = data.status == "ok" || data.status == "converged" || data.status.empty();
  std::string words = data.status.empty() ? "Done" : data.status;
  std::replace(words.begin(), words.end(), '_', ' ');
  words = capitalised(words);
  return {words == "Ok" ? "Analysed" : words, good ? "good" : "bad", data.message};
}

}  // namespace klang::reports::detail
