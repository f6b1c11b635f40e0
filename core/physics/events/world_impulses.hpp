#pragma once
#include <string>
#include <vector>

#include "core/physics/events/event_log.hpp"

namespace klang::events {

/// An impulse of a log as tables for people and spreadsheets show it.
struct WorldImpulse {
  double time_s = 0.0;
  std::string body, other;
  double x_m = 0.0, y_m = 0.0, z_m = 0.0;
  double jx_n_s = 0.0, jy_n_s = 0.0, jz_n_s = 0.0;
  double duration_s = 0.0;
  ImpulseKind kind = ImpulseKind::kImpact;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"time_s", "of first touch, or where a step of a lasting contact begins"}, self.time_s);
    visit({"body", "that is pushed"}, self.body);
    visit({"other", "that pushes; floor: the plane z = 0 or the world"}, self.other);
    visit({"x_m", "place in the body's own frame"}, self.x_m);
    visit({"y_m", "place in the body's own frame"}, self.y_m);
    visit({"z_m", "place in the body's own frame"}, self.z_m);
    visit({"jx_n_s", "impulse on the body, in the world's axes"}, self.jx_n_s);
    visit({"jy_n_s", "impulse on the body, in the world's axes"}, self.jy_n_s);
    visit({"jz_n_s", "impulse on the body, in the world's axes"}, self.jz_n_s);
    visit({"duration_s", "of contact; of a lasting one: the step"}, self.duration_s);
    visit({"kind", "impact, lasting or fracture"}, self.kind);
  }
};

/// The impulses of a log in its order, turned into the world by the body's first pose after the impulse's time (a crack's: at or after it) (its last one
/// where there is none): that of the end of the step that pushed it. A body without poses has the world's axes.
std::vector<WorldImpulse> world_impulses(const EventLog& log);

}  // namespace klang::events
