#pragma once
#include <gtest/gtest.h>

#include "tests/cli/klang_process.hpp"

namespace klang::test {

/// Runs and expects exit code 2, one line that contains each of the words, and no new files.
inline void expect_refused(const Scratch& scratch, const std::string& arguments, const std::vector<std::string>& words,
                           const std::string& environment = {}) {
  const auto before = scratch.files();
  const auto result = run_klang(arguments, scratch.path(), environment);
  EXPECT_EQ(result.exit_code, 2) << arguments << "\n" << result.err;
  EXPECT_EQ(result.err_lines(), 1) << result.err;
  for (const std::string& word : words)
    EXPECT_NE(result.err.find(word), std::string::npos) << word << " in: " << result.err;
  EXPECT_EQ(scratch.files(), before);
}

}  // namespace klang::test
