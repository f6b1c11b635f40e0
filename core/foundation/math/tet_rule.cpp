#include "core/foundation/math/tet_rule.hpp"

namespace klang {

TetRule make_tet_rule() {
  TetRule rule;
  int n = 0;
  const auto corner_orbit = [&](double a, double weight) {
    for (int k = 0; k < 4; ++k, ++n) {
      rule.point[n].fill(a);
      rule.point[n][k] = 1 - 3 * a;
      rule.weight[n] = weight / 6;
    }
  };
  corner_orbit(0.092735250310891226402, 0.073493043116361949544);
  corner_orbit(0.31088591926330060980, 0.11268792571801585080);
  for (int i = 0; i < 4; ++i) {
    for (int j = i + 1; j < 4; ++j, ++n) {
      rule.point[n].fill(0.5 - 0.045503704125649649492);
      rule.point[n][i] = rule.point[n][j] = 0.045503704125649649492;
      rule.weight[n] = 0.042546020777081466438 / 6;
    }
  }
  return rule;
}

}  // namespace klang
