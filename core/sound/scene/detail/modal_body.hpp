#pragma once
#include <Eigen/Geometry>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "core/geometry/mesh/tet_mesh.hpp"
#include "core/physics/modal/constraints/modal_step.hpp"
#include "core/sound/scene/detail/residual_flexibility.hpp"
#include "core/sound/scene/detail/surface_groups.hpp"
#include "core/sound/scene/scene_bodies.hpp"

namespace klang::scene::detail {

/// A place of a modal body: in the frame of the centre of mass, with its rows of the modes.
struct ModalPlace {
  Eigen::Vector3d rest_m = Eigen::Vector3d::Zero();
  Eigen::Matrix3Xd shape;
  std::vector<std::pair<int, double>> nodes;  ///< of the surface, with weights: for the residual flexibility
};

struct HeldPlace {
  ModalPlace place;
  std::shared_ptr<const fracture::HoldPath> path;
  Eigen::Vector3d origin_m = Eigen::Vector3d::Zero();  ///< in the world, at the start
};

/// When something pushed.
struct Span {
  double begin_s = 0.0, duration_s = 0.0;
};

/// What pushed a modal body, in its own frame; the impulse in the world's axes until the step of the world ends, then in those of the body then,
/// as its pose has them that readers turn it back by.
struct ModalTouch {
  Span span;
  int other = -1;  ///< row of a body, or -1: the floor
  bool is_new = false;
  Eigen::Vector3d point_m = Eigen::Vector3d::Zero(), impulse_n_s = Eigen::Vector3d::Zero();
};

/// Where a point is inside a modal body.
struct ModalDepth {
  double depth_m = 0.0;
  Eigen::Vector3d out = Eigen::Vector3d::Zero();  ///< unit, in the world
  ModalPlace place;                               ///< of the surface
};

/// Corners that lie near one another at rest: no corner of theirs is displaced by more than sum of |z_k| times most[k].
struct CornerGroup {
  std::vector<int> corners;
  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();
  double reach_m = 0.0;
  Eigen::VectorXd most;
};

/// One modal body of a scene (H03): a rigid frame and its lowest elastic modes.
struct ModalBody {
  int row = 0;
  double mass_kg = 0.0, dt_s = 0.0, time_s = 0.0, residual = 0.0;
  bool linear_program = false;
  rigid::Skin skin;
  double ball_radius_m = 0.0;  ///< of a sphere, else 0
  Eigen::Vector3d rest_centre_m, centre_m, velocity_m_s, angular_momentum;
  Eigen::Matrix3d inertia;
  Eigen::Quaterniond turn;
  modal::ModalState modes{Eigen::VectorXd(), Eigen::VectorXd()};
  std::vector<ModalPlace> places;                  ///< corners of the surface
  Eigen::MatrixXd corner_shapes;                   ///< of all places, three rows each
  std::vector<CornerGroup> groups;                 ///< of all places
  std::shared_ptr<ResidualFlexibility> discarded;  ///< null: discarded modes are stiff where corners touch
  std::shared_ptr<ResidualFlexibility> under_balls;
  double spring_j = 0.0;  ///< in the discarded modes at the floor and other bodies
  /// Half of what touches that last gave at the end of the last small step, for the next one: without it the speeds are those of that moment.
  Eigen::Vector3d ahead_m_s = Eigen::Vector3d::Zero(), ahead_momentum = Eigen::Vector3d::Zero();
  Eigen::VectorXd ahead_modes;  ///< none: empty
  std::vector<HeldPlace> held;
  mesh::SurfaceMesh surface;                        ///< at rest, about the centre of mass
  SurfaceGroups surface_groups;                     ///< of it
  Eigen::MatrixXd surface_shapes;                   ///< of its vertices, three rows each
  std::vector<std::vector<Eigen::Vector4d>> parts;  ///< convex ones: outward planes n, offset, about the centre of mass
  Eigen::Vector3d low_m, high_m;                    ///< box at rest, about the centre of mass
  double reach_m = 0.0;                             ///< farthest corner
  rigid::EnergyLedger ledger;                       ///< losses alone
  std::vector<ModalTouch> touches;
  std::vector<events::Pose> poses;

