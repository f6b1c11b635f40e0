#pragma once
#include <filesystem>
#include <vector>

#include "core/physics/bubble/pitch_formulas.hpp"

/// What a scene takes from a result of `klang bubble fit`.
namespace klang::liquid_scene {

/// Radii of the bubbles found. @throws InputError: no such result, no bubble in it
std::vector<double> recorded_radii(const std::filesystem::path& file);

/// The law's two combinations that a recording with a known rise determines, K e^eta and eta / |phi0|; phi0 stays as it is (nothing
/// else enters eq. 6). @throws InputError where the fit did not determine both, or for a law without them
void take_recorded_pitch(const std::filesystem::path& file, bubble::PitchModel& pitch);

}  // namespace klang::liquid_scene
