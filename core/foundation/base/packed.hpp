#pragma once
#include <cstddef>
#include <cstring>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace klang {

/// Values one after another as this processor keeps them: for messages between processes of one run, never for files.
class Packer {
 public:
  template <class T>
  Packer& add(const T& value) {
    static_assert(std::is_trivially_copyable_v<T>);
    return add_bytes(&value, sizeof value);
  }
  /// A vector of values (std::vector, std::string, Eigen): its length and its values.
  template <class List>
  Packer& add_list(const List& list) {
    static_assert(std::is_trivially_copyable_v<std::decay_t<decltype(*list.data())>>);
    add(static_cast<std::size_t>(list.size()));
    return add_bytes(list.data(), static_cast<std::size_t>(list.size()) * sizeof(*list.data()));
  }
  std::string take() { return std::move(bytes_); }

 private:
  Packer& add_bytes(const void* from, std::size_t n) {
    if (n > 0) bytes_.append(static_cast<const char*>(from), n);
    return *this;
  }
  std::string bytes_;
};

/// Reads what Packer wrote, in the same order. @throws std::runtime_error where fewer bytes are there than asked for
class Unpacker {
 public:
  explicit Unpacker(std::string_view bytes) : rest_(bytes) {}
  template <class T>
  T take() {
    static_assert(std::is_trivially_copyable_v<T>);
    T value;
    take_bytes(&value, sizeof value);
    return value;
  }
  template <class List>
  List take_list() {
    const auto n = take<std::size_t>();
    using Value = std::decay_t<decltype(*std::declval<List&>().data())>;
    if (n > rest_.size() / sizeof(Value)) throw std::runtime_error("a message between processes is cut off");
    List list;
    list.resize(static_cast<decltype(list.size())>(n));
    take_bytes(list.data(), n * sizeof(Value));
    return list;
  }
  bool done() const { return rest_.empty(); }

 private:
  void take_bytes(void* to, std::size_t n) {
    if (n > rest_.size()) throw std::runtime_error("a message between processes is cut off");
    if (n > 0) std::memcpy(to, rest_.data(), n);
    rest_.remove_prefix(n);
  }
  std::string_view rest_;
};

}  // namespace klang
