#pragma once
#include <optional>
#include <string>
#include <vector>

#include "core/foundation/base/monitor.hpp"
#include "core/foundation/config/result_header.hpp"
#include "validate/claim/claim.hpp"

namespace klang::validate {

enum class PaperVerdict {
  kNotRun,
  kAgrees,    ///< ours is the printed number within the tolerance (and the reference, where there is one)
  kPaperOff,  ///< known to be misprinted or inaccurate, and ours is not the printed number; the note says why
  kDiffers    ///< ours is neither, or it is off its reference, or a number that was called wrong agrees: not passed
};
constexpr auto words_of(PaperVerdict) {
  return std::array{Word{PaperVerdict::kNotRun, "not run"}, Word{PaperVerdict::kAgrees, "agrees"},
                    Word{PaperVerdict::kPaperOff, "paper is off"}, Word{PaperVerdict::kDiffers, "differs"}};
}

/// A number that a paper prints, beside what this program computes for it.
struct PaperNumber {
  std::string id;        ///< "s02.table2.d5.computed": unique
  std::string paper;     ///< "S02"
  std::string place;     ///< "Table 2"
  std::string quantity;  ///< "D5, lowest bending frequency [Hz]"
  double printed = 0.0;
  double ours = 0.0;
  std::optional<double>
      reference;  ///< made outside this project (a file of independent values), or the paper's own law
  std::string reference_source;
  double reference_tolerance = 1e-6;  ///< relative, of ours
  double tolerance = 0.0;             ///< relative, of ours to the printed number
  std::string tolerance_source;
  bool paper_off = false;  ///< the printed number is known not to be what it should
  std::string note;
  PaperVerdict verdict = PaperVerdict::kNotRun;
  int digits = 6;  ///< of ours that are the same on any machine: what the Markdown shows

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"id", "unique"}, self.id);
    visit({"paper", "its short name: S02, SB, HF, M03"}, self.paper);
    visit({"place", "table or section"}, self.place);
    visit({"quantity", "with its unit"}, self.quantity);
    visit({"printed", "by the paper"}, self.printed);
    visit({"ours", "computed when the command ran"}, self.ours);
    visit({"reference", "made outside this project, or the paper's own law"}, self.reference);
    visit({"reference_source", "where that is from"}, self.reference_source);
    visit({"reference_tolerance", "relative, of ours to the reference"}, self.reference_tolerance);
    visit({"tolerance", "relative, of ours to the printed number"}, self.tolerance);
    visit({"tolerance_source", "why so much"}, self.tolerance_source);
    visit({"note", "what is to be known"}, self.note);
    visit({"verdict", "of the number"}, self.verdict);
  }
};

/// What the papers print and this program cannot compute, or that says nothing here.
struct PaperGap {
  std::string paper, place, reason;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"paper", "its short name"}, self.paper);
    visit({"place", "table or section"}, self.place);
    visit({"reason", "why it is not computed"}, self.reason);
  }
};

struct PaperTables {
  std::vector<PaperNumber> numbers;
  std::vector<PaperGap> gaps;
  bool passed() const;
};

/// Verdict of a number from its printed value, ours, the reference and the tolerances.
PaperVerdict verdict_of(const PaperNumber& number);

/// Computes every number of the papers' tables that the program can, at once (half a minute on one core).
///   S02: O'Brien, Shen and Gatchalian 2002;  SB: Zheng and James 2010;  HF: Zheng and James 2009;  M03: Hauser, Shen and
///   O'Brien 2003;  B99, D02: O'Brien and Hodgins 1999, O'Brien, Bargteil and Hodgins 2002 (nothing yet)
/// @throws NumericalError, Interrupted
PaperTables run_papers(Monitor& monitor = silent_monitor());

std::vector<Claim> claims_of(const PaperTables& tables);

/// papers.json of `klang validate papers`; status passed or not_passed.
struct PapersDocument {
  ResultHeader header;
  bool passed = false;
  std::vector<PaperNumber> numbers;
  std::vector<PaperGap> not_computed;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    ResultHeader::describe(self.header, visit);
    visit({"passed", "no number differs without a known reason"}, self.passed);
    visit({"numbers", "printed, ours, reference, verdict"}, self.numbers);
    visit({"not_computed", "what the papers print and this program cannot compute"}, self.not_computed);
  }
};
PapersDocument papers_document(ResultHeader header, const PaperTables& tables);

/// The table as Markdown, what docs/papers.md holds.
std::string markdown(const PaperTables& tables);

}  // namespace klang::validate
