#pragma once
#include <optional>
#include <string>
#include <vector>

#include "reports/kit/result_data.hpp"
#include "reports/kit/svg_plot.hpp"
#include "reports/pages/spectrogram.hpp"

namespace klang::reports::detail {

/// The fitted chirps as lines over a spectrogram, and a window that shows chirps of their pitch.
Ridges ridges_of(const BubbleData& bubbles);

/// Measured decay over pitch against a free bubble's; empty without rings.
std::optional<Svg> bubble_decay_figure(const BubbleData& bubbles);

std::string bubble_table(const BubbleData& bubbles);
std::string pitch_table(const BubbleData& bubbles);
std::string bubble_key_figures(const ResultData& data);
std::vector<std::string> bubble_sentences(const ResultData& data);

}  // namespace klang::reports::detail
