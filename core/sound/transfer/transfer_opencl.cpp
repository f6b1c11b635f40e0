#include "core/sound/transfer/transfer_opencl.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <map>
#include <mutex>

#include "core/foundation/base/check.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/sound/transfer/detail/opencl_handles.hpp"
#include "transfer_kernels_cl.hpp"

namespace klang::acoustics {
namespace {

using detail::OwnedBuffer;
using detail::OwnedKernel;
using detail::OwnedQueue;
using Complex = std::complex<double>;

void check(cl_int code, const char* what) {
  if (code != CL_SUCCESS)
    throw OpenClError(std::string("OpenCL: ") + what + " failed with code " + std::to_string(code));
}

std::string one_line(std::string text) {
  std::replace(text.begin(), text.end(), '\n', ' ');
  return text.substr(0, 300);
}

// Context and compiled program of one device and precision. They live as long as the process: drivers are not reliably
// there any more when static objects are destroyed.
struct Compiled {
  cl_device_id device;
  cl_context context;
  cl_program program;
  int group;
};

const Compiled& compiled(cl_device_id device, bool is_cpu, Precision precision) {
  static std::mutex mutex;
  static auto& cache = *new std::map<std::pair<cl_device_id, Precision>, Compiled>;
  const std::lock_guard lock(mutex);
  const auto key = std::pair(device, precision);
  if (const auto found = cache.find(key); found != cache.end()) return found->second;
  cl_int code = CL_SUCCESS;
  detail::OwnedContext context(clCreateContext(nullptr, 1, &device, nullptr, nullptr, &code));
  check(code, "clCreateContext");
  const char* source = kTransferKernelsSource;
  detail::OwnedProgram program(clCreateProgramWithSource(context.get(), 1, &source, nullptr, &code));
  check(code, "clCreateProgramWithSource");
  const int group = is_cpu ? 8 : 64;
  const std::string options = std::string("-cl-std=CL1.2 -DGROUP=") + std::to_string(group) +
                              (precision == Precision::kDouble ? " -DKLANG_DOUBLE" : " -cl-single-precision-constant");
  if (clBuildProgram(program.get(), 1, &device, options.c_str(), nullptr, nullptr) != CL_SUCCESS) {
    std::size_t size = 0;
    clGetProgramBuildInfo(program.get(), device, CL_PROGRAM_BUILD_LOG, 0, nullptr, &size);
    std::string log(size, '\0');
    clGetProgramBuildInfo(program.get(), device, CL_PROGRAM_BUILD_LOG, size, log.data(), nullptr);
    throw OpenClError("OpenCL: the kernels do not compile: " + one_line(log));
  }
  return cache.emplace(key, Compiled{device, context.release(), program.release(), group}).first->second;
}

// A double as one or two numbers of the device's precision that add up to it.
template <typename Real>
std::array<Real, 2> two_parts(long double value) {
  const Real high = static_cast<Real>(value);
  return {high, static_cast<Real>(value - static_cast<long double>(high))};
}

constexpr long double kTwoPi = 6.283185307179586476925286766559005768L;

}  // namespace

struct OpenClTransfer::State {
  OpenClDevice device;
  Precision precision;
  const Compiled* program = nullptr;
  std::mutex mutex;
  OwnedQueue queue;
  OwnedKernel hankel, sectoral_harmonics, harmonics, reduction;
  // Of the model, on the device; 16 bytes where there is nothing.
  OwnedBuffer order, centre_of_mode, first_degree, first_coefficient, degree, order_of_centre, first_harmonic, turns,
      coefficients, diagonal, by_z, by_previous;
  // Of the listeners, for n_slots_held of them.
  OwnedBuffer distance, direction, h, sectoral, y, p;
  int n_listeners_held = 0, listeners_a_time = 1;
  int n_modes = 0, n_centres = 0, n_degrees = 0, n_harmonics = 0, largest_order = 0;
  std::vector<Eigen::Vector3d> centres;
  std::unique_ptr<TransferLayout> layout;  // for check_listeners

