#include "core/sound/scene/detail/glb_buffers.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace klang::scene::detail {
namespace {

using nlohmann::json;

constexpr int kFloat = 5126, kUnsigned = 5125, kVertices = 34962, kCorners = 34963;  // glTF's numbers

}  // namespace

int GlbBuffers::add_accessor(json view, json accessor) {
  accessor["bufferView"] = views.size();
  views.push_back(std::move(view));
  accessors.push_back(std::move(accessor));
  return static_cast<int>(accessors.size()) - 1;
}

int GlbBuffers::add(const std::vector<float>& values, int width, bool vertices, bool with_range) {
  static const char* const kTypes[] = {"", "SCALAR", "", "VEC3", "VEC4"};
  json view = {{"buffer", 0}, {"byteOffset", bytes.size()}, {"byteLength", values.size() * sizeof(float)}};
  if (vertices) view["target"] = kVertices;
  json accessor = {
      {"componentType", kFloat}, {"count", values.size() / static_cast<std::size_t>(width)}, {"type", kTypes[width]}};
  if (with_range) {
    std::vector<float> low(static_cast<std::size_t>(width), HUGE_VALF), high(low.size(), -HUGE_VALF);
    for (std::size_t i = 0; i < values.size(); ++i) {
      const std::size_t c = i % low.size();
      low[c] = std::min(low[c], values[i]);
      high[c] = std::max(high[c], values[i]);
    }
    accessor["min"] = low;
    accessor["max"] = high;
  }
  for (const float value : values) append(bytes, value);
  return add_accessor(std::move(view), std::move(accessor));
}

int GlbBuffers::add_corners(const std::vector<std::uint32_t>& corners) {
  json view = {{"buffer", 0},
               {"byteOffset", bytes.size()},
               {"byteLength", corners.size() * sizeof(std::uint32_t)},
               {"target", kCorners}};
  json accessor = {{"componentType", kUnsigned}, {"count", corners.size()}, {"type", "SCALAR"}};
  for (const std::uint32_t corner : corners) append(bytes, corner);
  return add_accessor(std::move(view), std::move(accessor));
}

void GlbKeys::add(int node, const Channel& channel, const std::vector<float>& times, const std::vector<float>& values,
                  GlbBuffers& buffers) {
  const auto& [path, width, interpolation] = channel;
  const int input = buffers.add(times, 1, false, true), output = buffers.add(values, width, false, false);
  channels.push_back({{"sampler", samplers.size()}, {"target", {{"node", node}, {"path", path}}}});
  samplers.push_back({{"input", input}, {"output", output}, {"interpolation", interpolation}});
}

std::string glb_bytes(json document, std::string binary) {
  document["buffers"] = {{{"byteLength", binary.size()}}};
  std::string text = document.dump();
  text.resize((text.size() + 3) / 4 * 4, ' ');
  binary.resize((binary.size() + 3) / 4 * 4, '\0');
  std::string file = "glTF";
  append<std::uint32_t>(file, 2);
  append<std::uint32_t>(file, static_cast<std::uint32_t>(12 + 8 + text.size() + 8 + binary.size()));
  append<std::uint32_t>(file, static_cast<std::uint32_t>(text.size()));
  file += "JSON" + text;
  append<std::uint32_t>(file, static_cast<std::uint32_t>(binary.size()));
  file += std::string("BIN\0", 4) + binary;
  return file;
}

}  // namespace klang::scene::detail
