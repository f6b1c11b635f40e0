#pragma once

namespace klang::validate::detail {

constexpr double kCentsPerNeper = 1731.2340490667561;
constexpr double kLevelRange = 1e-4;  // of the loudest third octave: weaker ones are not judged

}  // namespace klang::validate::detail
