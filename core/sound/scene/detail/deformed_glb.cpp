#include "core/sound/scene/detail/deformed_glb.hpp"

#include <algorithm>
#include <map>

namespace klang::scene::detail {
namespace {

using nlohmann::json;

/// Frames first to last of a body have one surface and are one node.
struct Run {
  std::size_t first = 0, last = 0;
};

std::vector<Run> runs_of(const DeformedBody& body) {
  std::vector<Run> runs = {{0, 0}};
  for (std::size_t i = 1; i < body.frames.size(); ++i) {
    Run& run = runs.back();
    if (body.frames[i].surface != body.frames[run.first].surface) {
      runs.push_back({i, i});
      continue;
    }
    run.last = i;
    if (i - run.first == kMostTargets && i + 1 < body.frames.size()) runs.push_back({i, i});  // goes on from there
  }
  return runs;
}

}  // namespace

void add_deformed_body(const DeformedBody& body, const std::string& name, int material, double rate_hz,
                       GlbParts parts) {
  std::map<std::int32_t, int> corners_of;  // accessors by surface
  const auto time_of = [&](std::size_t frame) { return static_cast<float>(body.frames[frame].number / rate_hz); };
  const std::vector<Run> runs = runs_of(body);
  for (std::size_t r = 0; r < runs.size(); ++r) {
    const auto& [first, last] = runs[r];
    const DeformedFrame& start = body.frames[first];
    auto [corners, is_new] = corners_of.try_emplace(start.surface, 0);
    if (is_new) {
      std::vector<std::uint32_t> list;
      for (const auto& triangle : body.surfaces[static_cast<std::size_t>(start.surface)].triangles)
        for (const std::int32_t corner : triangle) list.push_back(static_cast<std::uint32_t>(corner));
      corners->second = parts.buffers.add_corners(list);
    }
    json primitive = {{"attributes", {{"POSITION", parts.buffers.add(start.places_m, 3, true, true)}}},
                      {"indices", corners->second},
                      {"material", material},
                      {"mode", 4}};
    bool moves = false;
    for (std::size_t i = first + 1; i <= last; ++i) moves = moves || body.frames[i].places_m != start.places_m;
    const std::string label = runs.size() == 1 ? name : name + " from " + std::to_string(start.number);
    json mesh = {{"name", label}};
    std::vector<float> times, weights;
    if (moves) {
      json targets = json::array();
      const std::size_t n = last - first;
      for (std::size_t i = first; i <= last; ++i) {
        times.push_back(time_of(i));
        for (std::size_t k = 1; k <= n; ++k) weights.push_back(first + k == i ? 1.0F : 0.0F);
        if (i == first) continue;
        std::vector<float> moved = body.frames[i].places_m;
        for (std::size_t c = 0; c < moved.size(); ++c) moved[c] -= start.places_m[c];
        targets.push_back({{"POSITION", parts.buffers.add(moved, 3, true, true)}});
      }
      primitive["targets"] = std::move(targets);
      mesh["weights"] = std::vector<float>(n, 0.0F);
    }
    mesh["primitives"] = json::array({std::move(primitive)});
    const int node = static_cast<int>(parts.nodes.size());
    parts.children.push_back(node);
    parts.nodes.push_back({{"name", label}, {"mesh", parts.meshes.size()}});
    parts.meshes.push_back(std::move(mesh));
    if (moves) parts.keys.add(node, {"weights", 1, "LINEAR"}, times, weights, parts.buffers);
    std::vector<float> switch_s = {0.0F}, sizes(3, r == 0 ? 1.0F : 0.0F);
    if (r > 0) {
      switch_s.push_back(time_of(first));
      sizes.insert(sizes.end(), 3, 1.0F);
    }
    if (r + 1 < runs.size()) {
      switch_s.push_back(time_of(runs[r + 1].first));
      sizes.insert(sizes.end(), 3, 0.0F);
    }
    if (switch_s.size() > 1) parts.keys.add(node, {"scale", 3, "STEP"}, switch_s, sizes, parts.buffers);
  }
}

}  // namespace klang::scene::detail
