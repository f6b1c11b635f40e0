#pragma once
#include <string>

#include "core/foundation/config/result_header.hpp"

/// The result of `klang bubble info`.
namespace klang::apps {

struct BubbleInfoDocument {
  ResultHeader header;
  double radius_m = 0.0, undamped_frequency_hz = 0.0, damped_frequency_hz = 0.0, decay_per_s = 0.0;
  double delta_radiation = 0.0, delta_viscous = 0.0, delta_thermal = 0.0, polytropic_index = 0.0;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    ResultHeader::describe(self.header, visit);
    visit({"radius_m", "at rest"}, self.radius_m);
    visit({"undamped_frequency_hz", "Minnaert's with the polytropic index and surface tension"},
          self.undamped_frequency_hz);
    visit({"damped_frequency_hz", "that is heard"}, self.damped_frequency_hz);
    visit({"decay_per_s", "of the amplitude"}, self.decay_per_s);
    visit({"delta_radiation", "by sound; the decay is half the sum of the deltas times 2 pi undamped_frequency_hz"},
          self.delta_radiation);
    visit({"delta_viscous", "by the liquid's viscosity"}, self.delta_viscous);
    visit({"delta_thermal", "by heat"}, self.delta_thermal);
    visit({"polytropic_index", "of the gas: 1 isothermal, heat capacity ratio adiabatic"}, self.polytropic_index);
  }
};

}  // namespace klang::apps
