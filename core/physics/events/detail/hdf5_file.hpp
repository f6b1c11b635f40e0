#pragma once
#include <cstdint>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace klang::events::detail {

/// The library keeps its state per process and is built without threads; it also prints its errors unless told not to.
/// One session at a time, silent while it lives.
class Hdf5Session {
 public:
  Hdf5Session();
  ~Hdf5Session();
  Hdf5Session(const Hdf5Session&) = delete;
  Hdf5Session& operator=(const Hdf5Session&) = delete;

 private:
  std::lock_guard<std::mutex> lock_;
  void* print_data_ = nullptr;
  int (*print_)(std::int64_t, void*) = nullptr;
};

/// A number that the library gives for what is open, closed at the end.
class Hdf5Handle {
 public:
  Hdf5Handle() = default;
  Hdf5Handle(std::int64_t id, int (*closer)(std::int64_t)) : id_(id), close_(closer) {}
  Hdf5Handle(Hdf5Handle&& other) noexcept;
  Hdf5Handle& operator=(Hdf5Handle&& other) noexcept;
  ~Hdf5Handle();
  bool ok() const { return id_ >= 0; }
  operator std::int64_t() const { return id_; }
  /// False where it did not work: what was still to be written is lost.
  bool close();

 private:
  std::int64_t id_ = -1;
  int (*close_)(std::int64_t) = nullptr;
};

/// A file that is made in memory: closing one whose disk is full leaves the library in a state in which it crashes later. Every
/// failure is an InputError with the file and the name.
class Hdf5Output {
 public:
  /// @param path  where it will be, for messages
  explicit Hdf5Output(std::filesystem::path path);
  void attribute(const std::string& name, int value);
  void attribute(const std::string& name, const std::string& value);
  void group(const std::string& name, const std::string& meaning);
  /// name "group/field"; n_columns 1: a list, otherwise a table with the columns of a row side by side.
  void numbers(const std::string& name, const std::string& meaning, std::span<const double> values,
               std::size_t n_columns);
  void integers(const std::string& name, const std::string& meaning, std::span<const int> values);
  void texts(const std::string& name, const std::string& meaning, std::span<const std::string> values);
  /// The file as it is to stand on the disk.
  std::string bytes();

 private:
  void dataset(const std::string& name, const std::string& meaning, std::int64_t type, const void* data,
               std::size_t n_rows, std::size_t n_columns);
  void describe(std::int64_t object, const std::string& name, const std::string& text);
  void check(bool ok, const std::string& name) const;
  Hdf5Session session_;
  std::filesystem::path path_;
  Hdf5Handle file_;
};

/// A file that is read. Every failure is an InputError with the file and the name.
class Hdf5Input {
 public:
  explicit Hdf5Input(std::filesystem::path path);
  std::optional<int> integer_attribute(const std::string& name) const;
  bool has(const std::string& name) const;
  /// Rows of "group/field". @throws InputError where it has not n_columns or claims to hold more than the file can
  std::size_t rows(const std::string& name, std::size_t n_columns) const;
  std::vector<double> numbers(const std::string& name, std::size_t n_columns) const;
  std::vector<int> integers(const std::string& name) const;
  std::vector<std::string> texts(const std::string& name) const;
  const std::filesystem::path& path() const { return path_; }

 private:
  struct Dataset {
    Hdf5Handle id, type;
    std::size_t n_rows = 0;
  };
  Dataset open(const std::string& name, std::size_t n_columns) const;
  [[noreturn]] void refuse(const std::string& name, const std::string& problem, const std::string& value = {},
                           const std::string& allowed = {}) const;
  Hdf5Session session_;
  std::filesystem::path path_;
  std::uintmax_t n_bytes_ = 0;
  Hdf5Handle file_;
};

}  // namespace klang::events::detail
