#include "core/physics/events/event_log_file.hpp"

#include <algorithm>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/output_file.hpp"
#include "core/physics/events/detail/hdf5_file.hpp"

namespace klang::events {
namespace {

constexpr int kSchemaVersion = 1;
constexpr const char* kFormat = "klangprobe event log";

// One field of all rows of a table.
struct Column {
  std::string name, meaning;
  std::vector<double> numbers;
  std::vector<int> integers;
  std::vector<std::string> texts;
  std::size_t n_columns = 1;  // of numbers
  enum class Kind { kNumbers, kIntegers, kTexts } kind = Kind::kNumbers;
};

template <class T>
constexpr Column::Kind kind_of() {
  if constexpr (std::same_as<T, int>)
    return Column::Kind::kIntegers;
  else if constexpr (Worded<T> || std::same_as<T, std::string>)
    return Column::Kind::kTexts;
  else
    return Column::Kind::kNumbers;
}

template <class T>
constexpr std::size_t columns_of() {
  if constexpr (requires { T::SizeAtCompileTime; })
    return static_cast<std::size_t>(T::SizeAtCompileTime);
  else
    return 1;
}

// Appends the fields of a row to the columns.
class RowWriter {
 public:
  explicit RowWriter(std::vector<Column>& columns) : columns_(columns) {}
  template <class T>
  void operator()(const Field&, const T& value) {
    Column& column = columns_[next_++];
    if constexpr (kind_of<T>() == Column::Kind::kIntegers)
      column.integers.push_back(value);
    else if constexpr (Worded<T>)
      column.texts.push_back(to_text(value));
    else if constexpr (std::same_as<T, std::string>)
      column.texts.push_back(value);
    else if constexpr (std::same_as<T, double>)
      column.numbers.push_back(value);
    else
      column.numbers.insert(column.numbers.end(), value.data(), value.data() + value.size());
  }

 private:
  std::vector<Column>& columns_;
  std::size_t next_ = 0;
};

template <class Row>
void write_table(detail::Hdf5Output& file, const std::string& table, const std::string& meaning,
                 const std::vector<Row>& rows) {
  std::vector<Column> columns;
  const Row empty{};
  Row::describe(empty, [&]<class T>(const Field& field, const T&) {
    Column& column = columns.emplace_back();
    column.name = table + "/" + std::string(field.name);
    column.meaning = field.meaning;
    column.kind = kind_of<T>();
    column.n_columns = columns_of<T>();
  });
  for (const Row& row : rows) Row::describe(row, RowWriter(columns));
  file.group(table, meaning);
  for (const Column& column : columns) {
    switch (column.kind) {
      case Column::Kind::kNumbers:
        file.numbers(column.name, column.meaning, column.numbers, column.n_columns);
        break;
      case Column::Kind::kIntegers:
        file.integers(column.name, column.meaning, column.integers);
        break;
      case Column::Kind::kTexts:
        file.texts(column.name, column.meaning, column.texts);
        break;
    }
  }
}

// Reads one field of all rows of a table.
template <class Row>
class ColumnReader {
 public:
  ColumnReader(const detail::Hdf5Input& file, std::string table) : file_(file), table_(std::move(table)) {}

  std::vector<Row> rows() {
    if (!file_.has(table_)) return {};
    Row empty{};
    Row::describe(empty, [&]<class T>(const Field& field, T&) { count(field, columns_of<T>()); });
    std::vector<Row> rows(n_rows_.value_or(0));
    std::size_t number = 0;
    Row::describe(empty, [&]<class T>(const Field& field, T&) { read<T>(field, number++, rows); });
    return rows;
  }

 private:
  std::string name_of(const Field& field) const { return table_ + "/" + std::string(field.name); }

  void count(const Field& field, std::size_t n_columns) {
    const std::string name = name_of(field);
    if (!file_.has(name)) {
      if (field.required) throw InputError(file_.path().string(), "lacks a dataset", name);
      return;
    }
    const std::size_t n = file_.rows(name, n_columns);
    if (n_rows_.value_or(n) != n) {
      throw InputError(file_.path().string() + ": " + name, "has another number of rows than the datasets beside it",
                       std::to_string(n), std::to_string(*n_rows_));
    }
    n_rows_ = n;
  }

