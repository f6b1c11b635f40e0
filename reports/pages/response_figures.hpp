#pragma once
#include <string>

#include "fit/ringdown/analysis_document.hpp"
#include "reports/kit/report_folder.hpp"

namespace klang::reports::detail {

/// Of responses at several places: the stability chart, poles by each estimator, shapes and their modal assurance; empty
/// without responses. Adds figures/stability.
std::string stability_html(const fit::AnalysisDocument& data, ReportFolder& folder);
std::string assurance_html(const fit::AnalysisDocument& data);

}  // namespace klang::reports::detail
