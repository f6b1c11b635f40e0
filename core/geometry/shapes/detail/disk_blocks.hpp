#pragma once
#include <Eigen/Core>
#include <functional>
#include <vector>

namespace klang::mesh::detail {

/// A piece of the unit disk; ring pieces have u running outwards to the circle at u = 1.
struct DiskPiece {
  bool ring = false;
  std::function<Eigen::Vector2d(double u, double v)> map;
};

/// The unit disk as four quarters turned by 90 degrees, each a piece of a square core and two ring pieces:
/// symmetric under quarter turns and mirrors. Core pieces are divided n_core x n_core, ring pieces n_ring x
/// n_core.
std::vector<DiskPiece> disk_pieces();

/// A piece of the unit ball; shell pieces have u running outwards to the sphere at u = 1.
struct BallPiece {
  bool shell = false;
  std::function<Eigen::Vector3d(double u, double v, double w)> map;
};

/// The unit ball as eight mirrored octants, each a piece of a cube core and three shell pieces: the whole
/// symmetry of the cube. Core pieces are divided n_core^3, shell pieces n_shell x n_core x n_core.
std::vector<BallPiece> ball_pieces();

}  // namespace klang::mesh::detail
