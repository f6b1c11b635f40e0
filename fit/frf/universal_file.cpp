#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <optional>

#include "core/foundation/base/errors.hpp"
#include "fit/frf/response_set.hpp"

namespace klang::fit {
namespace {

constexpr int kTimeResponse = 1, kFrf = 4;
constexpr std::int64_t kMostValues = 50'000'000;

/// A dataset between its two lines of -1.
struct Dataset {
  int number = 0;
  bool binary = false;
  std::string_view head, body;  ///< of binary ones: the line of the number; what follows it
  std::size_t line = 0;         ///< of the file, where it begins
};

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && std::isspace(static_cast<unsigned char>(text.front()))) text.remove_prefix(1);
  while (!text.empty() && std::isspace(static_cast<unsigned char>(text.back()))) text.remove_suffix(1);
  return text;
}

/// Lines one after the other.
class Lines {
 public:
  explicit Lines(std::string_view text) : rest_(text) {}
  bool done() const { return rest_.empty(); }
  std::string_view rest() const { return rest_; }
  std::string_view next() {
    const std::size_t end = rest_.find('\n');
    std::string_view line = rest_.substr(0, end);
    rest_ = end == std::string_view::npos ? std::string_view() : rest_.substr(end + 1);
    if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
    return line;
  }

 private:
  std::string_view rest_;
};

int whole(std::string_view text, const std::string& place, const char* what) {
  text = trimmed(text);
  if (!text.empty() && text.front() == '+') text.remove_prefix(1);
  int value = 0;
  const auto read = std::from_chars(text.data(), text.data() + text.size(), value);
  if (text.empty() || read.ec != std::errc{} || read.ptr != text.data() + text.size())
    throw InputError(place, std::string(what) + " is no whole number", std::string(text.substr(0, 30)));
  return value;
}

/// Numbers of a text: a sign that follows no exponent letter begins a new one (columns of 13 leave no blank before it).
class Numbers {
 public:
  Numbers(std::string_view text, std::string place) : rest_(text), place_(std::move(place)) {}
  double next() {
    while (!rest_.empty() && std::isspace(static_cast<unsigned char>(rest_.front()))) rest_.remove_prefix(1);
    std::size_t end = 0;
    for (; end < rest_.size() && !std::isspace(static_cast<unsigned char>(rest_[end])); ++end) {
      const char before = end > 0 ? rest_[end - 1] : ' ';
      if (end > 0 && (rest_[end] == '-' || rest_[end] == '+') && std::strchr("eEdD", before) == nullptr) break;
    }
    if (end == 0) throw InputError(place_, "ends before its numbers do");
    std::string token(rest_.substr(0, end));
    rest_.remove_prefix(end);
    for (char& c : token)
      if (c == 'd' || c == 'D') c = 'e';
    const char* begin = token.c_str() + (token.front() == '+' ? 1 : 0);
    double value = 0;
    const auto read = std::from_chars(begin, token.c_str() + token.size(), value);
    if (read.ec != std::errc{} || read.ptr != token.c_str() + token.size())
      throw InputError(place_, "holds what is no number", token.substr(0, 30));
    return value;
  }

 private:
  std::string_view rest_;
  std::string place_;
};

