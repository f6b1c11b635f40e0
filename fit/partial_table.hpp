#pragma once
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace klang::fit {

/// One measured partial: amplitude exp(-decay_per_s t) cos(2 pi frequency_hz t + phase_rad), t from the strike.
struct Partial {
  double frequency_hz = 0.0;
  std::optional<double> frequency_std_hz;
  std::optional<double> decay_per_s;
  std::optional<double> decay_std_per_s;
  std::optional<double> amplitude;  ///< full scale = 1
  std::optional<double> amplitude_std;
  std::optional<double> phase_rad;
  std::optional<double> phase_std_rad;
};

struct PartialTable {
  std::vector<Partial> partials;  ///< ascending in frequency
  std::string origin;             ///< the recording or file
};

/// CSV with a header line (frequency_hz required; the other names of Partial optional, an empty cell is "not measured")
/// or JSON as klang analyze writes it (by extension). InputError names file, line, column, value.
PartialTable read_partial_table(const std::filesystem::path& path);
void write_partial_table(const std::filesystem::path& path, const PartialTable& table);  ///< CSV

}  // namespace klang::fit
