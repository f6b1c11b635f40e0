#pragma once
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "core/foundation/config/result_header.hpp"
#include "validate/claim/claim.hpp"
#include "validate/studies/study.hpp"

/// study.json of `klang converge`.
namespace klang::validate {

struct LevelRecord {
  std::optional<double> h_m, n, error, value, pairwise_order;
  std::string excluded;
  double n_unknowns = 0.0, wall_time_s = 0.0;
  std::optional<double> error_low, error_high;
  std::optional<double> exact, shape_error;
  std::vector<LevelPoint> points;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit(absent_if_empty({"h_m", "element size; studies in space have it"}), self.h_m);
    visit(absent_if_empty({"n", "samples per second, order of an expansion, sources; the others have it"}), self.n);
    visit({"error", "against the series' reference"}, self.error);
    visit({"value", "a number that converges"}, self.value);
    visit(absent_if_empty({"exact", "what it should be"}), self.exact);
    visit(absent_if_empty({"shape_error", "of a shape that comes back: what differs, over its volume"}),
          self.shape_error);
    visit(absent_if_empty({"points", "places at which the error was looked for"}), self.points);
    visit({"pairwise_order", "slope from the level before to this one"}, self.pairwise_order);
    visit({"excluded", "why it is not in the fit; empty where it is"}, self.excluded);
    visit({"n_unknowns", "cost that does not depend on the machine"}, self.n_unknowns);
    visit({"wall_time_s", "of the level"}, self.wall_time_s);
    visit(absent_if_empty({"error_low", "95 % interval of a mean over random repeats"}), self.error_low);
    visit(absent_if_empty({"error_high", "its upper end"}), self.error_high);
  }
};

struct GciRecord {
  std::optional<double> order, extrapolated, exact, gci_fine, gci_coarse, asymptotic_ratio;
  bool oscillating = false;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"order", "apparent order"}, self.order);
    visit({"extrapolated", "Richardson's limit of the value"}, self.extrapolated);
    visit({"exact", "the value, where it is known"}, self.exact);
    visit({"gci_fine", "of the two finest levels, relative"}, self.gci_fine);
    visit({"gci_coarse", "one level up"}, self.gci_coarse);
    visit({"asymptotic_ratio", "near 1 in the asymptotic range"}, self.asymptotic_ratio);
    visit({"oscillating", "the values swing about their limit"}, self.oscillating);
  }
};

/// What a series found of its order; of the first one a study's document holds it too.
struct OrderRecord {
  std::vector<LevelRecord> levels;
  std::optional<double> observed_order, expected_order, order_tolerance;
  std::optional<std::array<double, 2>> order_ci95;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"levels", "coarse to fine"}, self.levels);
    visit({"observed_order", "slope of the fitted line; of a geometric series its rate"}, self.observed_order);
    visit({"expected_order", "null: none is claimed"}, self.expected_order);
    visit({"order_tolerance", "accepted difference of the two orders"}, self.order_tolerance);
    visit({"order_ci95", "95 % interval of the observed order"}, self.order_ci95);
  }
};

struct SeriesRecord {
  std::string id, title, reference, step, error;
  Convergence kind = Convergence::kAlgebraic;
  OrderRecord order;
  bool higher_is_fine = false;
  std::optional<double> error_tolerance, error_floor;
  std::string floor;
  bool counts = true;
  std::optional<bool> asymptotic;
  std::optional<GciRecord> gci;
  bool passed = false;
  std::string verdict;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"id", "unique within the study"}, self.id);
    visit({"title", "what is solved, by what"}, self.title);
    visit({"reference", "in words, with its accuracy"}, self.reference);
    visit({"step", "words of the horizontal axis"}, self.step);
    visit({"error", "words of the vertical axis"}, self.error);
    visit({"kind", "how errors should fall"}, self.kind);
    OrderRecord::describe(self.order, visit);
    visit({"higher_is_fine", "a higher order than expected passes too"}, self.higher_is_fine);
    visit({"error_tolerance", "largest accepted error of the finest level"}, self.error_tolerance);
    visit({"error_floor", "levels at or below are left out of the fit"}, self.error_floor);
    visit({"floor", "what the floor is"}, self.floor);
    visit({"counts", "false: shown for comparison only"}, self.counts);
    visit({"asymptotic", "the last two pairwise orders agree with the fitted one"}, self.asymptotic);
    visit({"gci", "grid convergence index of the values on the three finest levels in the fit"}, self.gci);
    visit({"passed", "order and error within their bands"}, self.passed);
    visit({"verdict", "one sentence"}, self.verdict);
  }
};

/// A field that a study left beside its result.
struct FieldRecord {
  std::string name, title, caption, file;
  std::optional<std::string> quantity;
  std::optional<bool> decibels;
  std::optional<double> floor;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"name", "of the file, without its extension"}, self.name);
    visit({"title", "of the picture"}, self.title);
    visit({"caption", "one or two sentences"}, self.caption);
    visit({"file", "beside the result"}, self.file);
    visit(absent_if_empty({"quantity", "of the values, with its unit"}), self.quantity);
    visit(absent_if_empty({"decibels", "drawn as level over the largest"}), self.decibels);
    visit(absent_if_empty({"floor", "smallest value worth a colour"}), self.floor);
  }
};

struct FieldRecords {
  std::vector<FieldRecord> surfaces, slices, balloons;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"surfaces", "numbers on a surface (.vtp)"}, self.surfaces);
    visit({"slices", "pressure in a plane (.vti)"}, self.slices);
    visit({"balloons", "level in every direction (.vtp)"}, self.balloons);
  }
};

struct StudyDocument {
  ResultHeader header;
  std::string study, title, question;
  bool passed = false;
  OrderRecord main;
  std::vector<SeriesRecord> series;
  std::vector<Claim> claims;
  FieldRecords fields;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    ResultHeader::describe(self.header, visit);
    visit({"study", "its name"}, self.study);
    visit({"title", "of the page"}, self.title);
    visit({"question", "what is shown"}, self.question);
    visit({"passed", "every series that counts, and every claim"}, self.passed);
    OrderRecord::describe(self.main, visit);
    visit({"series", "one method on one problem each; the first is the main one"}, self.series);
    visit({"claims", "order and error of each series that counts, then the study's own"}, self.claims);
    visit({"fields", "what can be looked at"}, self.fields);
  }
};
StudyDocument study_document(ResultHeader header, const Study& study);

/// One row per level: series,level,h_m,n,error,value,pairwise_order,excluded,n_unknowns,error_low,error_high.
std::string levels_csv(const Study& study);

}  // namespace klang::validate
