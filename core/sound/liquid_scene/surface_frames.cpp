#include <algorithm>
#include <cmath>

#include "core/foundation/base/errors.hpp"
#include "core/physics/liquid/distance_grid.hpp"
#include "core/sound/dual_domain/boundary_file.hpp"
#include "core/sound/dual_domain/liquid_boundary.hpp"
#include "core/sound/liquid_scene/foreign_frames.hpp"
#include "core/sound/liquid_scene/liquid_transfer.hpp"

namespace klang::liquid_scene {
namespace {

using Eigen::Index;
using Eigen::Vector3d;

constexpr double kOnWall = 1e-4;  // of the box's longest edge

class SurfaceFrames : public ForeignFrames {
 public:
  SurfaceFrames(const ForeignOptions& options, Monitor& monitor) : options_(options) {
    const bubble::BoundaryFrames found = bubble::find_frames(options.frames, options.frame_step_s);
    files_ = found.files;
    frame_step_s_ = even_step_s(found.time_s, options.frames);
    Vector3d low = Vector3d::Constant(HUGE_VAL), high = -low;
    double edge = 0.0;
    for (const std::filesystem::path& file : files_) {
      monitor.throw_if_stopped();
      const liquid::LiquidSurface surface = load(file);
      const mesh::SurfaceMesh& s = surface.surface;
      for (Index v = 0; v < s.vertices_m.rows(); ++v) {
        low = low.cwiseMin(s.vertices_m.row(v).transpose());
        high = high.cwiseMax(s.vertices_m.row(v).transpose());
      }
      if (edge == 0.0 && s.triangles.rows() > 0) edge = mean_edge(s);
    }
    if (!(low.array() < high.array()).all())
      throw InputError(options.frames, "the surfaces enclose nothing", "", "closed surfaces of a liquid");
    wall_low_ = low;
    wall_high_ = high;
    // Places in the files stay what they are where they lie in the box [0, size] already.
    const double nothing = 1e-6 * (high - low).maxCoeff();  // round-off of who wrote them
    const bool at_origin = (low.array() >= -nothing).all() && (low.array() <= (high - low).array()).all();
    Vector3d box_low = at_origin ? Vector3d(Vector3d::Zero()) : low;
    Vector3d box_high = high;
    if (options.low_m) {
      wall_low_ = box_low = *options.low_m;
      wall_high_ = box_high = *options.high_m;
    }
    const double longest = (box_high - box_low).maxCoeff();
    const double cell = options.cell_m.value_or(std::clamp(edge, longest / 128.0, longest / 24.0));
    for (int axis = 0; axis < 3; ++axis)  // whole cells, and air above
      box_high[axis] = box_low[axis] + cell * std::max(2.0, std::ceil((box_high[axis] - box_low[axis]) / cell - 1e-6) +
                                                                (axis == 2 && !options.low_m ? 1.0 : 0.0));
    set_box(box_low, box_high, cell);
  }

  std::size_t n_frames() const override { return files_.size(); }

  ForeignFrame read(std::size_t frame) override {
    liquid::LiquidSurface surface = load(files_[frame]);
    // An .obj without groups comes with all of its faces free.
    const bool all_free =
        std::all_of(surface.region.begin(), surface.region.end(), [](int region) { return region == 0; });
    if (surface.region.empty() || (all_free && (options_.low_m || files_[frame].extension() == ".obj")))
      find_walls(surface);
    surface.surface.vertices_m.rowwise() -= low_m_.transpose();
    bubble::BoundaryMesh body = main_body(surface, shape_.cell_m);
    body.name = files_[frame].string();
    const bubble::LiquidBoundary closed(std::move(body));  // says what is wrong with an open or turned surface
    ForeignFrame result;
    result.phi_m = liquid::surface_distance(shape_, Vector3d::Zero(), surface);
    result.surface = std::move(surface);
    return result;
  }

 private:
  liquid::LiquidSurface load(const std::filesystem::path& file) const {
    bubble::BoundaryMesh mesh = bubble::read_boundary_without_regions(file, options_.unit_m);
    if (options_.y_up)
      for (Index v = 0; v < mesh.surface.vertices_m.rows(); ++v) {
        const Vector3d x = mesh.surface.vertices_m.row(v).transpose();
        mesh.surface.vertices_m.row(v) = Vector3d(x.x(), -x.z(), x.y()).transpose();
      }
    return {std::move(mesh.surface), std::move(mesh.region)};
  }

  static double mean_edge(const mesh::SurfaceMesh& s) {
    double sum = 0.0;
    for (Index t = 0; t < s.triangles.rows(); ++t)
      sum += (s.vertices_m.row(s.triangles(t, 0)) - s.vertices_m.row(s.triangles(t, 1))).norm();
    return sum / static_cast<double>(s.triangles.rows());
  }

  /// Faces that lie on the sides or the floor of the common box (of the vessel, where it is given: on the lid too) are walls.
  void find_walls(liquid::LiquidSurface& surface) {
    const mesh::SurfaceMesh& s = surface.surface;
    const double near = kOnWall * (wall_high_ - wall_low_).maxCoeff();
    surface.region.assign(static_cast<std::size_t>(s.triangles.rows()), 0);
    bool any = false;
    for (Index t = 0; t < s.triangles.rows(); ++t)
      for (int side = 0; side < 6; ++side) {
        if (side == 5 && !options_.low_m) continue;
        const int axis = side % 3;
        const double wall = side < 3 ? wall_low_[axis] : wall_high_[axis];
        bool on = true;
        for (int c = 0; c < 3; ++c) on = on && std::abs(s.vertices_m(s.triangles(t, c), axis) - wall) <= near;
        if (!on) continue;
        surface.region[static_cast<std::size_t>(t)] = 1;
        any = true;
      }
    if (said_) return;
    said_ = true;
    warnings_.push_back(any ? "the surfaces have no regions: faces on the sides and the floor of their common box are "
                              "taken as rigid walls"
                            : "the surfaces have no regions and touch no wall: all of them counts as free");
  }

  const ForeignOptions options_;
  Vector3d wall_low_, wall_high_;
  bool said_ = false;
};

}  // namespace

std::unique_ptr<ForeignFrames> surface_frames(const ForeignOptions& options, Monitor& monitor) {
  return std::make_unique<SurfaceFrames>(options, monitor);
}

}  // namespace klang::liquid_scene