  OwnedBuffer buffer(std::size_t n_bytes, const void* data = nullptr) {
    cl_int code = CL_SUCCESS;
    const auto flags =
        static_cast<cl_mem_flags>(data != nullptr ? CL_MEM_READ_ONLY | CL_MEM_COPY_HOST_PTR : CL_MEM_READ_WRITE);
    OwnedBuffer memory(clCreateBuffer(program->context, flags, n_bytes, const_cast<void*>(data), &code));
    check(code, "clCreateBuffer");
    return memory;
  }
  template <typename T>
  OwnedBuffer upload(const std::vector<T>& values) {
    return values.empty() ? buffer(16) : buffer(values.size() * sizeof(T), values.data());
  }
  OwnedKernel kernel(const char* name) {
    cl_int code = CL_SUCCESS;
    OwnedKernel made(clCreateKernel(program->program, name, &code));
    check(code, name);
    return made;
  }
  template <typename Number>
  static void set(cl_kernel kernel, cl_uint& index, Number value) {
    check(clSetKernelArg(kernel, index++, sizeof value, &value), "clSetKernelArg");
  }
  static void set(cl_kernel kernel, cl_uint& index, const OwnedBuffer& memory) {
    cl_mem handle = memory.get();
    check(clSetKernelArg(kernel, index++, sizeof handle, &handle), "clSetKernelArg");
  }
  template <typename... Arguments>
  void launch(const OwnedKernel& kernel, std::initializer_list<std::size_t> sizes, const std::size_t* group,
              const Arguments&... arguments) {
    cl_uint index = 0;
    (set(kernel.get(), index, arguments), ...);
    check(clEnqueueNDRangeKernel(queue.get(), kernel.get(), static_cast<cl_uint>(sizes.size()), nullptr, sizes.begin(),
                                 group, 0, nullptr, nullptr),
          "clEnqueueNDRangeKernel");
  }

