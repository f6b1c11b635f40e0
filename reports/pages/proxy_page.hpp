#pragma once
#include <optional>
#include <string>
#include <vector>

#include "reports/kit/result_data.hpp"
#include "reports/kit/svg_plot.hpp"

/// The page of `klang proxy fit`.
namespace klang::reports::detail {

/// Partials of target, start and fit over frequency, and how far start and fit lie from the target, rank by rank.
Svg proxy_partials_figure(const ProxyFitData& data);
/// The three views along the axes of both ellipsoids, to one scale.
Svg proxy_shape_figure(const ProxyFitData& data);

std::string proxy_measure_table(const ProxyFitData& data);
std::string proxy_parameter_table(const ProxyFitData& data);
std::string proxy_partial_table(const ProxyFitData& data);
std::string proxy_key_figures(const ProxyFitData& data);
std::vector<std::string> proxy_sentences(const ProxyFitData& data);

}  // namespace klang::reports::detail
