// SB: Zheng and James 2010, "Rigid-Body Fracture Sound with Precomputed Soundbanks"; and what is left out of all papers.
#include <cmath>
#include <vector>

#include "core/physics/solid/material.hpp"
#include "core/sound/waves/medium.hpp"
#include "core/sound/waves/spherical_bessel.hpp"
#include "validate/papers/detail/paper_groups.hpp"

namespace klang::validate::detail {
namespace {

/// Share of a monopole's power that orders above n lack when it stands k d from the centre: 1 - sum (2 l + 1) j_l(k d)^2.
double lost_power(double kd, int n) {
  std::vector<double> j(static_cast<std::size_t>(n) + 1);
  acoustics::spherical_bessel_j(kd, j);
  double kept = 0.0;
  for (std::size_t l = 0; l < j.size(); ++l) kept += static_cast<double>(2 * l + 1) * j[l] * j[l];
  return 1.0 - kept;
}

}  // namespace

std::vector<PaperNumber> soundbank_numbers(Monitor&) {
  std::vector<PaperNumber> numbers;
  struct Row {
    double ka;
    // tests/reference/radiation.json: truncation_offcentre_monopole[].nbar_paper, nbar_for_1pct
    int printed, reference;
    bool off;
  };
  constexpr Row kRows[] = {{5.0, 4, 6, true}, {10.0, 5, 11, true}, {20.0, 10, 22, true}};
  for (const Row& row : kRows) {
    int order = 0;
    while (lost_power(row.ka, order) > 0.01) ++order;
    char words[120], note[80];
    std::snprintf(words, sizeof words,
                  "multipole order for a body of ka = %g (here: keeps 99 %% of a monopole's power at its rim)", row.ka);
    std::snprintf(note, sizeof note, "the printed order loses %.0f %%, errata 46",
                  100.0 * lost_power(row.ka, row.printed));
    numbers.push_back({"sb.order." + std::to_string(static_cast<int>(row.ka)),
                       "SB",
                       "Section 4",
                       words,
                       static_cast<double>(row.printed),
                       static_cast<double>(order),
                       static_cast<double>(row.reference),
                       "series",
                       1e-6,
                       0.01,
                       "exact",
                       row.off,
                       note,
                       {}});
  }
  const acoustics::Medium air;
  numbers.push_back(elsewhere({"sb.element",
                               "SB",
                               "Section 4",
                               "a sixth of the wavelength in air at 20 kHz [mm]",
                               5.0,
                               1e3 * air.sound_speed_m_s / 20000.0 / 6.0,
                               343.0 / 120.0,
                               "speed of sound 343 m/s",
                               1e-3,
                               0.1,
                               "rounding",
                               true,
                               "5 mm are a sixth at 11.4 kHz",
                               {}}));
  // Young's moduli: printed "x 10^10 GPa".
  for (const auto& [name, preset, printed, other] :
       {std::tuple{"glass", "borosilicate_glass", 6.2e19, 6.2e10}, {"ceramic", "porcelain", 7.2e19, 7.2e10}}) {
    numbers.push_back(elsewhere({std::string("sb.table1.") + name,
                                 "SB",
                                 "Table 1",
                                 std::string("Young's modulus of ") + name + " [Pa]",
                                 printed,
                                 solid::material_preset(preset).youngs_modulus_pa(),
                                 other,
                                 "the paper's digits in 10^10 Pa",
                                 0.1,
                                 0.1,
                                 "chosen: two glasses, one porcelain",
                                 true,
                                 std::string("printed in units of 10^10 GPa; ours: preset ") + preset,
                                 {}}));
  }
  return numbers;
}

std::vector<PaperGap> paper_gaps() {
  return {{"S02", "Table 1: base frequencies of Bowl #1, the ceramic bunny, the aluminium shelf, the letter T",
           "shape, size and supports are not given; rows of the same body in another material are held against these"},
          {"S02", "Table 1: nodes, minutes", "machine and mesh of 2002"},
          {"SB", "Table 2: minutes themselves", "another machine; the rows are held against each other"},
          {"SB", "Table 3: triangles, tetrahedra, modes, solves, minutes",
           "meshes are not given, the machine is another; modes and minutes are held against each other"},
          {"SB", "concrete slab of 9 x 9 x 0.9 m", "its material is not given"},
          {"HF", "Table 1: residuals of the two passes",
           "the liquid's shape at a solve is not given; `klang converge dual-domain` has them for a tank of Droplet's "
           "size"},
          {"HF", "Table 2: hours themselves", "another machine; the shares are held against the hours"},
          {"HF", "Figure 13",
           "the liquid's shape is not given; `klang converge dual-domain` has the curves for a tank of its size"},
          {"B99", "Table 1: toughness", "in N/m^2 of a tensor of forces: no strength follows from it, errata 19"},
          {"D02", "Figure 3: walls 1 to 4", "their gamma1, gamma2 are lost in the text, errata 70"},
          {"H03", "Table 1: modes, times", "the models are not given"}};
}

}  // namespace klang::validate::detail
