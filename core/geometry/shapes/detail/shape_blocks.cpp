#include "core/geometry/shapes/detail/shape_blocks.hpp"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/check.hpp"
#include "core/foundation/base/conventions.hpp"
#include "core/geometry/shapes/detail/disk_blocks.hpp"

namespace klang::mesh::detail {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

std::vector<Block> tube_blocks(double length_m, double outer_radius_m, double wall_m, const std::array<int, 3>& n) {
  std::vector<Block> blocks;
  const double inner_radius_m = outer_radius_m - wall_m;
  for (const Segment& z : mirrored_segments(n[0], 0.5 * length_m, "z_min", "z_max"))
    blocks.push_back({{n[2], n[1], z.n},
                      [=](double u, double v, double w) -> Vector3d {
                        const double radius_m = (1.0 - u) * inner_radius_m + u * outer_radius_m;
                        const double angle = 2.0 * kPi * v;
                        return {radius_m * std::cos(angle), radius_m * std::sin(angle), z.at(w)};
                      },
                      {"inner", "outer", "", "", z.from_face, z.to_face}});
  return blocks;
}

std::vector<Block> rod_blocks(double length_m, double radius_m, const std::array<int, 3>& n) {
  std::vector<Block> blocks;
  for (const Segment& z : mirrored_segments(n[0], 0.5 * length_m, "z_min", "z_max"))
    for (const DiskPiece& piece : disk_pieces())
      blocks.push_back({{piece.ring ? n[2] : n[1], n[1], z.n},
                        [=, map = piece.map](double u, double v, double w) -> Vector3d {
                          const Vector2d p = radius_m * map(u, v);
                          return {p.x(), p.y(), z.at(w)};
                        },
                        {"", piece.ring ? "outer" : "", "", "", z.from_face, z.to_face}});
  return blocks;
}

std::vector<Block> box_blocks(double length_m, double width_m, double height_m, const std::array<int, 3>& n) {
  std::vector<Block> blocks;
  const std::array<double, 3> grading = box_grading({length_m, width_m, height_m});
  for (const Segment& x : mirrored_segments(n[0], 0.5 * length_m, "x_min", "x_max", grading[0]))
    for (const Segment& y : mirrored_segments(n[1], 0.5 * width_m, "y_min", "y_max", grading[1]))
      for (const Segment& z : mirrored_segments(n[2], 0.5 * height_m, "z_min", "z_max", grading[2]))
        blocks.push_back({{x.n, y.n, z.n},
                          [=](double u, double v, double w) -> Vector3d {
                            return {x.at(u), y.at(v), z.at(w)};
                          },
                          {x.from_face, x.to_face, y.from_face, y.to_face, z.from_face, z.to_face}});
  return blocks;
}

/// Seven bricks an octant: each direction is beside the hollow or beyond its face.
std::vector<Block> shell_box_blocks(double edge_m, double wall_m, const std::array<int, 3>& n) {
  struct Part {
    Segment segment;
    bool beyond;
    std::string inner_face, outer_face;  // of the hollow and of the cube, where this part reaches them
  };
  const auto parts = [&](const std::string& axis) {
    std::vector<Part> result;
    const double inner = 0.5 * edge_m - wall_m;
    for (const double sign : {-1.0, 1.0}) {
      result.push_back({{std::max(1, (n[0] + 1) / 2), 0.0, sign * inner, "", ""}, false, "", ""});
      result.push_back(
          {{n[1], sign * inner, sign * 0.5 * edge_m, "", ""}, true, "inner", axis + (sign < 0.0 ? "_min" : "_max")});
    }
    return result;
  };
  std::vector<Block> blocks;
  for (const Part& x : parts("x"))
    for (const Part& y : parts("y"))
      for (const Part& z : parts("z")) {
        const int n_beyond = x.beyond + y.beyond + z.beyond;
        if (n_beyond == 0) continue;
        const auto inner = [&](const Part& part) { return n_beyond == 1 ? part.inner_face : std::string(); };
        blocks.push_back({{x.segment.n, y.segment.n, z.segment.n},
                          [xs = x.segment, ys = y.segment, zs = z.segment](double u, double v, double w) -> Vector3d {
                            return {xs.at(u), ys.at(v), zs.at(w)};
                          },
                          {inner(x), x.outer_face, inner(y), y.outer_face, inner(z), z.outer_face}});
      }
  return blocks;
}

std::vector<Block> ellipsoid_blocks(const Vector3d& semi_axes_m, const std::array<int, 3>& n) {
  std::vector<Block> blocks;
  for (const BallPiece& piece : ball_pieces())
    blocks.push_back({{piece.shell ? n[1] : n[0], n[0], n[0]},
                      [=, map = piece.map](double u, double v, double w) -> Vector3d {
                        return semi_axes_m.cwiseProduct(map(u, v, w));
                      },
                      {"", piece.shell ? "outer" : "", "", "", "", ""}});
  return blocks;
}

/// A disk bent over spheres of all radii through the wall: disk radius is polar angle over that of the flat
/// rim.
std::vector<Block> bowl_blocks(double outer_radius_m, double wall_m, double depth_m, const std::array<int, 3>& n) {
  std::vector<Block> blocks;
  for (const DiskPiece& piece : disk_pieces())
    blocks.push_back({{piece.ring ? n[1] : n[0], n[0], n[2]},
                      [=, map = piece.map](double u, double v, double w) -> Vector3d {
                        const double radius_m = outer_radius_m - (1.0 - w) * wall_m;
                        const double rim_angle = std::acos((outer_radius_m - depth_m) / radius_m);
                        const Vector2d disk = map(u, v);
                        const double angle = rim_angle * disk.norm();
                        const double sine_ratio = angle > 0.0 ? rim_angle * std::sin(angle) / angle : rim_angle;
                        return {radius_m * sine_ratio * disk.x(), radius_m * sine_ratio * disk.y(),
                                outer_radius_m - radius_m * std::cos(angle)};
                      },
                      {"", piece.ring ? "z_max" : "", "", "", "inner", "outer"}});
  return blocks;
}

}  // namespace

