#pragma once
#include <vtkLookupTable.h>
#include <vtkNew.h>

#include <Eigen/Core>

#include "reports/kit/raster.hpp"

class vtkRenderer;

namespace klang::reports::detail {

/// White light from the upper left on a transparent ground, drawn off screen. Empty pixels where OpenGL gives none.
RgbaImage captured(vtkRenderer* renderer, int columns, int rows);

/// Parallel projection; the picture is 2 half_height_m high and has `centre_m` in its middle.
struct View {
  Eigen::Vector3d centre_m, eye_m;
  double half_height_m;
  Eigen::Vector3d up = Eigen::Vector3d::UnitZ();
};
void look(vtkRenderer* renderer, const View& view);

/// heat_palette() from low to high.
vtkNew<vtkLookupTable> heat_table(double low, double high);

}  // namespace klang::reports::detail
