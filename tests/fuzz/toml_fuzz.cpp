// Any bytes given as a recipe or as a specimen are either read or refused with an InputError; nothing else.
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "core/foundation/base/errors.hpp"
#include "datasets-synthetic/drop_recipe.hpp"
#include "datasets-synthetic/recipe_spec.hpp"
#include "fit/specimen/specimen.hpp"

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
  return 0;
}
