#include "reports/scenes/study_pictures.hpp"

#include "reports/scenes/study_scene.hpp"

namespace klang::reports::detail {

DrawnPictures render_fields(const std::vector<FieldPictureRequest>& requests, Monitor& monitor) {
  const auto drawer = [&](const std::function<void(std::size_t, const std::optional<Drawing>&)>& done) {
    for (std::size_t i = 0; i < requests.size(); ++i) {
      std::optional<Drawing> drawing;
      if (const auto drawn = draw_field(requests[i].file, requests[i].kind))
        drawing = Drawing{drawn->image, false, drawn->low, drawn->high};
      done(i, drawing);
    }
  };
  return draw_in_own_process(requests.size(), drawer, "pictures", "fields", monitor);
}

}  // namespace klang::reports::detail
