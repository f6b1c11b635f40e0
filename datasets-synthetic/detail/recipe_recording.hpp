#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <vector>

#include "core/foundation/base/monitor.hpp"
#include "datasets-synthetic/recipe.hpp"
#include "datasets-synthetic/recipe_spec.hpp"

namespace klang::datasets::detail {

/// One specimen of a recipe, struck and recorded.
struct RecipeRecording {
  SyntheticRecording recording;
  std::vector<Eigen::Vector3d> mounts_m;  ///< the points of the body that were taken
  nlohmann::json truth;                   ///< its entry in the truth file
};

/// Strikes the specimen, disturbs what the pickups hear as the recipe says, and writes down the truth.
/// @throws InputError when nothing is struck or heard in the band
RecipeRecording make_recording(const Recipe& recipe, std::size_t index, std::uint64_t seed, Monitor& monitor);

}  // namespace klang::datasets::detail