std::vector<Dataset> datasets_of(std::string_view bytes, const std::string& name) {
  std::vector<Dataset> sets;
  Lines lines(bytes);
  while (!lines.done()) {
    if (trimmed(lines.next()) != "-1") continue;
    if (lines.done()) break;
    Dataset set;
    set.head = lines.next();
    std::string_view number = trimmed(set.head.substr(0, 6));
    set.binary = set.head.size() > 6 && (set.head[6] == 'b' || set.head[6] == 'B');
    if (!number.empty() && (number.back() == 'b' || number.back() == 'B')) number.remove_suffix(1), set.binary = true;
    set.number = whole(number, name, "a dataset's number");
    const std::string_view from = lines.rest();
    if (set.binary) {
      Numbers head(set.head.substr(std::min<std::size_t>(7, set.head.size())), name);
      for (int i = 0; i < 2; ++i) (void)head.next();
      const double n_lines = checked(name, "lines of a binary dataset", head.next(), 0, 100);
      const double n_bytes = checked(name, "bytes of a binary dataset", head.next(), 0, 4e9);
      for (int i = 0; i < static_cast<int>(n_lines); ++i) (void)lines.next();
      const std::size_t ahead = from.size() - lines.rest().size(),
                        whole_size = ahead + static_cast<std::size_t>(n_bytes);
      if (whole_size > from.size()) throw InputError(name, "is truncated within a binary dataset");
      set.body = from.substr(0, whole_size);
      lines = Lines(from.substr(whole_size));
      while (!lines.done() && trimmed(lines.next()) != "-1") continue;
    } else {
      std::size_t length = 0;
      bool closed = false;
      while (!lines.done() && !closed) {
        length = from.size() - lines.rest().size();
        closed = trimmed(lines.next()) == "-1";
      }
      if (!closed) throw InputError(name, "is truncated: its last dataset has no end");
      set.body = from.substr(0, length);
    }
    sets.push_back(set);
  }
  if (sets.empty()) throw InputError(name, "is no universal file: it has no dataset between lines of -1");
  return sets;
}

/// The head of a function at nodal degrees of freedom.
struct Function {
  int type = 0;
  ResponsePoint response, reference;
  int ordinate_type = 0;
  Eigen::Index n = 0;
  bool even = true;
  double first = 0, step = 0;
  int abscissa_kind = 0, ordinate_kind = 0, denominator_kind = 0;
  std::string unit, denominator_unit;
};

std::string_view columns(std::string_view line, std::size_t from, std::size_t n) {
  return from < line.size() ? trimmed(line.substr(from, n)) : std::string_view();
}

Function function_head(Lines& lines, const std::string& place) {
  Function f;
  for (int i = 0; i < 5; ++i) (void)lines.next();
  const std::string_view degrees = lines.next(), form = lines.next(), abscissa = lines.next(), ordinate = lines.next(),
                         denominator = lines.next();
  (void)lines.next();
  f.type = whole(columns(degrees, 0, 5), place, "the function type");
  const auto optional = [&](std::string_view text, const char* what) {
    return text.empty() ? 0 : whole(text, place, what);
  };
  f.response = {optional(columns(degrees, 41, 10), "the response node"),
                optional(columns(degrees, 51, 4), "the response direction")};
  f.reference = {optional(columns(degrees, 66, 10), "the reference node"),
                 optional(columns(degrees, 76, 4), "the reference direction")};
  f.ordinate_type = whole(columns(form, 0, 10), place, "the ordinate data type");
  f.n = static_cast<Eigen::Index>(
      checked(place, "lines", static_cast<double>(whole(columns(form, 10, 10), place, "the number of lines")), 1,
              static_cast<double>(kMostValues)));
  f.even = whole(columns(form, 20, 10), place, "the spacing of the abscissa") != 0;
  Numbers spacing(form.substr(std::min<std::size_t>(30, form.size())), place);
  f.first = spacing.next();
  f.step = spacing.next();
  f.abscissa_kind = optional(columns(abscissa, 0, 10), "the abscissa's kind");
  f.ordinate_kind = optional(columns(ordinate, 0, 10), "the ordinate's kind");
  f.denominator_kind = optional(columns(denominator, 0, 10), "the denominator's kind");
  f.unit = std::string(columns(ordinate, 47, 21));
  f.denominator_unit = std::string(columns(denominator, 47, 21));
  return f;
}

/// Values of a binary dataset, as numbers.
template <class T>
double value_at(const char* bytes, bool swap) {
  std::array<char, sizeof(T)> raw;
  std::memcpy(raw.data(), bytes, sizeof(T));
  if (swap) std::reverse(raw.begin(), raw.end());
  return static_cast<double>(std::bit_cast<T>(raw));
}

/// Reads x (where uneven), real and, where complex, imaginary parts by calling next(double precision).
template <class Next>
void fill(const Function& f, Next&& next, Eigen::VectorXd& x, Eigen::RowVectorXcd& y) {
  const bool twice = f.ordinate_type == 4 || f.ordinate_type == 6, complex = f.ordinate_type >= 5;
  x.resize(f.n);
  y.resize(f.n);
  for (Eigen::Index i = 0; i < f.n; ++i) {
    x[i] = f.even ? f.first + f.step * static_cast<double>(i) : next(false);
    const double real = next(twice);
    y[i] = {real, complex ? next(twice) : 0.0};
  }
}

