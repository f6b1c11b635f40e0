#include "core/geometry/shapes/detail/disk_blocks.hpp"

#include <cmath>

#include "core/foundation/base/conventions.hpp"

namespace klang::mesh::detail {
namespace {

// Corners of a quarter of the core: on an axis, on the diagonal (of a face), on the space diagonal. Chosen
// between the straight square and the circle so that neither core nor ring cells get angles near 180 degrees.
constexpr double kDiskAxis = 0.50, kDiskDiagonal = 0.40;
constexpr double kBallAxis = 0.50, kBallDiagonal = 0.41, kBallSpace = 0.35;

Eigen::Vector2d quarter_core(double u, double v) {
  return {kDiskAxis * u * (1.0 - v) + kDiskDiagonal * u * v, kDiskAxis * v * (1.0 - u) + kDiskDiagonal * u * v};
}

Eigen::Vector2d quarter_ring(double u, double v) {
  const double angle = 0.25 * kPi * v;
  return (1.0 - u) * quarter_core(1.0, v) + u * Eigen::Vector2d(std::cos(angle), std::sin(angle));
}

Eigen::Vector3d octant_core(double u, double v, double w) {
  // Trilinear in the seven corners; written so that exchanging two parameters exchanges two coordinates
  // exactly.
  const auto coordinate = [](double own, double a, double b) {
    return own *
           (kBallAxis * (1.0 - a) * (1.0 - b) + kBallDiagonal * (a * (1.0 - b) + b * (1.0 - a)) + kBallSpace * a * b);
  };
  return {coordinate(u, v, w), coordinate(v, u, w), coordinate(w, u, v)};
}

Eigen::Vector3d octant_shell(double u, double v, double w) {
  const Eigen::Vector3d outside(1.0, std::tan(0.25 * kPi * v), std::tan(0.25 * kPi * w));
  return (1.0 - u) * octant_core(1.0, v, w) + (u / outside.norm()) * outside;
}

}  // namespace

std::vector<DiskPiece> disk_pieces() {
  std::vector<DiskPiece> pieces;
  for (int quarter = 0; quarter < 4; ++quarter) {
    const auto turned = [quarter](Eigen::Vector2d p) {
      for (int i = 0; i < quarter; ++i) p = Eigen::Vector2d(-p.y(), p.x());
      return p;
    };
    pieces.push_back({false, [turned](double u, double v) { return turned(quarter_core(u, v)); }});
    pieces.push_back({true, [turned](double u, double v) { return turned(quarter_ring(u, v)); }});
    pieces.push_back({true, [turned](double u, double v) {
                        const Eigen::Vector2d p = quarter_ring(u, v);
                        return turned(Eigen::Vector2d(p.y(), p.x()));
                      }});
  }
  return pieces;
}

std::vector<BallPiece> ball_pieces() {
  std::vector<BallPiece> pieces;
  for (int octant = 0; octant < 8; ++octant) {
    const Eigen::Vector3d sign(octant & 1 ? -1.0 : 1.0, octant & 2 ? -1.0 : 1.0, octant & 4 ? -1.0 : 1.0);
    pieces.push_back({false, [sign](double u, double v, double w) -> Eigen::Vector3d {
                        return sign.cwiseProduct(octant_core(u, v, w));
                      }});
    for (int axis = 0; axis < 3; ++axis)
      pieces.push_back({true, [sign, axis](double u, double v, double w) -> Eigen::Vector3d {
                          const Eigen::Vector3d p = octant_shell(u, v, w);
                          const Eigen::Vector3d turned = axis == 0   ? p
                                                         : axis == 1 ? Eigen::Vector3d(p[1], p[0], p[2])
                                                                     : Eigen::Vector3d(p[1], p[2], p[0]);
                          return sign.cwiseProduct(turned);
                        }});
  }
  return pieces;
}

}  // namespace klang::mesh::detail