std::array<double, 3> box_grading(const std::array<double, 3>& sides_m) {
  std::array<int, 3> rank{0, 1, 2};
  std::stable_sort(rank.begin(), rank.end(), [&](int a, int b) { return sides_m[a] > sides_m[b]; });
  std::array<double, 3> grading{0.2, 0.2, 0.2};
  if (sides_m[rank[0]] > 4.0 * sides_m[rank[1]]) {
    grading[rank[0]] = 0.0;
    if (sides_m[rank[1]] > 1.5 * sides_m[rank[2]]) grading[rank[1]] = 0.5;
  }
  return grading;
}

BlockLayout shape_blocks(const ShapeSpec& spec, const std::array<int, 3>& counts) {
  std::array<int, 3> n;
  for (int i = 0; i < 3; ++i) n[i] = std::max(1, counts[i]);
  const auto dim = [&](const char* name) { return spec.dims.at(name); };
  BlockLayout layout;
  if (spec.kind == "tube") {
    n[1] = std::max(6, n[1] + n[1] % 2);
    layout.blocks = tube_blocks(dim("length_m"), dim("outer_radius_m"), dim("wall_m"), n);
  } else if (spec.kind == "rod") {
    layout.blocks = rod_blocks(dim("length_m"), dim("radius_m"), n);
  } else if (spec.kind == "box") {
    layout.blocks = box_blocks(dim("length_m"), dim("width_m"), dim("height_m"), n);
  } else if (spec.kind == "shell_box") {
    layout.blocks = shell_box_blocks(dim("edge_m"), dim("wall_m"), n);
  } else if (spec.kind == "sphere") {
    layout.blocks = ellipsoid_blocks(Vector3d::Constant(dim("radius_m")), n);
  } else if (spec.kind == "ellipsoid") {
    layout.blocks = ellipsoid_blocks({dim("a_m"), dim("b_m"), dim("c_m")}, n);
  } else {
    KLANG_CHECK(spec.kind == "bowl", "a kind without blocks");
    layout.blocks = bowl_blocks(dim("outer_radius_m"), dim("wall_m"), dim("depth_m"), n);
  }
  double largest = 0.0;
  for (const auto& [name, value] : spec.dims) largest = std::max(largest, value);
  // Blocks agree to rounding (1e-15 of the size); the thinnest admissible cell is 1e-5 of it over its
  // divisions.
  layout.glue_m = 1e-12 * largest;
  return layout;
}

}  // namespace klang::mesh::detail
