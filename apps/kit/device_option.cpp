#include "apps/kit/device_option.hpp"

namespace klang::apps {

opencl::DeviceChoice DeviceOption::choice() const {
  if (!device) return {};
  const auto wanted = precision == "single" ? opencl::Precision::kSingle : opencl::Precision::kDouble;
  opencl::DeviceChoice choice{.used = true, .device = *device, .precision = wanted};
  const std::vector<opencl::Device> devices = opencl::devices();
  if (devices.empty()) {
    choice.used = choice.device != "auto";
  } else {
    const opencl::Device& chosen = devices[opencl::chosen_device(devices, choice.device)];
    if (choice.device == "auto") choice.used = chosen.kind == "gpu" && chosen.double_precision;
  }
  return choice;
}

void add_device_option(CLI::App& app, CommonOptions& common, DeviceOption& option, const std::string& what) {
  app.add_option("--device", option.device,
                 what +
                     " on an OpenCL device: auto (a GPU where there is one, else the processor), cpu (OpenCL on the "
                     "processor), an index or part of a name as in klang doctor; without it, on the processor");
  app.add_option("--precision", option.precision, "Of the OpenCL device")
      ->check(CLI::IsMember({"single", "double"}))
      ->capture_default_str();
  name_field(app, common, "device", "--device");
}

}  // namespace klang::apps
