// Any bytes given as a recipe, a specimen or a scene are either read or refused with an InputError; nothing else.
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "core/foundation/base/errors.hpp"
#include "core/sound/stage/bubble_scene.hpp"
#include "datasets-synthetic/drop_recipe.hpp"
#include "datasets-synthetic/recipe_spec.hpp"
#include "fit/specimen/specimen.hpp"

namespace {

/// A population's bubbles are made while a scene is read, and many of them say no more than few: "count" with a long number is left out.
bool counts_to_many(std::string_view text) {
  for (std::size_t at = text.find("count"); at != std::string_view::npos; at = text.find("count", at + 1)) {
    const std::string_view after = text.substr(at, 60);
    int n_digits = 0;
    for (const char c : after) {
      n_digits = (c >= '0' && c <= '9') || c == '_' ? n_digits + 1 : 0;
      if (n_digits > 3) return true;
    }
    if (after.substr(5).find_first_of("eEx") != std::string_view::npos) return true;
  }
  return false;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  try {
    klang::datasets::parse_recipe(text, "fuzz.toml", ".");
  } catch (const klang::InputError&) {
  }
  try {
    klang::datasets::parse_drop_recipe(text, "fuzz.toml", 1);
  } catch (const klang::InputError&) {
  }
  try {
    klang::fit::parse_fit_problem(text, "fuzz.toml", ".");
  } catch (const klang::InputError&) {
  }
  if (counts_to_many(text)) return 0;
  try {
    klang::stage::parse_bubble_scene(text, "fuzz.toml", "/nowhere", 1);
  } catch (const klang::InputError&) {
  }
  return 0;
}
