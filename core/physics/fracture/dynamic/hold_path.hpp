#pragma once
#include <Eigen/Core>
#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "core/foundation/config/fields.hpp"

namespace klang::fracture {

enum class HoldKind { kPosition, kVelocity, kAcceleration };
constexpr auto words_of(HoldKind) {
  return std::array{Word{HoldKind::kPosition, "position"}, Word{HoldKind::kVelocity, "velocity"},
                    Word{HoldKind::kAcceleration, "acceleration"}};
}

/// How a held place moves: displacement from where it was at the start, velocity or acceleration in the world, linear between rows,
/// constant after the last and, for displacements and velocities, before the first.
class HoldPath {
 public:
  struct Row {
    double time_s = 0.0;
    Eigen::Vector3d value = Eigen::Vector3d::Zero();
  };
  HoldPath() = default;  ///< does not move
  /// @throws InputError for times that do not rise, or no rows
  HoldPath(HoldKind kind, std::vector<Row> rows, const std::string& place = "hold");

  HoldKind kind() const { return kind_; }
  bool is_still() const;  ///< whether what it holds never moves
  /// Acceleration holds: velocity of the place at the start, which is kept.
  void set_start_velocity(const Eigen::Vector3d& velocity_m_s) { start_velocity_ = velocity_m_s; }
  Eigen::Vector3d displacement_m(double time_s) const;
  Eigen::Vector3d velocity_m_s(double time_s) const;  ///< at a kink of displacements: after it
  Eigen::Vector3d acceleration_m_s2(double time_s) const;

 private:
  std::size_t row_before(double time_s) const;
  HoldKind kind_ = HoldKind::kPosition;
  std::vector<Row> rows_;
  std::vector<Eigen::Vector3d> integral_, double_integral_;  ///< at the rows
  Eigen::Vector3d start_velocity_ = Eigen::Vector3d::Zero();
};

/// Columns time_s, x, y, z by their names. @throws InputError with file and line
std::vector<HoldPath::Row> read_hold_rows(const std::filesystem::path& csv);

}  // namespace klang::fracture
