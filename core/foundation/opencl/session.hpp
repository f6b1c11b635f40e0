#pragma once
#include <array>
#include <complex>
#include <cstddef>
#include <initializer_list>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/foundation/opencl/devices.hpp"

namespace klang::opencl {

enum class Precision { kSingle, kDouble };

/// The device, its driver or its compiler failed, or it has no memory for the work; the message is one line.
class Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Memory on a device; shared by its copies, released with the last one.
class Buffer {
 public:
  Buffer() = default;
  std::size_t size() const { return n_bytes_; }

 private:
  friend class Session;
  std::shared_ptr<void> handle_;
  std::size_t n_bytes_ = 0;
};

/// A double as one or two numbers of the device's precision that add up to it.
template <typename Real>
std::array<Real, 2> two_parts(long double value) {
  const Real high = static_cast<Real>(value);
  return {high, static_cast<Real>(value - static_cast<long double>(high))};
}

/// Kernels of one source on one device: a queue that runs in order, and the memory that they use. Sources are compiled once per
/// device and precision in the process. In the source REAL, REAL2 and GROUP (the size of a work group that suits the device) are
/// defined, and KLANG_DOUBLE where REAL is double. A session is used by one thread at a time; different sessions by any.
class Session {
 public:
  /// @param source  lives as long as the process
  /// @param choice  as chosen_device
  /// @throws InputError when no device fits the choice; Error when it lacks the precision, and where there is none
  Session(const char* source, const std::string& choice, Precision precision);
  ~Session();
  Session(Session&&) noexcept;
  Session& operator=(Session&&) noexcept;

  const Device& device() const;
  Precision precision() const;
  std::size_t group() const;  ///< GROUP
  /// n up to the next multiple of group(): for ranges whose kernels leave out what is beyond n.
  std::size_t padded(std::size_t n) const { return (n + group() - 1) / group() * group(); }

  /// To be called before anything large is allocated: drivers promise memory that they do not have.
  /// @param limit_bytes  what may be used of the device's memory; 0: all
  /// @throws Error that names both numbers
  void check_memory(std::size_t all_bytes, std::size_t largest_bytes, const std::string& what,
                    std::size_t limit_bytes = 0) const;

  Buffer buffer(std::size_t n_bytes);  ///< 16 bytes at least
  template <typename T>
  Buffer upload(const std::vector<T>& values) {
    return upload_bytes(values.data(), values.size() * sizeof(T));
  }
  Buffer upload_bytes(const void* data, std::size_t n_bytes);
  /// Both return when the copy is done.
  void write(Buffer& to, const void* data, std::size_t n_bytes, std::size_t at_byte = 0);
  void read(const Buffer& from, void* data, std::size_t n_bytes, std::size_t at_byte = 0);
  /// height rows of width bytes, row_bytes apart on the device from at_byte on, packed at data.
  void read_block(const Buffer& from, std::size_t at_byte, std::size_t row_bytes, std::size_t width, std::size_t height,
                  void* data);

  /// Enqueues a kernel.
  /// @param sizes  of the range; group: of a work group, nullptr: the driver's choice
  template <typename... Arguments>
  void run(const char* kernel, std::initializer_list<std::size_t> sizes, const std::size_t* group,
           const Arguments&... arguments) {
    unsigned index = 0;
    (set(kernel, index++, arguments), ...);
    enqueue(kernel, sizes, group);
  }
  void finish();

 private:
  void set_bytes(const char* kernel, unsigned index, std::size_t size, const void* value);
  template <typename Number>
  void set(const char* kernel, unsigned index, const Number& value) {
    set_bytes(kernel, index, sizeof value, &value);
  }
  void set(const char* kernel, unsigned index, const Buffer& memory) {
    void* handle = memory.handle_.get();
    set_bytes(kernel, index, sizeof handle, &handle);
  }
  void enqueue(const char* kernel, std::initializer_list<std::size_t> sizes, const std::size_t* group);

  struct State;
  std::unique_ptr<State> state_;
};

/// Whether and where work goes to a device.
struct DeviceChoice {
  bool used = false;        ///< false: the processor's own code
  std::string device = {};  ///< chosen_device
  Precision precision = Precision::kDouble;
  std::size_t memory_bytes = 0;  ///< of the device's that may be used; 0: all
};

}  // namespace klang::opencl
