#pragma once
#include <string_view>

namespace klang::detail {
[[noreturn]] void check_failed(const char* condition, std::string_view message, const char* file, int line);
}

/// A caller's bug, not a user's: always on, prints the place to stderr and aborts. Bad input is an InputError.
#define KLANG_CHECK(condition, message)                                                         \
  do {                                                                                          \
    if (!(condition)) ::klang::detail::check_failed(#condition, (message), __FILE__, __LINE__); \
  } while (false)
