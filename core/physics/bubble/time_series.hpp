#pragma once
#include <complex>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace klang::bubble {

/// Columns of a CSV file over its column time_s.
struct TimeSeries {
  std::vector<double> times_s;               ///< ascending
  std::vector<std::vector<double>> columns;  ///< in the order asked for; empty where an optional one is absent
};

/// Reads a CSV whose first line names its columns. Lines that are empty or begin with # do not count.
/// @param needed, optional  names beside time_s; every other column is an error
/// @param even  a step longer than 1.5 times the middle one is an error: frames are missing
/// @throws InputError with file and line
TimeSeries read_time_series(const std::filesystem::path& path, std::span<const std::string_view> needed,
                            std::span<const std::string_view> optional, bool even);

/// A bubble's transfer over time: pressure at the listener for unit vibration amplitude [Pa/m].
struct TransferSeries {
  std::vector<double> times_s;
  std::vector<std::complex<double>> pressure_pa_per_m;
  /// Straight lines between, the end values outside.
  std::complex<double> at(double time_s) const;
};

/// CSV with time_s,re,im, or JSON {"transfer": [{"time_s", "re", "im"}, ...]}, by the extension.
TransferSeries read_transfer_series(const std::filesystem::path& path);

}  // namespace klang::bubble
