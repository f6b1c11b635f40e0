#include "reports/scenes/vtk_capture.hpp"

#include <vtkCamera.h>
#include <vtkLightKit.h>
#include <vtkRenderWindow.h>
#include <vtkRenderer.h>
#include <vtkUnsignedCharArray.h>

#include <algorithm>

namespace klang::reports::detail {

void look(vtkRenderer* renderer, const View& view) {
  vtkCamera* const camera = renderer->GetActiveCamera();
  camera->ParallelProjectionOn();
  camera->SetFocalPoint(view.centre_m.data());
  camera->SetPosition(view.eye_m.data());
  camera->SetViewUp(view.up.data());
  camera->SetParallelScale(view.half_height_m);
  renderer->ResetCameraClippingRange();
}

RgbaImage captured(vtkRenderer* renderer, int columns, int rows) {
  vtkNew<vtkLightKit> light;
  light->SetKeyLightIntensity(0.9);
  light->SetKeyLightWarmth(0.5);  // white: the colours mean something
  light->SetFillLightWarmth(0.5);
  light->SetBackLightWarmth(0.5);
  light->SetKeyToFillRatio(2.2);
  light->AddLightsToRenderer(renderer);
  renderer->SetBackground(1, 1, 1);
  renderer->SetBackgroundAlpha(0);
  vtkNew<vtkRenderWindow> window;
  window->SetOffScreenRendering(1);
  window->SetAlphaBitPlanes(1);
  window->SetMultiSamples(0);
  window->SetSize(columns, rows);
  window->AddRenderer(renderer);
  window->Render();
  vtkNew<vtkUnsignedCharArray> pixels;
  if (window->GetRGBACharPixelData(0, 0, columns - 1, rows - 1, 0, pixels) != VTK_OK) return {};
  RgbaImage image{columns, rows, {}};
  image.pixels.resize(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows) * 4);
  for (int row = 0; row < rows; ++row) {  // VTK's first row is the lowest
    const unsigned char* from = pixels->GetPointer(static_cast<vtkIdType>(rows - 1 - row) * columns * 4);
    std::copy(from, from + static_cast<std::ptrdiff_t>(columns) * 4,
              image.pixels.begin() + static_cast<std::ptrdiff_t>(row) * columns * 4);
  }
  return image;
}

vtkNew<vtkLookupTable> heat_table(double low, double high) {
  vtkNew<vtkLookupTable> table;
  table->SetNumberOfTableValues(256);
  for (std::size_t i = 0; i < 256; ++i) {
    const auto& colour = heat_palette()[i];
    table->SetTableValue(static_cast<vtkIdType>(i), colour[0] / 255.0, colour[1] / 255.0, colour[2] / 255.0, 1.0);
  }
  table->SetTableRange(low, high);
  return table;
}

}  // namespace klang::reports::detail
