#pragma once
#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "core/physics/liquid/grid.hpp"
#include "core/physics/liquid_vdb/vdb_extent.hpp"

/// What OpenVDB does for liquid_vdb, of which only this is known outside: half of what the program would relocate at every start
/// are OpenVDB's symbols. The program loads it as klang_vdb.so; what links klang::vdb_codec has it built in.
namespace klang::liquid {

/// The level set of one file and, where it has them, its velocities.
class VdbGrids {
 public:
  virtual ~VdbGrids() = default;
  virtual const VdbExtent& extent() const = 0;
  virtual double value(int i, int j, int k) const = 0;
  virtual bool has_velocity() const = 0;
  virtual double face_velocity(int axis, int i, int j, int k) const = 0;
};

/// As the functions of vdb_file.hpp that have the same names; all throw InputError naming the file.
struct VdbCodec {
  /// The file's bytes, where its head is whole.
  std::size_t (*check_head)(const std::filesystem::path& path) = nullptr;
  /// Reads in this process: the library takes memory as a file claims it, prints, and may crash.
  std::unique_ptr<VdbGrids> (*read)(const std::string& name, const std::string& grid) = nullptr;
  /// With a random number (UUID) in its head. The name is what complaints call it.
  void (*write)(const std::string& name, const std::filesystem::path& path, const GridShape& shape, const Field& phi_m,
                const std::optional<MacGrid>& u, double time_s) = nullptr;
};

}  // namespace klang::liquid

extern "C" const klang::liquid::VdbCodec* klang_vdb_codec();
