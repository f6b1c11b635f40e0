#pragma once
#include <string>
#include <utility>
#include <vector>

#include "reports/kit/result_data.hpp"
#include "reports/pages/study_figures.hpp"

namespace klang::reports::detail {

struct StudyPicture {
  StudyField field;
  Svg svg;
};

struct StudyParts {
  std::vector<CaptionedFigure> convergence, cost;
  std::vector<StudyPicture> pictures;
};

struct StudySection {
  std::string id, name, html;
};

std::vector<StudySection> study_sections(const StudyData& study, const StudyParts& parts);
std::string study_key_figures(const StudyData& study);
/// Sentences that say what came out; HTML.
std::vector<std::string> study_sentences(const StudyData& study);

}  // namespace klang::reports::detail
