#include "core/sound/scene/detail/shape_keeper.hpp"

#include <algorithm>
#include <array>

#include "core/geometry/mesh/tet_mesh.hpp"
#include "core/sound/scene/detail/modal_body.hpp"

namespace klang::scene::detail {
namespace {

constexpr double kSlackS = 1e-9;

std::size_t slot(int i) { return static_cast<std::size_t>(i); }

struct Face {
  std::array<int, 3> sorted, nodes;
  int element = 0;
};

}  // namespace

ShapeKeeper::Surface ShapeKeeper::surface_of(const fracture::CrackMesh& mesh) {
  std::vector<Face> faces;
  faces.reserve(4 * slot(mesh.n_elements()));
  for (int e = 0; e < mesh.n_elements(); ++e) {
    const std::array<int, 4> corners = mesh.nodes_of(e);
    for (const auto& own : mesh::kTetFaces) {
      Face face{{}, {corners[slot(own[0])], corners[slot(own[1])], corners[slot(own[2])]}, e};
      face.sorted = face.nodes;
      std::sort(face.sorted.begin(), face.sorted.end());
      faces.push_back(face);
    }
  }
  std::sort(faces.begin(), faces.end(), [](const Face& a, const Face& b) {
    return a.sorted != b.sorted ? a.sorted < b.sorted : a.element < b.element;
  });
  Surface surface;
  std::vector<std::int32_t> number(slot(mesh.n_nodes()), -1);
  for (std::size_t i = 0; i < faces.size(); ++i) {
    const bool shared = (i > 0 && faces[i - 1].sorted == faces[i].sorted) ||
                        (i + 1 < faces.size() && faces[i + 1].sorted == faces[i].sorted);
    if (shared) continue;
    std::array<std::int32_t, 3> triangle{};
    for (std::size_t k = 0; k < 3; ++k) {
      std::int32_t& own = number[slot(faces[i].nodes[k])];
      if (own < 0) {
        own = static_cast<std::int32_t>(surface.nodes.size());
        surface.nodes.push_back(faces[i].nodes[k]);
      }
      triangle[k] = own;
    }
    surface.triangles.push_back(triangle);
    surface.elements.push_back(faces[i].element);
  }
  return surface;
}

ShapeKeeper::Surface ShapeKeeper::surface_of(const ModalBody& body) {
  Surface surface;
  std::vector<std::int32_t> number(slot(static_cast<int>(body.surface.vertices_m.rows())), -1);
  for (std::size_t i = 0; i < body.places.size(); ++i) {
    number[slot(body.places[i].nodes.front().first)] = static_cast<std::int32_t>(i);
    surface.nodes.push_back(static_cast<std::int32_t>(i));
  }
  for (Eigen::Index t = 0; t < body.surface.triangles.rows(); ++t) {
    std::array<std::int32_t, 3> triangle{};
    for (std::size_t k = 0; k < 3; ++k)
      triangle[k] = number[slot(body.surface.triangles(t, static_cast<Eigen::Index>(k)))];
    surface.triangles.push_back(triangle);
    surface.elements.push_back(0);
  }
  return surface;
}

bool ShapeKeeper::is_due(double time_s) const { return rate_hz_ > 0.0 && next_ / rate_hz_ <= time_s + kSlackS; }

void ShapeKeeper::add(Surface surface) {
  n_bytes_ += surface.n_bytes();
  surfaces_.push_back(std::move(surface));
}

template <class PlaceAt>
void ShapeKeeper::add_frames(double time_s, const PlaceAt& place_at) {
  for (; is_due(time_s); next_ += stride_) {
    DeformedFrame frame;
    frame.number = next_;
    frame.surface = static_cast<std::int32_t>(surfaces_.size()) - 1;
    frame.places_m.reserve(3 * surfaces_.back().nodes.size());
    for (const std::int32_t node : surfaces_.back().nodes) {
      const Eigen::Vector3d place = place_at(node, time_s - next_ / rate_hz_);
      for (int axis = 0; axis < 3; ++axis) frame.places_m.push_back(static_cast<float>(place[axis]));
    }
    n_bytes_ += sizeof(float) * frame.places_m.size();
    frames_.push_back(std::move(frame));
  }
}

void ShapeKeeper::keep(const fracture::CrackMesh& mesh, double time_s) {
  if (!is_due(time_s)) return;
  if (mesh.n_changes() != changes_seen_) {
    changes_seen_ = mesh.n_changes();
    add(surface_of(mesh));
  }
  add_frames(time_s, [&](std::int32_t node, double before_s) -> Eigen::Vector3d {
    return mesh.place_m[slot(node)] - before_s * mesh.velocity_m_s[slot(node)];
  });
}

void ShapeKeeper::keep(const ModalBody& body, double time_s) {
  if (!is_due(time_s)) return;
  if (surfaces_.empty()) add(surface_of(body));
  add_frames(time_s, [&](std::int32_t node, double before_s) -> Eigen::Vector3d {
    const ModalPlace& place = body.places[slot(node)];
    return body.centre_m + body.arm(place) - before_s * body.velocity_at(place);
  });
}

void ShapeKeeper::thin() {
  stride_ *= 2;
  frames_.erase(std::remove_if(frames_.begin(), frames_.end(),
                               [&](const DeformedFrame& frame) { return frame.number % stride_ != 0; }),
                frames_.end());
  next_ = (next_ + stride_ - 1) / stride_ * stride_;
  // Surfaces that no frame has any more go; the last stays, which the mesh has now.
  std::vector<Surface> used;
  std::vector<std::int32_t> number(surfaces_.size(), -1);
  for (std::size_t s = 0; s < surfaces_.size(); ++s) {
    const bool is_used =
        s + 1 == surfaces_.size() || std::any_of(frames_.begin(), frames_.end(), [&](const DeformedFrame& frame) {
          return static_cast<std::size_t>(frame.surface) == s;
        });
    if (!is_used) continue;
    number[s] = static_cast<std::int32_t>(used.size());
    used.push_back(std::move(surfaces_[s]));
  }
  surfaces_ = std::move(used);
  n_bytes_ = 0;
  for (const Surface& surface : surfaces_) n_bytes_ += surface.n_bytes();
  for (DeformedFrame& frame : frames_) {
    frame.surface = number[slot(frame.surface)];
    n_bytes_ += sizeof(float) * frame.places_m.size();
  }
}

void thin_to(std::size_t most_bytes, const std::vector<ShapeKeeper*>& keepers) {
  const auto n_bytes = [&] {
    std::size_t sum = 0;
    for (const ShapeKeeper* keeper : keepers) sum += keeper->n_bytes();
    return sum;
  };
  const auto may_go = [](const ShapeKeeper* keeper) { return keeper->n_frames() > 1; };
  while (n_bytes() > most_bytes && std::any_of(keepers.begin(), keepers.end(), may_go))
    for (ShapeKeeper* keeper : keepers) keeper->thin();
}

std::string words_of_thinning(const char* whose, int stride, std::size_t most_bytes) {
  return "frames of " + std::string(whose) + " bodies change at every " + std::to_string(stride) +
         "th of them only: all would need more than " + std::to_string(most_bytes >> 20) +
         " MiB; a lower frames.rate_hz shows each";
}

DeformedBody ShapeKeeper::shapes(const std::vector<int>& row_of_element) const {
  DeformedBody body;
  body.row = row_;
  body.stride = stride_;
  body.frames = frames_;
  for (const Surface& surface : surfaces_) {
    DeformedSurface made;
    made.triangles = surface.triangles;
    for (const std::int32_t element : surface.elements) made.rows.push_back(row_of_element[slot(element)]);
    body.surfaces.push_back(std::move(made));
  }
  return body;
}

}  // namespace klang::scene::detail
