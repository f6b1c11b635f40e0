#pragma once
#include <Eigen/Geometry>
#include <array>
#include <span>
#include <vector>

#include "core/physics/rigid/detail/body_state.hpp"

namespace klang::rigid::detail {

/// A point where two bodies touch, or would within the step.
struct Contact {
  int a = 0, b = -1;  ///< b = -1: the floor
  std::array<int, 2> parts{0, 0};
  Eigen::Vector3d place = Eigen::Vector3d::Zero(), normal = Eigen::Vector3d::UnitZ();  ///< world; normal from b to a
  Eigen::Vector3d arm_a = Eigen::Vector3d::Zero(), arm_b = Eigen::Vector3d::Zero();    ///< from the centres
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();  ///< columns: normal and two tangents
  double gap = 0.0;    ///< where the bodies would be at the step's end without it; negative: overlap
  double touch = 0.0;  ///< an impact: in the step, from its begin
  Eigen::Quaterniond turn_a = Eigen::Quaterniond::Identity(), turn_b = Eigen::Quaterniond::Identity();  ///< there
  double restitution = 0.0, friction = 0.0;
  int link = -1;      ///< of the world's links; -1: bodies that touch
  bool tied = false;  ///< a link that holds in all directions, by any impulse

  Eigen::Vector3d impact = Eigen::Vector3d::Zero();   ///< impulse on a of this step's impacts, along axes
  Eigen::Vector3d lasting = Eigen::Vector3d::Zero();  ///< and of the force that holds
  double approach = 0.0;                              ///< normal speed at touch
  double give = 0.0;                                  ///< speed along the normal per impulse, at touch, as held
  double target = 0.0;                                ///< normal velocity that a solve aims at
};

struct Bodies {
  std::span<BodyState> all;
  std::vector<Eigen::Matrix3d> inverse_inertia;  ///< in the world, as they lie at their clocks
};

/// Of a's surface against b's at the place, along the contact's axes.
Eigen::Vector3d relative_velocity(const Contact& contact, const Bodies& bodies);
/// An impulse on a, its opposite on b; along the contact's axes.
void push(const Contact& contact, const Eigen::Vector3d& impulse, Bodies& bodies);
/// Velocity per impulse at the place: the diagonal of J M^-1 J^T along the contact's axes.
Eigen::Vector3d mobility(const Contact& contact, const Bodies& bodies);

/// Contacts' impulses (by the member) so that each normal velocity is at least target, its impulse not negative, one of both zero,
/// and the tangential impulse within friction times the normal one and against the sliding; of a tied one the velocity is 0:
/// projected Gauss-Seidel sweeps.
/// @param tolerance  largest change of a velocity by a sweep at which it ends; it also ends where fifty sweeps gain less than a tenth
/// @return           worst violation that is left, as a velocity
double solve_contacts(std::span<Contact* const> contacts, Eigen::Vector3d Contact::*impulse, int sweeps,
                      double tolerance, Bodies& bodies);

}  // namespace klang::rigid::detail
