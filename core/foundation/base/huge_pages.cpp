#include "core/foundation/base/huge_pages.hpp"

#include <sys/mman.h>

#include <algorithm>
#include <cstdint>
#include <new>

namespace klang {

void advise_huge_pages(void* begin, std::size_t n_bytes) {
  constexpr std::size_t kPage = 4096, kFewest = std::size_t{2} << 20;
  if (begin == nullptr || n_bytes < kFewest) return;
  const std::uintptr_t from = (reinterpret_cast<std::uintptr_t>(begin) + kPage - 1) / kPage * kPage,
                       to = (reinterpret_cast<std::uintptr_t>(begin) + n_bytes) / kPage * kPage;
  madvise(reinterpret_cast<void*>(from), to - from, MADV_HUGEPAGE);
}

void* huge_malloc(std::size_t n_bytes) {
  void* memory = std::malloc(n_bytes);
  advise_huge_pages(memory, n_bytes);
  return memory;
}

HugeValues huge_zeros(std::size_t n) {
  void* memory = std::calloc(std::max<std::size_t>(n, 1), sizeof(double));
  if (memory == nullptr) throw std::bad_alloc();
  advise_huge_pages(memory, n * sizeof(double));
  return HugeValues(static_cast<double*>(memory));
}

}  // namespace klang
