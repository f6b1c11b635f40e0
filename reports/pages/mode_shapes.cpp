#include "reports/pages/mode_shapes.hpp"

#include <algorithm>

#include "reports/kit/raster.hpp"
#include "reports/kit/text.hpp"
#include "reports/pages/page_parts.hpp"
#include "reports/scenes/mode_pictures.hpp"

namespace klang::reports::detail {
namespace {

constexpr double kTwinRatio = 1.0003;

struct Wanted {
  std::size_t body;
  ModePicture picture;
};

std::vector<Wanted> chosen(const std::vector<BodyModes>& bodies, std::vector<std::vector<ModePicture>> candidates,
                           std::size_t limit) {
  std::vector<Wanted> wanted;
  const bool alike = std::all_of(bodies.begin(), bodies.end(), [&](const BodyModes& body) {
    return !body.kind.empty() && body.kind == bodies.front().kind;
  });
  if (alike && bodies.size() > 1) {
    for (std::size_t i = 0; i < bodies.size() && wanted.size() < limit; ++i) {
      if (candidates[i].empty()) continue;
      wanted.push_back({i, candidates[i].front()});
      candidates[i].erase(candidates[i].begin());
    }
    while (!candidates[0].empty() && wanted.size() < limit) {
      wanted.push_back({0, candidates[0].front()});
      candidates[0].erase(candidates[0].begin());
    }
  }
  for (std::size_t rank = 0; wanted.size() < limit; ++rank) {
    bool any = false;
    for (std::size_t i = 0; i < candidates.size() && wanted.size() < limit; ++i) {
      if (rank >= candidates[i].size()) continue;
      wanted.push_back({i, candidates[i][rank]});
      any = true;
    }
    if (!any) break;
  }
  return wanted;
}

std::string four_digits(int number) {
  std::string text = std::to_string(number);
  text.insert(0, text.size() < 4 ? 4 - text.size() : 0, '0');
  return text;
}

}  // namespace

std::vector<ModePicture> without_twins(const std::vector<ModePicture>& modes) {
  std::vector<ModePicture> kept;
  for (const ModePicture& mode : modes) {
    if (mode.mode_index < 0) continue;
    if (!kept.empty() && mode.frequency_hz < kept.back().frequency_hz * kTwinRatio) {
      kept.back().twins += (kept.back().twins.empty() ? " and its twin " : ", ") + std::to_string(mode.mode_index);
      continue;
    }
    kept.push_back(mode);
  }
  return kept;
}

std::vector<std::vector<ModePicture>> mode_pictures(const std::vector<BodyModes>& bodies, ReportFolder& folder) {
  std::vector<std::vector<ModePicture>> candidates(bodies.size()), pictures(bodies.size());
  std::vector<std::filesystem::path> files;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    files.push_back(folder.beside(bodies[i].modes_file));
    if (!files[i].empty()) candidates[i] = bodies[i].candidates;
  }
  if (!folder.options().pictures) return pictures;
  std::vector<Wanted> wanted =
      chosen(bodies, std::move(candidates), static_cast<std::size_t>(std::max(0, folder.options().max_mode_pictures)));
  if (wanted.empty()) return pictures;
  std::vector<ModePictureRequest> requests;
  for (const Wanted& entry : wanted) requests.push_back({files[entry.body], entry.picture.mode_index});
  RenderResult rendered = render_modes(requests, folder.monitor());
  if (!rendered.warning.empty()) folder.warn(rendered.warning);
  for (std::size_t k = 0; k < wanted.size(); ++k) {
    RenderedPicture& drawn = rendered.pictures[k];
    if (drawn.png.empty()) continue;
    ModePicture& picture = wanted[k].picture;
    picture.png = std::move(drawn.png);
    picture.width = drawn.width;
    picture.height = drawn.height;
    picture.tangential = drawn.tangential;
    folder.add_file("figures/" + bodies[wanted[k].body].stem + "-" + four_digits(picture.mode_index) + ".png",
                    picture.png);
    pictures[wanted[k].body].push_back(std::move(picture));
  }
  return pictures;
}

std::string shapes_html(const std::vector<ModePicture>& pictures) {
  if (pictures.empty()) return {};
  int wide = 0;
  std::string body;
  for (const ModePicture& picture : pictures) {
    if (picture.width > 2 * picture.height) ++wide;
    std::string caption = "<b>" + escaped(hertz(picture.frequency_hz)) + "</b> mode " +
                          std::to_string(picture.mode_index) + escaped(picture.twins) + picture.measured;
    if (picture.tangential) caption += "; moves within its surface only, colour is the size of the motion";
    body += "<figure><img alt=\"Shape of mode " + std::to_string(picture.mode_index) + " at " +
            escaped(hertz(picture.frequency_hz)) + "\" width=\"" + std::to_string(picture.width) + "\" height=\"" +
            std::to_string(picture.height) + "\" src=\"" + data_uri("image/png", picture.png) + "\">" +
            tag("figcaption", caption) + "</figure>\n";
  }
  return "<h3>Mode shapes</h3>\n<div class=\"shapes" +
         std::string(2 * wide > static_cast<int>(pictures.size()) ? " long" : "") + "\">" + body +
         "</div>\n<p class=\"how\"><small>The body at one extreme of its motion, greatly enlarged. Colour is "
         "the displacement normal to the surface, which is what sounds: red outwards, blue inwards; dark lines are the "
         "nodes.</small></p>\n";
}

}  // namespace klang::reports::detail