void read_values(const Dataset& set, const Function& f, std::string_view data, const std::string& place,
                 Eigen::VectorXd& x, Eigen::RowVectorXcd& y) {
  if (!set.binary) {
    if (static_cast<std::size_t>(f.n) > data.size()) throw InputError(place, "ends before its numbers do");
    Numbers numbers(data, place);
    return fill(
        f, [&](bool) { return numbers.next(); }, x, y);
  }
  Numbers head(set.head.substr(std::min<std::size_t>(7, set.head.size())), place);
  const double order = head.next(), format = head.next();
  if ((order != 1 && order != 2) || format != 2)
    throw InputError(place, "binary numbers of an unknown form", to_text(order) + ", " + to_text(format),
                     "IEEE, either byte order");
  const bool swap = (order == 2) == (std::endian::native == std::endian::little);
  const std::size_t of_value =
      (f.ordinate_type == 4 || f.ordinate_type == 6 ? 8U : 4U) * (f.ordinate_type >= 5 ? 2U : 1U);
  if (static_cast<std::size_t>(f.n) > data.size() / (of_value + (f.even ? 0U : 4U)))
    throw InputError(place, "ends before its numbers do");
  std::size_t at = 0;
  fill(
      f,
      [&](bool twice) {
        const std::size_t size = twice ? 8 : 4;
        if (at + size > data.size()) throw InputError(place, "ends before its numbers do");
        const double value = twice ? value_at<double>(data.data() + at, swap) : value_at<float>(data.data() + at, swap);
        at += size;
        return value;
      },
      x, y);
}

/// Nodes of dataset 15 (one line each) or 2411 (two).
void read_nodes(const Dataset& set, const std::string& name, std::map<int, Eigen::Vector3d>& nodes) {
  Lines lines(set.body);
  while (!lines.done()) {
    const std::string_view line = lines.next();
    if (trimmed(line).empty()) continue;
    const int label = whole(columns(line, 0, 10), name, "a node's number");
    Numbers place(set.number == 15 ? line.substr(std::min<std::size_t>(40, line.size())) : lines.next(),
                  name + ": node " + std::to_string(label));
    Eigen::Vector3d at;
    for (double& coordinate : at) coordinate = place.next();
    nodes[label] = at;
  }
}

/// What else a function says of itself must be what is read here. @throws InputError
void check_meaning(const Function& f, const std::string& place) {
  const int abscissa = f.type == kFrf ? 18 : 17;
  if (f.abscissa_kind != 0 && f.abscissa_kind != abscissa)
    throw InputError(place, "has an abscissa of another kind", std::to_string(f.abscissa_kind),
                     f.type == kFrf ? "18: frequency" : "17: time");
  if (f.type == kFrf && f.denominator_kind != 0 && f.denominator_kind != 13)
    throw InputError(place, "is no response to a force", "ordinate denominator " + std::to_string(f.denominator_kind),
                     "13: excitation force");
}

int derivative_of_kind(const Function& f, ResponseSet& set) {
  switch (f.ordinate_kind) {
    case 8:
      return 0;
    case 11:
      return 1;
    case 12:
      return 2;
    default:
      break;
  }
  try {
    return derivative_of_unit(f.unit, set.origin);
  } catch (const InputError&) {
    if (f.ordinate_kind > 1 || !(f.unit.empty() || f.unit == "NONE"))
      throw InputError(set.origin, "a response of an unknown quantity",
                       "ordinate kind " + std::to_string(f.ordinate_kind) + ", unit " + f.unit,
                       "displacement (8, m), velocity (11, m/s), acceleration (12, m/s^2)");
    const std::string words = "the file does not say what was measured: taken for acceleration";
    if (std::find(set.warnings.begin(), set.warnings.end(), words) == set.warnings.end()) set.warnings.push_back(words);
    return 2;
  }
}

