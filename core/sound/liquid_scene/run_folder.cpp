#include "core/sound/liquid_scene/run_folder.hpp"

#include <nlohmann/json.hpp>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/json.hpp"
#include "core/foundation/base/output_file.hpp"
#include "core/foundation/base/provenance.hpp"
#include "core/foundation/config/fields_json.hpp"

namespace klang::liquid_scene {
namespace {

std::string numbered(const char* head, std::size_t number, const char* tail) {
  std::string digits = std::to_string(number);
  digits.insert(0, digits.size() < 6 ? 6 - digits.size() : 0, '0');
  return head + digits + tail;
}

}  // namespace

bool RunFolder::has(const std::string& name) const {
  std::error_code error;
  return std::filesystem::is_regular_file(folder_ / name, error);
}

std::filesystem::path RunFolder::frame_file(std::size_t frame) const {
  return folder_ / numbered("frames/boundary_", frame, ".vtp");
}
std::filesystem::path RunFolder::field_file(std::size_t frame) const {
  return folder_ / numbered("fields/", frame, ".klf");
}

RunDocument RunFolder::read_document() const {
  return read_fields<RunDocument>(read_result_json(file("run.json")), file("run.json").string());
}

void RunFolder::write_document(const RunDocument& document) const {
  write_file(file("run.json"), json_text(json_of(document)));
}

void RunFolder::write_collection(const LiquidScene& scene, std::size_t n_frames) const {
  std::string text =
      "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\" "
      "byte_order=\"LittleEndian\">\n<Collection>\n";
  for (std::size_t frame = 0; frame < n_frames; ++frame)
    text += "<DataSet timestep=\"" + to_text(scene.frame_s(frame)) + "\" part=\"0\" file=\"" +
            numbered("frames/boundary_", frame, ".vtp") + "\"/>\n";
  write_file(file("frames.pvd"), text + "</Collection>\n</VTKFile>\n");
}

std::string run_key(const LiquidScene& scene) {
  std::string text = version();
  for (const std::filesystem::path& path : scene.inputs()) text += ";" + sha256(read_file(path));
  return sha256(text);
}

namespace {
std::string key_of(std::string text, const std::vector<std::filesystem::path>& files) {
  text += version();
  for (const std::filesystem::path& path : files) text += ";" + sha256(read_file(path));
  return sha256(text);
}
}  // namespace

std::string flow_key(const LiquidScene& scene) { return key_of(scene.flow_text, scene.key_files); }

std::string bubbles_key(const LiquidScene& scene) {
  std::vector<std::filesystem::path> files = scene.key_files;
  for (const std::filesystem::path& path : {scene.entrainment.recording, scene.pitch_from})
    if (!path.empty()) files.push_back(path);
  return key_of(scene.bubbles_text, files);
}

double estimated_bytes(const LiquidScene& scene, double until_s) {
  const liquid::GridShape& s = scene.setup.shape;
  const double cells = static_cast<double>(s.n_cells());
  const double sides =
      2.0 * (static_cast<double>(s.nx) * s.ny + static_cast<double>(s.ny) * s.nz + static_cast<double>(s.nx) * s.nz);
  const double frames = std::min(until_s, scene.duration_s) * scene.frame_rate_hz + 1.0;
  // Compressed: a byte and a half per cell and component, some 30 bytes per triangle of half the box's surface; two checkpoints.
  const double n_particles = 8.0 * 0.6 * cells;
  return frames * (cells * 4.0 * 0.8 + 2.0 * 0.7 * sides * 25.0) + 2.0 * (72.0 * n_particles + 40.0 * cells);
}

void require_room(const LiquidScene& scene, double until_s, const std::filesystem::path& folder) {
  std::filesystem::path at = std::filesystem::absolute(folder);
  std::error_code error;
  while (!std::filesystem::exists(at, error) && at.has_relative_path()) at = at.parent_path();
  const std::filesystem::space_info space = std::filesystem::space(at, error);
  const double needed = estimated_bytes(scene, until_s);
  if (!error && static_cast<double>(space.available) < needed)
    throw InputError(folder.string(), "the disk has too little room for the frames",
                     to_text(std::round(static_cast<double>(space.available) / 1e6)) + " MB free",
                     "about " + to_text(std::ceil(needed / 1e6)) + " MB");
}

}  // namespace klang::liquid_scene
