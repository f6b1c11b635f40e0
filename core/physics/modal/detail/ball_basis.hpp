#pragma once
#include <Eigen/Core>
#include <array>
#include <vector>

namespace klang::modal::detail {

/// Parity of a function under the three reflections: bit d is set where it is odd in axis d (x, y, z).
using Parity = int;
inline constexpr int kParities = 8;

/// Polynomials of total degree <= degree, orthonormal on the unit ball, split by parity. Made once per degree and shared.
class BallBasis {
 public:
  /// @param degree  3 to 24
  explicit BallBasis(int degree);
  int degree() const { return degree_; }
  Eigen::Index size(Parity parity) const { return static_cast<Eigen::Index>(degrees_[parity].size()); }

  /// The matrix of d/d xi_axis from the functions of a parity to those of parity ^ (1 << axis): exact.
  const Eigen::MatrixXd& slope(Parity parity, int axis) const { return slope_[parity][axis]; }

  /// All functions of a parity at points (3 x n_points, |xi| <= 1 or somewhat more): n_points x size(parity).
  Eigen::MatrixXd values(Parity parity, const Eigen::Matrix3Xd& points) const;

 private:
  int degree_;
  std::array<std::vector<std::array<int, 3>>, kParities> degrees_;  // of the Legendre polynomials in x, y, z
  std::array<Eigen::MatrixXd, kParities> to_orthonormal_;
  std::array<std::array<Eigen::MatrixXd, 3>, kParities> slope_;
};

/// The basis of a degree, made at the first call; any thread.
const BallBasis& ball_basis(int degree);

}  // namespace klang::modal::detail
