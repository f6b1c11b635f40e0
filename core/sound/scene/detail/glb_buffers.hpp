#pragma once
#include <cstring>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace klang::scene::detail {

/// Appends a number as it stands in memory.
template <class Number>
void append(std::string& bytes, Number value) {
  char raw[sizeof value];
  std::memcpy(raw, &value, sizeof value);
  bytes.append(raw, sizeof value);
}

/// The numbers of a glTF file and where they stand.
class GlbBuffers {
 public:
  nlohmann::json views = nlohmann::json::array(), accessors = nlohmann::json::array();
  std::string bytes;

  /// @param width  floats per entry. @return number of the accessor
  int add(const std::vector<float>& values, int width, bool vertices, bool with_range);
  /// Corners of triangles. @return number of the accessor
  int add_corners(const std::vector<std::uint32_t>& corners);

 private:
  int add_accessor(nlohmann::json view, nlohmann::json accessor);
};

/// Keyframes of nodes.
class GlbKeys {
 public:
  nlohmann::json channels = nlohmann::json::array(), samplers = nlohmann::json::array();

  struct Channel {
    const char* path;
    int width;
    const char* interpolation;
  };
  void add(int node, const Channel& channel, const std::vector<float>& times, const std::vector<float>& values,
           GlbBuffers& buffers);
};

/// A whole file of a document, which gets its buffer here, and its numbers.
std::string glb_bytes(nlohmann::json document, std::string binary);

}  // namespace klang::scene::detail
