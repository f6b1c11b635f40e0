#pragma once
#include <cstddef>

namespace klang {

/// Asks the system to back a large block, not yet touched, by huge pages: fewer page faults and table look-ups where matrices of
/// hundreds of megabytes are made and read from end to end. Does nothing where the system cannot.
void prefer_huge_pages(void* data, std::size_t n_bytes);

/// Of the machine.
std::size_t physical_memory_bytes();

}  // namespace klang
