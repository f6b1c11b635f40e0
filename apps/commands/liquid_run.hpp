#pragma once
#include <filesystem>
#include <optional>
#include <string>

#include "apps/kit/command.hpp"
#include "core/sound/liquid_scene/run_document.hpp"

/// What `klang scene run`, `check` and `info` do with a scene of a liquid.
namespace klang::apps {

struct LiquidRunOptions {
  std::filesystem::path scene, output;
  std::optional<double> until_s, checkpoint_s;
  std::optional<std::string> stage;
  bool no_sound = false, resume = false;
  bool no_page = false;
  std::optional<std::string> last_stage;  ///< ends after it
};

struct LiquidCheckDocument {
  ResultHeader header;
  std::string name;
  double cell_m = 0.0, duration_s = 0.0, volume_m3 = 0.0, estimated_bytes = 0.0;
  std::int64_t n_cells = 0, n_particles = 0, n_frames = 0, n_solids = 0, n_inlets = 0;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    ResultHeader::describe(self.header, visit);
    visit({"name", "of the scene"}, self.name);
    visit({"cell_m", "edge of a cell"}, self.cell_m);
    visit({"n_cells", "of the box"}, self.n_cells);
    visit({"n_particles", "at the start"}, self.n_particles);
    visit({"volume_m3", "of liquid at the start"}, self.volume_m3);
    visit({"duration_s", "length"}, self.duration_s);
    visit({"n_frames", "that will be written"}, self.n_frames);
    visit({"n_solids", "in the scene"}, self.n_solids);
    visit({"n_inlets", "in the scene"}, self.n_inlets);
    visit({"estimated_bytes", "of the folder of its run"}, self.estimated_bytes);
  }
};

/// Whether a scene file has [domain]. @throws InputError when it cannot be read
bool is_liquid_file(const std::filesystem::path& scene);
/// Whether a folder holds the run of a liquid.
bool is_liquid_folder(const std::filesystem::path& folder);

int run_liquid(const LiquidRunOptions& options, const CommonOptions& common, Monitor& monitor);
int check_liquid(const std::filesystem::path& scene, const CommonOptions& common);
int show_liquid(const std::filesystem::path& folder, const CommonOptions& common);

}  // namespace klang::apps
