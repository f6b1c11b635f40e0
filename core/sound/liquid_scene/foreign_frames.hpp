#pragma once
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/foundation/base/monitor.hpp"
#include "core/foundation/config/fields.hpp"
#include "core/physics/liquid/frames.hpp"
#include "core/physics/liquid/grid.hpp"
#include "core/sound/liquid_scene/run_folder.hpp"

namespace klang::liquid_scene {

/// What is asked of frames of another program.
struct ForeignOptions {
  std::string frames;         ///< "f_####.vdb", "f_####.vtp" (.vtu, .obj), "f.pvd", or the folder of an OpenFOAM case
  double frame_step_s = 0.0;  ///< of numbered files
  double unit_m = 1.0;        ///< of lengths in the files (velocities: per second)
  bool y_up = false;          ///< (x, y, z) of the files is our (x, -z, y)
  std::optional<double> cell_m;                  ///< of the distances that are made of surfaces and cases
  std::optional<Eigen::Vector3d> low_m, high_m;  ///< the vessel's inner walls, z up, in metres
  std::string field;                             ///< of an OpenFOAM case: share of liquid; empty: the first alpha.*
  void validate() const;                         ///< InputError

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"frames", "Files of a series, or the folder of a case"}, self.frames);
    visit({"frame_step_s", "Time between numbered files", at_least(0.0)}, self.frame_step_s);
    visit({"unit_m", "Metres per unit of the files", inside(0.0, 1e6)}, self.unit_m);
    visit({"y_up", "(x, y, z) of the files is (x, -z, y)"}, self.y_up);
    visit({"cell_m", "Cell of the distances that are made of surfaces and cases", inside(0.0, 10.0)}, self.cell_m);
    visit({"field", "Share of liquid in a case; empty: the first alpha.*"}, self.field);
  }
};

/// One frame in the box of its source.
struct ForeignFrame {
  liquid::Field phi_m;                           ///< a distance to the full depth
  std::optional<liquid::MacGrid> u;              ///< [m/s]
  std::optional<liquid::LiquidSurface> surface;  ///< as the files have it, low corner at 0; none: made of phi
  liquid::Field solid_m;                         ///< distance to what is no liquid's room; empty: none
};

/// Frames of another program, each read when it is asked for.
class ForeignFrames {
 public:
  virtual ~ForeignFrames() = default;
  virtual std::size_t n_frames() const = 0;
  virtual ForeignFrame read(std::size_t frame) = 0;
  const liquid::GridShape& shape() const { return shape_; }
  double frame_step_s() const { return frame_step_s_; }
  const Eigen::Vector3d& low_m() const { return low_m_; }  ///< where the box's low corner lies in the files
  const std::vector<std::filesystem::path>& files() const { return files_; }
  const std::vector<std::string>& warnings() const { return warnings_; }

 protected:
  void set_box(const Eigen::Vector3d& low_m, const Eigen::Vector3d& high_m, double cell_m);
  liquid::GridShape shape_;
  double frame_step_s_ = 0.0;
  Eigen::Vector3d low_m_ = Eigen::Vector3d::Zero();
  std::vector<std::filesystem::path> files_;
  std::vector<std::string> warnings_;
};

/// Level sets, grid "phi". All frames must have the same voxels; the box is that of all voxels that are stored.
std::unique_ptr<ForeignFrames> vdb_frames(const ForeignOptions& options, Monitor& monitor);
/// Closed surfaces, .vtp, .vtu or .obj, with regions or without (then faces on the sides and the floor of their common box are walls).
std::unique_ptr<ForeignFrames> surface_frames(const ForeignOptions& options, Monitor& monitor);
/// A case of OpenFOAM by VTK's reader: the surface where the share of liquid is 1/2.
std::unique_ptr<ForeignFrames> openfoam_frames(const ForeignOptions& options, Monitor& monitor);

/// Even times, or an InputError. @return the step
double even_step_s(const std::vector<double>& time_s, const std::string& name);

/// What an import is called and where it is heard from.
struct ImportedAs {
  std::string kind, name;
  std::optional<Eigen::Vector3d> listener_m;  ///< in the files' place, z up; none: before the box and over it
};

/// A folder as a run would have left it after its stage flow.
/// @throws InputError: a folder that holds a run, fewer than two frames, no liquid in any of them
RunDocument import_frames(ForeignFrames& frames, const ImportedAs& as, const ResultHeader& header,
                          const RunFolder& folder, Monitor& monitor);

}  // namespace klang::liquid_scene
