#pragma once
#include <optional>
#include <string>
#include <vector>

#include "core/foundation/config/result_header.hpp"

/// chime.json of `klang chime`: where to cut a set of chimes.
namespace klang::fit {

struct ChimeNote {
  std::string note;
  double frequency_hz = 0.0, length_m = 0.0;
  std::optional<double> length_std_m;
  std::string length_caveat;
  double cents_per_tenth_mm = 0.0, node_m = 0.0, node_rule_m = 0.0, residual_cents = 0.0;
  std::string specimen;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit(needed({"note", "as it was asked for"}), self.note);
    visit(needed({"frequency_hz", "of the first bending mode"}), self.frequency_hz);
    visit(needed({"length_m", "to cut"}), self.length_m);
    visit({"length_std_m",
           "its standard deviation: of the fitted material and of how far the struck ones lie from the model; null: "
           "not known"},
          self.length_std_m);
    visit(absent_if_empty({"length_caveat", "what length_std_m leaves out: \"without the tolerances of ...\""}),
          self.length_caveat);
    visit({"cents_per_tenth_mm", "by which the note falls when it is cut 0.1 mm too long (negative)"},
          self.cents_per_tenth_mm);
    visit({"node_m", "hanging point: node of the first bending mode, from either end, by the model"}, self.node_m);
    visit({"node_rule_m", "the same by the rule for slender bars: 22.4 % of the length"}, self.node_rule_m);
    visit({"residual_cents", "of the model at that length over the note"}, self.residual_cents);
    visit({"specimen", "of the fit, whose section and material it has"}, self.specimen);
  }
};

struct ChimeDocument {
  ResultHeader header;
  std::string name;
  double a4_hz = 440.0;
  std::string temperament, damping;
  std::vector<ChimeNote> notes;
  std::optional<std::string> sound;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    ResultHeader::describe(self.header, visit);
    visit({"name", "of the fit"}, self.name);
    visit({"a4_hz", "that the notes go by"}, self.a4_hz);
    visit({"temperament", "equal, just, or the name of a Scala file"}, self.temperament);
    visit({"damping", "of the sound: fitted, or assumed"}, self.damping);
    visit({"notes", "in the order in which they were asked for"}, self.notes);
    visit({"sound", "file beside the result: the set, one strike each"}, self.sound);
  }
};

}  // namespace klang::fit
