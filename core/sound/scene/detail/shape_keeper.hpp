#pragma once
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "core/physics/fracture/dynamic/crack_mesh.hpp"
#include "core/sound/scene/deformed_shapes.hpp"

namespace klang::scene::detail {

struct ModalBody;

/// Keeps the surface of a body that deforms at the times of frames.
class ShapeKeeper {
 public:
  /// @param rate_hz  0: keeps nothing
  ShapeKeeper(int row, double rate_hz) : row_(row), rate_hz_(rate_hz) {}

  /// After each small step: keeps the frames that have become due; where one is within the step, by the velocities now.
  void keep(const fracture::CrackMesh& mesh, double time_s);
  /// The same of a modal body, whose triangles stay: its corners.
  void keep(const ModalBody& body, double time_s);
  /// Of two kept frames one goes; so of those to come.
  void thin();
  int row() const { return row_; }
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
  static Surface surface_of(const ModalBody& body);
  bool is_due(double time_s) const;
  void add(Surface surface);
  /// @param place_at  place of a node so long before now
  template <class PlaceAt>
  void add_frames(double time_s, const PlaceAt& place_at);

  int row_ = 0;
  double rate_hz_ = 0.0;
  int next_ = 0, stride_ = 1, changes_seen_ = -1;
  std::size_t n_bytes_ = 0;
  std::vector<Surface> surfaces_;
  std::vector<DeformedFrame> frames_;
};

/// While keepers of the same times have more bytes than that together, of two kept frames one goes. The shapes at the start stay.
void thin_to(std::size_t most_bytes, const std::vector<ShapeKeeper*>& keepers);

/// What is to be said where they were thinned.
std::string words_of_thinning(const char* whose, int stride, std::size_t most_bytes);

}  // namespace klang::scene::detail
