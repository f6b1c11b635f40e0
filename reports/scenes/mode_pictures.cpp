#include "reports/scenes/mode_pictures.hpp"

#include <map>

#include "reports/scenes/drawing_process.hpp"
#include "reports/scenes/mode_scene.hpp"

namespace klang::reports::detail {

RenderResult render_modes(const std::vector<ModePictureRequest>& requests, Monitor& monitor) {
  std::map<std::filesystem::path, std::vector<std::size_t>> by_file;
  for (std::size_t i = 0; i < requests.size(); ++i) by_file[requests[i].modes_file].push_back(i);
  const auto drawer = [&](const std::function<void(std::size_t, const std::optional<Drawing>&)>& done) {
    for (const auto& [file, rows] : by_file) {
      std::vector<int> modes;
      for (const std::size_t row : rows) modes.push_back(requests[row].mode_index);
      draw_modes(file, modes, [&](std::size_t k, const std::optional<ModeImage>& drawn) {
        std::optional<Drawing> drawing;
        if (drawn) drawing = Drawing{drawn->image, drawn->tangential, 0, 0};
        done(rows[k], drawing);
      });
    }
  };
  DrawnPictures drawn = draw_in_own_process(requests.size(), drawer, "mode pictures", "mode shapes", monitor);
  RenderResult result;
  result.warning = std::move(drawn.warning);
  for (DrawnPicture& picture : drawn.pictures)
    result.pictures.push_back({std::move(picture.png), picture.width, picture.height, picture.flag});
  return result;
}

}  // namespace klang::reports::detail
