#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/physics/fracture/dynamic/crack_mesh.hpp"
#include "core/sound/scene/deformed_shapes.hpp"

namespace klang::scene::detail {

/// Keeps the surface of a cracking body at the times of frames.
class ShapeKeeper {
 public:
  ShapeKeeper(int row, double rate_hz) : row_(row), rate_hz_(rate_hz) {}

  /// After each small step: keeps the frames that have become due; where one is within the step, by the velocities now.
  void keep(const fracture::CrackMesh& mesh, double time_s);
  /// Of two kept frames one goes; so of those to come.
  void thin();
  std::size_t n_bytes() const { return n_bytes_; }
  std::size_t n_frames() const { return frames_.size(); }
  int stride() const { return stride_; }
  /// @param row_of_element  rows of the log's bodies at the end
  DeformedBody shapes(const std::vector<int>& row_of_element) const;

 private:
  /// Triangles of the boundary and the nodes that are corners of them.
  struct Surface {
    std::vector<std::array<std::int32_t, 3>> triangles;
    std::vector<std::int32_t> elements, nodes;
    std::size_t n_bytes() const { return 12 * triangles.size() + 4 * elements.size() + 4 * nodes.size(); }
  };
  static Surface surface_of(const fracture::CrackMesh& mesh);

  int row_ = 0;
  double rate_hz_ = 0.0;
  int next_ = 0, stride_ = 1, changes_seen_ = -1;
  std::size_t n_bytes_ = 0;
  std::vector<Surface> surfaces_;
  std::vector<DeformedFrame> frames_;
};

}  // namespace klang::scene::detail
