#include "fit/frf/detail/mat_file.hpp"

#include <matio.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "core/foundation/base/child.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/output_file.hpp"
#include "core/foundation/base/packed.hpp"

namespace klang::fit::detail {
namespace {

constexpr double kMostNumbers = 5e7;

struct CloseFile {
  void operator()(mat_t* file) const { Mat_Close(file); }
};
struct FreeVariable {
  void operator()(matvar_t* variable) const { Mat_VarFree(variable); }
};
using File = std::unique_ptr<mat_t, CloseFile>;
using Variable = std::unique_ptr<matvar_t, FreeVariable>;

template <class T>
Eigen::MatrixXd copied(const void* data, Eigen::Index rows, Eigen::Index columns) {
  using Values = Eigen::Matrix<T, Eigen::Dynamic, Eigen::Dynamic>;
  return Eigen::Map<const Values>(static_cast<const T*>(data), rows, columns).template cast<double>();
}

Eigen::MatrixXd numbers(const void* data, matio_types type, Eigen::Index rows, Eigen::Index columns,
                        const std::string& place) {
  switch (type) {
    case MAT_T_DOUBLE:
      return copied<double>(data, rows, columns);
    case MAT_T_SINGLE:
      return copied<float>(data, rows, columns);
    case MAT_T_INT8:
      return copied<std::int8_t>(data, rows, columns);
    case MAT_T_UINT8:
      return copied<std::uint8_t>(data, rows, columns);
    case MAT_T_INT16:
      return copied<std::int16_t>(data, rows, columns);
    case MAT_T_UINT16:
      return copied<std::uint16_t>(data, rows, columns);
    case MAT_T_INT32:
      return copied<std::int32_t>(data, rows, columns);
    case MAT_T_UINT32:
      return copied<std::uint32_t>(data, rows, columns);
    case MAT_T_INT64:
      return copied<std::int64_t>(data, rows, columns);
    case MAT_T_UINT64:
      return copied<std::uint64_t>(data, rows, columns);
    default:
      throw InputError(place, "holds no plain numbers");
  }
}

/// Variables of one file.
class Reader {
 public:
  explicit Reader(const std::filesystem::path& path) : place_(path.string()) {
    (void)read_file(path);  // says what is wrong with a path
    Mat_LogInit(nullptr);
    Mat_LogInitFunc("klang", [](int, char*) {});
    file_.reset(Mat_Open(path.c_str(), MAT_ACC_RDONLY));
    if (!file_) throw InputError(place_, "is no MATLAB file");
  }
  /// Its size is looked at before its numbers are read: a small file can claim any.
  Variable find(const char* name) {
    const Variable info(Mat_VarReadInfo(file_.get(), name));
    if (!info) return nullptr;
    double n = 1.0;
    for (int d = 0; d < info->rank; ++d) n *= static_cast<double>(info->dims[d]);
    if (!(n <= kMostNumbers)) throw InputError(place_ + ": " + name, "is too large", to_text(n), "up to 5e7 numbers");
    return Variable(Mat_VarRead(file_.get(), name));
  }

  /// Empty where there is none.
  Eigen::MatrixXcd matrix(const char* name) {
    const Variable variable = find(name);
    if (!variable) return {};
    const std::string place = place_ + ": " + name;
    if (variable->rank != 2 || !variable->data || variable->class_type < MAT_C_DOUBLE ||
        variable->class_type > MAT_C_UINT64)
      throw InputError(place, "is no matrix of numbers");
    const auto rows = static_cast<Eigen::Index>(variable->dims[0]),
               columns = static_cast<Eigen::Index>(variable->dims[1]);
    Eigen::MatrixXcd result(rows, columns);
    if (variable->isComplex) {
      const auto* split = static_cast<const mat_complex_split_t*>(variable->data);
      result.real() = numbers(split->Re, variable->data_type, rows, columns, place);
      result.imag() = numbers(split->Im, variable->data_type, rows, columns, place);
    } else {
      result.real() = numbers(variable->data, variable->data_type, rows, columns, place);
      result.imag().setZero();
    }
    return result;
  }
  Eigen::VectorXd vector(const char* name) {
    const Eigen::MatrixXcd values = matrix(name);
    if (values.size() > 0 && values.rows() != 1 && values.cols() != 1)
      throw InputError(place_ + ": " + name, "is no vector");
    if (!values.imag().isZero(0.0)) throw InputError(place_ + ": " + name, "is complex");
    return values.real().reshaped();
  }
  std::string text(const char* name) {
    const Variable variable = find(name);
    if (!variable) return {};
    if (variable->class_type != MAT_C_CHAR || !variable->data) throw InputError(place_ + ": " + name, "is no text");
    std::string result;
    const std::size_t n = variable->nbytes / std::max(1, variable->data_size);
    for (std::size_t i = 0; i < n; ++i)
      result += variable->data_size == 2 ? static_cast<char>(static_cast<const std::uint16_t*>(variable->data)[i])
                                         : static_cast<const char*>(variable->data)[i];
    return result;
  }
  const std::string& place() const { return place_; }

