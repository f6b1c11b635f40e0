#pragma once
#include <CLI/App.hpp>
#include <string>

#include "core/physics/bubble/bubble_medium.hpp"

namespace klang::apps {

/// `--thermal`: how the loss by heat is told. @throws InputError
bubble::BubbleTheory thermal_theory(const std::string& choice);
void add_thermal_option(CLI::App& app, std::string& choice);

}  // namespace klang::apps
