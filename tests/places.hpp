#pragma once
#include <string>

namespace klang::test {

/// The checkout and what it holds for tests. A library of their own says where they lie: an absolute path among a compiler's
/// options would keep every checkout from using what another one has compiled.
std::string source_dir();
std::string test_data();

}  // namespace klang::test
