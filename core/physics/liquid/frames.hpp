#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "core/geometry/mesh/tet_mesh.hpp"

namespace klang::liquid {

/// The surface of a body of liquid and what each triangle is: 0 free surface, 1 rigid wall, 2 solid in the liquid, 3 the dry part of
/// such a solid. Counter-clockwise seen from outside the liquid (3: outside the solid); closed, and closed too without 2, or without 3.
struct LiquidSurface {
  mesh::SurfaceMesh surface;
  std::vector<int> region;  ///< n_triangles, 0 to 3
};

/// A marker near the surface that is being pulled into the liquid: a place where a bubble may be born.
struct SeedEvent {
  double time_s = 0.0;           ///< at which the slope of phi over the window fell below the threshold
  std::uint64_t marker = 0;      ///< which marker, so that one is not counted twice
  Eigen::Vector3d position_m;    ///< then
  Eigen::Vector3d velocity_m_s;  ///< then
  double phi_slope_m_s = 0.0;    ///< by linear regression, below 0
};

/// Frames of a liquid, z up, from a run of the program or from files: what bubbles and radiation need, whoever computed it.
/// Calls with different frames come in rising order where that is possible; an implementation may keep few frames in memory.
/// All functions may be called from several threads.
class LiquidFrames {
 public:
  virtual ~LiquidFrames() = default;
  virtual std::span<const double> time_s() const = 0;  ///< rising, even, one or more
  virtual LiquidSurface boundary(std::size_t frame) const = 0;
  /// Signed distance to the surface of the liquid (free or not), below 0 in the liquid and true to its full depth.
  virtual double phi_m(std::size_t frame, const Eigen::Vector3d& x_m) const = 0;
  /// None: this point or all frames have no velocity.
  virtual std::optional<Eigen::Vector3d> velocity_m_s(std::size_t frame, const Eigen::Vector3d& x_m) const = 0;
  virtual double cell_m() const = 0;  ///< the size of what the frames can tell apart
  /// Where liquid leaves the domain: a bubble that gets here has ended.
  virtual bool in_outlet(const Eigen::Vector3d& x_m) const;
  /// Recorded by the solver that made the frames; nullptr: markers are carried along with velocity_m_s.
  virtual const std::vector<SeedEvent>* seeds() const { return nullptr; }
  /// The same frames, of which these may be asked for without the search and lock that an implementation needs to keep few of them; phi_m and
  /// velocity_m_s of others are as before. It refers to this. nullptr: this is as fast already.
  virtual std::shared_ptr<const LiquidFrames> held(std::size_t first, std::size_t last) const;
};

/// Frames from one to another, held; for loops that ask often.
class HeldFrames {
 public:
  HeldFrames(const LiquidFrames& frames, std::size_t first, std::size_t last)
      : held_(frames.held(first, last)), frames_(held_ ? *held_ : frames) {}
  const LiquidFrames& operator*() const { return frames_; }

 private:
  std::shared_ptr<const LiquidFrames> held_;
  const LiquidFrames& frames_;
};

/// A time between frames: both neighbours and the share of the later one; the first or last frame outside.
struct FrameTime {
  std::size_t before = 0, after = 0;
  double share = 0.0;
};
FrameTime frame_time(const LiquidFrames& frames, double time_s);

/// Linear between frames.
double phi_m(const LiquidFrames& frames, double time_s, const Eigen::Vector3d& x_m);
/// None where either frame has none.
std::optional<Eigen::Vector3d> velocity_m_s(const LiquidFrames& frames, double time_s, const Eigen::Vector3d& x_m);

}  // namespace klang::liquid