  // Of the present moment, by refresh().
  Eigen::Matrix3Xd corners_m;  ///< places in the world; empty where nothing is near
  std::vector<int> looked_at;  ///< corners whose places are of now, ascending
  double swell_m = 0.0;        ///< largest displacement of a corner, or more

  Eigen::Matrix3d inverse_inertia() const {
    const Eigen::Matrix3d r = turn.toRotationMatrix();
    return r * inertia.inverse() * r.transpose();
  }
  Eigen::Vector3d spin() const { return inverse_inertia() * angular_momentum; }
  double moving_j() const {
    return 0.5 * mass_kg * velocity_m_s.squaredNorm() + 0.5 * angular_momentum.dot(spin()) +
           0.5 * modes.v.squaredNorm();
  }
  double ahead_j() const;  ///< of moving_j(): by what is ahead
  double strain_j() const { return 0.5 * modes.z.dot(modes.lambda().cwiseProduct(modes.z)) + spring_j; }
  Eigen::Vector3d arm(const ModalPlace& p) const { return turn * (p.rest_m + p.shape * modes.z); }
  Eigen::Vector3d velocity_at(const ModalPlace& p) const {
    return velocity_m_s + spin().cross(arm(p)) + turn * (p.shape * modes.v);
  }
  void fly(double dt, const Eigen::Vector3d& gravity);
  /// Where a place will be after fly(dt), to round-off.
  Eigen::Vector3d place_after(const ModalPlace& place, double dt, const Eigen::Vector3d& gravity) const;
  void refresh();
  /// The same of those groups of corners alone that may touch something, of which a ball (centre in the world, radius) holds all: H03's refitted
  /// tree, of one level.
  using MayTouch = std::function<bool(const Eigen::Vector3d&, double)>;
  void refresh_where(const MayTouch& may_touch);
  /// Whether a ball may reach into it, by its shape at rest and how far it swells.
  bool may_hold(const Eigen::Vector3d& centre, double radius_m) const;
  /// An impulse at a place, without what it costs.
  void push(const ModalPlace& place, const Eigen::Vector3d& impulse_n_s);
  void turn_touches(std::size_t from);  ///< impulses of touches from there on to its own axes
  Span last_step() const { return {time_s - dt_s, dt_s}; }
  /// Of an impulse between two steps, which is half of the last one's and half of the next one's.
  Span between_steps(double next_s) const { return {time_s - 0.5 * dt_s, 0.5 * (dt_s + next_s)}; }
  void note(const ModalPlace& place, int other, bool is_new, const Eigen::Vector3d& impulse_n_s, const Span& span);
  /// The place of the surface nearest to a point about the centre of mass at rest, and its outward normal.
  ModalPlace nearest(const Eigen::Vector3d& own, Eigen::Vector3d& normal) const;
  /// The same among some of its triangles.
  ModalPlace nearest(const Eigen::Vector3d& own, const mesh::SurfaceMesh& among, Eigen::Vector3d& normal) const;
  ModalPlace place_at(const mesh::SurfacePoint& found, Eigen::Vector3d& normal) const;
  std::optional<ModalDepth> depth_of(const Eigen::Vector3d& x) const;
  bool is_near(const Eigen::Vector3d& x, double distance_m) const;
  /// Static compliance of the discarded modes: displacement at a along u of a unit force at b along w, both in the world.
  double discarded_m_per_n(const ModalPlace& a, const Eigen::Vector3d& u, const ModalPlace& b,
                           const Eigen::Vector3d& w) const;
  double bent_m() const;  ///< no corner is displaced by more
  void keep_pose();
};

/// Groups of some 32 places by halving along their longest extent.
std::vector<CornerGroup> corner_groups(const std::vector<ModalPlace>& places);

/// Its mesh, modes and holds. @throws InputError; NumericalError where modes are not found
ModalBody modal_body_of(const Scene& scene, int row, const rigid::RigidBodySpec& spec, const SceneNotes& notes,
                        Monitor& monitor);

}  // namespace klang::scene::detail
