#include "validate/claim/claim.hpp"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/errors.hpp"

namespace klang::validate {
namespace {

/// Text inside an XML attribute; control characters, which XML 1.0 does not allow, become spaces.
std::string attribute(std::string_view text) {
  std::string result;
  for (const char c : text) {
    switch (c) {
      case '&':
        result += "&amp;";
        break;
      case '<':
        result += "&lt;";
        break;
      case '>':
        result += "&gt;";
        break;
      case '"':
        result += "&quot;";
        break;
      default:
        result += static_cast<unsigned char>(c) < 0x20 ? ' ' : c;
    }
  }
  return result;
}

}  // namespace

Claim judged(Claim claim) {
  claim.passed =
      claim.not_judged.empty() && std::abs(claim.measured - claim.reference.value_or(0.0)) <= claim.tolerance;
  return claim;
}

std::string junit_xml(std::string_view suite, const std::vector<Claim>& claims) {
  const auto n_skipped =
      std::count_if(claims.begin(), claims.end(), [](const Claim& c) { return !c.not_judged.empty(); });
  const auto n_failed =
      std::count_if(claims.begin(), claims.end(), [](const Claim& c) { return !c.passed; }) - n_skipped;
  const std::string counts =
      " tests=\"" + std::to_string(claims.size()) + "\" failures=\"" + std::to_string(n_failed) + "\" errors=\"0\"";
  std::string xml = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites" + counts + ">\n<testsuite name=\"" +
                    attribute(suite) + "\"" + counts + " skipped=\"" + std::to_string(n_skipped) + "\">\n";
  for (const Claim& claim : claims) {
    xml += "<testcase classname=\"" + attribute(suite) + "\" name=\"" + attribute(claim.name) + "\"";
    const std::string facts = "measured " + to_text(claim.measured) +
                              (claim.reference ? ", reference " + to_text(*claim.reference) : "") + ", tolerance " +
                              to_text(claim.tolerance);
    if (!claim.not_judged.empty()) {
      xml += "><skipped message=\"" + attribute(claim.words + ": " + claim.not_judged) + "\"/></testcase>\n";
    } else if (claim.passed) {
      xml += "><system-out>" + attribute(claim.words + ": " + facts) + "</system-out></testcase>\n";
    } else {
      xml += "><failure type=\"claim\" message=\"" + attribute(facts) + "\">" + attribute(claim.words) +
             "</failure></testcase>\n";
    }
  }
  return xml + "</testsuite>\n</testsuites>\n";
}

}  // namespace klang::validate