  template <typename Real>
  void upload_model(const TransferModel& model);
  template <typename Real>
  void hold(int n_listeners);
  template <typename Real>
  void run(const Eigen::Ref<const Eigen::Matrix3Xd>& listeners, Eigen::Index first, int count,
           Eigen::MatrixXcd& pressures);
};

template <typename Real>
void OpenClTransfer::State::upload_model(const TransferModel& model) {
  n_modes = static_cast<int>(model.modes.size());
  std::vector<int> orders, centre_index, degrees_at, coefficients_at, centre_orders, harmonics_at;
  std::vector<std::array<Real, 2>> turns_per_m, c;
  for (const ModeTransfer& mode : model.modes) {
    const Multipole& m = mode.multipole;
    auto found = std::find(centres.begin(), centres.end(), m.centre_m);
    if (found == centres.end()) {
      centres.push_back(m.centre_m);
      centre_orders.push_back(0);
      found = centres.end() - 1;
    }
    const auto centre = static_cast<int>(found - centres.begin());
    int& centre_order = centre_orders[static_cast<std::size_t>(centre)];
    centre_order = std::max(centre_order, m.order);
    orders.push_back(m.order);
    centre_index.push_back(centre);
    degrees_at.push_back(n_degrees);
    n_degrees += m.order + 1;
    largest_order = std::max(largest_order, m.order);
    turns_per_m.push_back(two_parts<Real>(m.wavenumber_per_m / kTwoPi));
    coefficients_at.push_back(static_cast<int>(c.size()));
    c.resize(c.size() + static_cast<std::size_t>(basis_size(m.order)));
    const auto put = [&](int n, int place, Complex value) {
      c[static_cast<std::size_t>(coefficients_at.back() + basis_index(n, place))] = {static_cast<Real>(value.real()),
                                                                                     static_cast<Real>(value.imag())};
    };
    for (int n = 0; n <= m.order; ++n) {
      put(n, 0, m.coefficients_pa[basis_index(n, 0)]);
      for (int k = 1; k <= n; ++k) {  // as in TransferLayout
        const Complex up = m.coefficients_pa[basis_index(n, k)];
        const Complex down = (k % 2 == 0 ? 1.0 : -1.0) * m.coefficients_pa[basis_index(n, -k)];
        put(n, k, up + down);
        put(n, -k, Complex(0.0, 1.0) * (up - down));
      }
    }
  }
  n_centres = static_cast<int>(centres.size());
  for (const int n : centre_orders) {
    harmonics_at.push_back(n_harmonics);
    n_harmonics += static_cast<int>(basis_size(n));
  }
  std::vector<int> degree_of;
  for (int n = 0; n <= largest_order; ++n) degree_of.insert(degree_of.end(), static_cast<std::size_t>(2 * n + 1), n);
  const SphericalHarmonics tables(largest_order);
  const auto to_real = [](const std::vector<double>& values) {
    return std::vector<Real>(values.begin(), values.end());
  };
  order = upload(orders);
  centre_of_mode = upload(centre_index);
  first_degree = upload(degrees_at);
  first_coefficient = upload(coefficients_at);
  degree = upload(degree_of);
  order_of_centre = upload(centre_orders);
  first_harmonic = upload(harmonics_at);
  turns = upload(turns_per_m);
  coefficients = upload(c);
  diagonal = upload(to_real(tables.diagonal()));
  const auto to_parts = [](const std::vector<double>& values) {
    std::vector<std::array<Real, 2>> parts;
    for (const double value : values) parts.push_back(two_parts<Real>(value));
    return parts;
  };
  by_z = upload(to_parts(tables.by_z()));
  by_previous = upload(to_parts(tables.by_previous()));
  // At most 128 MB of what the passes hand on, and at most 4096 listeners at a time.
  const double bytes_each = sizeof(Real) * (2.0 * n_degrees + n_harmonics + 2.0 * n_centres * (largest_order + 1.0) +
                                            8.0 * n_centres + 2.0 * n_modes);
  listeners_a_time = static_cast<int>(std::clamp(128e6 / bytes_each, 1.0, 4096.0));
}

template <typename Real>
void OpenClTransfer::State::hold(int n_listeners) {
  if (n_listeners <= n_listeners_held) return;
  const auto n = static_cast<std::size_t>(n_listeners) * sizeof(Real);
  const auto count = [](int value) { return static_cast<std::size_t>(std::max(1, value)); };
  distance = buffer(2 * n * count(n_centres));
  direction = buffer(6 * n * count(n_centres));
  h = buffer(2 * n * count(n_degrees));
  sectoral = buffer(2 * n * count(n_centres) * count(largest_order + 1));
  y = buffer(n * count(n_harmonics));
  p = buffer(2 * n * count(n_modes));
  n_listeners_held = n_listeners;
}

template <typename Real>
void OpenClTransfer::State::run(const Eigen::Ref<const Eigen::Matrix3Xd>& listeners, Eigen::Index first, int count,
                                Eigen::MatrixXcd& pressures) {
  hold<Real>(count);
  std::vector<std::array<Real, 2>> distances;
  std::vector<std::array<Real, 2>> directions;
  for (Eigen::Index l = first; l < first + count; ++l) {
    for (const Eigen::Vector3d& centre : centres) {
      const Eigen::Vector3d r = listeners.col(l) - centre;
      const double length = r.norm();
      distances.push_back(two_parts<Real>(length));
      for (int axis = 0; axis < 3; ++axis) directions.push_back(two_parts<Real>(r[axis] / length));
    }
  }
  check(clEnqueueWriteBuffer(queue.get(), distance.get(), CL_TRUE, 0, distances.size() * sizeof distances[0],
                             distances.data(), 0, nullptr, nullptr),
        "clEnqueueWriteBuffer");
  check(clEnqueueWriteBuffer(queue.get(), direction.get(), CL_TRUE, 0, directions.size() * sizeof directions[0],
                             directions.data(), 0, nullptr, nullptr),
        "clEnqueueWriteBuffer");
  const std::array<Real, 2> two_pi = two_parts<Real>(kTwoPi);
  const auto n_l = static_cast<std::size_t>(count), n_m = static_cast<std::size_t>(n_modes),
             n_c = static_cast<std::size_t>(n_centres);
  launch(hankel, {n_m, n_l}, nullptr, order, centre_of_mode, first_degree, n_degrees, n_centres, two_pi[0], two_pi[1],
         turns, distance, h);
  launch(sectoral_harmonics, {n_c, n_l}, nullptr, order_of_centre, n_centres, largest_order, diagonal, direction,
         sectoral);
  launch(harmonics, {static_cast<std::size_t>(largest_order) + 1, n_c, n_l}, nullptr, order_of_centre, first_harmonic,
         n_harmonics, n_centres, largest_order, by_z, by_previous, direction, sectoral, y);
  const std::size_t group[2] = {static_cast<std::size_t>(program->group), 1};
  launch(reduction, {n_m * group[0], n_l}, group, order, centre_of_mode, first_degree, first_harmonic,
         first_coefficient, degree, n_degrees, n_harmonics, n_modes, coefficients, h, y, p);
  std::vector<std::complex<Real>> result(n_m * n_l);
  check(clEnqueueReadBuffer(queue.get(), p.get(), CL_TRUE, 0, result.size() * sizeof result[0], result.data(), 0,
                            nullptr, nullptr),
        "clEnqueueReadBuffer");
  pressures.middleCols(first, count) =
      Eigen::Map<const Eigen::Matrix<std::complex<Real>, Eigen::Dynamic, Eigen::Dynamic>>(result.data(), n_modes, count)
          .template cast<Complex>();
}

OpenClTransfer::OpenClTransfer(const TransferModel& model, const std::string& choice, Precision precision)
    : state_(new State) {
  const std::vector<OpenClDevice> devices = opencl_devices();
  if (devices.empty()) throw OpenClError("OpenCL: no device is installed");
  const std::size_t index = chosen_device(devices, choice);
  state_->device = devices[index];
  state_->precision = precision;
  if (precision == Precision::kDouble && !devices[index].double_precision) {
    throw OpenClError("OpenCL: " + devices[index].name + " has single precision only");
  }
  state_->layout = std::make_unique<TransferLayout>(model);
  const std::vector<cl_device_id> ids = detail::opencl_device_ids();
  if (index >= ids.size()) throw OpenClError("OpenCL: the device has gone");
  state_->program = &compiled(ids[index], devices[index].kind == "cpu", precision);
  cl_int code = CL_SUCCESS;
  state_->queue.reset(
      clCreateCommandQueueWithProperties(state_->program->context, state_->program->device, nullptr, &code));
  check(code, "clCreateCommandQueueWithProperties");
  state_->hankel = state_->kernel("hankel");
  state_->sectoral_harmonics = state_->kernel("sectoral_harmonics");
  state_->harmonics = state_->kernel("harmonics");
  state_->reduction = state_->kernel("reduction");
  precision == Precision::kDouble ? state_->upload_model<double>(model) : state_->upload_model<float>(model);
}

OpenClTransfer::~OpenClTransfer() = default;
const OpenClDevice& OpenClTransfer::device() const { return state_->device; }

void OpenClTransfer::evaluate(const Eigen::Ref<const Eigen::Matrix3Xd>& listeners_m, Eigen::MatrixXcd& pressures_pa) {
  check_listeners(*state_->layout, listeners_m);
  pressures_pa.resize(state_->n_modes, listeners_m.cols());
  if (pressures_pa.size() == 0) return;
  const std::lock_guard lock(state_->mutex);  // kernel arguments and buffers are the object's
  for (Eigen::Index first = 0; first < listeners_m.cols(); first += state_->listeners_a_time) {
    const int count = static_cast<int>(std::min<Eigen::Index>(state_->listeners_a_time, listeners_m.cols() - first));
    if (state_->precision == Precision::kDouble) {
      state_->run<double>(listeners_m, first, count, pressures_pa);
    } else {
      state_->run<float>(listeners_m, first, count, pressures_pa);
    }
  }
}

AnyTransferEvaluator::AnyTransferEvaluator(const TransferModel& model, const TransferDeviceOptions& options) {
  if (options.opencl) {
    try {
      device_ = std::make_unique<OpenClTransfer>(model, options.device, options.precision);
      device_name_ = device_->device().name;
      return;
    } catch (const OpenClError& error) {
      message_ = std::string(error.what()) + "; transfer is evaluated on the processor";
    }
  }
  processor_ = std::make_unique<TransferEvaluator>(model);
}

void AnyTransferEvaluator::evaluate(const Eigen::Ref<const Eigen::Matrix3Xd>& listeners_m,
                                    Eigen::MatrixXcd& pressures_pa) {
  if (device_ != nullptr) {
    device_->evaluate(listeners_m, pressures_pa);
  } else {
    processor_->evaluate(listeners_m, pressures_pa);
  }
}

}  // namespace klang::acoustics
