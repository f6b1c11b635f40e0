#pragma once
#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/monitor.hpp"
#include "core/foundation/config/fields.hpp"
#include "core/physics/modal/modal_model.hpp"
#include "fit/frf/response_set.hpp"
#include "fit/ringdown/response_record.hpp"

namespace klang::fit {

struct ResponseOptions {
  Band band;
  int most_order = 60;    ///< of the stability chart
  void validate() const;  ///< InputError

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"band.low_hz", "Lowest frequency", between(0.0, 1e12)}, self.band.low_hz);
    visit({"band.high_hz", "Highest frequency", inside(0.0, 1e12)}, self.band.high_hz);
    visit({"most_order", "Highest order of the stability chart", between(2.0, 200.0)}, self.most_order);
  }
};

enum class ResponseStatus { kNotRun, kOk, kNothingFound };

struct ResponseAnalysis {
  ResponseStatus status = ResponseStatus::kNotRun;
  std::string message;  ///< why nothing was found
  /// Amplitude and phase are those of the largest response to a unit impulse (FRFs, in their unit times 1/s) or at the first
  /// sample used (decays).
  std::vector<AnalysisPartial> partials;
  ResponseRecord record;
  double explained_energy = 0.0;  ///< 1 - |misfit|^2 / |data|^2 in band, every response counting alike
  std::vector<std::string> warnings;
  bool usable() const { return status == ResponseStatus::kOk; }
};

/// Poles and shapes of a set: a stability chart over rising orders, poles that stand in it refined by least squares over all
/// responses, other estimators beside them.
/// @throws InputError: options, lines that are not even, fewer than 16 in band
ResponseAnalysis analyse_responses(const ResponseSet& set, const ResponseOptions& options,
                                   Monitor& monitor = silent_monitor());

/// Modal assurance criterion |a^H b|^2 / (a^H a b^H b), 0 to 1; 0 where one of them is 0.
double assurance(const Eigen::VectorXcd& a, const Eigen::VectorXcd& b);

/// Holds the shapes against a model's: the motion of its mesh node nearest to each place, along the measured direction.
/// @throws InputError: the set does not say where and in which direction it was measured, or a place lies further from the body than 5 % of its size
void compare_with_model(const ResponseSet& set, const modal::ModalModel& model, ResponseAnalysis& analysis);

}  // namespace klang::fit
