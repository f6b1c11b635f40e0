#pragma once
#include <array>
#include <map>
#include <set>
#include <vector>

#include "core/physics/fracture/dynamic/element_contact.hpp"
#include "core/sound/scene/detail/deforming_body.hpp"

namespace klang::scene::detail {

/// Cracking bodies that press on one another: their elements by the volume that they have in common (fracture::ElementContact), with Coulomb's
/// friction of their materials. Those whose boxes may meet within a step of the world go through it together in small steps of the shortest limit
/// among them; the others go alone.
class BodyMeeting {
 public:
  explicit BodyMeeting(std::vector<DeformingBody*> bodies);
  /// Finds out which may touch another one before dt is over; 1 for each of these.
  const std::vector<char>& choose(double dt_s);
  /// These, through a step of the world.
  void advance(double until_s, std::vector<PressedBody>& pressed);
  double stored_j() const { return contact_.last().energy_j; }  ///< by what is pressed now
  double lost_j() const {
    return lost_j_;
  }  ///< what contacts stored of elements that were cut, and what they store since
  /// Impulses on pieces, one of each pair in a step of the world. @param rows  of each body, as DeformingBody::add_to() gave them
  void add_to(SceneMotion& motion, const std::vector<std::vector<int>>& rows) const;

 private:
  /// Forces of now: made anew once bodies have gone on or were cut.
  const fracture::ElementContact::Forces& forces();
  void note_pushes(double dt_s);
  void note_contacts(double begin_s, double until_s);
  /// What two bodies' pieces did to each other in a step of the world.
  struct Met {
    std::array<int, 2> bodies = {0, 0};
    std::array<DeformingBody::Contact, 2> contacts;
  };

  std::vector<DeformingBody*> bodies_;
  std::vector<const fracture::CrackMesh*> meshes_;
  fracture::ElementContact contact_;
  std::vector<char> together_;  ///< of bodies: chosen
  fracture::NodeForces none_;   ///< of those that are not
  bool is_stale_ = true;
  std::vector<int> changes_seen_;
  double dt_s_ = 0.0, lost_j_ = 0.0;
  std::map<std::array<int, 4>, Eigen::Vector3d> pushes_;  ///< impulses in this step of the world: bodies, elements
  std::set<std::array<int, 4>> touched_;                  ///< in the last step of the world: bodies, pieces
  std::vector<Met> met_;
};

}  // namespace klang::scene::detail
