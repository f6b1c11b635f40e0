#pragma once
#include <cstddef>
#include <cstdlib>
#include <memory>

namespace klang {

/// Asks the system for pages of 2 MB under memory that nothing has been written to yet: to fetch thousands of small ones costs as much as the work on
/// them. A hint: nothing happens below two megabytes, or where there are none.
void advise_huge_pages(void* begin, std::size_t n_bytes);

/// malloc() with that advice; std::free() frees it.
void* huge_malloc(std::size_t n_bytes);

struct Freed {
  void operator()(double* values) const { std::free(values); }
};
using HugeValues = std::unique_ptr<double[], Freed>;

/// So many zeros; pages of large arrays are fetched where they are first used. @throws std::bad_alloc
HugeValues huge_zeros(std::size_t n);

}  // namespace klang
