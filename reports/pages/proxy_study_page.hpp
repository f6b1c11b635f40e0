#pragma once
#include <optional>
#include <string>
#include <vector>

#include "reports/kit/result_data.hpp"
#include "reports/kit/svg_plot.hpp"

/// The page of `klang proxy study`.
namespace klang::reports::detail {

/// Distances of the mix from the all-direct mix over the threshold.
Svg proxy_error_figure(const ProxyStudyData& data);
/// Processor time over the threshold.
Svg proxy_time_figure(const ProxyStudyData& data);
std::string proxy_threshold_table(const ProxyStudyData& data);
std::string proxy_piece_table(const ProxyStudyData& data);
std::string proxy_stage_table(const ProxyStudyData& data);
std::string proxy_study_key_figures(const ProxyStudyData& data);
std::vector<std::string> proxy_study_sentences(const ProxyStudyData& data);

}  // namespace klang::reports::detail
