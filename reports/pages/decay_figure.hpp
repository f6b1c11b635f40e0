#pragma once
#include <optional>
#include <string>
#include <vector>

#include "fit/run/fit_document.hpp"
#include "reports/kit/svg_plot.hpp"

namespace klang::reports::detail {

/// A measured decay.
struct DecayMark {
  std::size_t series = 0;  ///< of the body
  std::string body;        ///< its name; may be empty
  fit::Partial partial;
  bool without_mode = false;  ///< hollow
};

struct DecayPlot {
  std::vector<DecayMark> marks;
  std::vector<std::string> bodies;         ///< names by series
  std::vector<fit::DampingRecord> models;  ///< best first
  std::string best;                        ///< name of the model that is drawn thick
};

/// Decay over frequency, measured with error bars, and every damping candidate's curve. Empty without a decay and a model.
std::optional<Svg> decay_figure(const DecayPlot& plot);

}  // namespace klang::reports::detail
