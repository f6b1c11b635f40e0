#pragma once
#include <vector>

#include "core/foundation/config/result_header.hpp"
#include "core/sound/audio/note.hpp"
#include "fit/iet/iet_document.hpp"
#include "fit/ringdown/takes.hpp"

/// listen.json of `klang listen`: taps as they came, and the moduli of a specimen whose dimensions and mass are known.
namespace klang::fit {

struct ListenDocument {
  ResultHeader header;
  double a4_hz = audio::kConcertPitchHz;
  std::vector<Take> takes;
  std::vector<IetRow> moduli;
  std::vector<IetSummary> summary;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    ResultHeader::describe(self.header, visit);
    visit({"a4_hz", "that the notes go by"}, self.a4_hz);
    visit({"takes", "taps, in the order in which they came"}, self.takes);
    visit({"moduli", "of each tap, where dimensions and mass are given: as a specimen of iet.json"}, self.moduli);
    visit({"summary", "mean and standard deviation over the taps, without outliers"}, self.summary);
  }
};

}  // namespace klang::fit
