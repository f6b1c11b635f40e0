#pragma once
#include <filesystem>

#include "fit/frf/response_set.hpp"

namespace klang::fit::detail {

/// As read_responses, of a MATLAB file (levels 5 and 7.3).
ResponseSet read_mat_responses(const std::filesystem::path& path);

}  // namespace klang::fit::detail
