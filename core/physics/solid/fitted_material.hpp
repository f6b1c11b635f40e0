#pragma once
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "core/physics/solid/material.hpp"

namespace klang::solid {

/// A fit.json of `klang fit` as JSON. @throws InputError: no such file, no JSON, another kind of result, a fit that did not
/// converge
nlohmann::json read_fit_json(const std::filesystem::path& path);

/// What to say where a fit contradicts itself (its `judgement`, by the evidence that it found): its numbers are not to be believed.
/// Nothing where it is trusted or doubtful, or has no verdict.
std::optional<std::string> contradiction_of(const nlohmann::json& fit, const std::filesystem::path& path);

/// The material that a fit found: its `material` {lame_lambda_pa, lame_mu_pa, density_kg_m3}.
/// @param density_kg_m3  instead of the fit's, where > 0
/// @throws InputError naming the file and the key that is missing or impossible
Material fitted_material(const nlohmann::json& fit, const std::filesystem::path& path, double density_kg_m3 = 0.0);

}  // namespace klang::solid
