#include "core/sound/liquid_scene/matched_scene.hpp"

#include <toml++/toml.h>

#include <sstream>

namespace klang::liquid_scene {
namespace {

toml::table& table_under(toml::table& parent, std::string_view key) {
  toml::table* found = parent[key].as_table();
  if (found == nullptr) {
    parent.insert_or_assign(key, toml::table{});
    found = parent[key].as_table();
  }
  return *found;
}

void make_absolute(toml::table& table, std::string_view key, const std::filesystem::path& base) {
  const auto text = table[key].value<std::string>();
  if (text && !text->empty())
    table.insert_or_assign(key, std::filesystem::absolute(base / *text).lexically_normal().string());
}

}  // namespace

std::string matched_scene_text(std::string_view toml, const std::filesystem::path& base, const SceneMatch& match) {
  toml::table root = toml::parse(toml);
  if (toml::array* solids = root["solid"].as_array())
    for (toml::node& node : *solids)
      if (toml::table* solid = node.as_table()) {
        make_absolute(*solid, "keys_csv", base);
        if ((*solid)["motion"].value_or(std::string()).ends_with(".csv")) make_absolute(*solid, "motion", base);
      }
  if (toml::table* listener = root["listener"].as_table()) make_absolute(*listener, "path_csv", base);
  if (toml::table* pitch = root["pitch"].as_table()) make_absolute(*pitch, "from", base);
  toml::table& entrainment = table_under(root, "entrainment");
  entrainment.insert_or_assign("attempts_per_m2_s", match.attempts_per_m2_s);
  entrainment.insert_or_assign("radii", toml::table{{"kind", "recording"},
                                                    {"file", match.recorded},
                                                    {"smallest_m", match.smallest_m},
                                                    {"largest_m", match.largest_m}});
  if (match.with_pitch) {
    toml::table& pitch = table_under(root, "pitch");
    pitch.insert_or_assign("from", match.recorded);
    pitch.erase("k_delta_per_m");
    pitch.erase("eta");
  }
  std::ostringstream text;
  text << "# Rate and radii of bubbles from a recording (klang scene match).\n" << root << "\n";
  return text.str();
}

}  // namespace klang::liquid_scene
