#include "core/foundation/opencl/session.hpp"

#include <algorithm>
#include <cstdio>
#include <map>
#include <mutex>
#include <tuple>

#include "core/foundation/base/check.hpp"
#include "core/foundation/opencl/detail/handles.hpp"

namespace klang::opencl {

// Context and compiled program of one device, source and precision. They live as long as the process: drivers are not
// reliably there any more when static objects are destroyed.
struct detail::Compiled {
  cl_device_id device;
  cl_context context;
  cl_program program;
  std::size_t group;
};

namespace {

using detail::Compiled;

void check(cl_int code, const std::string& what) {
  if (code == CL_SUCCESS) return;
  if (code == CL_MEM_OBJECT_ALLOCATION_FAILURE || code == CL_OUT_OF_RESOURCES || code == CL_OUT_OF_HOST_MEMORY)
    throw Error("OpenCL: " + what + " failed with code " + std::to_string(code) + ": the device is out of memory");
  throw Error("OpenCL: " + what + " failed with code " + std::to_string(code));
}

std::string one_line(std::string text) {
  std::replace(text.begin(), text.end(), '\n', ' ');
  return text.substr(0, 300);
}

constexpr const char* kDoublePrelude =
    "#pragma OPENCL EXTENSION cl_khr_fp64 : enable\n"
    "typedef double REAL;\ntypedef double2 REAL2;\n#define KLANG_DOUBLE\n";
constexpr const char* kSinglePrelude = "typedef float REAL;\ntypedef float2 REAL2;\n";

const Compiled& compiled(cl_device_id device, bool is_cpu, const char* source, Precision precision) {
  static std::mutex mutex;
  static auto& cache = *new std::map<std::tuple<cl_device_id, const char*, Precision>, Compiled>;
  const std::lock_guard lock(mutex);
  const auto key = std::tuple(device, source, precision);
  if (const auto found = cache.find(key); found != cache.end()) return found->second;
  cl_int code = CL_SUCCESS;
  detail::OwnedContext context(clCreateContext(nullptr, 1, &device, nullptr, nullptr, &code));
  check(code, "clCreateContext");
  const char* parts[2] = {precision == Precision::kDouble ? kDoublePrelude : kSinglePrelude, source};
  detail::OwnedProgram program(clCreateProgramWithSource(context.get(), 2, parts, nullptr, &code));
  check(code, "clCreateProgramWithSource");
  const std::size_t group = is_cpu ? 8 : 64;
  const std::string options = "-cl-std=CL1.2 -DGROUP=" + std::to_string(group) +
                              (precision == Precision::kDouble ? "" : " -cl-single-precision-constant");
  if (clBuildProgram(program.get(), 1, &device, options.c_str(), nullptr, nullptr) != CL_SUCCESS) {
    std::size_t size = 0;
    clGetProgramBuildInfo(program.get(), device, CL_PROGRAM_BUILD_LOG, 0, nullptr, &size);
    std::string log(size, '\0');
    clGetProgramBuildInfo(program.get(), device, CL_PROGRAM_BUILD_LOG, size, log.data(), nullptr);
    throw Error("OpenCL: the kernels do not compile: " + one_line(log));
  }
  return cache.emplace(key, Compiled{device, context.release(), program.release(), group}).first->second;
}

std::string gigabytes(std::size_t bytes) {
  char text[40];
  std::snprintf(text, sizeof text, "%.3g GB", static_cast<double>(bytes) / 1e9);
  return text;
}

cl_mem memory_of(const std::shared_ptr<void>& handle) { return static_cast<cl_mem>(handle.get()); }

}  // namespace

struct Session::State {
  Device device;
  Precision precision;
  const Compiled* compiled = nullptr;
  detail::OwnedQueue queue;
  std::map<std::string, detail::OwnedKernel, std::less<>> kernels;

