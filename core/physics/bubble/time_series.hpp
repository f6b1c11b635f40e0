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

/// A bubble's transfer over time and frequency: pressure at the listener for unit vibration amplitude [Pa/m].
/// A fixed source's pressure goes as omega^2, so that what is known at one frequency serves others through P / omega^2.
class TransferSeries {
 public:
  struct Row {
    double time_s;
    double frequency_hz;  ///< 0 in all rows: not known; the values hold at whatever pitch the bubble has then
    std::complex<double> pressure_pa_per_m;
  };
  /// @param rows  one or more, in any order; times need not share their frequencies
  /// @param name  for messages
  /// @throws InputError: a time (with its frequency) twice, a number not finite, a frequency in some rows only
  TransferSeries(std::vector<Row> rows, const std::string& name);

  bool has_frequency() const { return rows_.front().frequency_hz > 0.0; }
  const std::vector<Row>& rows() const { return rows_; }  ///< by time, then frequency
  /// At the momentary frequency of the bubble [Hz].
  /// Of each of the two neighbouring times: P / omega^2 between its two neighbouring frequencies, modulus as a power of the
  /// frequency and phase on the shorter way (sound's way to a far listener turns the phase many times between frequencies);
  /// that of the nearest frequency beyond the ends. Then along a straight line in time; the end values outside.
  std::complex<double> at(double time_s, double frequency_hz) const;

 private:
  std::complex<double> at_time(std::size_t time,
                               double frequency_hz) const;  ///< P / frequency^2, P without frequencies
  std::vector<Row> rows_;
  std::vector<double> times_s_;
  std::vector<std::size_t> first_row_;  ///< of each time, and the end
};

/// CSV with time_s,frequency_hz,re,im, or JSON {"transfer": [{"time_s", "frequency_hz", "re", "im"}, ...]}, by the extension.
/// frequency_hz may be absent; JSON of klang bubble transfer has it among its options.
TransferSeries read_transfer_series(const std::filesystem::path& path);

}  // namespace klang::bubble
