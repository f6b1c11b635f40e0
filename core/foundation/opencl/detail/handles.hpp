#pragma once
#include <CL/cl.h>

#include <memory>
#include <type_traits>
#include <vector>

namespace klang::opencl::detail {

template <auto release>
struct Release {
  template <typename Handle>
  void operator()(Handle handle) const {
    release(handle);
  }
};
template <typename Handle, auto release>
using Owned = std::unique_ptr<std::remove_pointer_t<Handle>, Release<release>>;

using OwnedContext = Owned<cl_context, clReleaseContext>;
using OwnedQueue = Owned<cl_command_queue, clReleaseCommandQueue>;
using OwnedProgram = Owned<cl_program, clReleaseProgram>;
using OwnedKernel = Owned<cl_kernel, clReleaseKernel>;

struct Compiled;

/// In the order of devices().
std::vector<cl_device_id> device_ids();

}  // namespace klang::opencl::detail
