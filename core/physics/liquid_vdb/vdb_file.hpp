#pragma once
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "core/foundation/base/monitor.hpp"
#include "core/physics/liquid/grid.hpp"
#include "core/physics/liquid_vdb/vdb_extent.hpp"

/// Liquids as .vdb, as programs for pictures hand them on. OpenVDB itself stays in klang::vdb_codec, which is loaded when it is wanted.
namespace klang::liquid {

/// Whether this program can read and write .vdb: built with OpenVDB, and klang_vdb.so is there.
bool has_vdb();

class VdbGrids;

/// One file, read whole; first in a child process, whose memory is bounded by the file's size.
class VdbFile {
 public:
  /// @throws InputError naming the file: no OpenVDB, no such grid of numbers, not cubic or turned voxels, an empty grid, a band under
  /// 2 voxels on either side; Interrupted
  explicit VdbFile(const std::filesystem::path& path, const std::string& grid = "phi",
                   Monitor& monitor = silent_monitor());
  ~VdbFile();
  VdbFile(VdbFile&&) noexcept;
  const VdbExtent& extent() const;
  double value(int i, int j, int k) const;  ///< of phi, in the file's unit
  /// A grid "velocity" or "vel" of the same voxels, if there is one.
  bool has_velocity() const;
  /// Component at the centre of the face of voxel (i, j, k) towards lower indices.
  double face_velocity(int axis, int i, int j, int k) const;

 private:
  std::unique_ptr<VdbGrids> grids_;
};

/// Grid "phi": a level set in metres whose every voxel is stored, to full depth, the centre of the first at (h/2, h/2, h/2); and, where u
/// is given, "velocity", staggered. The metadata time_s say when. @throws InputError: no OpenVDB, cannot be written
void write_vdb(const std::filesystem::path& path, const GridShape& shape, const Field& phi_m,
               const std::optional<MacGrid>& u, double time_s);

}  // namespace klang::liquid
