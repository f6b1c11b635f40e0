#include <CL/cl.h>

#include <CLI/CLI.hpp>
#include <cstdlib>
#include <memory>

#include "command.hpp"
#include "core/base/json.hpp"
#include "core/base/parallel.hpp"
#include "core/base/provenance.hpp"
#include "versions.hpp"

namespace klang::apps {
namespace {

struct OpenClDevice {
  std::string platform, name, kind;
  unsigned compute_units = 0;
  unsigned long long memory_bytes = 0;
  bool double_precision = false;
};

std::string platform_text(cl_platform_id platform, cl_platform_info what) {
  std::size_t size = 0;
  if (clGetPlatformInfo(platform, what, 0, nullptr, &size) != CL_SUCCESS || size == 0) return {};
  std::string text(size, '\0');
  clGetPlatformInfo(platform, what, size, text.data(), nullptr);
  text.resize(size - 1);
  return text;
}

std::string device_text(cl_device_id device, cl_device_info what) {
  std::size_t size = 0;
  if (clGetDeviceInfo(device, what, 0, nullptr, &size) != CL_SUCCESS || size == 0) return {};
  std::string text(size, '\0');
  clGetDeviceInfo(device, what, size, text.data(), nullptr);
  text.resize(size - 1);
  return text;
}

std::vector<OpenClDevice> opencl_devices() {
  cl_uint n_platforms = 0;
  if (clGetPlatformIDs(0, nullptr, &n_platforms) != CL_SUCCESS) return {};
  std::vector<cl_platform_id> platforms(n_platforms);
  clGetPlatformIDs(n_platforms, platforms.data(), nullptr);
  std::vector<OpenClDevice> found;
  for (cl_platform_id platform : platforms) {
    cl_uint n_devices = 0;
    if (clGetDeviceIDs(platform, CL_DEVICE_TYPE_ALL, 0, nullptr, &n_devices) != CL_SUCCESS) continue;
    std::vector<cl_device_id> devices(n_devices);
    clGetDeviceIDs(platform, CL_DEVICE_TYPE_ALL, n_devices, devices.data(), nullptr);
    for (cl_device_id device : devices) {
      OpenClDevice d;
      d.platform = platform_text(platform, CL_PLATFORM_NAME);
      d.name = device_text(device, CL_DEVICE_NAME);
      cl_device_type type = 0;
      clGetDeviceInfo(device, CL_DEVICE_TYPE, sizeof type, &type, nullptr);
      d.kind = (type & CL_DEVICE_TYPE_GPU) != 0 ? "gpu" : (type & CL_DEVICE_TYPE_CPU) != 0 ? "cpu" : "other";
      cl_uint units = 0;
      clGetDeviceInfo(device, CL_DEVICE_MAX_COMPUTE_UNITS, sizeof units, &units, nullptr);
      d.compute_units = units;
      cl_ulong memory = 0;
      clGetDeviceInfo(device, CL_DEVICE_GLOBAL_MEM_SIZE, sizeof memory, &memory, nullptr);
      d.memory_bytes = memory;
      d.double_precision = device_text(device, CL_DEVICE_EXTENSIONS).find("cl_khr_fp64") != std::string::npos;
      found.push_back(d);
    }
  }
  return found;
}

int run_doctor(const CommonOptions& common) {
  const char* display = std::getenv("DISPLAY");
  const auto libraries = library_versions();
  const auto devices = opencl_devices();
  const bool has_xvfb = program_in_path("Xvfb");
  nlohmann::json json = result_header("doctor", "done", common, nlohmann::json::object(), {});
  json["threads"] = thread_count();
  json["display"] = display != nullptr ? display : "";
  json["xvfb"] = has_xvfb;
  say(common, "klang %s, %d threads\n\nlibraries\n", version().c_str(), thread_count());
  for (const auto& [name, text] : libraries) {
    json["libraries"][name] = text;
    say(common, "  %-14s %s\n", name.c_str(), text.c_str());
  }
  say(common, "\nOpenCL devices\n");
  json["opencl_devices"] = nlohmann::json::array();
  for (const OpenClDevice& d : devices) {
    json["opencl_devices"].push_back({{"platform", d.platform}, {"name", d.name}, {"kind", d.kind},
                                      {"compute_units", d.compute_units}, {"memory_bytes", d.memory_bytes},
                                      {"double_precision", d.double_precision}});
    say(common, "  %s: %s (%s, %u compute units, %.1f GB, %s)\n", d.platform.c_str(), d.name.c_str(), d.kind.c_str(),
        d.compute_units, static_cast<double>(d.memory_bytes) / 1e9,
        d.double_precision ? "double precision" : "single precision only");
  }
  if (devices.empty()) say(common, "  none\n");
  say(common, "\npictures\n  DISPLAY %s; Xvfb %s\n", display != nullptr ? display : "is not set",
      has_xvfb ? "is installed" : "is NOT installed");
  if (display == nullptr && !has_xvfb) say(common, "  mode pictures will be left out: install the package xvfb\n");
  write_json(common, json);
  return kDone;
}

}  // namespace

Subcommand add_doctor(CLI::App& program, CommonOptions& common) {
  CLI::App* app = program.add_subcommand("doctor", "What is installed: libraries, OpenCL devices, display, threads");
  app->footer("Example:\n  klang doctor --json doctor.json");
  return {app, [&common] { return run_doctor(common); }};
}

}  // namespace klang::apps
