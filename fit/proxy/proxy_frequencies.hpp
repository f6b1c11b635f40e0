#pragma once
#include <array>
#include <vector>

#include "core/sound/soundbank/soundbank.hpp"

namespace klang::fit {

/// A bank's interpolated frequencies for searches: logarithms taken once, microseconds per shape.
class ProxyFrequencies {
 public:
  /// @param count  of the lowest frequencies that will be asked for; the bank must outlive it
  ProxyFrequencies(const soundbank::Soundbank& bank, int count);

  struct Line {
    double ln_frequency = 0.0;  ///< ln(omega |axes| / c_s)
    soundbank::ModeId id;       ///< class, and rank within it
    Eigen::Index row = 0;       ///< of the table
  };
  /// The lowest, ascending: the same values as soundbank::proxy_frequencies_hz. Fewer than count where a class might hide one.
  void lowest(const soundbank::ShapePlace& place, std::vector<Line>& lines) const;
  /// Their derivatives with respect to u and v (lines as lowest gives them).
  void slopes(const soundbank::ShapePlace& place, const std::vector<Line>& lines,
              std::vector<std::array<double, 2>>& slopes) const;

  const soundbank::Soundbank& bank() const { return bank_; }

 private:
  const soundbank::Soundbank& bank_;
  std::size_t count_;
  std::array<Eigen::Index, soundbank::kModeClasses> begin_{}, size_{};
  std::array<bool, soundbank::kModeClasses> may_hide_{};  ///< modes below the count that the bank has not
  Eigen::MatrixXd ln_frequency_;                          ///< by class and index x nodes
};

}  // namespace klang::fit
