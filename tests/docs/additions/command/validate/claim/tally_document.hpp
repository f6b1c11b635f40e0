#pragma once
#include "core/foundation/config/fields.hpp"
#include "core/foundation/config/result_header.hpp"

namespace klang::validate {

/// What klang tally writes.
struct TallyDocument {
  ResultHeader header;
  int n_taps = 0;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    ResultHeader::describe(self.header, visit);
    visit({"n_taps", "taps that were counted"}, self.n_taps);
  }
};

}  // namespace klang::validate