/// As MATLAB files have it: of an FRF the response's unit over the force's ("m/s^2/N").
std::string unit_of(const Function& f, int derivative) {
  const auto is_said = [](const std::string& unit) { return !unit.empty() && unit != "NONE"; };
  std::string unit = f.unit;
  if (!is_said(unit)) unit = derivative == 2 ? "m/s^2" : derivative == 1 ? "m/s" : "m";
  if (f.type != kFrf || unit.ends_with("/N") || unit == "1/kg") return unit;
  return unit + "/" + (is_said(f.denominator_unit) ? f.denominator_unit : "N");
}

}  // namespace

ResponseSet read_universal_bytes(std::string_view bytes, const std::string& name) {
  ResponseSet set;
  set.origin = name;
  double metres = 1.0;
  std::vector<Eigen::RowVectorXcd> rows;
  std::vector<Function> functions;
  int n_others = 0;
  for (const Dataset& dataset : datasets_of(bytes, name)) {
    if (dataset.number == 15 || dataset.number == 2411) read_nodes(dataset, name, set.nodes_m);
    if (dataset.number == 164) {
      Lines lines(dataset.body);
      (void)lines.next();
      metres = 1.0 / checked(name, "length factor of dataset 164", Numbers(lines.next(), name).next(), 1e-9, 1e9);
    }
    if (dataset.number != 58) continue;
    const std::string place = name + ": function " + std::to_string(functions.size() + 1);
    Lines lines(dataset.body);
    const Function f = function_head(lines, place);
    if (f.type != kTimeResponse && f.type != kFrf) {
      ++n_others;
      continue;
    }
    if (f.ordinate_type != 2 && f.ordinate_type != 4 && f.ordinate_type != 5 && f.ordinate_type != 6)
      throw InputError(place, "unknown ordinate data type", std::to_string(f.ordinate_type), "2, 4, 5 or 6");
    check_meaning(f, place);
    Eigen::VectorXd x;
    Eigen::RowVectorXcd y;
    read_values(dataset, f, lines.rest(), place, x, y);
    if (functions.empty()) {
      set.in_time = f.type == kTimeResponse;
      set.abscissa = x;
      set.derivative = derivative_of_kind(f, set);
      set.unit = unit_of(f, set.derivative);
    } else {
      if (set.in_time != (f.type == kTimeResponse)) throw InputError(place, "FRFs and time responses in one file");
      if (x.size() != set.abscissa.size() || !x.isApprox(set.abscissa, 1e-6))
        throw InputError(place, "has other lines than the first");
      if (set.derivative != derivative_of_kind(f, set))
        throw InputError(place, "is of another quantity than the first");
    }
    functions.push_back(f);
    rows.push_back(std::move(y));
  }
  if (functions.empty())
    throw InputError(name,
                     "holds no frequency response (function type 4) and no time response (type 1) in a dataset 58");
  if (n_others > 0)
    set.warnings.push_back(std::to_string(n_others) +
                           " functions of other kinds (spectra, coherences ...) are left out");
  for (auto& [label, at] : set.nodes_m) at *= metres;
  set.values.resize(static_cast<Eigen::Index>(rows.size()), set.abscissa.size());
  // A hammer that roves over the body while one accelerometer stays tells the same (reciprocity): the places are its.
  const bool roving =
      functions.size() > 1 && std::all_of(functions.begin(), functions.end(), [&](const Function& f) {
        return f.response.node == functions[0].response.node && f.response.direction == functions[0].response.direction;
      });
  for (const Function& f : functions) {
    const bool same =
        f.reference.node == functions[0].reference.node && f.reference.direction == functions[0].reference.direction;
    if (!roving && !set.in_time && !same)
      throw InputError(name, "has responses to forces at several places",
                       std::to_string(functions[0].reference.node) + " and " + std::to_string(f.reference.node),
                       "one place of the force, or one response and a roving force");
  }
  for (std::size_t i = 0; i < rows.size(); ++i) {
    set.values.row(static_cast<Eigen::Index>(i)) = rows[i];
    set.points.push_back(roving ? functions[i].reference : functions[i].response);
  }
  validate(set);
  return set;
}

}  // namespace klang::fit
