#include "tests/places.hpp"

namespace klang::test {

std::string source_dir() { return KLANG_SOURCE_DIR; }
std::string test_data() { return source_dir() + "/tests/data"; }

}  // namespace klang::test