 private:
  std::string place_;
  File file_;
};

void read_places(Reader& reader, ResponseSet& set) {
  const Eigen::VectorXd node = reader.vector("node"), direction = reader.vector("direction");
  const Eigen::MatrixXd points = reader.matrix("points_m").real();
  const Eigen::Index n = set.n_responses();
  const auto fits = [&](Eigen::Index length, const char* name) {
    if (length != 0 && length != n)
      throw InputError(reader.place() + ": " + name, "has not one entry per response", std::to_string(length),
                       std::to_string(n));
  };
  fits(node.size(), "node");
  fits(direction.size(), "direction");
  fits(points.rows(), "points_m");
  if (points.size() > 0 && points.cols() != 3) throw InputError(reader.place() + ": points_m", "has not three columns");
  const auto whole = [&](const char* name, double value, double low, double high) {
    if (checked(reader.place(), name, value, low, high) != std::floor(value))
      throw InputError(reader.place() + ": " + name, "is no whole number", to_text(value));
    return static_cast<int>(value);
  };
  for (Eigen::Index i = 0; i < n; ++i) {
    ResponsePoint point;
    point.node = node.size() > 0 ? whole("node", node[i], 0, 2e9) : static_cast<int>(i) + 1;
    if (direction.size() > 0) point.direction = whole("direction", direction[i], -3, 3);
    set.points.push_back(point);
    if (points.size() == 0) continue;
    const auto [known, is_new] = set.nodes_m.emplace(point.node, points.row(i).transpose());
    if (!is_new && known->second != points.row(i).transpose())
      throw InputError(reader.place() + ": points_m", "places one node at two points", std::to_string(point.node));
  }
}

ResponseSet read_here(const std::filesystem::path& path) {
  Reader reader(path);
  ResponseSet set;
  set.origin = path.string();
  set.abscissa = reader.vector("frequency_hz");
  set.values = reader.matrix("frf");
  if (set.abscissa.size() == 0 && set.values.size() == 0) {
    set.in_time = true;
    set.abscissa = reader.vector("time_s");
    set.values = reader.matrix("response");
  }
  if (set.abscissa.size() == 0 || set.values.size() == 0)
    throw InputError(set.origin,
                     "needs the variables frequency_hz and frf (responses x lines), or time_s and response");
  if (set.values.cols() != set.abscissa.size() && set.values.rows() == set.abscissa.size())
    throw InputError(set.origin, set.in_time ? "response stands on its side" : "frf stands on its side",
                     std::to_string(set.values.rows()) + " x " + std::to_string(set.values.cols()),
                     "responses x lines");
  set.unit = reader.text("unit");
  if (set.unit.empty()) throw InputError(set.origin, "needs the variable unit", "", "m/s^2/N, m/s/N or m/N");
  set.derivative = derivative_of_unit(set.unit, set.origin + ": unit");
  read_places(reader, set);
  validate(set);
  return set;
}

std::string packed(const ResponseSet& set) {
  Packer to;
  to.add(set.in_time).add(set.derivative).add_list(set.unit).add_list(set.abscissa).add_list(set.points);
  to.add(set.values.rows()).add_list(Eigen::VectorXcd(set.values.reshaped())).add(set.nodes_m.size());
  for (const auto& [node, at_m] : set.nodes_m) to.add(node).add_list(at_m);
  return to.take();
}

ResponseSet unpacked(std::string_view bytes) {
  Unpacker from(bytes);
  ResponseSet set;
  set.in_time = from.take<bool>();
  set.derivative = from.take<int>();
  set.unit = from.take_list<std::string>();
  set.abscissa = from.take_list<Eigen::VectorXd>();
  set.points = from.take_list<std::vector<ResponsePoint>>();
  const auto rows = from.take<Eigen::Index>();
  const auto values = from.take_list<Eigen::VectorXcd>();
  set.values = values.reshaped(rows, values.size() / std::max<Eigen::Index>(rows, 1));
  for (auto n = from.take<std::size_t>(); n > 0; --n) {
    const int node = from.take<int>();
    set.nodes_m[node] = from.take_list<Eigen::Vector3d>();
  }
  return set;
}

}  // namespace

ResponseSet read_mat_responses(const std::filesystem::path& path) {
  // In a child: the library takes memory as a file claims it, before it can be asked how much.
  const ChildResult child = run_in_child([&] { return packed(read_here(path)); });
  if (child.signal != 0) throw InputError(path.string(), "is damaged: MATLAB's library ends at it");
  if (!child.done) throw InputError(child.bytes);
  ResponseSet set = unpacked(child.bytes);
  set.origin = path.string();
  return set;
}

}  // namespace klang::fit::detail
