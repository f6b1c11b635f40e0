#pragma once
#include <Eigen/Core>
#include <functional>
#include <string>
#include <vector>

#include "core/sound/dual_domain/liquid_boundary.hpp"

namespace klang::bubble {

/// A boundary put together of parallelograms, each cut into cells of two triangles whose diagonals alternate. Vertices along the
/// edges of patches are repeated: LiquidBoundary joins what belongs together.
class BoundaryPatches {
 public:
  /// corner + s u + t v, 0 <= s, t <= 1, outward normal along u x v.
  struct Patch {
    Eigen::Vector3d corner_m, u_m, v_m;
    int region = 0;  ///< of BoundaryMesh
  };
  /// @param h_m    edge length > 0; each side is cut into as many equal ones as come nearest to it, one at least
  /// @param moved  where a point of a patch comes to lie; empty: where it is
  void add(const Patch& patch, double h_m,
           const std::function<Eigen::Vector3d(const Eigen::Vector3d& x_m)>& moved = {});
  /// The six faces of the box from low_m on, its top free (region 0), the rest rigid (region 1).
  void add_tank(const Eigen::Vector3d& low_m, const Eigen::Vector3d& size_m, double h_m,
                const std::function<Eigen::Vector3d(const Eigen::Vector3d& x_m)>& moved = {});
  BoundaryMesh mesh(const std::string& name) const;

 private:
  std::vector<Eigen::Vector3d> vertices_;
  std::vector<Eigen::Vector3i> triangles_;
  std::vector<int> region_;
};

}  // namespace klang::bubble
