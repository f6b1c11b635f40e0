#pragma once
#include <cstdint>
#include <filesystem>
#include <istream>
#include <ostream>
#include <string>
#include <vector>

#include "core/foundation/base/errors.hpp"

namespace klang {

/// Appends a mark and the SHA-256 of all that is in a file, so that later no damaged byte of it is taken for a number.
/// @throws InputError where it cannot be read or written
void seal_file(const std::filesystem::path& path);
/// Whether a file ends with the seal of what is before. A file that is not there has none.
bool is_sealed(const std::filesystem::path& path);

/// Bytes from here to the end of a stream that can be wound.
std::uint64_t bytes_left(std::istream& in);

/// A value without pointers, as it stands in memory.
template <class T>
void write_value(std::ostream& out, const T& value) {
  out.write(reinterpret_cast<const char*>(&value), sizeof value);
}
/// How many there are as 64 bits, and the entries.
template <class T>
void write_list(std::ostream& out, const std::vector<T>& values) {
  write_value(out, static_cast<std::uint64_t>(values.size()));
  out.write(reinterpret_cast<const char*>(values.data()), static_cast<std::streamsize>(values.size() * sizeof(T)));
}
/// What write_value() wrote. @throws InputError of that name where the stream ends before
template <class T>
T read_value(std::istream& in, const std::string& name) {
  T value;
  if (!in.read(reinterpret_cast<char*>(&value), sizeof value)) throw InputError(name, "is damaged or cut off");
  return value;
}

/// A list of n entries as they stand in memory. No memory is asked for that the stream could not fill.
/// @throws InputError of that name
template <class T>
void read_list(std::istream& in, std::vector<T>& values, std::uint64_t n, const std::string& name) {
  if (n > bytes_left(in) / sizeof(T)) throw InputError(name, "is damaged or cut off");
  values.resize(n);
  if (n > 0 && !in.read(reinterpret_cast<char*>(values.data()), static_cast<std::streamsize>(n * sizeof(T))))
    throw InputError(name, "is damaged or cut off");
}

}  // namespace klang
