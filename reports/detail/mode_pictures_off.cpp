#include "reports/detail/mode_pictures.hpp"

namespace klang::reports::detail {

RenderResult render_modes(const std::vector<ModePictureRequest>& requests, Monitor&) {
  return {std::vector<RenderedPicture>(requests.size()),
          requests.empty() ? "" : "built without VTK: mode pictures left out"};
}

}  // namespace klang::reports::detail
