#pragma once
#include <Eigen/Geometry>
#include <optional>
#include <vector>

#include "core/physics/rigid/rigid_world.hpp"

namespace klang::scene::detail {

/// Where a point is inside a body: how deep, and the way out.
struct Depth {
  double depth_m = 0.0;
  Eigen::Vector3d out = Eigen::Vector3d::Zero();  ///< unit
};

/// A rigid body while deforming ones press on it within a step of the world: it goes on from where the step began, with their
/// impulses, and gives the world its new velocity at the end, with half a step's more of the same push: the world then moves it over the next
/// step to where the push takes it, to second order. One that is struck goes back by the whole step instead, and the world moves it to where
/// each impulse, at its own moment in the step, takes it.
class PressedBody {
 public:
  enum class Way { kPressed, kStruck };
  PressedBody(const rigid::RigidWorld& world, int body, Way way = Way::kPressed);
  void begin(const rigid::RigidWorld& world, double dt_s, const Eigen::Vector3d& gravity_m_s2);
  /// @param x  in the world
  std::optional<Depth> depth_of(const Eigen::Vector3d& x) const;
  /// False: depth_of() has nothing. Cheap.
  bool may_have(const Eigen::Vector3d& x) const {
    return (x - centre_).squaredNorm() <= 1.000001 * reach_m_ * reach_m_;
  }
  Eigen::Vector3d velocity_at(const Eigen::Vector3d& x) const { return velocity_ + spin_.cross(x - centre_); }
  void push(const Eigen::Vector3d& x, const Eigen::Vector3d& impulse_n_s);
  /// The same by friction, whose share of the energy is told apart.
  void rub(const Eigen::Vector3d& x, const Eigen::Vector3d& impulse_n_s);
  double rubbed_j() const { return rubbed_j_; }  ///< of what it got in this step, by friction
  void advance(double dt_s);
  void rewind();  ///< to the place where the step began, with what was gained so far
  /// Energy that it got in this step [J].
  double end(rigid::RigidWorld& world);
  int body() const { return body_; }
  const rigid::Skin& skin() const { return skin_; }
  double mass_kg() const { return fixed_ ? 1e300 : mass_kg_; }
  double inverse_mass_per_kg() const { return fixed_ ? 0.0 : 1.0 / mass_kg_; }
  const Eigen::Matrix3d& inverse_inertia() const { return inverse_inertia_; }  ///< in the world's axes; 0: fixed
  const Eigen::Vector3d& centre_m() const { return centre_; }
  const Eigen::Vector3d& velocity_m_s() const { return velocity_; }
  const Eigen::Vector3d& spin_rad_s() const { return spin_; }
  double moving_j() const;
  double ball_radius_m() const { return ball_radius_m_; }
  Eigen::Vector3d to_body(const Eigen::Vector3d& x) const { return turn_.transpose() * (x - centre_) + body_centre_m_; }
  Eigen::Vector3d turned_to_body(const Eigen::Vector3d& v) const { return turn_.transpose() * v; }
  /// Corners of its convex parts, in the world.
  std::vector<Eigen::Vector3d> corners_m() const;
  /// Sphere about its centre that holds it.
  bool is_near(const Eigen::Vector3d& low, const Eigen::Vector3d& high) const;
  /// Whether a ball may reach into it.
  bool may_hold(const Eigen::Vector3d& centre, double radius_m) const;

 private:
  struct Plane {
    Eigen::Vector3d normal;
    double offset_m = 0.0;
  };
  int body_ = 0;
  Way way_ = Way::kPressed;
  bool fixed_ = false;
  double rubbed_j_ = 0.0;
  double left_s_ = 0.0;                              ///< of the step
  Eigen::Vector3d shift_ = Eigen::Vector3d::Zero();  ///< that what was gained makes until the step's end
  std::vector<Eigen::Vector3d> own_corners_;
  double mass_kg_ = 0.0, ball_radius_m_ = 0.0, reach_m_ = 0.0;
  rigid::Skin skin_;
  Eigen::Matrix3d inertia_ = Eigen::Matrix3d::Zero(), turn_ = Eigen::Matrix3d::Identity(),
                  inverse_inertia_ = Eigen::Matrix3d::Zero();
  Eigen::Vector3d body_centre_m_, centre_, velocity_, spin_, begin_centre_, begin_velocity_,
      gravity_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d gained_ = Eigen::Vector3d::Zero(), gained_spin_ = Eigen::Vector3d::Zero();  ///< in this step
  Eigen::Vector3d lead_ = Eigen::Vector3d::Zero(),
                  lead_spin_ = Eigen::Vector3d::Zero();  ///< that the world has beside the velocity
  std::optional<Eigen::Vector3d> end_centre_;            ///< of the last step
  std::vector<std::vector<Plane>> parts_;
};

}  // namespace klang::scene::detail
