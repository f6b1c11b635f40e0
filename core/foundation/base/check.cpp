#include "core/foundation/base/check.hpp"

#include <cstdio>
#include <cstdlib>

namespace klang::detail {

void check_failed(const char* condition, std::string_view message, const char* file, int line) {
  std::fprintf(stderr, "%s:%d: check failed: %s: %.*s\n", file, line, condition, static_cast<int>(message.size()),
               message.data());
  std::abort();
}

}  // namespace klang::detail
