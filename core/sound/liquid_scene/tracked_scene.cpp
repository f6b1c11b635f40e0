#include "core/sound/liquid_scene/tracked_scene.hpp"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/output_file.hpp"
#include "core/foundation/config/fields.hpp"
#include "core/physics/entrainment/entrainment.hpp"
#include "core/sound/liquid_scene/liquid_transfer.hpp"
#include "core/sound/liquid_scene/toml_text.hpp"

namespace klang::liquid_scene {
namespace {

using Eigen::Vector3d;

constexpr double kFarthestM = 9e3;    ///< a scene takes 1e4, and the head stands beside them
constexpr double kLongestS = 3599.0;  ///< as above

}  // namespace

RunDocument import_tracked(const entrainment::TrackedBubbles& tracked, const std::string& name,
                           const std::optional<Vector3d>& listener_m, const ResultHeader& header,
                           const RunFolder& folder) {
  if (folder.begun() || folder.has("scene.toml"))
    throw InputError(folder.path().string(), "holds a run already", "", "another folder");
  Vector3d low = Vector3d::Constant(1e300), high = -low;
  double end_s = 0.0;
  const stage::BubbleScene defaults;
  for (const entrainment::BubblePath& path : tracked.paths) {
    for (const Vector3d& x : path.position_m) {
      low = low.cwiseMin(x);
      high = high.cwiseMax(x);
    }
    const std::optional<HeardBubble> one = heard(path, defaults);
    end_s = std::max(end_s, one ? std::max(one->faded_s, path.end_s()) : path.end_s());
  }
  if (tracked.paths.empty())
    throw InputError(name, "has no bubble with a pitch", std::to_string(tracked.n_left_out) + " without",
                     "FREQUENCY above 0");
  for (const Vector3d& corner : {low, high})
    for (const double x : corner) checked(name, "position of a bubble [m]", x, -kFarthestM, kFarthestM);
  checked(name, "last moment of a bubble [s]", end_s, 0.0, kLongestS);
  const Vector3d middle = 0.5 * (low + high);
  const Vector3d ear = listener_m.value_or(Vector3d(middle.x(), low.y() - 0.5, std::max(high.z(), 0.0) + 0.5));
  if (!(ear.z() > 0.0)) throw option_error("listener", "is not in the air", list(ear), "z above 0: our axes, z up");
  if (!(ear.cwiseAbs().maxCoeff() <= kFarthestM))
    throw option_error("listener", "is out of range", list(ear), "within " + to_text(kFarthestM) + " m");
  constexpr int kCells = 8;
  const double cell = std::clamp(std::ceil(100.0 * (high - low).maxCoeff()) / 100.0, 0.1, 80.0) / kCells,
               size = kCells * cell;
  const double duration = std::clamp(std::ceil(100.0 * end_s) / 100.0, 0.01, kLongestS);
  const std::string toml =
      "# Bubbles of another program: what was tracked stands in bubbles.trk, the box says nothing of its liquid.\n"
      "name = " +
      quoted(name) + "\n\n[domain]\nsize_m = " + list(Vector3d::Constant(size)) + "\ncell_m = " + to_text(cell) +
      "\nduration_s = " + to_text(duration) + "\n\n[[pool]]\ndepth_m = " + to_text(0.5 * size) +
      "\n\n[transfer]\nmethod = \"half_space\"\n\n[listener]\nposition_m = " + list(ear) + "\n";
  std::filesystem::create_directories(folder.path());
  write_file(folder.file("scene.toml"), toml);
  const LiquidScene scene = read_liquid_scene(folder.file("scene.toml"));
  RunDocument document;
  document.header = header;
  document.name = scene.name;
  document.run = run_key(scene);
  document.flow_run = flow_key(scene);
  document.bubbles_run = bubbles_key(scene);
  document.end_s = duration;
  document.stages.flow = document.stages.bubbles = StageRecord{StageStatus::kDone, 0.0, 0.0, 0};
  document.n_bubbles = static_cast<std::int64_t>(tracked.paths.size());
  document.births_per_s = static_cast<double>(document.n_bubbles) / duration;
  write_file(folder.file("bubbles.csv"),
             entrainment::bubbles_csv(
                 entrainment::bubble_rows(tracked.paths, scene.sound.medium, scene.sound.theory, scene.sound.pitch)));
  entrainment::write_tracked_bubbles(folder.file("bubbles.trk"), tracked.paths);
  folder.write_document(document);
  return document;
}

}  // namespace klang::liquid_scene
