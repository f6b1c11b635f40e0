#pragma once
#include <string>
#include <vector>

namespace klang::opencl {

struct Device {
  std::string platform, name;
  std::string kind;  ///< "gpu", "cpu" or "other"
  unsigned compute_units = 0;
  unsigned long long memory_bytes = 0;
  bool double_precision = false;
  unsigned long long largest_buffer_bytes = 0;  ///< in one piece
};

/// All devices of all platforms, in the order in which an index chooses them. Empty where OpenCL finds none.
std::vector<Device> devices();

/// Which one is meant: "auto" or empty: the first GPU with double precision, else PoCL's processor, else another, else the first of all; "cpu": PoCL's
/// processor or another; an index; a part of its name (any case).
/// @throws InputError when no device fits; devices must not be empty
std::size_t chosen_device(const std::vector<Device>& devices, const std::string& choice);

}  // namespace klang::opencl
