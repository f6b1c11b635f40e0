#pragma once
#include <string>
#include <string_view>

namespace klang {

/// "0.1.0" or "0.1.0+g1234abc" (the commit it was configured from).
std::string version();

/// Lower-case hexadecimal SHA-256 of the bytes.
std::string sha256(std::string_view bytes);

}  // namespace klang
