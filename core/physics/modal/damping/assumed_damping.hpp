#pragma once
#include <string>

#include "core/physics/modal/damping/damping_reader.hpp"

namespace klang::damping {

/// What is assumed of things whose damping nobody measured: each mode loses this share of its energy per radian.
inline constexpr double kAssumedLossFactor = 1e-3;

LawValue assumed_damping();

/// "no damping was measured (WHOSE): a loss factor of 1/1000 is assumed": said wherever it is.
std::string assumed_damping_words(const std::string& whose);

}  // namespace klang::damping
