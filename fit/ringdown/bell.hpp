#pragma once
#include <optional>
#include <string>
#include <vector>

#include "core/foundation/config/fields.hpp"
#include "core/sound/audio/note.hpp"
#include "fit/ringdown/partial_table.hpp"

namespace klang::fit {

/// The partials that founders name. A partial that was not found is empty.
struct Bell {
  std::optional<double> hum_hz, prime_hz, tierce_hz, quint_hz, nominal_hz;
  std::optional<double> strike_note_hz;  ///< half the nominal: the pitch that is heard at the stroke
  std::string strike_note;               ///< the nearest note, "A4"
  bool found() const { return nominal_hz.has_value(); }

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"hum_hz", "hum, about 1/4 of the nominal"}, self.hum_hz);
    visit({"prime_hz", "prime (fundamental), about 1/2"}, self.prime_hz);
    visit({"tierce_hz", "tierce, about 3/5 (minor third), 5/8 in a major-third bell"}, self.tierce_hz);
    visit({"quint_hz", "quint, about 3/4"}, self.quint_hz);
    visit({"nominal_hz", "nominal"}, self.nominal_hz);
    visit({"strike_note_hz", "half the nominal: the pitch heard at the stroke"}, self.strike_note_hz);
    visit({"strike_note", "its nearest note"}, self.strike_note);
  }
};

/// Names the partials of a tuned bell. The nominal is the partial about which the others stand best: hum 1/4, prime 1/2,
/// tierce 3/5, quint 3/4, superquint 3/2 and octave nominal 2 of it (relative frequencies of Rossing, Science of
/// Percussion Instruments, 2000, ch. 11), each within 150 cents (hum 250), the louder of a doublet. Where fewer than three
/// of hum, prime, tierce and quint are there, nothing is named: the evidence does not make it a bell.
Bell name_bell(const std::vector<Partial>& partials, double a4_hz = audio::kConcertPitchHz);

}  // namespace klang::fit
