#pragma once
#include <Eigen/Core>
#include <filesystem>
#include <string>

namespace klang::apps {

/// Rows of n_columns numbers separated by commas (spaces around them are allowed); empty lines and lines that start with #
/// are left out, and so is a first line that does not start with a number. columns names them for messages ("re,im").
/// @throws InputError naming the line: no number, not finite, another number of columns; or no rows
Eigen::MatrixXd read_number_table(const std::filesystem::path& path, int n_columns, const std::string& columns);

}  // namespace klang::apps
