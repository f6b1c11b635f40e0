#pragma once
#include <map>
#include <set>
#include <vector>

#include "core/sound/scene/detail/modal_island.hpp"

namespace klang::scene::detail {

/// All touches, holds and joints of modal bodies with the floor, with one another and with rigid bodies.
///
/// Corners of one surface that are inside another body are touches: impulses end their approach, with the materials' restitution where
/// they are new and with Coulomb's friction, all at once among bodies that hang together (a linear complementarity problem,
/// H03 section 3.4 in its right form, erratum 71); holds and joints are met whatever touches exert. A ball that is rigid touches by Hertz' spring, F = 4/3 E* sqrt(R) d^1.5, in
/// series with the residual flexibility where there is one: a ball has no modes of its own, and the kept modes of what it strikes do not hold
/// the dent.
class ModalContacts {
 public:
  ModalContacts(const Scene& scene, std::vector<ModalBody>& bodies, std::vector<JointPlace> joints);
  /// Of balls: half a small step each, before and after all fly; at_end books what springs took and hold, and what the step's size costs.
  void press_balls(std::vector<PressedBody>& others, double half_dt_s, bool at_end);
  double ball_springs_j() const;
  /// Of touches of balls that ended: fewest periods of the highest mode of the body that was touched, and that body's number; -1: none.
  std::pair<double, int> shortest_touch() const { return {shortest_periods_, shortest_body_}; }
  double joint_error_m() const { return joint_error_m_; }  ///< farthest that held places and joints were off
  double given_j() const { return given_j_; }              ///< by touches, of which none should
  double ahead_rigid_j() const { return ahead_rigid_j_; }  ///< of the last small step (ModalIsland)
  const std::vector<events::Impulse>& on_rigid() const { return on_rigid_; }
  /// Impulses of everything else, at the end of a small step. What lasts is held over the next one.
  /// @param dt_s  small steps of bodies that do not touch anew
  /// @param ends  whether this one ended one of those: only there their size may change
  /// @return  the next small step, for which the modes are set: dt_s, or a sixth of it for two of the slowest periods of a body that touched anew. Rebounds
  ///          are of the second order in it
  double solve(std::vector<PressedBody>& others, double dt_s, bool ends = true);

 private:
  /// Modal body, corner, and what it touches: modal bodies, -1 (floor), then -2 - number of a rigid one.
  using Key = std::array<int, 3>;
  struct Ball {
    mesh::SurfaceMesh near;
    Eigen::Vector3d looked_from_m = Eigen::Vector3d::Constant(HUGE_VAL);
    double spring_j = 0.0, spring_before_j = 0.0, gained_j = 0.0, gained_ball_j = 0.0, slid_j = 0.0, touched_s = 0.0;
    bool touches = false, is_new = true;
    Eigen::Vector3d impulse_n_s = Eigen::Vector3d::Zero();  ///< on the modal body in this small step
    ModalPlace place;
    void book(ModalBody& body);
  };
  std::vector<ModalTouching> find(std::vector<PressedBody>& others);
  void find_corners(std::size_t a, std::vector<PressedBody>& others, std::vector<ModalTouching>& found,
                    std::set<Key>& now);
  void apply(const ModalTouching& touch, const Eigen::Vector3d& impulse_n_s, std::vector<PressedBody>& others);
  /// The row of a rigid body that got an impulse from a modal one.
  void note_rigid(const ModalBody& from, const PressedBody& other, const Eigen::Vector3d& x,
                  const Eigen::Vector3d& impulse_n_s, bool is_new, const Span& span);
  void press_ball(std::size_t a, PressedBody& ball, Ball& state, double dt_s);
  void time_touch(std::size_t a, Ball& state, double dt_s);

  const Scene& scene_;
  std::vector<ModalBody>& bodies_;
  std::vector<JointPlace> joints_;
  std::set<Key> was_down_;
  std::map<Key, Eigen::Vector3d> last_n_s_;  ///< what touches exerted in the last small step
  double last_dt_s_ = 0.0, fine_until_s_ = -1.0;
  bool fine_ = false;
  double next_step_s(const std::vector<ModalTouching>& touches, double dt_s, bool ends);
  double joint_error_m_ = 0.0, given_j_ = 0.0, ahead_rigid_j_ = 0.0, shortest_periods_ = HUGE_VAL;
  int shortest_body_ = -1;
  std::vector<events::Impulse> on_rigid_;  ///< rows of rigid bodies that were pushed
  std::map<std::pair<std::size_t, int>, Ball> balls_;
};

/// Those of a surface that may be within a distance of a point.
mesh::SurfaceMesh triangles_near(const mesh::SurfaceMesh& surface, const SurfaceGroups& groups,
                                 const Eigen::Vector3d& x, double distance_m);

}  // namespace klang::scene::detail
