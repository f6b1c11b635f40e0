#pragma once
#include <CL/cl.h>

#include <memory>
#include <type_traits>
#include <vector>

namespace klang::acoustics::detail {

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
using OwnedBuffer = Owned<cl_mem, clReleaseMemObject>;

/// In the order of opencl_devices().
std::vector<cl_device_id> opencl_device_ids();

}  // namespace klang::acoustics::detail
