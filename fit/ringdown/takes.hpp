#pragma once
#include <optional>
#include <string>
#include <vector>

#include "core/foundation/base/monitor.hpp"
#include "core/foundation/config/fields.hpp"
#include "fit/ringdown/ringdown.hpp"

/// Single taps of a longer recording.
namespace klang::fit {

struct Take {
  double strike_s = 0.0;
  std::string note;
  std::optional<double> cents;
  std::vector<Partial> partials;
  std::optional<std::string> file;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"strike_s", "from where listening began"}, self.strike_s);
    visit({"note", "the nearest to the strongest partial"}, self.note);
    visit({"cents", "of the strongest partial above it"}, self.cents);
    visit({"partials", "of this tap"}, self.partials);
    visit({"file", "the take, beside the result"}, self.file);
  }
};

/// A tap and its ring, cut out of a recording.
struct TakeSound {
  double strike_s = 0.0;
  audio::Signal sound;  ///< from 20 ms before the strike to 20 ms before the next, or kLongestTakeS
};
inline constexpr double kLongestTakeS = 10.0;

/// The taps of a recording, at least min_gap_s apart: closer ones (bounces) are one. Empty where nothing is struck.
std::vector<TakeSound> cut_takes(const audio::Signal& recording, double min_gap_s = 0.3);

/// What rings in a take; empty where it is no tap (nothing decays, or too little of it is explained).
std::optional<Take> analysed_take(const TakeSound& take, double a4_hz, Monitor& monitor = silent_monitor());

}  // namespace klang::fit
