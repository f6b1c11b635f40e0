#pragma once
#include <cstddef>
#include <deque>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace klang {

/// The lines of a comma-separated file that count: not empty and not beginning with #. A byte order mark, blanks around
/// cells and carriage returns are taken off. What separates cells is told by the first such line: semicolons where it has
/// any, else tabs, else commas. Cells in quotes may hold separators and doubled quotes. Beside semicolons and tabs a
/// number's decimal mark may be a comma (its cell then reads with a point), unless the file has numbers with points, too.
class CsvFile {
 public:
  /// @throws InputError as read_file, and for UTF-16
  explicit CsvFile(const std::filesystem::path& path, std::size_t max_bytes = std::size_t{4} << 30);
  /// The file's bytes in memory. @param name  for messages
  CsvFile(std::string bytes, std::string name);
  CsvFile(const CsvFile&) = delete;  // cells look into the file's bytes
  CsvFile& operator=(const CsvFile&) = delete;
  /// Goes to the next line; false at the end.
  bool next();
  const std::vector<std::string_view>& cells() const { return cells_; }  ///< one or more; valid while the file lives
  std::size_t line_number() const { return line_number_; }               ///< from 1, of all lines
  const std::string& name() const { return name_; }
  std::string place() const { return name_ + ", line " + std::to_string(line_number_); }  ///< for messages

 private:
  std::string name_, bytes_;
  std::size_t at_ = 0, line_number_ = 0;
  std::vector<std::string_view> cells_;
  char separator_ = '\0';  ///< not known yet
  bool decimal_comma_ = false;
  std::deque<std::string> made_cells_;  ///< those that do not stand so in the file

  void find_separator(std::string_view line);
  void split(std::string_view line);
  std::string_view cell_of(std::string_view text);
};

/// A cell as a number ("+1.5e3" too, "nan" and "inf" as what they say); empty when it is none.
std::optional<double> csv_number(std::string_view cell);

/// A cell as a finite number. @throws InputError
double csv_number(std::string_view cell, std::string_view place, std::string_view allowed = {});

}  // namespace klang
