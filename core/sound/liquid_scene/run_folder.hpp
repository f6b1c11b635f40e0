#pragma once
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "core/physics/liquid/frames.hpp"
#include "core/physics/liquid/grid.hpp"
#include "core/sound/liquid_scene/liquid_scene.hpp"
#include "core/sound/liquid_scene/run_document.hpp"

namespace klang::liquid_scene {

/// The folder of a run: scene.toml, run.json, flow.csv, frames.pvd, frames/, fields/, checkpoint/, and what later stages add. Every file
/// is whole at any moment.
class RunFolder {
 public:
  explicit RunFolder(std::filesystem::path folder) : folder_(std::move(folder)) {}
  const std::filesystem::path& path() const { return folder_; }
  std::filesystem::path file(const std::string& name) const { return folder_ / name; }
  bool has(const std::string& name) const;
  bool begun() const { return has("run.json"); }
  std::filesystem::path frame_file(std::size_t frame) const;  ///< frames/boundary_000123.vtp
  std::filesystem::path field_file(std::size_t frame) const;  ///< fields/000123.klf

  RunDocument read_document() const;
  void write_document(const RunDocument& document) const;
  /// frames.pvd of the first n frames.
  void write_collection(const LiquidScene& scene, std::size_t n_frames) const;

 private:
  std::filesystem::path folder_;
};

/// Of which scene and files a run is, whatever its seed; changes when any byte of them or the program's version does.
std::string run_key(const LiquidScene& scene);
/// The same of what the stages flow (and bubbles) depend on alone: a later stage may be done again with the rest changed.
std::string flow_key(const LiquidScene& scene);
std::string bubbles_key(const LiquidScene& scene);

/// Bytes that the frames of a run will take, estimated.
double estimated_bytes(const LiquidScene& scene, double until_s);
/// @throws InputError where the disk has less room
void require_room(const LiquidScene& scene, double until_s, const std::filesystem::path& folder);

/// Surface as .vtp with the cell array "region".
void write_surface(const std::filesystem::path& path, const liquid::LiquidSurface& surface);
/// phi at centres and velocity at faces in 16 bits each, compressed.
void write_fields(const std::filesystem::path& path, const liquid::GridShape& shape, const liquid::Field& phi_m,
                  const std::optional<liquid::MacGrid>& u);
struct FrameFields {
  liquid::GridShape shape;
  liquid::Field phi_m;
  std::optional<liquid::MacGrid> u;  ///< none: another program's frames without it
};
/// @throws InputError naming the file
FrameFields read_fields_file(const std::filesystem::path& path);

/// The frames that a run's flow left; keeps the last few fields in memory.
std::unique_ptr<liquid::LiquidFrames> folder_frames(const LiquidScene& scene, const RunFolder& folder,
                                                    std::size_t n_frames);

}  // namespace klang::liquid_scene
