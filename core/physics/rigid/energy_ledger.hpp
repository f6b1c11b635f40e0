#pragma once
#include "core/foundation/config/fields.hpp"

namespace klang::rigid {

/// Where the energy is and where it went [J]. Losses are sums since the start and never fall. What is there and what was lost,
/// less what was put in from outside, is constant:
///   kinetic + potential + strain + contact + friction + fracture + vibration + viscous + plastic + correction - work = const,
/// of which residual_j is the part that does not close, by round-off.
struct EnergyLedger {
  double time_s = 0.0;
  double kinetic_j = 0.0;
  double potential_j = 0.0;  ///< 0 where all centres lie at the world's origin
  double strain_j = 0.0;     ///< of bodies under load
  double contact_j = 0.0;    ///< lost along the normals of contacts
  double friction_j = 0.0;   ///< lost across them
  double fracture_j = 0.0;   ///< in new surfaces
  double vibration_j = 0.0;  ///< left to ring in pieces of broken bodies
  double viscous_j = 0.0;    ///< lost to viscous stress in deforming bodies
  double plastic_j = 0.0;    ///< lost to plastic flow in them
  double correction_j =
      0.0;              ///< less what the solver itself put in: pushing penetrating bodies apart, contacts that gain
  double work_j = 0.0;  ///< put in from outside: bodies added, velocities changed
  double residual_j = 0.0;

  double sum_j() const {
    return kinetic_j + potential_j + strain_j + contact_j + friction_j + fracture_j + vibration_j + viscous_j +
           plastic_j + correction_j - work_j;
  }

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"time_s", "end of the step"}, self.time_s);
    visit({"kinetic_j", "of all bodies"}, self.kinetic_j);
    visit({"potential_j", "in the field of gravity; 0 where all centres lie at the world's origin"}, self.potential_j);
    visit({"strain_j", "of bodies under load"}, self.strain_j);
    visit({"contact_j", "lost along the normals of contacts since the start"}, self.contact_j);
    visit({"friction_j", "lost across them since the start"}, self.friction_j);
    visit({"fracture_j", "in new surfaces since the start"}, self.fracture_j);
    visit({"vibration_j", "left to ring in pieces of broken bodies"}, self.vibration_j);
    visit({"viscous_j", "lost to viscous stress in deforming bodies since the start"}, self.viscous_j);
    visit({"plastic_j", "lost to plastic flow in them since the start"}, self.plastic_j);
    visit({"correction_j", "less what the solver itself put in: penetrating bodies pushed apart, contacts that gain"},
          self.correction_j);
    visit({"work_j", "put in from outside since the start"}, self.work_j);
    visit({"residual_j", "what does not close"}, self.residual_j);
  }
};

}  // namespace klang::rigid
