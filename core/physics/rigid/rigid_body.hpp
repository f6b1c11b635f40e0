#pragma once
#include <Eigen/Geometry>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/geometry/mesh/round_surface.hpp"

namespace klang::rigid {

/// A convex piece of a body by its corners in the body's frame [m], one per column. The hull of the corners collides; a face is
/// where its corners are.
struct ConvexPart {
  Eigen::Matrix3Xd corners_m;
};

/// What a body's skin does when it is touched. Of a pair: restitution as pair_restitution(), the smaller friction.
struct Skin {
  double restitution = 0.5;  ///< 0 to 1: separation over approach speed of an impact
  double friction = 0.4;     ///< Coulomb's, >= 0
  double youngs_modulus_pa = 70e9;
  double poissons_ratio = 0.22;
  double radius_m = 0.0;  ///< of the surface where it touches; 0: RigidBodySpec::touch_radius_m()
};

/// How a body's surface bends at a place with that outward normal, in the body's frame: k1 e1 e1^T + k2 e2 e2^T [1/m] with the tangents e1,
/// e2 of the principal directions. Nothing: an edge or a corner.
using Curvature =
    std::function<std::optional<Eigen::Matrix3d>(const Eigen::Vector3d& place_m, const Eigen::Vector3d& outward)>;

/// A rigid body as a scene gives it. Its frame is that of its shape, mesh and modes.
struct RigidBodySpec {
  std::string name;
  double mass_kg = 0.0;
  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();       ///< of mass, in the body's frame
  Eigen::Matrix3d inertia_kg_m2 = Eigen::Matrix3d::Zero();  ///< about the centre, axes of the body's frame
  double ball_radius_m = 0.0;                               ///< > 0: a ball about its centre, which has no parts
  std::vector<ConvexPart> parts;
  std::vector<mesh::RoundSurface>
      round;  ///< of which the parts' hull is: the floor touches these, not their facets; none: corners
  Skin skin;
  Curvature curvature = {};                              ///< none: it touches with edges and corners alone
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();  ///< of the body's frame, in the world
  Eigen::Quaterniond orientation = Eigen::Quaterniond::Identity();
  Eigen::Vector3d velocity_m_s = Eigen::Vector3d::Zero();            ///< of the centre
  Eigen::Vector3d angular_velocity_rad_s = Eigen::Vector3d::Zero();  ///< in the world's axes
  bool fixed = false;                                                ///< does not move, whatever pushes it

  /// Smallest extent of a part or the ball along x, y, z of the body's frame, halved [m].
  double smallest_half_width_m() const;
  /// How round edges and corners are taken to be: a tenth of the smallest half-width; a ball's own radius.
  double touch_radius_m() const;
  /// 1/m at a place of its surface, of the skin's or the ball's radius, by curvature, or as round as edges are.
  Eigen::Matrix3d curvature_at(const Eigen::Vector3d& place_m, const Eigen::Vector3d& outward) const;
  double size_m() const;  ///< largest distance of a point from the centre, doubled

  /// @throws InputError that names the body: mass, inertia (positive, principal moments that a body can have), parts with less
  ///         than two corners, a ball with parts or neither, numbers that are not finite, restitution outside 0 to 1
  void validate() const;
};

/// That of the skins when both are equal, else the smaller.
double pair_restitution(const Skin& a, const Skin& b);
double pair_friction(const Skin& a, const Skin& b);

/// Mass, centre and inertia of a body with uniform density that fills its parts, which must not overlap: a sum over cones of the
/// hulls' triangles. @throws InputError for parts without volume
void set_mass_from_parts(RigidBodySpec& body, double density_kg_m3);

/// A ball of uniform density.
RigidBodySpec ball(std::string name, double radius_m, double mass_kg);
/// A cuboid of uniform density, centred on its frame.
RigidBodySpec cuboid(std::string name, const Eigen::Vector3d& sides_m, double mass_kg);

}  // namespace klang::rigid
