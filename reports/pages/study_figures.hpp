#pragma once
#include <array>
#include <string>
#include <vector>

#include "reports/kit/raster.hpp"
#include "reports/kit/svg_plot.hpp"
#include "reports/pages/plot_parts.hpp"
#include "reports/scenes/drawing_process.hpp"
#include "reports/scenes/field_files.hpp"
#include "validate/studies/fields.hpp"
#include "validate/studies/study_document.hpp"

/// The plots of a convergence study.
namespace klang::reports::detail {

/// A field that a study left beside its result.
struct StudyField {
  FieldKind kind = FieldKind::kSurface;
  validate::FieldRecord record;
};

/// Error over step, one figure for each kind of step: measured levels (hollow where they are not in the fit), fitted lines
/// with their 95 % bands, slopes that are expected, floors.
std::vector<CaptionedFigure> convergence_figures(const validate::StudyDocument& study);

/// Error over unknowns, where levels differ in them and the step is a length.
std::vector<CaptionedFigure> cost_figures(const validate::StudyDocument& study);

/// The plane as an image with axes in metres and a colour bar.
Svg slice_figure(const StudyField& field, const validate::SliceField& slice);

/// A VTK picture of an error map or a balloon with its colour bar from low to high.
Svg picture_figure(const StudyField& field, const DrawnPicture& picture);

}  // namespace klang::reports::detail
