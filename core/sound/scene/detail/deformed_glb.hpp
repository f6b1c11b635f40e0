#pragma once
#include <string>

#include "core/sound/scene/deformed_shapes.hpp"
#include "core/sound/scene/detail/glb_buffers.hpp"

namespace klang::scene::detail {

/// What a glTF document's parts are added to.
struct GlbParts {
  GlbBuffers& buffers;
  GlbKeys& keys;
  nlohmann::json &nodes, &meshes, &children;
};

/// A body that deforms: a node for each run of frames between changes of its mesh (and for kMostTargets frames at most), there by
/// keyframes of its scale while these frames last; its mesh is the first of them, morph targets are the others, whose weights go from one
/// to the next. Straight triangles without normals: viewers shade them flat.
void add_deformed_body(const DeformedBody& body, const std::string& name, int material, double rate_hz, GlbParts parts);

inline constexpr int kMostTargets = 64;

}  // namespace klang::scene::detail
