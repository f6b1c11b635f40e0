#pragma once
#include <string>
#include <vector>

#include "core/foundation/config/fields.hpp"
#include "fit/bubble/bubble_search.hpp"

namespace klang::fit::bubble {

/// What speaks for and against a recording of bubbles, as shares of energy from 0 to 1. Of the rings' energy if nothing else is
/// said; "clear" leaves out rings too short or too noisy to tell.
struct RecordingEvidence {
  double explained = 0.0;  ///< by bubbles, of the recording's energy above its noise
  double bubbles = 0.0;    ///< of the clear rings'
  double struck = 0.0;     ///< three or more rings of steady pitch that begin within 3 ms
  double gliding = 0.0;    ///< rings that begin where and at the pitch at which another is, of the clear rings'
  double falling = 0.0;    ///< rings whose pitch falls by 5 % or more, of the clear rings'
  double driven = 0.0;     ///< rings whose amplitude does not fall as a bubble's, of the clear rings'

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"explained", "by bubbles, of the energy above the noise"}, self.explained);
    visit({"bubbles", "of the clear rings' energy, as the following but struck"}, self.bubbles);
    visit({"struck", "three or more rings of steady pitch that begin together, of all rings' energy"}, self.struck);
    visit({"gliding", "rings that go on where another ends"}, self.gliding);
    visit({"falling", "rings of falling pitch"}, self.falling);
    visit({"driven", "rings whose amplitude does not fall as a bubble's"}, self.driven);
  }
};

RecordingEvidence evidence_of(const BubbleSearchResult& found);

/// Why a recording is none of bubbles, whatever single rings look like; empty where nothing speaks against it. The limits
/// stand in docs/bubbles.md.
std::string refusal_of(const BubbleSearchResult& found, const RecordingEvidence& evidence);

}  // namespace klang::fit::bubble
