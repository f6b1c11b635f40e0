#include "reports/pages/page.hpp"
#include "validate/claim/tally_document.hpp"

namespace klang::reports::detail {
namespace {

Page make(const validate::TallyDocument& document, ReportFolder&) {
  Page page;
  page.title = "Tally";
  page.sentences.push_back(std::to_string(document.n_taps) + " taps were counted.");
  return page;
}

}  // namespace

PageKind tally_page() { return page_kind<validate::TallyDocument>("tally", make); }

}  // namespace klang::reports::detail
