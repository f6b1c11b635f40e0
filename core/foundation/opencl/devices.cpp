#include "core/foundation/opencl/devices.hpp"

#include <algorithm>
#include <cctype>
#include <optional>

#include "core/foundation/base/check.hpp"
#include "core/foundation/config/fields.hpp"
#include "core/foundation/opencl/detail/handles.hpp"

namespace klang::opencl {
namespace {

std::string device_text(cl_device_id device, cl_device_info what) {
  std::size_t size = 0;
  if (clGetDeviceInfo(device, what, 0, nullptr, &size) != CL_SUCCESS || size == 0) return {};
  std::string text(size, '\0');
  clGetDeviceInfo(device, what, size, text.data(), nullptr);
  text.resize(size - 1);
  return text;
}

template <typename Value>
Value device_value(cl_device_id device, cl_device_info what) {
  Value value{};
  clGetDeviceInfo(device, what, sizeof value, &value, nullptr);
  return value;
}

std::string platform_name(cl_platform_id platform) {
  std::size_t size = 0;
  if (clGetPlatformInfo(platform, CL_PLATFORM_NAME, 0, nullptr, &size) != CL_SUCCESS || size == 0) return {};
  std::string text(size, '\0');
  clGetPlatformInfo(platform, CL_PLATFORM_NAME, size, text.data(), nullptr);
  text.resize(size - 1);
  return text;
}

std::string lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

}  // namespace

std::vector<cl_device_id> detail::device_ids() {
  cl_uint n_platforms = 0;
  if (clGetPlatformIDs(0, nullptr, &n_platforms) != CL_SUCCESS) return {};
  std::vector<cl_platform_id> platforms(n_platforms);
  clGetPlatformIDs(n_platforms, platforms.data(), nullptr);
  std::vector<cl_device_id> found;
  for (cl_platform_id platform : platforms) {
    cl_uint n_devices = 0;
    if (clGetDeviceIDs(platform, CL_DEVICE_TYPE_ALL, 0, nullptr, &n_devices) != CL_SUCCESS) continue;
    std::vector<cl_device_id> devices(n_devices);
    clGetDeviceIDs(platform, CL_DEVICE_TYPE_ALL, n_devices, devices.data(), nullptr);
    found.insert(found.end(), devices.begin(), devices.end());
  }
  return found;
}

std::vector<Device> devices() {
  std::vector<Device> found;
  for (cl_device_id device : detail::device_ids()) {
    Device d;
    d.platform = platform_name(device_value<cl_platform_id>(device, CL_DEVICE_PLATFORM));
    d.name = device_text(device, CL_DEVICE_NAME);
    const auto type = device_value<cl_device_type>(device, CL_DEVICE_TYPE);
    d.kind = (type & CL_DEVICE_TYPE_GPU) != 0 ? "gpu" : (type & CL_DEVICE_TYPE_CPU) != 0 ? "cpu" : "other";
    d.compute_units = device_value<cl_uint>(device, CL_DEVICE_MAX_COMPUTE_UNITS);
    d.memory_bytes = device_value<cl_ulong>(device, CL_DEVICE_GLOBAL_MEM_SIZE);
    d.largest_buffer_bytes = device_value<cl_ulong>(device, CL_DEVICE_MAX_MEM_ALLOC_SIZE);
    d.double_precision = device_text(device, CL_DEVICE_EXTENSIONS).find("cl_khr_fp64") != std::string::npos;
    found.push_back(std::move(d));
  }
  return found;
}

std::size_t chosen_device(const std::vector<Device>& devices, const std::string& choice) {
  KLANG_CHECK(!devices.empty(), "there is a device to choose");
  const auto first = [&](auto&& fits) {
    const auto found = std::find_if(devices.begin(), devices.end(), fits);
    return found == devices.end() ? std::optional<std::size_t>() : static_cast<std::size_t>(found - devices.begin());
  };
  const auto pocl = first([](const Device& d) {
    return d.kind == "cpu" && lower(d.platform).find("portable computing language") != std::string::npos;
  });
  const auto processor = pocl ? pocl : first([](const Device& d) { return d.kind == "cpu"; });
  if (choice.empty() || choice == "auto")
    return first([](const Device& d) { return d.kind == "gpu" && d.double_precision; }).value_or(processor.value_or(0));
  if (choice == "cpu" && processor) return *processor;
  const bool number = std::all_of(choice.begin(), choice.end(), [](unsigned char c) { return std::isdigit(c) != 0; });
  if (number && choice.size() < 6 && std::stoul(choice) < devices.size()) return std::stoul(choice);
  for (std::size_t i = 0; i < devices.size() && !number; ++i) {
    if (lower(devices[i].name).find(lower(choice)) != std::string::npos) return i;
  }
  std::string names = "auto, cpu";
  for (std::size_t i = 0; i < devices.size(); ++i) names += ", " + std::to_string(i) + " (" + devices[i].name + ")";
  throw OptionsError("", {{"device", "fits no OpenCL device", choice, names}});
}

}  // namespace klang::opencl