  template <class T>
  void read(const Field& field, std::size_t number, std::vector<Row>& rows) {
    const std::string name = name_of(field);
    if (!file_.has(name)) return;
    if constexpr (kind_of<T>() == Column::Kind::kIntegers) {
      const std::vector<int> values = file_.integers(name);
      fill<T>(number, rows, [&](std::size_t i, T& value) { value = values[i]; });
    } else if constexpr (kind_of<T>() == Column::Kind::kTexts) {
      const std::vector<std::string> values = file_.texts(name);
      fill<T>(number, rows, [&](std::size_t i, T& value) {
        if constexpr (Worded<T>) {
          const std::optional<T> word = enum_from_text<T>(values[i]);
          if (!word) {
            throw InputError(file_.path().string() + ": " + name + "[" + std::to_string(i) + "]", "is unknown",
                             values[i], allowed_words<T>());
          }
          value = *word;
        } else {
          value = values[i];
        }
      });
    } else {
      constexpr std::size_t n = columns_of<T>();
      const std::vector<double> values = file_.numbers(name, n);
      fill<T>(number, rows, [&](std::size_t i, T& value) {
        if constexpr (n == 1)
          value = values[i];
        else
          value = Eigen::Map<const T>(values.data() + n * i);
      });
    }
  }

  // set(i, member) for the field of that number in each row.
  template <class T, class Set>
  static void fill(std::size_t number, std::vector<Row>& rows, const Set& set) {
    for (std::size_t i = 0; i < rows.size(); ++i) {
      std::size_t at = 0;
      Row::describe(rows[i], [&]<class Member>(const Field&, Member& member) {
        if constexpr (std::same_as<Member, T>) {
          if (at == number) set(i, member);
        }
        ++at;
      });
    }
  }

  const detail::Hdf5Input& file_;
  std::string table_;
  std::optional<std::size_t> n_rows_;
};

void add_bodies(EventLog& log) {
  int n = 0;
  const auto count = [&](int body) { n = std::max(n, body < 1000000 ? body + 1 : 0); };
  for (const Impulse& impulse : log.impulses) {
    count(impulse.body);
    count(impulse.other);
  }
  for (const Pose& pose : log.poses) count(pose.body);
  for (int i = 0; i < n; ++i) log.bodies.push_back({"body " + std::to_string(i), -1});
}

}  // namespace

void write_event_log(const std::filesystem::path& path, const EventLog& log) {
  log.validate();
  detail::Hdf5Output file(path);
  file.attribute("format", std::string(kFormat));
  file.attribute("schema_version", kSchemaVersion);
  EventLog::describe_tables(
      log, [&](const char* table, const char* meaning, const auto& rows) { write_table(file, table, meaning, rows); });
  write_file(path, file.bytes());
}

EventLog read_event_log(const std::filesystem::path& path) {
  EventLog log;
  {
    const detail::Hdf5Input file(path);
    const std::optional<int> version = file.integer_attribute("schema_version");
    if (!version) throw InputError(path.string(), "is no event log: it lacks the attribute schema_version");
    if (*version != kSchemaVersion) {
      throw InputError(path.string(), "has another schema_version", std::to_string(*version),
                       std::to_string(kSchemaVersion));
    }
    bool any = false;
    EventLog::describe_tables(log, [&](const char* table, const char*, auto& rows) {
      using Row = typename std::decay_t<decltype(rows)>::value_type;
      any = any || file.has(table);
      rows = ColumnReader<Row>(file, table).rows();
    });
    if (!any) throw InputError(path.string(), "is no event log: it has none of its tables");
    if (!file.has("bodies")) add_bodies(log);
  }
  try {
    log.validate();
  } catch (const InputError& error) {
    throw InputError(path.string(), error.what());
  }
  return log;
}

}  // namespace klang::events
