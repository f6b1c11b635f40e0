#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/physics/bubble/bubble_motion.hpp"
#include "core/physics/bubble/pitch_formulas.hpp"

namespace klang::datasets {

struct Drop {
  double onset_s = 0.1, radius_m = 1e-3, depth_m = 0.01, strength = 1.0;
  bubble::RiseOptions rise;
  bubble::PitchModel pitch;
};

struct DropRecording {
  std::string name;
  std::vector<Drop> drops;  ///< by onset
};

enum class DropSnr { kDrop, kRecording };

/// Recordings of falling drops: each entrains a bubble that rings, rises and is heard over noise and a room's tail.
struct DropRecipe {
  std::string name;
  bubble::BubbleMedium medium;
  bubble::BubbleTheory theory = bubble::BubbleTheory::kLeighton;
  bool soft_attack = false;
  double sample_rate_hz = 48000.0, duration_s = 2.0, peak = 0.5;
  std::optional<double> snr_db;
  DropSnr snr_of = DropSnr::kDrop;
  bool pink = false;
  std::optional<double> room_rt60_s;
  double room_level_db = -20.0;
  std::vector<DropRecording> recordings;
};

/// Whether a recipe says kind = "drops". False also for what is no TOML.
bool is_drop_recipe(std::string_view toml);

/// @throws InputError with file, line and key. Seeded sets are drawn here.
DropRecipe parse_drop_recipe(std::string_view toml, const std::string& name, std::uint64_t seed);

/// The keys as Markdown tables: part of docs/recipes-drops.md.
std::string drop_recipe_schema_markdown();

}  // namespace klang::datasets
