#include "core/sound/liquid_scene/from_recording.hpp"

#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/output_file.hpp"
#include "core/foundation/base/parse_json.hpp"
#include "core/physics/bubble/bubble_medium.hpp"

namespace klang::liquid_scene {
namespace {

nlohmann::json read_result(const std::filesystem::path& file) {
  nlohmann::json json = parse_json(read_file(file), file.string());
  if (!json.is_object()) throw InputError(file.string(), "is no result of klang bubble fit");
  return json;
}

/// The value of a combination by how its formula begins.
std::optional<double> combination(const nlohmann::json& list, const std::string& formula) {
  if (!list.is_array()) return std::nullopt;
  for (const auto& entry : list)
    if (entry.is_object() && entry.value("combination", std::string()).starts_with(formula) &&
        entry.contains("value") && entry["value"].is_number())
      return entry["value"].get<double>();
  return std::nullopt;
}

}  // namespace

std::vector<double> recorded_radii(const std::filesystem::path& file) {
  const nlohmann::json json = read_result(file);
  if (const auto status = json.find("status"); status != json.end() && status->is_string() && *status != "ok")
    throw InputError(file.string(), "found no bubbles that can be trusted", "status " + status->get<std::string>(),
                     "a result with status ok");
  std::vector<double> radii;
  const auto list = json.find("bubbles");
  if (list != json.end() && list->is_array())
    for (const auto& bubble : *list)
      if (bubble.is_object() && bubble.contains("radius_m") && bubble["radius_m"].is_number())
        radii.push_back(bubble["radius_m"].get<double>());
  for (std::size_t i = 0; i < radii.size(); ++i)
    checked(file.string(), "bubbles[" + std::to_string(i) + "].radius_m", radii[i], bubble::kSmallestRadiusM,
            bubble::kLargestRadiusM);
  if (radii.empty()) throw InputError(file.string(), "has no radius of a bubble", "", "a result of klang bubble fit");
  return radii;
}

void take_recorded_pitch(const std::filesystem::path& file, bubble::PitchModel& pitch) {
  if (pitch.kind != bubble::PitchKind::kHarmonicFluids && pitch.kind != bubble::PitchKind::kHarmonicFluidsFrozen)
    throw InputError("[pitch] from", "goes with the law of eq. (6) only", "",
                     "model harmonic_fluids or harmonic_fluids_frozen");
  const nlohmann::json json = read_result(file);
  const nlohmann::json fit = json.value("pitch", nlohmann::json::object());
  const nlohmann::json list = fit.is_object() ? fit.value("identifiable", nlohmann::json()) : nlohmann::json();
  const std::optional<double> slope = combination(list, "eta / |phi0|"), rise = combination(list, "k_delta * exp(eta)");
  if (!slope || !rise)
    throw InputError("[pitch] from", file.string() + " does not determine the law of pitch", "",
                     "a result of klang bubble fit with --rise that has K e^eta and eta / |phi0|");
  pitch.eta = *slope * -pitch.phi0_m;
  pitch.k_delta_per_m = *rise * std::exp(-pitch.eta);
  try {
    pitch.validate();
  } catch (const InputError& e) {
    throw InputError("[pitch] from", file.string() + " with phi0_m = " + to_text(pitch.phi0_m) +
                                         " makes a law of pitch that is none (" + e.what() + ")");
  }
}

}  // namespace klang::liquid_scene
