#pragma once
#include <map>
#include <string>
#include <vector>

#include "core/foundation/config/result_header.hpp"
#include "fit/tune/tune.hpp"

/// The result of `klang tune`.
namespace klang::fit {

struct TunedTargetRecord {
  TunedTarget target;
  std::map<std::string, double> hz_per_mm, cents_per_tenth_mm;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"mode", "as it was asked for"}, self.target.mode);
    visit({"mode_index", "elastic mode, from 0"}, self.target.mode_index);
    visit({"wanted_hz", "as asked"}, self.target.wanted_hz);
    visit({"start_hz", "of the body as it was"}, self.target.start_hz);
    visit({"reached_hz", "of the tuned body"}, self.target.reached_hz);
    visit({"residual_cents", "reached over wanted"}, self.target.residual_cents);
    visit({"hz_per_mm", "by dimension"}, self.hz_per_mm);
    visit({"cents_per_tenth_mm", "by dimension: what a cut of 0.1 mm does"}, self.cents_per_tenth_mm);
  }
};

struct TuneDocument {
  ResultHeader header;
  std::vector<TunedDimension> dimensions;
  std::vector<TunedTargetRecord> targets;
  int n_rounds = 0;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    ResultHeader::describe(self.header, visit);
    visit({"dimensions", "that could change"}, self.dimensions);
    visit({"targets", "modes and their frequencies"}, self.targets);
    visit({"n_rounds", "of meshing anew"}, self.n_rounds);
  }
};
TuneDocument tune_document(const TuneResult& result, Provenance provenance);

}  // namespace klang::fit
