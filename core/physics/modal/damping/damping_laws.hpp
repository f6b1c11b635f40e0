#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "core/physics/modal/damping/damping_law.hpp"

namespace klang::damping {

/// Where a law is offered; each includes those before it.
enum class LawUse {
  kFits,     ///< decays are fitted by every law
  kRecipes,  ///< recipes of synthetic recordings
  kOptions   ///< command-line options, whose laws add up
};

/// The laws offered for a use, in the order in which they are tried and listed.
const std::vector<const DampingLaw*>& damping_laws(LawUse use = LawUse::kFits);

/// The law of that name, or nullptr.
const DampingLaw* find_law(std::string_view name, LawUse use = LawUse::kFits);

/// The law whose parameters are just these, in any order; nullptr where there is none.
const DampingLaw* law_of_parameters(const std::vector<std::string>& names);

/// Whether a law has a parameter of that name.
bool is_law_parameter(std::string_view name);

/// "rayleigh, loss_factor, zener".
std::string law_names(LawUse use);

}  // namespace klang::damping