  cl_kernel kernel(const char* name) {
    if (const auto held = kernels.find(name); held != kernels.end()) return held->second.get();
    cl_int code = CL_SUCCESS;
    detail::OwnedKernel made(clCreateKernel(compiled->program, name, &code));
    check(code, name);
    return kernels.emplace(name, std::move(made)).first->second.get();
  }
};

Session::Session(const char* source, const std::string& choice, Precision precision) : state_(new State) {
  const std::vector<Device> found = devices();
  if (found.empty()) throw Error("OpenCL: no device is installed");
  const std::size_t index = chosen_device(found, choice);
  state_->device = found[index];
  state_->precision = precision;
  if (precision == Precision::kDouble && !found[index].double_precision)
    throw Error("OpenCL: " + found[index].name + " has single precision only");
  const std::vector<cl_device_id> ids = detail::device_ids();
  if (index >= ids.size()) throw Error("OpenCL: the device has gone");
  state_->compiled = &compiled(ids[index], found[index].kind == "cpu", source, precision);
  cl_int code = CL_SUCCESS;
  state_->queue.reset(
      clCreateCommandQueueWithProperties(state_->compiled->context, state_->compiled->device, nullptr, &code));
  check(code, "clCreateCommandQueueWithProperties");
}

Session::~Session() = default;
Session::Session(Session&&) noexcept = default;
Session& Session::operator=(Session&&) noexcept = default;

const Device& Session::device() const { return state_->device; }
Precision Session::precision() const { return state_->precision; }
std::size_t Session::group() const { return state_->compiled->group; }

void Session::check_memory(std::size_t all_bytes, std::size_t largest_bytes, const std::string& what,
                           std::size_t limit_bytes) const {
  const Device& d = state_->device;
  const std::size_t has = limit_bytes > 0 ? std::min<std::size_t>(limit_bytes, d.memory_bytes) : d.memory_bytes;
  if (all_bytes > has)
    throw Error("OpenCL: " + what + " needs " + gigabytes(all_bytes) + ", " + d.name + " has " + gigabytes(has) +
                (limit_bytes > 0 ? " to use" : ""));
  if (largest_bytes > d.largest_buffer_bytes)
    throw Error("OpenCL: " + what + " needs " + gigabytes(largest_bytes) + " in one piece, " + d.name + " gives " +
                gigabytes(d.largest_buffer_bytes));
}

Buffer Session::buffer(std::size_t n_bytes) {
  Buffer made;
  made.n_bytes_ = std::max<std::size_t>(n_bytes, 16);
  cl_int code = CL_SUCCESS;
  cl_mem memory = clCreateBuffer(state_->compiled->context, CL_MEM_READ_WRITE, made.n_bytes_, nullptr, &code);
  check(code, "clCreateBuffer of " + gigabytes(made.n_bytes_));
  made.handle_ = std::shared_ptr<void>(memory, [](void* handle) { clReleaseMemObject(static_cast<cl_mem>(handle)); });
  return made;
}

Buffer Session::upload_bytes(const void* data, std::size_t n_bytes) {
  Buffer made = buffer(n_bytes);
  if (n_bytes > 0) write(made, data, n_bytes);
  return made;
}

void Session::write(Buffer& to, const void* data, std::size_t n_bytes, std::size_t at_byte) {
  KLANG_CHECK(at_byte + n_bytes <= to.n_bytes_, "the write lies within the buffer");
  check(clEnqueueWriteBuffer(state_->queue.get(), memory_of(to.handle_), CL_TRUE, at_byte, n_bytes, data, 0, nullptr,
                             nullptr),
        "clEnqueueWriteBuffer");
}

void Session::read(const Buffer& from, void* data, std::size_t n_bytes, std::size_t at_byte) {
  KLANG_CHECK(at_byte + n_bytes <= from.n_bytes_, "the read lies within the buffer");
  check(clEnqueueReadBuffer(state_->queue.get(), memory_of(from.handle_), CL_TRUE, at_byte, n_bytes, data, 0, nullptr,
                            nullptr),
        "clEnqueueReadBuffer");
}

void Session::read_block(const Buffer& from, std::size_t at_byte, std::size_t row_bytes, std::size_t width,
                         std::size_t height, void* data) {
  KLANG_CHECK(height > 0 && at_byte + (height - 1) * row_bytes + width <= from.n_bytes_,
              "the block lies within the buffer");
  const std::size_t from_at[3] = {at_byte % row_bytes, at_byte / row_bytes, 0}, to_at[3] = {0, 0, 0};
  const std::size_t region[3] = {width, height, 1};
  check(clEnqueueReadBufferRect(state_->queue.get(), memory_of(from.handle_), CL_TRUE, from_at, to_at, region,
                                row_bytes, 0, width, 0, data, 0, nullptr, nullptr),
        "clEnqueueReadBufferRect");
}

void Session::finish() { check(clFinish(state_->queue.get()), "clFinish"); }

void Session::set_bytes(const char* kernel, unsigned index, std::size_t size, const void* value) {
  check(clSetKernelArg(state_->kernel(kernel), index, size, value), std::string("clSetKernelArg of ") + kernel);
}

void Session::enqueue(const char* kernel, std::initializer_list<std::size_t> sizes, const std::size_t* group) {
  check(clEnqueueNDRangeKernel(state_->queue.get(), state_->kernel(kernel), static_cast<cl_uint>(sizes.size()), nullptr,
                               sizes.begin(), group, 0, nullptr, nullptr),
        kernel);
}

}  // namespace klang::opencl
