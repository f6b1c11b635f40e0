#pragma once
#include <vector>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/config/fields.hpp"
#include "core/sound/audio/signal.hpp"

namespace klang::audio {

struct StrikeOptions {
  Band band;                     ///< high_hz is cut to half the sample rate
  double min_rise_db = 6.0;      ///< how far the level must rise within 10 ms, 1 to 60
  double min_level_db = -26.0;   ///< against the loudest strike, -80 to 0
  double min_interval_s = 0.03;  ///< closer ones count as one, 0.005 to 10
  void validate() const;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"band.low_hz", "Lowest frequency", between(0.0, 1e9)}, self.band.low_hz);
    visit({"band.high_hz", "Highest frequency", inside(0.0, 1e9)}, self.band.high_hz);
    visit({"min_rise_db", "Rise of the level within 10 ms at least", between(1.0, 60.0)}, self.min_rise_db);
    visit({"min_level_db", "Level against the loudest strike at least", between(-80.0, 0.0)}, self.min_level_db);
    visit({"min_interval_s", "Closer strikes count as one", between(0.005, 10.0)}, self.min_interval_s);
  }
};

struct Strike {
  double time_s = 0.0;     ///< onset, from the signal's start
  double settled_s = 0.0;  ///< contact is over: from here on the body rings freely (12 ms later at most, 62
                           ///< ms after bounces)
  double level = 0.0;      ///< rms of the loudest 10 ms just after it, full scale = 1
};

/// Onsets of struck sounds, ascending. A strike is a rise of the level within 10 ms, in the whole band or in
/// a quarter of 24 logarithmic bands (10 ms Hann frames every 2.5 ms; the reference is the highest level of
/// the 10 to 40 ms before), which tells it from the slow rises of beating partials. The time is refined on
/// the 0.5 ms energy envelope. A mallet that touches the body again within 60 ms shows as a rise of a linear
/// predictor's error; settled_s lies after it. A signal that rings from its first frame has a strike at 0.
/// Empty when nothing rises.
/// @throws InputError for options out of range, no samples or a rate that is not positive.
std::vector<Strike> detect_strikes(const Signal& signal, const StrikeOptions& options = {});

}  // namespace klang::audio
