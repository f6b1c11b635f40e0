#include <algorithm>
#include <cmath>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/output_file.hpp"
#include "core/foundation/config/fields.hpp"
#include "core/physics/liquid/level_set.hpp"
#include "core/physics/liquid/surface.hpp"
#include "core/sound/liquid_scene/foreign_frames.hpp"
#include "core/sound/liquid_scene/stage_watch.hpp"
#include "core/sound/liquid_scene/toml_text.hpp"

namespace klang::liquid_scene {
namespace {

using Eigen::Vector3d;
constexpr double kMostBoxCells = 6.4e7;

/// The folder's scene: its box and where it is heard; how it makes bubbles is for the user to say.
std::string scene_text(const ForeignFrames& frames, const std::string& name,
                       const std::optional<Vector3d>& listener_m) {
  const liquid::GridShape& shape = frames.shape();
  const Vector3d size = shape.size_m();
  const Vector3d ear =
      listener_m ? Vector3d(*listener_m - frames.low_m()) : Vector3d(0.5 * size.x(), -0.5, size.z() + 0.3);
  if (!(ear.z() > 0.0)) throw option_error("listener", "is below the box", list(ear), "in the air");
  return "# Frames of another program. Bubbles come from [entrainment] (where the frames have velocity) or [[bubble]], "
         "put here by hand;\n"
         "# then `klang scene run scene.toml -o . --stage bubbles`. The box's low corner lies at " +
         list(frames.low_m()) + " m of the files.\nname = " + quoted(name) +
         "\n\n[domain]\nimported = true\nsize_m = " + list(size) + "\ncell_m = " + to_text(shape.cell_m) +
         "\nduration_s = " + to_text(static_cast<double>(frames.n_frames() - 1) * frames.frame_step_s()) +
         "\nframe_rate_hz = " + to_text(1.0 / frames.frame_step_s()) + "\n\n[listener]\nposition_m = " + list(ear) +
         "\n";
}

}  // namespace

void ForeignOptions::validate() const {
  std::vector<Violation> violations = violations_of(*this);
  if (low_m.has_value() != high_m.has_value())
    violations.push_back({low_m ? "low" : "high", "stands alone", {}, "both low and high"});
  else if (low_m && !(low_m->array() < high_m->array()).all())
    violations.push_back({"low", "is not below high", list(*low_m) + " to " + list(*high_m), {}});
  throw_violations({}, std::move(violations));
}

void ForeignFrames::set_box(const Vector3d& low_m, const Vector3d& high_m, double cell_m) {
  low_m_ = low_m;
  int* const counts[] = {&shape_.nx, &shape_.ny, &shape_.nz};
  double cells = 1.0;
  for (int axis = 0; axis < 3; ++axis) {
    const double n = std::round((high_m[axis] - low_m[axis]) / cell_m);
    cells *= n;
    if (!(n >= 2.0) || !(cells <= kMostBoxCells))
      throw InputError("frames", "the box has too few or too many cells",
                       list(high_m - low_m) + " m of cells of " + to_text(cell_m) + " m",
                       "2 along each edge, 64 million in all");
    *counts[axis] = static_cast<int>(n);
  }
  shape_.cell_m = cell_m;
}

double even_step_s(const std::vector<double>& time_s, const std::string& name) {
  if (time_s.size() < 2) throw InputError(name, "has too few frames", std::to_string(time_s.size()), "2 or more");
  const double step = (time_s.back() - time_s.front()) / static_cast<double>(time_s.size() - 1);
  for (std::size_t k = 1; k < time_s.size(); ++k)
    if (!(std::abs(time_s[k] - time_s[k - 1] - step) <= 1e-3 * step))
      throw InputError(name, "frames are uneven in time at frame " + std::to_string(k),
                       to_text(time_s[k] - time_s[k - 1]) + " s after the one before", to_text(step) + " s");
  return step;
}

namespace {

void require_within(const liquid::Field& field, double most, const std::string& frame, const char* what) {
  for (const double value : field.data())
    if (!(std::abs(value) <= most))
      throw InputError(frame, what, to_text(value), "up to " + to_text(most) + ": the unit?");
}

/// Numbers, and such as a liquid may have.
void require_sound_fields(const ForeignFrame& frame, const std::string& place) {
  constexpr double kFarthestM = 1e5, kFastestMS = 1e4;
  require_within(frame.phi_m, kFarthestM, place, "a distance to the surface [m] is out of range");
  for (int axis = 0; frame.u && axis < 3; ++axis)
    require_within((*frame.u)[axis], kFastestMS, place, "a velocity of the liquid [m/s] is out of range");
}

}  // namespace

RunDocument import_frames(ForeignFrames& frames, const ImportedAs& as, const ResultHeader& header,
                          const RunFolder& folder, Monitor& monitor) {
  const StageWatch watch;
  if (folder.begun() || folder.has("scene.toml"))
    throw InputError(folder.path().string(), "holds a run already", "", "another folder");
  const std::string toml = scene_text(frames, as.name, as.listener_m);
  const LiquidScene scene = parse_liquid_scene(toml, "scene.toml", ".");
  require_room(scene, scene.duration_s, folder.path());
  const liquid::GridShape& shape = frames.shape();
  const liquid::SolidField no_solids = liquid::solid_field(shape, {});
  RunDocument document;
  document.header = header;
  document.name = scene.name;
  bool any_liquid = false, any_velocity = false;
  OutputDirectory out(folder.path());
  const RunFolder staging(out.staging());
  out.sub_folder("frames");
  out.sub_folder("fields");
  for (std::size_t k = 0; k < frames.n_frames(); ++k) {
    monitor.throw_if_stopped();
    monitor.progress("import", static_cast<double>(k) / static_cast<double>(frames.n_frames()));
    const ForeignFrame frame = frames.read(k);
    require_sound_fields(frame, as.name + ", frame " + std::to_string(k));
    write_fields(staging.field_file(k), shape, frame.phi_m, frame.u);
    write_surface(staging.frame_file(k),
                  frame.surface ? *frame.surface : liquid::liquid_surface(shape, frame.phi_m, frame.solid_m));
    const double volume = liquid::liquid_volume_m3(shape, frame.phi_m, no_solids);
    any_liquid = any_liquid || volume > 0.0;
    any_velocity = any_velocity || frame.u.has_value();
    if (k == 0) document.volume.start_m3 = volume;
    document.volume.end_m3 = volume;
    if (document.volume.start_m3 > 0.0)
      document.volume.max_drift_relative =
          std::max(document.volume.max_drift_relative, std::abs(volume / document.volume.start_m3 - 1.0));
  }
  if (!any_liquid) throw InputError(as.name, "there is no liquid in any frame", "", "phi below 0 somewhere in the box");
  write_file(staging.file("scene.toml"), toml);
  staging.write_collection(scene, frames.n_frames());
  document.imported = ImportRecord{as.kind, any_velocity, {frames.low_m().x(), frames.low_m().y(), frames.low_m().z()}};
  document.end_s = scene.duration_s;
  document.n_frames = static_cast<std::int64_t>(frames.n_frames());
  document.n_cells = static_cast<std::int64_t>(shape.n_cells());
  document.stages.flow =
      StageRecord{StageStatus::kDone, watch.seconds(), watch.cpu_s(), static_cast<std::int64_t>(frames.n_frames())};
  for (const std::string& warning : frames.warnings()) document.header.warnings.push_back(warning);
  const LiquidScene written = read_liquid_scene(staging.file("scene.toml"));
  document.run = run_key(written);
  document.flow_run = flow_key(written);
  document.bubbles_run = bubbles_key(written);
  staging.write_document(document);
  out.commit();
  return document;
}

}  // namespace klang::liquid_scene
