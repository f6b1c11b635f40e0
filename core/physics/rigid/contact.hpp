#pragma once
#include <Eigen/Geometry>

#include "core/physics/events/impulse.hpp"

namespace klang::rigid {

/// The world's plane as the other body of a contact.
inline constexpr int kFloor = -1;

/// One point of one contact in one step: body a was pushed by impulse_n_s, body b by its opposite.
struct ContactImpulse {
  int a = 0, b = kFloor;
  events::ImpulseKind kind = events::ImpulseKind::kImpact;  ///< kImpact or kLasting
  double time_s = 0.0;                                  ///< of touch inside the step; a lasting one: the step's begin
  double duration_s = 0.0;                              ///< Hertz' contact time; a lasting one: the step
  double approach_m_s = 0.0;                            ///< normal speed at touch; a lasting one: 0
  Eigen::Vector3d place_m = Eigen::Vector3d::Zero();    ///< in the world
  Eigen::Vector3d place_a_m = Eigen::Vector3d::Zero();  ///< in a's own frame
  Eigen::Vector3d place_b_m = Eigen::Vector3d::Zero();  ///< in b's own frame; the floor: the world's
  Eigen::Quaterniond turn_a = Eigen::Quaterniond::Identity();  ///< of a's frame into the world's at time_s
  Eigen::Quaterniond turn_b = Eigen::Quaterniond::Identity();  ///< of b's frame; the floor: none
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();            ///< unit, from b to a, in the world
  Eigen::Vector3d impulse_n_s = Eigen::Vector3d::Zero();       ///< on a, in the world
};

}  // namespace klang::rigid
