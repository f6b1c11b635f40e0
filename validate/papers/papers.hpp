#pragma once
#include <filesystem>
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

/// What ours is.
enum class NumberSource {
  kProgram,   ///< by a function of this program that it has for its users
  kPaper,     ///< arithmetic on other numbers of the paper, or its own law: whether the paper agrees with itself
  kElsewhere  ///< a value that is known from elsewhere: a preset, a textbook's constant, equal temperament
};
constexpr auto words_of(NumberSource) {
  return std::array{Word{NumberSource::kProgram, "computed by the program"},
                    Word{NumberSource::kPaper, "the paper against itself"},
                    Word{NumberSource::kElsewhere, "a value from elsewhere"}};
}

/// A number that a paper prints, beside what should stand there. A number that is called wrong has a reference.
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
  NumberSource source = NumberSource::kProgram;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"id", "unique"}, self.id);
    visit({"paper", "its short name: S02, H03, B99, D02, HF, SB"}, self.paper);
    visit({"place", "table or section"}, self.place);
    visit({"quantity", "with its unit"}, self.quantity);
    visit({"printed", "by the paper"}, self.printed);
    visit({"ours", "what should stand there, of the source said"}, self.ours);
    visit({"source", "what ours is"}, self.source);
    visit({"reference", "made outside this project, the paper's own law, or as its source says"}, self.reference);
    visit({"reference_source", "where that is from"}, self.reference_source);
    visit({"reference_tolerance", "relative, of ours to the reference"}, self.reference_tolerance);
    visit({"tolerance", "relative, of ours to the printed number"}, self.tolerance);
    visit({"tolerance_source", "why so much; \"chosen: ...\": by us, neither digits nor theory give it"},
          self.tolerance_source);
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

enum class SceneVerdict {
  kNotRun,
  kAgrees,     ///< within a tenth
  kSameOrder,  ///< within a factor of two
  kOther,
  kNotJudged  ///< another machine, or the paper prints no number
};
constexpr auto words_of(SceneVerdict) {
  return std::array{Word{SceneVerdict::kNotRun, "not run"}, Word{SceneVerdict::kAgrees, "agrees"},
                    Word{SceneVerdict::kSameOrder, "same order"}, Word{SceneVerdict::kOther, "other"},
                    Word{SceneVerdict::kNotJudged, "not judged"}};
}

/// What a scene says of a paper's number; scenes take minutes to hours and are run by hand. Sizes that a paper does not give are ours, so
/// that none of these is part of what passes.
struct PaperScene {
  std::string paper, place, scene, quantity;
  std::optional<double> printed;  ///< none: only words are
  std::optional<double> ours;     ///< of a run; none: not run
  std::string command, version;   ///< that made the run
  std::string note;
  std::string reason;  ///< why it is not run or not judged
  SceneVerdict verdict = SceneVerdict::kNotRun;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"paper", "its short name"}, self.paper);
    visit({"place", "table or figure"}, self.place);
    visit({"scene", "file"}, self.scene);
    visit({"quantity", "of the run"}, self.quantity);
    visit({"printed", "by the paper; null: in words only"}, self.printed);
    visit({"ours", "of a run in the folder given, or of the run by hand that was kept; null: none"}, self.ours);
    visit({"command", "that makes, or made, the run"}, self.command);
    visit({"version", "of the program that made it; \"\": not run"}, self.version);
    visit({"note", "what is to be known"}, self.note);
    visit({"verdict", "agrees: within a tenth; same order: within a factor of two"}, self.verdict);
    visit({"reason", "why it is not run or not judged"}, self.reason);
  }
};

struct PaperTables {
  std::vector<PaperNumber> numbers;
  std::vector<PaperScene> scenes;
  std::vector<PaperGap> gaps;
  bool passed() const;
};

/// Verdict of a number from its printed value, ours, the reference and the tolerances; one that is called wrong without a
/// reference for what is right differs.
PaperVerdict verdict_of(const PaperNumber& number);

/// What the papers' tables print beside what should stand there (half a minute on one core).
///   S02: O'Brien, Shen and Gatchalian 2002;  SB: Zheng and James 2010;  HF: Zheng and James 2009;  H03: Hauser, Shen and
///   O'Brien 2003;  B99, D02: O'Brien and Hodgins 1999, O'Brien, Bargteil and Hodgins 2002
/// @param runs  folder of `klang scene run` folders, PAPER_NAME each (sb_tile for scenes/sb/tile.toml); empty: the runs that were kept.
///              Runs that are unfinished, partial or of another scene are not judged (PaperScene::reason)
/// @throws InputError (runs is no folder, or holds a file that is no result), NumericalError, Interrupted
PaperTables run_papers(Monitor& monitor = silent_monitor(), const std::filesystem::path& runs = {});

/// "not run (unfinished)", "not judged: the first 0.1 s of 0.9 s"
std::string verdict_words(const PaperScene& scene);

std::vector<Claim> claims_of(const PaperTables& tables);

/// papers.json of `klang validate papers`; status passed or not_passed.
struct PapersDocument {
  ResultHeader header;
  bool passed = false;
  std::vector<PaperNumber> numbers;
  std::vector<PaperScene> scenes;
  std::vector<PaperGap> not_computed;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    ResultHeader::describe(self.header, visit);
    visit({"passed", "no number differs without a known reason"}, self.passed);
    visit({"numbers", "printed, ours, reference, verdict"}, self.numbers);
    visit({"scenes", "what runs of scenes say; no part of passed"}, self.scenes);
    visit({"not_computed", "what the papers print and this program cannot compute"}, self.not_computed);
  }
};
PapersDocument papers_document(ResultHeader header, const PaperTables& tables);

/// The table as Markdown, what docs/papers.md holds.
std::string markdown(const PaperTables& tables);

}  // namespace klang::validate
