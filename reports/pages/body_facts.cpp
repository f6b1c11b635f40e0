#include "reports/pages/body_facts.hpp"

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <string_view>
#include <vector>

#include "reports/kit/text.hpp"

namespace klang::reports::detail {
namespace {

using nlohmann::json;

// As a person gives them: the largest dimensions first, unknown ones last.
constexpr std::array<std::string_view, 13> kOrder = {
    "edge_m", "length_m", "width_m", "height_m", "outer_radius_m", "radius_m",  "a_m",
    "b_m",    "c_m",      "depth_m", "wall_m",   "thickness_m",    "max_edge_m"};

std::string text_of(const json& object, const char* key) {
  const auto found = object.find(key);
  return found != object.end() && found->is_string() ? found->get<std::string>() : std::string();
}

std::vector<std::pair<std::string, double>> sorted_dimensions(const json& dims) {
  std::vector<std::pair<std::string, double>> sorted;
  for (const auto& [key, value] : dims.items()) {
    if (value.is_number()) sorted.emplace_back(key, value.get<double>());
  }
  const auto rank = [](const auto& entry) {
    return std::find(kOrder.begin(), kOrder.end(), entry.first) - kOrder.begin();
  };
  std::stable_sort(sorted.begin(), sorted.end(), [&](const auto& a, const auto& b) { return rank(a) < rank(b); });
  return sorted;
}

}  // namespace

ShapeWords shape_words(const JsonText& text) {
  ShapeWords result;
  if (text.text.empty()) return result;
  const json shape = json::parse(text.text, nullptr, false);
  if (shape.is_string()) result.words = shape.get<std::string>();
  if (!shape.is_object()) return result;
  result.words = result.kind = text_of(shape, "kind");
  if (const std::string mesh = text_of(shape, "mesh"); !mesh.empty())
    result.words += (result.words.empty() ? "mesh " : ", mesh ") + mesh;
  if (const std::string profile = text_of(shape, "profile_csv"); !profile.empty())
    result.words += ", profile " + profile;
  const auto dims = shape.find("dims");
  for (const auto& [key, value] : sorted_dimensions(dims != shape.end() && dims->is_object() ? *dims : shape)) {
    const Quantity shown_as = quantity(key, value);
    result.words += (result.words.empty() ? "" : ", ") + shown_as.words + " " + rounded(value * shown_as.factor, 5) +
                    " " + shown_as.unit;
  }
  return result;
}

std::string facts_html(const BodyFacts& facts) {
  std::string text;
  const auto fact = [&](const std::string& words) { text += (text.empty() ? "" : " · ") + words; };
  if (facts.mass_kg) fact("mass " + rounded(1000 * *facts.mass_kg, 5) + " g");
  if (facts.explained_energy) fact(rounded(100 * *facts.explained_energy, 4) + " % of the energy explained");
  if (facts.n_strikes > 1) fact(std::to_string(facts.n_strikes) + " strikes");
  if (facts.n_nodes)
    fact(std::to_string(*facts.n_nodes) + " nodes" +
         (facts.n_elements ? ", " + std::to_string(*facts.n_elements) + " elements" : ""));
  if (facts.none_missing)
    fact(*facts.none_missing ? "no mode missing in the band (proven by a Sturm count)"
                             : "not proven that no mode is missing in the band");
  return text.empty() ? "" : "<p class=\"how\"><small>" + text + "</small></p>\n";
}

}  // namespace klang::reports::detail
