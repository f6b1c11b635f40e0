#include "core/foundation/base/memory.hpp"

#include <sys/mman.h>
#include <unistd.h>

#include <cstdint>

namespace klang {

void prefer_huge_pages(void* data, std::size_t n_bytes) {
  constexpr std::size_t kWorthwhile = std::size_t{4} << 20;
  if (n_bytes < kWorthwhile) return;
  const auto page = static_cast<std::uintptr_t>(::sysconf(_SC_PAGESIZE));
  const auto begin = (reinterpret_cast<std::uintptr_t>(data) + page - 1) / page * page;
  const auto end = (reinterpret_cast<std::uintptr_t>(data) + n_bytes) / page * page;
  (void)::madvise(reinterpret_cast<void*>(begin), end - begin, MADV_HUGEPAGE);  // a wish: no error matters
}

std::size_t physical_memory_bytes() {
  return static_cast<std::size_t>(::sysconf(_SC_PHYS_PAGES)) * static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
}

}  // namespace klang
