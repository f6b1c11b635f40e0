#pragma once
#include <vtkLookupTable.h>
#include <vtkNew.h>

#include "reports/kit/raster.hpp"

class vtkRenderer;

namespace klang::reports::detail {

/// White light from the upper left on a transparent ground, drawn off screen. Empty pixels where OpenGL gives none.
RgbaImage captured(vtkRenderer* renderer, int columns, int rows);

/// heat_palette() from low to high.
vtkNew<vtkLookupTable> heat_table(double low, double high);

}  // namespace klang::reports::detail
