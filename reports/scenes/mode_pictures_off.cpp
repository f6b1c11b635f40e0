#include "reports/scenes/frame_scene.hpp"
#include "reports/scenes/liquid_pictures.hpp"
#include "reports/scenes/mode_pictures.hpp"
#include "reports/scenes/study_pictures.hpp"

namespace klang::reports::detail {

RenderResult render_modes(const std::vector<ModePictureRequest>& requests, Monitor&) {
  return {std::vector<RenderedPicture>(requests.size()),
          requests.empty() ? "" : "built without VTK: mode pictures left out"};
}

DrawnPictures render_fields(const std::vector<FieldPictureRequest>& requests, Monitor&) {
  DrawnPictures result;
  result.pictures.resize(requests.size());
  if (!requests.empty()) result.warning = "built without VTK pictures: pictures left out";
  return result;
}

DrawnPictures render_frames(const std::vector<FramePictureRequest>& requests, Monitor&) {
  DrawnPictures result;
  result.pictures.resize(requests.size());
  if (!requests.empty()) result.warning = "built without VTK pictures: stills left out";
  return result;
}

DrawnPictures render_liquid(const std::vector<LiquidPictureRequest>& requests, Monitor& monitor) {
  return render_fields(std::vector<FieldPictureRequest>(requests.size()), monitor);
}

}  // namespace klang::reports::detail
