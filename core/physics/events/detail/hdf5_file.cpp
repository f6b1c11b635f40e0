#include "core/physics/events/detail/hdf5_file.hpp"

#include <hdf5.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <utility>

#include "core/foundation/base/errors.hpp"

namespace klang::events::detail {
namespace {

static_assert(std::is_same_v<hid_t, std::int64_t> && std::is_same_v<herr_t, int>);

constexpr std::uintmax_t kMostCompression = 1032;  // of deflate
constexpr const char* kMeaning = "meaning";

std::mutex& library_mutex() {
  static std::mutex mutex;
  return mutex;
}

// A fixed-length UTF-8 text of n bytes, padded with zeros.
Hdf5Handle text_type(std::size_t n) {
  Hdf5Handle type(H5Tcopy(H5T_C_S1), H5Tclose);
  H5Tset_size(type, std::max<std::size_t>(n, 1));
  H5Tset_strpad(type, H5T_STR_NULLPAD);
  H5Tset_cset(type, H5T_CSET_UTF8);
  return type;
}

}  // namespace

Hdf5Session::Hdf5Session() : lock_(library_mutex()) {
  H5Eget_auto2(H5E_DEFAULT, &print_, &print_data_);
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
}
Hdf5Session::~Hdf5Session() { H5Eset_auto2(H5E_DEFAULT, print_, print_data_); }

Hdf5Handle::Hdf5Handle(Hdf5Handle&& other) noexcept : id_(std::exchange(other.id_, -1)), close_(other.close_) {}
Hdf5Handle& Hdf5Handle::operator=(Hdf5Handle&& other) noexcept {
  close();
  id_ = std::exchange(other.id_, -1);
  close_ = other.close_;
  return *this;
}
Hdf5Handle::~Hdf5Handle() { close(); }
bool Hdf5Handle::close() {
  const std::int64_t id = std::exchange(id_, -1);
  return id < 0 || close_(id) >= 0;
}

Hdf5Output::Hdf5Output(std::filesystem::path path) : path_(std::move(path)) {
  constexpr std::size_t kGrowBytes = std::size_t{1} << 20;
  const Hdf5Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  check(H5Pset_fapl_core(access, kGrowBytes, false) >= 0, {});
  file_ = Hdf5Handle(H5Fcreate(path_.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, access), H5Fclose);
  check(file_.ok(), {});
}

void Hdf5Output::check(bool ok, const std::string& name) const {
  if (!ok) throw InputError(path_.string(), "cannot be written", name);
}

void Hdf5Output::attribute(const std::string& name, int value) {
  const Hdf5Handle space(H5Screate(H5S_SCALAR), H5Sclose);
  const Hdf5Handle attribute(H5Acreate2(file_, name.c_str(), H5T_STD_I32LE, space, H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
  check(attribute.ok() && H5Awrite(attribute, H5T_NATIVE_INT, &value) >= 0, name);
}

void Hdf5Output::attribute(const std::string& name, const std::string& value) { describe(file_, name, value); }

void Hdf5Output::describe(std::int64_t object, const std::string& name, const std::string& text) {
  const Hdf5Handle type = text_type(text.size()), space(H5Screate(H5S_SCALAR), H5Sclose);
  const Hdf5Handle attribute(H5Acreate2(object, name.c_str(), type, space, H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
  check(attribute.ok() && H5Awrite(attribute, type, text.c_str()) >= 0, name);
}

void Hdf5Output::group(const std::string& name, const std::string& meaning) {
  const Hdf5Handle group(H5Gcreate2(file_, name.c_str(), H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT), H5Gclose);
  check(group.ok(), name);
  describe(group, kMeaning, meaning);
}

void Hdf5Output::dataset(const std::string& name, const std::string& meaning, std::int64_t type, const void* data,
                         std::size_t n_rows, std::size_t n_columns) {
  const hsize_t size[2] = {n_rows, n_columns};
  const Hdf5Handle space(H5Screate_simple(n_columns == 1 ? 1 : 2, size, nullptr), H5Sclose);
  // Without the time of writing: the same log gives the same bytes.
  const Hdf5Handle create(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
  H5Pset_obj_track_times(create, false);
  const Hdf5Handle set(H5Dcreate2(file_, name.c_str(), type, space, H5P_DEFAULT, create, H5P_DEFAULT), H5Dclose);
  check(set.ok() && (n_rows == 0 || H5Dwrite(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, data) >= 0), name);
  describe(set, kMeaning, meaning);
}

void Hdf5Output::numbers(const std::string& name, const std::string& meaning, std::span<const double> values,
                         std::size_t n_columns) {
  dataset(name, meaning, H5T_IEEE_F64LE, values.data(), values.size() / n_columns, n_columns);
}

void Hdf5Output::integers(const std::string& name, const std::string& meaning, std::span<const int> values) {
  dataset(name, meaning, H5T_STD_I32LE, values.data(), values.size(), 1);
}

void Hdf5Output::texts(const std::string& name, const std::string& meaning, std::span<const std::string> values) {
  std::size_t longest = 1;
  for (const std::string& text : values) longest = std::max(longest, text.size());
  std::vector<char> bytes(values.size() * longest, '\0');
  for (std::size_t i = 0; i < values.size(); ++i) values[i].copy(bytes.data() + i * longest, longest);
  dataset(name, meaning, text_type(longest), bytes.data(), values.size(), 1);
}

std::string Hdf5Output::bytes() {
  check(H5Fflush(file_, H5F_SCOPE_GLOBAL) >= 0, {});
  const ssize_t n = H5Fget_file_image(file_, nullptr, 0);
  check(n > 0, {});
  std::string bytes(static_cast<std::size_t>(n), '\0');
  check(H5Fget_file_image(file_, bytes.data(), bytes.size()) == n, {});
  return bytes;
}

Hdf5Input::Hdf5Input(std::filesystem::path path) : path_(std::move(path)) {
  std::error_code error;
  n_bytes_ = std::filesystem::file_size(path_, error);
  if (error) throw InputError(path_.string(), "cannot be read", error.message());
  if (!std::ifstream(path_)) throw InputError(path_.string(), "cannot be read", std::strerror(errno));
  file_ = Hdf5Handle(H5Fopen(path_.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose);
  if (!file_.ok()) throw InputError(path_.string(), "is no HDF5 file, or is damaged");
}

void Hdf5Input::refuse(const std::string& name, const std::string& problem, const std::string& value,
                       const std::string& allowed) const {
  throw InputError(path_.string() + ": " + name, problem, value, allowed);
}

std::optional<int> Hdf5Input::integer_attribute(const std::string& name) const {
  if (H5Aexists(file_, name.c_str()) <= 0) return std::nullopt;
  const Hdf5Handle attribute(H5Aopen(file_, name.c_str(), H5P_DEFAULT), H5Aclose);
  const Hdf5Handle type(H5Aget_type(attribute), H5Tclose), space(H5Aget_space(attribute), H5Sclose);
  int value = 0;
  if (H5Tget_class(type) != H5T_INTEGER || H5Sget_simple_extent_npoints(space) != 1 ||
      H5Aread(attribute, H5T_NATIVE_INT, &value) < 0) {
    refuse(name, "is no integer");
  }
  return value;
}

bool Hdf5Input::has(const std::string& name) const {
  for (std::size_t end = name.find('/'); end != std::string::npos; end = name.find('/', end + 1)) {
    if (H5Lexists(file_, name.substr(0, end).c_str(), H5P_DEFAULT) <= 0) return false;
  }
  return H5Lexists(file_, name.c_str(), H5P_DEFAULT) > 0;
}

Hdf5Input::Dataset Hdf5Input::open(const std::string& name, std::size_t n_columns) const {
  Dataset set;
  set.id = Hdf5Handle(H5Dopen2(file_, name.c_str(), H5P_DEFAULT), H5Dclose);
  if (!set.id.ok()) refuse(name, "is no dataset, or is damaged");
  set.type = Hdf5Handle(H5Dget_type(set.id), H5Tclose);
  const Hdf5Handle space(H5Dget_space(set.id), H5Sclose);
  const int rank = H5Sget_simple_extent_ndims(space);
  hsize_t size[2] = {0, 1};
  const bool shaped = (rank == 1 || rank == 2) && H5Sget_simple_extent_dims(space, size, nullptr) >= 0;
  if (!shaped || size[1] != n_columns) {
    refuse(name, "has the wrong shape",
           rank == 2 ? std::to_string(size[1]) + " columns" : std::to_string(rank) + " axes",
           n_columns == 1 ? "a list" : "rows of " + std::to_string(n_columns) + " numbers");
  }
  const std::size_t width = std::max<std::size_t>(H5Tget_size(set.type), 1);
  if (size[0] > kMostCompression * n_bytes_ / (width * n_columns))
    refuse(name, "claims to have more rows than the file can hold", std::to_string(size[0]));
  set.n_rows = size[0];
  return set;
}

std::size_t Hdf5Input::rows(const std::string& name, std::size_t n_columns) const {
  return open(name, n_columns).n_rows;
}

std::vector<double> Hdf5Input::numbers(const std::string& name, std::size_t n_columns) const {
  const Dataset set = open(name, n_columns);
  const H5T_class_t kind = H5Tget_class(set.type);
  std::vector<double> values(set.n_rows * n_columns);
  if ((kind != H5T_FLOAT && kind != H5T_INTEGER) ||
      (!values.empty() && H5Dread(set.id, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()) < 0)) {
    refuse(name, "does not hold numbers, or is damaged");
  }
  return values;
}

std::vector<int> Hdf5Input::integers(const std::string& name) const {
  const Dataset set = open(name, 1);
  std::vector<int> values(set.n_rows);
  if (H5Tget_class(set.type) != H5T_INTEGER ||
      (!values.empty() && H5Dread(set.id, H5T_NATIVE_INT, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()) < 0)) {
    refuse(name, "does not hold integers, or is damaged");
  }
  return values;
}

std::vector<std::string> Hdf5Input::texts(const std::string& name) const {
  const Dataset set = open(name, 1);
  if (H5Tget_class(set.type) != H5T_STRING) refuse(name, "does not hold texts");
  std::vector<std::string> values(set.n_rows);
  if (values.empty()) return values;
  if (H5Tis_variable_str(set.type) > 0) {
    std::vector<char*> pointers(set.n_rows, nullptr);
    const bool ok = H5Dread(set.id, set.type, H5S_ALL, H5S_ALL, H5P_DEFAULT, pointers.data()) >= 0;
    for (std::size_t i = 0; ok && i < values.size(); ++i) values[i] = pointers[i] != nullptr ? pointers[i] : "";
    const Hdf5Handle space(H5Dget_space(set.id), H5Sclose);
    if (ok) H5Dvlen_reclaim(set.type, space, H5P_DEFAULT, pointers.data());
    if (!ok) refuse(name, "is damaged");
    return values;
  }
  const std::size_t width = H5Tget_size(set.type);
  std::vector<char> bytes(set.n_rows * width);
  if (H5Dread(set.id, set.type, H5S_ALL, H5S_ALL, H5P_DEFAULT, bytes.data()) < 0) refuse(name, "is damaged");
  const char pad = H5Tget_strpad(set.type) == H5T_STR_SPACEPAD ? ' ' : '\0';
  for (std::size_t i = 0; i < values.size(); ++i) {
    std::string& text = values[i].assign(bytes.data() + i * width, width);
    text.resize(pad == ' ' ? text.find_last_not_of(' ') + 1 : std::min(text.find('\0'), width));
  }
  return values;
}

}  // namespace klang::events::detail
