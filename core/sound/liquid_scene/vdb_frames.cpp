#include <algorithm>
#include <array>
#include <cmath>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/config/fields.hpp"
#include "core/physics/liquid/level_set.hpp"
#include "core/physics/liquid_vdb/vdb_file.hpp"
#include "core/sound/dual_domain/boundary_file.hpp"
#include "core/sound/liquid_scene/foreign_frames.hpp"

namespace klang::liquid_scene {
namespace {

using Eigen::Vector3d;

/// Voxels of the files and cells of our box: axes may be turned (y up).
class VdbFrames : public ForeignFrames {
 public:
  VdbFrames(const ForeignOptions& options, Monitor& monitor) : options_(options), monitor_(monitor) {
    if (!(options.frame_step_s > 0.0))
      throw option_error("frame_step_s", "is needed with .vdb", "", "seconds between two frames");
    const bubble::BoundaryFrames found = bubble::find_frames(options.frames, options.frame_step_s);
    files_ = found.files;
    frame_step_s_ = even_step_s(found.time_s, options.frames);
    bool first = true;
    for (const std::filesystem::path& file : files_) {
      monitor.throw_if_stopped();
      const liquid::VdbFile vdb(file, "phi", monitor);
      const liquid::VdbExtent& e = vdb.extent();
      if (first) {
        extent_ = e;
        has_velocity_ = true;
      } else if (!(std::abs(e.voxel / extent_.voxel - 1.0) <= 1e-5)) {
        throw InputError(file.string(), "the voxel size changes within the series", to_text(e.voxel),
                         to_text(extent_.voxel) + " as in the first frame");
      } else if (!((e.first - extent_.first).cwiseAbs().maxCoeff() <= 1e-3 * extent_.voxel)) {
        throw InputError(file.string(), "the voxels are shifted within the series");
      }
      first = false;
      for (std::size_t a = 0; a < 3; ++a) {
        extent_.low[a] = std::min(extent_.low[a], e.low[a]);
        extent_.high[a] = std::max(extent_.high[a], e.high[a]);
      }
      extent_.band_voxels = std::min(extent_.band_voxels, e.band_voxels);
      has_velocity_ = has_velocity_ && vdb.has_velocity();
    }
    crop();
    if (!has_velocity_)
      warnings_.push_back(
          "the frames have no grid \"velocity\" of phi's voxels: bubbles come from [[bubble]] alone, and the liquid "
          "does not carry them");
  }

  std::size_t n_frames() const override { return files_.size(); }

  ForeignFrame read(std::size_t frame) override {
    const liquid::VdbFile vdb(files_[frame], "phi", monitor_);
    ForeignFrame result;
    result.phi_m = liquid::Field(shape_.nx, shape_.ny, shape_.nz);
    for (int k = 0; k < shape_.nz; ++k) {
      monitor_.throw_if_stopped();
      for (int j = 0; j < shape_.ny; ++j)
        for (int i = 0; i < shape_.nx; ++i) {
          const std::array<int, 3> v = voxel(i, j, k);
          result.phi_m(i, j, k) = options_.unit_m * vdb.value(v[0], v[1], v[2]);
        }
    }
    // Where walls cut the liquid off, its distances there were to a surface that is none.
    const double keep = cropped_ ? 0.0 : (vdb.extent().band_voxels - 1.0) * shape_.cell_m;
    liquid::redistance(shape_, keep, shape_.size_m().norm(), result.phi_m);
    if (has_velocity_) result.u = velocity(vdb);
    if (frame == 0 && !options_.low_m && !touches_walls(result.phi_m))
      warnings_.push_back(
          "no vessel is given (--low, --high): all of the liquid's surface counts as free, its sides and bottom too");
    return result;
  }

