#include "validate/studies/study.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/json.hpp"
#include "validate/studies/studies.hpp"

namespace klang::validate {
namespace {

std::string brief(const char* format, double value) {
  char text[40];
  std::snprintf(text, sizeof text, format, value);
  return text;
}

std::string order_name(const Series& series) { return series.kind == Convergence::kGeometric ? "rate" : "order"; }

bool order_passes(const Series& series) {
  if (!series.order.observed_order) return false;
  const double off = *series.order.observed_order - series.expected_order;
  return (series.higher_is_fine ? -off : std::abs(off)) <= series.order_tolerance;
}

/// The error that the verdict looks at: that of the finest level, or for round-off the largest.
double judged_error(const Series& series) {
  if (series.levels.empty()) return std::nan("");
  if (series.kind != Convergence::kRoundOff) return series.levels.back().error;
  double largest = 0.0;
  for (const Level& level : series.levels) {
    if (!std::isnan(largest) && !(level.error <= largest)) largest = level.error;  // a NaN comes in and stays
  }
  return largest;
}

bool all_at_floor(const Series& series) {
  return series.levels.size() >= 2 && std::all_of(series.order.excluded.begin(), series.order.excluded.end(),
                                                  [](const std::string& why) { return why == "floor"; });
}

void add_gci(Series& series) {
  std::vector<const Level*> used;
  for (std::size_t i = 0; i < series.levels.size(); ++i) {
    if (series.order.excluded[i].empty() && series.levels[i].value) used.push_back(&series.levels[i]);
  }
  if (used.size() < 3 || series.kind != Convergence::kAlgebraic) return;
  std::array<double, 3> h{}, value{};
  for (std::size_t k = 0; k < 3; ++k) {
    const Level& level = *used[used.size() - 1 - k];
    h[k] = level.h_m ? *level.h_m : 1.0 / *level.n;
    value[k] = *level.value;
  }
  series.gci = grid_convergence(h, value);
}

const char* kind_name(Convergence kind) {
  return kind == Convergence::kAlgebraic ? "algebraic" : kind == Convergence::kGeometric ? "geometric" : "round_off";
}

nlohmann::json series_json(const Series& series) {
  nlohmann::json json = {{"id", series.id},
                         {"title", series.title},
                         {"reference", series.reference},
                         {"step", series.step_words},
                         {"error", series.error_words},
                         {"kind", kind_name(series.kind)},
                         {"observed_order", json_number(series.order.observed_order)},
                         {"order_ci95", nullptr},
                         {"expected_order", nullptr},
                         {"order_tolerance", nullptr},
                         {"higher_is_fine", series.higher_is_fine},
                         {"error_tolerance", json_number(series.error_tolerance)},
                         {"error_floor", json_number(series.error_floor)},
                         {"floor", series.floor_words},
                         {"counts", series.counts},
                         {"asymptotic", nullptr},
                         {"gci", nullptr},
                         {"passed", series.passed},
                         {"verdict", series.verdict},
                         {"levels", nlohmann::json::array()}};
  if (series.kind != Convergence::kRoundOff) {
    json["expected_order"] = json_number(series.expected_order);
    if (std::isfinite(series.expected_order)) json["order_tolerance"] = series.order_tolerance;
  }
  if (series.order.ci95) {
    json["order_ci95"] = {json_number((*series.order.ci95)[0]), json_number((*series.order.ci95)[1])};
  }
  if (series.order.asymptotic) json["asymptotic"] = *series.order.asymptotic;
  if (series.gci) {
    json["gci"] = {{"order", json_number(series.gci->order)},
                   {"extrapolated", json_number(series.gci->extrapolated)},
                   {"exact", json_number(series.exact_value)},
                   {"gci_fine", json_number(series.gci->gci_fine)},
                   {"gci_coarse", json_number(series.gci->gci_coarse)},
                   {"asymptotic_ratio", json_number(series.gci->asymptotic_ratio)},
                   {"oscillating", series.gci->oscillating}};
  }
  for (std::size_t i = 0; i < series.levels.size(); ++i) {
    const Level& level = series.levels[i];
    nlohmann::json row = {{"error", json_number(level.error)},
                          {"value", json_number(level.value)},
                          {"n_unknowns", level.n_unknowns},
                          {"wall_time_s", level.wall_time_s},
                          {"pairwise_order", json_number(series.order.pairwise[i])},
                          {"excluded", series.order.excluded[i]}};
    if (level.error_ci95) {
      row["error_low"] = json_number((*level.error_ci95)[0]);
      row["error_high"] = json_number((*level.error_ci95)[1]);
    }
    if (level.h_m) row["h_m"] = *level.h_m;
    if (level.n) row["n"] = *level.n;
    json["levels"].push_back(std::move(row));
  }
  return json;
}

template <class Field>
nlohmann::json fields_json(const std::vector<Field>& fields, const char* extension) {
  nlohmann::json list = nlohmann::json::array();
  for (const Field& field : fields) {
    list.push_back(
        {{"name", field.name}, {"title", field.title}, {"caption", field.caption}, {"file", field.name + extension}});
  }
  return list;
}

std::string csv_text(const std::string& text) {
  if (text.find_first_of(",\"\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? "\"\"" : std::string(1, c);
  return quoted + "\"";
}

}  // namespace

void judge(Series& series) {
  std::vector<double> step, error;
  for (const Level& level : series.levels) {
    step.push_back(series.kind == Convergence::kAlgebraic && !level.h_m ? 1.0 / *level.n : level.step());
    error.push_back(level.error);
  }
  series.order = estimate_order(step, error, series.kind, series.error_floor);
  series.gci.reset();
  add_gci(series);
  const double reached = judged_error(series);
  const bool small = reached <= series.error_tolerance;
  const std::string error_words =
      "error " + brief("%.2g", reached) + (small ? " ≤ " : " > ") + brief("%.2g", series.error_tolerance);
  if (series.kind == Convergence::kRoundOff) {
    series.passed = small;
    series.verdict = "largest " + error_words;
    return;
  }
  if (all_at_floor(series)) {
    series.passed = small;
    series.verdict = error_words + "; every level is at the floor, no order can be seen";
    return;
  }
  if (!std::isfinite(series.expected_order)) {
    series.passed = small;
    series.verdict = "finest " + error_words + "; no order is expected";
    return;
  }
  const bool ordered = order_passes(series);
  series.passed = small && ordered;
  const std::string expected = brief("%.3g", series.expected_order) + " ± " + brief("%.2g", series.order_tolerance) +
                               (series.higher_is_fine ? " or higher" : "");
  series.verdict =
      (series.order.observed_order ? order_name(series) + " " + brief("%.3f", *series.order.observed_order) +
                                         (ordered ? " within " : " outside ") + expected
                                   : "no " + order_name(series) + " could be fitted (" + expected + " expected)") +
      "; finest " + error_words;
}

bool Study::passed() const {
  return status == StudyStatus::kDone && !series.empty() &&
         std::all_of(series.begin(), series.end(), [](const Series& s) { return s.passed || !s.counts; }) &&
         std::all_of(claims.begin(), claims.end(), [](const Claim& c) { return c.passed; });
}

void StudyOptions::validate() const {
  if (levels != 0 && (levels < 3 || levels > 20))
    throw_violations("study", {{"levels", "", std::to_string(levels), "3 to 20, or 0 for all"}});
}

bool wanted(const StudyOptions& options, const std::string& id) { return id.find(options.only) != std::string::npos; }

std::size_t level_count(const StudyOptions& options, std::size_t n) {
  return options.levels > 0 ? std::min(n, static_cast<std::size_t>(options.levels)) : n;
}

std::vector<Claim> all_claims(const Study& study) {
  std::vector<Claim> claims;
  for (const Series& series : study.series) {
    if (!series.counts) continue;
    if (series.kind != Convergence::kRoundOff && std::isfinite(series.expected_order) && !all_at_floor(series)) {
      Claim order{series.id + "." + order_name(series),
                  series.title + ": errors fall at the expected " + order_name(series),
                  series.order.observed_order.value_or(std::nan("")),
                  series.expected_order,
                  series.order_tolerance,
                  series.order.observed_order,
                  order_passes(series)};
      claims.push_back(std::move(order));
    }
    claims.push_back(judged({series.id + ".error",
                             series.title + ": " + series.error_words,
                             judged_error(series),
                             {},
                             series.error_tolerance,
                             series.order.observed_order,
                             false}));
  }
  claims.insert(claims.end(), study.claims.begin(), study.claims.end());
  return claims;
}

nlohmann::json to_json(const Study& study) {
  nlohmann::json json = {{"study", study.name},
                         {"title", study.title},
                         {"question", study.question},
                         {"passed", study.passed()},
                         {"series", nlohmann::json::array()},
                         {"claims", nlohmann::json::array()},
                         {"fields",
                          {{"surfaces", fields_json(study.fields.surfaces, ".vtp")},
                           {"slices", fields_json(study.fields.slices, ".vti")},
                           {"balloons", fields_json(study.fields.balloons, ".vtp")}}}};
  for (std::size_t i = 0; i < study.fields.surfaces.size(); ++i)
    json["fields"]["surfaces"][i]["quantity"] = study.fields.surfaces[i].quantity;
  for (std::size_t i = 0; i < study.fields.slices.size(); ++i) {
    json["fields"]["slices"][i]["quantity"] = study.fields.slices[i].quantity;
    json["fields"]["slices"][i]["decibels"] = study.fields.slices[i].decibels;
    json["fields"]["slices"][i]["floor"] = study.fields.slices[i].floor;
  }
  for (const Series& series : study.series) json["series"].push_back(series_json(series));
  for (const Claim& claim : all_claims(study)) json["claims"].push_back(to_json(claim));
  if (!study.series.empty()) {
    for (const char* key : {"levels", "observed_order", "order_ci95", "expected_order", "order_tolerance"})
      json[key] = json["series"][0][key];
  }
  return json;
}

std::string levels_csv(const Study& study) {
  std::string csv = "series,level,h_m,n,error,value,pairwise_order,excluded,n_unknowns,error_low,error_high\n";
  const auto cell = [](const std::optional<double>& value) {
    return value && std::isfinite(*value) ? to_text(*value) : std::string();
  };
  for (const Series& series : study.series) {
    for (std::size_t i = 0; i < series.levels.size(); ++i) {
      const Level& level = series.levels[i];
      csv += csv_text(series.id) + "," + std::to_string(i) + "," + cell(level.h_m) + "," + cell(level.n) + "," +
             cell(level.error) + "," + cell(level.value) + "," + cell(series.order.pairwise[i]) + "," +
             csv_text(series.order.excluded[i]) + "," + cell(level.n_unknowns) + "," +
             (level.error_ci95 ? cell((*level.error_ci95)[0]) + "," + cell((*level.error_ci95)[1]) : std::string(",")) +
             "\n";
    }
  }
  return csv;
}

namespace {
struct KnownStudy {
  std::string name;
  Study (*run)(const StudyOptions&, Monitor&);
};
const std::vector<KnownStudy>& known_studies() {
  static const std::vector<KnownStudy> known = {{"fem", fem_study},
                                                {"bem", bem_study},
                                                {"multipole", multipole_study},
                                                {"synthesis", synthesis_study},
                                                {"dual-domain", dual_domain_study}};
  return known;
}
}  // namespace

const std::vector<std::string>& study_names() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> list;
    for (const KnownStudy& study : known_studies()) list.push_back(study.name);
    return list;
  }();
  return names;
}

Study run_study(const std::string& name, const StudyOptions& options, Monitor& monitor) {
  options.validate();
  for (const KnownStudy& known : known_studies()) {
    if (known.name != name) continue;
    Study study = known.run(options, monitor);
    study.name = name;
    if (study.series.empty()) throw InputError("converge " + name, "has no series whose name contains", options.only);
    for (Series& series : study.series) judge(series);
    study.status = StudyStatus::kDone;
    return study;
  }
  std::string names;
  for (const std::string& known : study_names()) names += (names.empty() ? "" : ", ") + known;
  throw InputError("converge", "is no study", name, names);
}

}  // namespace klang::validate
