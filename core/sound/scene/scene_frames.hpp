#pragma once
#include <memory>
#include <string>
#include <vector>

#include "core/physics/events/event_log.hpp"
#include "core/sound/scene/deformed_shapes.hpp"
#include "core/sound/scene/scene_bodies.hpp"

namespace klang::scene {

/// What is drawn of a row of a log's bodies.
struct FrameBody {
  std::string name;
  int material = 0;                                  ///< of the scene
  std::shared_ptr<const mesh::SurfaceMesh> surface;  ///< straight triangles in the body's frame; null: it deforms
  events::Pose start;                                ///< where the log holds no pose of it
};

/// A surface's corners alone, those that no triangle has left out.
mesh::SurfaceMesh straight_surface(const mesh::SurfaceMesh& surface);

/// The bodies of a scene as they are drawn; bodies of the same shape share their surface. Pieces are added by the caller.
std::vector<FrameBody> frame_bodies(const Scene& scene, Monitor& monitor = silent_monitor());

/// Pictures of a motion at even times from 0 on. A body is there until it breaks, a piece from then on; a cracking body and its
/// pieces as deformed as they were then, with their cracks.
class Frames {
 public:
  /// @param bodies  one for each of the log's
  /// @param shapes  of those that deform, which stand for their pieces too
  Frames(const Scene& scene, const events::EventLog& log, std::vector<FrameBody> bodies, double end_s,
         DeformedShapes shapes = {});

  const std::vector<double>& times_s() const { return times_s_; }
  /// glTF 2.0 in one file: a node per body with keyframes of place and turn; of scale at the moment where it breaks or comes
  /// to be. Of a body that deforms a node per run of frames between changes of its mesh, with morph targets. Metres; glTF's y is up: a node above all turns the scene's z there.
  std::string glb() const;
  /// VTK XML polygons in the world; cell array "body": row of the log's bodies.
  std::string vtp(std::size_t frame) const;
  /// The collection that names the frames' files with their times.
  std::string pvd() const;
  static std::string vtp_name(std::size_t frame);  ///< "frames/000012.vtp"
  /// Corners of the box that holds all frames [m].
  Eigen::Vector3d low_m() const { return low_m_; }
  Eigen::Vector3d high_m() const { return high_m_; }

 private:
  struct Shown {
    FrameBody body;
    events::Motion motion;
    std::int32_t row;  ///< of the log's bodies
    double from_s, until_s;
    events::Pose at(double time_s) const;
    bool is_there(double time_s) const { return time_s >= from_s && time_s < until_s; }
  };
  void find_box();
  const Scene& scene_;
  std::vector<Shown> bodies_;
  DeformedShapes shapes_;
  std::vector<std::string> names_;  ///< of the log's bodies
  std::vector<int> materials_;
  std::vector<double> broken_s_;  ///< of those that deform
  std::vector<double> times_s_;
  Eigen::Vector3d low_m_, high_m_;
};

}  // namespace klang::scene