 private:
  /// Whether liquid is cut off by the box anywhere but at its lid.
  bool touches_walls(const liquid::Field& phi) const {
    for (int k = 0; k < shape_.nz; ++k)
      for (int j = 0; j < shape_.ny; ++j)
        for (int i = 0; i < shape_.nx; ++i)
          if ((i == 0 || j == 0 || k == 0 || i == shape_.nx - 1 || j == shape_.ny - 1) && phi(i, j, k) < 0.0)
            return true;
    return false;
  }

  /// Which voxel of the files is a cell of ours.
  std::array<int, 3> voxel(int i, int j, int k) const {
    if (!options_.y_up) return {extent_.low[0] + i, extent_.low[1] + j, extent_.low[2] + k};
    return {extent_.low[0] + i, extent_.low[1] + k, extent_.high[2] - j};
  }

  liquid::MacGrid velocity(const liquid::VdbFile& vdb) const {
    liquid::MacGrid u(shape_);
    for (int axis = 0; axis < 3; ++axis)
      for (int k = 0; k < u[axis].nz(); ++k) {
        monitor_.throw_if_stopped();
        for (int j = 0; j < u[axis].ny(); ++j)
          for (int i = 0; i < u[axis].nx(); ++i) {
            std::array<int, 3> v = voxel(i, j, k);
            double sign = 1.0;
            int theirs = axis;
            if (options_.y_up && axis == 1) {  // our face below in y is theirs above in z
              theirs = 2;
              sign = -1.0;
              ++v[2];
            } else if (options_.y_up && axis == 2) {
              theirs = 1;
            }
            u[axis](i, j, k) = sign * options_.unit_m * vdb.face_velocity(theirs, v[0], v[1], v[2]);
          }
      }
    return u;
  }

  /// The voxels between the vessel's walls, and the box of them.
  void crop() {
    const double h = extent_.voxel * options_.unit_m;
    const std::array<int, 3> stored_low = extent_.low, stored_high = extent_.high;
    if (options_.low_m) {
      const auto theirs = [&](const Vector3d& x) { return options_.y_up ? Vector3d(x.x(), x.z(), -x.y()) : x; };
      const Vector3d a = theirs(*options_.low_m), b = theirs(*options_.high_m);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto n = static_cast<Eigen::Index>(axis);
        const auto place = [&](double x) {
          return std::clamp((x / options_.unit_m - extent_.first[n]) / extent_.voxel + 0.5, -1e6, 1e6);
        };
        const double low = place(std::min(a[n], b[n])), high = place(std::max(a[n], b[n]));
        extent_.low[axis] = static_cast<int>(std::lround(low));
        extent_.high[axis] = static_cast<int>(std::lround(high)) - 1;
        if (std::abs(low - std::round(low)) > 0.02 || std::abs(high - std::round(high)) > 0.02)
          warnings_.push_back("the vessel's walls are moved to the voxels' faces, by half a voxel at most");
      }
      cropped_ = stored_low != extent_.low || stored_high != extent_.high;
    }
    Vector3d low, high;
    for (int axis = 0; axis < 3; ++axis) {
      const auto a = static_cast<std::size_t>(axis);
      low[axis] = options_.unit_m * (extent_.first[axis] + extent_.voxel * (extent_.low[a] - 0.5));
      high[axis] = options_.unit_m * (extent_.first[axis] + extent_.voxel * (extent_.high[a] + 0.5));
    }
    if (options_.y_up) {
      const Vector3d l = low, u = high;
      low = {l.x(), -u.z(), l.y()};
      high = {u.x(), -l.z(), u.y()};
    }
    set_box(low, high, h);
    if (low_m_.cwiseAbs().maxCoeff() < 1e-6 * h) low_m_.setZero();
  }

  const ForeignOptions options_;
  Monitor& monitor_;
  liquid::VdbExtent extent_;
  bool has_velocity_ = false, cropped_ = false;
};

}  // namespace

std::unique_ptr<ForeignFrames> vdb_frames(const ForeignOptions& options, Monitor& monitor) {
  return std::make_unique<VdbFrames>(options, monitor);
}

}  // namespace klang::liquid_scene
