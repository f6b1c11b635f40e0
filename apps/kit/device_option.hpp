#pragma once
#include <CLI/CLI.hpp>
#include <optional>
#include <string>

#include "apps/kit/command.hpp"
#include "core/foundation/opencl/session.hpp"

namespace klang::apps {

/// --device and --precision of a command whose work the processor does quicker than OpenCL on the same processor.
struct DeviceOption {
  std::optional<std::string> device;
  std::string precision = "double";

  /// Without --device the processor's own code; auto: a GPU with double precision where there is one, else that code too.
  /// @throws InputError where no device fits
  opencl::DeviceChoice choice() const;
};

/// @param what  is made there, for the help: "The matrices are made"
void add_device_option(CLI::App& app, CommonOptions& common, DeviceOption& option, const std::string& what);

}  // namespace klang::apps
