#pragma once
#include <array>
#include <string>
#include <vector>

#include "reports/kit/raster.hpp"
#include "reports/kit/result_data.hpp"
#include "reports/kit/svg_plot.hpp"
#include "validate/studies/fields.hpp"

/// The plots of a convergence study.
namespace klang::reports::detail {

struct CaptionedFigure {
  Svg svg;
  std::string stem;     ///< of its files
  std::string caption;  ///< HTML
};

/// Error over step, one figure for each kind of step: measured levels (hollow where they are not in the fit), fitted lines
/// with their 95 % bands, slopes that are expected, floors.
std::vector<CaptionedFigure> convergence_figures(const StudyData& study);

/// Error over unknowns, where levels differ in them and the step is a length.
std::vector<CaptionedFigure> cost_figures(const StudyData& study);

/// The plane as an image with axes in metres and a colour bar.
Svg slice_figure(const StudyField& field, const validate::SliceField& slice);

/// A VTK picture of an error map or a balloon with its colour bar from low to high.
Svg picture_figure(const StudyField& field, const std::string& png, int width, int height, double low, double high);

}  // namespace klang::reports::detail
