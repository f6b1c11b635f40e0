#pragma once
#include <array>
#include <map>
#include <vector>

#include "core/sound/scene/detail/modal_body.hpp"
#include "core/sound/scene/detail/rigid_push.hpp"

namespace klang::scene::detail {

/// Of the largest mobility: combinations of held places that move less depend on the others. The kept modes hardly warp the end of a bar: to hold
/// that still takes forces that are mostly round-off, and grow.
inline constexpr double kDependentHolds = 1e-6;

/// What ties a place of a modal body to another's, or to the world where other is -1.
struct JointPlace {
  int body = 0, other = -1;  ///< of the list of modal bodies
  ModalPlace place, other_place;
  Eigen::Vector3d world_m = Eigen::Vector3d::Zero();
};

struct TouchSide {
  int member = -1;  ///< modal bodies, then rigid ones; -1: the floor
  Eigen::Vector3d x = Eigen::Vector3d::Zero();
  ModalPlace place;  ///< of a modal body
};

/// One point at which a modal body touches something.
struct ModalTouching {
  TouchSide a, b;
  Eigen::Vector3d out = Eigen::Vector3d::Zero();  ///< unit, the way a is pushed
  double gap_m = 0.0, restitution = 0.0, friction = 0.0;
  int a_row = -1, b_row = -1;  ///< bodies of the scene
  bool is_new = false;
  std::array<int, 3> key = {0, 0, 0};                  ///< whose corner touches what (ModalContacts)
  Eigen::Vector3d last_n_s = Eigen::Vector3d::Zero();  ///< on a, in the step before
};

/// Bodies that hang together by touches and joints in one small step, and the impulses that meet all of it at once. Unknowns are the speeds of
/// centres, spins and modes; rows those of held places and joints, then of touches along their normals and across.
class ModalIsland {
 public:
  struct World {
    std::vector<ModalBody>& bodies;
    std::vector<PressedBody>& others;
    Eigen::Vector3d gravity_m_s2;
    double dt_s = 0.0;
  };
  ModalIsland(const World& world, std::vector<int> members, std::vector<ModalTouching> touches,
              const std::vector<JointPlace>& joints);
  /// Pushes the modal bodies and books what that takes; nothing where there is nothing to meet.
  void solve();
  /// What holds and joints did, to the lists of the bodies: rows of the body itself, or of the one that it is joined to.
  void note_held();
  double missed_m() const {
    return missed_m_;
  }  ///< that held places and joints will be off by at the end of the next small step
  /// What touches gave by pushing bodies that part: none by Signorini's law, some by the linear program (erratum 71).
  double given_j() const { return given_j_; }
  /// Of the motion of rigid bodies after this: by what lasting touches gave them for the second half of the next step.
  double ahead_rigid_j() const { return ahead_rigid_j_; }
  const std::vector<ModalTouching>& touches() const { return touches_; }
  /// On a of each touch, in the world.
  const std::vector<Eigen::Vector3d>& impulses_n_s() const { return on_touches_; }

 private:
  bool is_modal(int member) const;
  TouchSide side_of(int member, const ModalPlace& place) const;
  void set(Eigen::Index row, const TouchSide& side, const Eigen::Vector3d& along, double sign);
  void set_rows();
  void set_mobile();
  void set_springs();
  Eigen::VectorXd missed_m_s() const;
  Eigen::Vector3d moves_by_m(const TouchSide& side) const;
  void find_impulses();
  void give(const Eigen::MatrixXd& mobile, const Eigen::MatrixXd& rows, const Eigen::VectorXd& impulses);
  void hit_held_places();
  void set_ahead();
  Eigen::Vector3d speed_of(const TouchSide& side) const;
  Eigen::VectorXd speeds() const;
  void book(const Eigen::VectorXd& speeds_before_m_s);

  World world_;
  std::vector<int> members_;
  std::vector<ModalTouching> touches_;
  std::vector<std::pair<int, const HeldPlace*>> holds_;
  std::vector<const JointPlace*> joints_;
  std::map<int, Eigen::Index> offset_;
  bool linear_program_ = false, flexible_ = false, any_shock_ = false;
  Eigen::Index n_unknowns_ = 0, n_held_ = 0, per_ = 1, n_down_ = 0;
  double ahead_rigid_j_ = 0.0, released_j_ = 0.0, given_j_ = 0.0,
         missed_m_ = 0.0;                        ///< released: by springs of the last small step
  Eigen::MatrixXd rows_, mobile_, a_, springs_;  ///< J; M^-1 J^T; J M^-1 J^T; of the discarded modes over dt^2
  Eigen::MatrixXd held_root_;  ///< of the part of over_step_ that held places and joints have: times its transpose
  Eigen::MatrixXd over_step_;  ///< what impulses make of the way over the next small step, over dt
  Eigen::VectorXd before_m_s_, impulses_;
  std::vector<Eigen::Matrix3d> frames_;  ///< of touches: columns out, then along
  std::vector<Eigen::Vector3d> on_touches_;
  struct Met;
};

}  // namespace klang::scene::detail
