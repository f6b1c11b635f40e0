#pragma once
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "fit/ringdown/partial_table.hpp"

/// What an analysis of FRFs or free decays at several places adds to analysis.json.
namespace klang::fit {

/// A partial with the shape in which it moves the places of measurement.
struct AnalysisPartial : Partial {
  std::vector<std::vector<double>> shape;  ///< [re, im] per response; the largest is 1 + 0i
  std::optional<int> model_mode;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    Partial::describe(self, visit);
    visit(absent_if_empty(
              {"shape",
               "of FRFs and decays at several places: [[re, im], ...], one per response; the largest is [1, 0]"}),
          self.shape);
    visit(absent_if_empty({"model_mode", "with --modes: mode of the model whose shape is most alike, from 0"}),
          self.model_mode);
  }
};

inline std::vector<AnalysisPartial> with_shapes(const std::vector<Partial>& partials) {
  std::vector<AnalysisPartial> result;
  for (const Partial& partial : partials) result.push_back({partial, {}, {}});
  return result;
}
inline std::vector<Partial> without_shapes(const std::vector<AnalysisPartial>& partials) {
  return {partials.begin(), partials.end()};
}

/// A pole of one order in the stability chart.
struct StabilityPole {
  int order = 0;
  double frequency_hz = 0.0, decay_per_s = 0.0;
  bool stable = false;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"order", "of the model"}, self.order);
    visit({"frequency_hz", "of the pole"}, self.frequency_hz);
    visit({"decay_per_s", "of the amplitude"}, self.decay_per_s);
    visit({"stable", "the order before has it within 1 % in frequency and 5 % in decay"}, self.stable);
  }
};

/// What one estimator says of a partial.
struct PoleEstimate {
  int partial = 0;
  std::string estimator;
  double frequency_hz = 0.0, decay_per_s = 0.0;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"partial", "its place in partials, from 0"}, self.partial);
    visit({"estimator", "least_squares (what partials hold), lscf, era or ringdown"}, self.estimator);
    visit({"frequency_hz", "of the pole"}, self.frequency_hz);
    visit({"decay_per_s", "of the amplitude"}, self.decay_per_s);
  }
};

/// Where a response was measured.
struct ResponsePlace {
  int node = 0, direction = 0;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"node", "of the file"}, self.node);
    visit({"direction", "1, 2, 3 for +x, +y, +z, negative the other way; 0: not known"}, self.direction);
  }
};

enum class ResponseKind { kFrf, kDecay };
constexpr auto words_of(ResponseKind) {
  return std::array{Word{ResponseKind::kFrf, "frf"}, Word{ResponseKind::kDecay, "decay"}};
}

struct ResponseRecord {
  ResponseKind kind = ResponseKind::kFrf;
  std::string unit;
  std::vector<ResponsePlace> places;
  std::vector<StabilityPole> stability;
  std::vector<PoleEstimate> estimates;
  std::vector<double> curve_hz, curve_db;
  std::vector<std::vector<double>> auto_mac, mac;
  std::vector<double> model_hz;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"kind", "frf or decay"}, self.kind);
    visit({"unit",
           "of the responses, m/s^2/N of FRFs and m/s^2 of decays or as the file has it (of a universal file the "
           "ordinate's over its denominator's)"},
          self.unit);
    visit({"places", "of the responses"}, self.places);
    visit({"stability", "chart: poles of rising orders, of FRFs by lscf, of decays by era"}, self.stability);
    visit({"estimates", "each partial by each estimator"}, self.estimates);
    visit(absent_if_empty({"curve_hz", "of FRFs: where curve_db stands, at most 600 lines"}), self.curve_hz);
    visit(
        absent_if_empty({"curve_db", "20 log10 of the responses' rms in their unit, the largest of its neighbourhood"}),
        self.curve_db);
    visit({"auto_mac", "modal assurance criterion of the partials' shapes with each other, 0 to 1"}, self.auto_mac);
    visit(absent_if_empty({"mac", "with --modes: of each partial's shape with each mode's"}), self.mac);
    visit(absent_if_empty({"model_hz", "with --modes: frequencies of these modes"}), self.model_hz);
  }
};

}  // namespace klang::fit
