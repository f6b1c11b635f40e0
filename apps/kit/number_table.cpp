#include "apps/kit/number_table.hpp"

#include <vector>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/config/csv.hpp"

namespace klang::apps {

Eigen::MatrixXd read_number_table(const std::filesystem::path& path, int n_columns, const std::string& columns) {
  CsvFile file(path);
  std::vector<double> values;
  for (bool first = true; file.next(); first = false) {
    const auto& cells = file.cells();
    if (first && !csv_number(cells.front())) continue;  // a header
    if (static_cast<int>(cells.size()) != n_columns)
      throw InputError(file.place(), "has the wrong number of columns", std::to_string(cells.size()), columns);
    for (const auto& cell : cells) values.push_back(csv_number(cell, file.place(), columns));
  }
  if (values.empty()) throw InputError(path.string(), "has no rows", "", columns);
  return Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>(
      values.data(), static_cast<Eigen::Index>(values.size()) / n_columns, n_columns);
}

}  // namespace klang::apps
