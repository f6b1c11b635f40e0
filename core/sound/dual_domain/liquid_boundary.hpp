#pragma once
#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "core/foundation/config/fields.hpp"
#include "core/geometry/mesh/tet_mesh.hpp"

namespace klang::bubble {

/// What a face of the boundary is. The first three bound the liquid with normals out of it; the air has free surface, walls
/// (thin: it sees their outside) and dry solid for its boundary.
enum class BoundaryRegion : int {
  kFreeSurface = 0,  ///< liquid against air: P = 0 seen from the liquid
  kRigidWall = 1,    ///< vessel: dP/dn = 0 on both sides
  kWetSolid = 2,     ///< a solid in the liquid: rigid, and no part of the air's boundary
  kDrySolid =
      3  ///< the part of such a solid that stands out of the liquid: normals out of the solid, air's boundary only
};

/// Triangles of the boundary and the region of each.
struct BoundaryMesh {
  mesh::SurfaceMesh surface;  ///< counter-clockwise seen from outside, corners only
  std::vector<int> region;    ///< n_triangles, 0 to 3
  std::string name;           ///< file, for messages
};

/// A point where boundary conditions are imposed: a vertex seen from one region and one side of a crease (HF section 5.5).
struct BoundarySample {
  Eigen::Vector3d point_m;
  Eigen::Vector3d normal;  ///< out of the liquid (dry solid: out of the solid), length 1
  double area_m2;          ///< a third of the triangles around
  BoundaryRegion region;
  int vertex;
};

struct BoundaryOptions {
  double expand_m = 0.0;
  double crease_angle_deg = 40.0;  ///< triangles of a vertex whose normals differ more get samples of their own
  void validate() const;           ///< InputError

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"expand_m", "Moves the free surface out, for bubbles and sources close to it", between(0.0, 1.0)},
          self.expand_m);
    visit({"crease_angle_deg", "Angle of normals from which on an edge is sharp", between(5.0, 180.0)},
          self.crease_angle_deg);
  }
};

/// The boundary of a body of liquid, checked: closed, consistently oriented, normals outwards, with free surface.
class LiquidBoundary {
 public:
  /// Vertices that agree to 1e-9 of the size become one first.
  /// @throws InputError naming the face (0-based) or edge: not finite, index out of range, unknown region, no free surface,
  /// an edge that is open, shared by more than two triangles or run twice in the same direction, normals into the liquid;
  /// a wet solid that reaches the air without its dry part
  explicit LiquidBoundary(const BoundaryMesh& mesh, const BoundaryOptions& options = {});

  const std::vector<BoundarySample>& samples() const { return samples_; }
  const mesh::SurfaceMesh& surface() const { return surface_; }  ///< welded and expanded; triangles as given
  int welded_vertex(int vertex) const { return target_[static_cast<std::size_t>(vertex)]; }  ///< of a vertex as given
  const std::vector<int>& region() const { return region_; }                                 ///< of each triangle
  const std::string& name() const { return name_; }
  double volume_m3() const { return volume_m3_; }
  double free_area_m2() const { return free_area_m2_; }
  double rigid_area_m2() const { return rigid_area_m2_; }  ///< walls and wet solids
  Eigen::Vector3d centre_m() const { return centre_m_; }   ///< of the liquid's volume
  double radius_m() const { return radius_m_; }            ///< from the centre to the farthest vertex of the liquid
  double spacing_m() const { return spacing_m_; }          ///< between samples: root of the mean area

  bool inside_liquid(const Eigen::Vector3d& x_m) const;
  /// Inside what the air goes around: liquid and the solids in it.
  bool inside_air_boundary(const Eigen::Vector3d& x_m) const;
  /// Shortest way to the triangles of the liquid.
  double distance_m(const Eigen::Vector3d& x_m) const;
  /// The point nearest to x on the free surface, or on walls and wet solids; empty where there is none.
  std::optional<Eigen::Vector3d> nearest_point_m(const Eigen::Vector3d& x_m, bool free_surface) const;
  /// Throws InputError where the point is outside the liquid, or closer to the boundary than clearance_m.
  void check_bubble(const Eigen::Vector3d& x_m, double clearance_m) const;

 private:
  void check_closed(bool of_liquid) const;
  bool inside(const Eigen::Vector3d& x_m, bool of_liquid) const;
  bool counts(std::size_t triangle, bool of_liquid) const;
  Eigen::Vector3d corner(Eigen::Index triangle, int c) const {
    return surface_.vertices_m.row(surface_.triangles(triangle, c)).transpose();
  }
  template <class Wanted>
  std::optional<Eigen::Vector3d> nearest(const Eigen::Vector3d& x_m, const Wanted& wanted) const;
  void measure();
  void sample(double crease_angle_deg);

  mesh::SurfaceMesh surface_;
  std::vector<int> region_, target_;
  std::string name_;
  std::vector<BoundarySample> samples_;
  double volume_m3_ = 0.0, free_area_m2_ = 0.0, rigid_area_m2_ = 0.0, radius_m_ = 0.0, spacing_m_ = 0.0;
  Eigen::Vector3d centre_m_ = Eigen::Vector3d::Zero();
};

}  // namespace klang::bubble
