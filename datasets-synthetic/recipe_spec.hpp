#pragma once
#include <Eigen/Core>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/geometry/shapes/shape.hpp"
#include "core/physics/modal/damping/damping_law.hpp"
#include "core/physics/solid/material.hpp"
#include "core/physics/solid/support.hpp"

namespace klang::datasets {

/// A blow; its place is given as a part of the body's half extent from its centre: (1, 0, 0.5) is the surface
/// of a tube at half of its upper half. The nearest point of the body is taken.
struct RecipeStrike {
  double time_s = 0.1;
  Eigen::Vector3d at = Eigen::Vector3d::Zero();
  Eigen::Vector3d impulse_n_s = Eigen::Vector3d::Zero();
  double contact_s = 0.0;  ///< standard deviation of the Gaussian force pulse
};

/// A channel of the recording: hears the velocity of a point (displacement times frequency) along a
/// direction.
struct RecipePickup {
  Eigen::Vector3d at = Eigen::Vector3d::Zero();
  Eigen::Vector3d direction = Eigen::Vector3d::UnitX();
};

/// A viscous damper (wire, foam) at a place: amplitude decays gain c |u|^2 / 2 per mode, c (d . u)^2 / 2 with a direction d.
struct RecipeMount {
  Eigen::Vector3d at = Eigen::Vector3d::Zero();
  std::optional<Eigen::Vector3d> direction;
  double damping_n_s_per_m = 0.0;
};

struct RecipeSpecimen {
  std::string name;
  mesh::ShapeSpec shape;
  solid::Support support;
  std::vector<RecipeStrike> strikes;
  std::vector<RecipePickup> pickups;
  std::vector<RecipeMount> mounts;
  bool predict = false;  ///< passed on to specimen.toml
};

/// What a recipe says (docs/recipes.md).
struct Recipe {
  std::string name;
  std::vector<RecipeSpecimen> specimens;
  solid::Material material;

  const damping::DampingLaw* damping = nullptr;
  std::vector<double> damping_parameters;  ///< of the law, in its order

  double sample_rate_hz = 48000.0, duration_s = 5.0, peak = 0.5, dc_offset = 0.0, highest_hz = 20000.0;
  std::optional<double> clip_level;

  std::optional<double> snr_db;
  bool pink = false;

  double mains_frequency_hz = 50.0, mains_amplitude = 0.0;
  int mains_harmonics = 3;

  std::optional<double> room_rt60_s;
  double room_level_db = -20.0;

  double split_detuning = 0.0;   ///< relative distance of the two frequencies of a degenerate pair
  double split_angle_rad = 0.6;  ///< how far the pair's shapes are turned from the strike

  double start_youngs_factor = 1.0;
  std::optional<double> start_poissons_ratio;  ///< empty: the true one
  std::vector<std::string> fit_parameters;

  double decay_per_s(double angular_frequency_rad_s) const;  ///< of the amplitude, by the damping law
};

/// Reads and checks a recipe. Unknown keys, wrong types and values out of range are InputErrors that name
/// file, line, key, value and what is allowed. Makes nothing: this is what the fuzz target calls.
Recipe parse_recipe(std::string_view toml, const std::string& name, const std::filesystem::path& base_folder);

/// The table of keys as Markdown: docs/recipes.md is this text.
std::string recipe_schema_markdown();

}  // namespace klang::datasets
