// HF: Zheng and James 2009, "Harmonic Fluids".
#include <array>
#include <cmath>

#include "core/foundation/base/conventions.hpp"
#include "core/physics/bubble/bubble_physics.hpp"
#include "core/physics/bubble/ringdown_formulas.hpp"
#include "core/sound/waves/medium.hpp"
#include "validate/papers/detail/paper_groups.hpp"

namespace klang::validate::detail {
namespace {

constexpr const char* kPaper = "HF";

void figure_1(std::vector<PaperNumber>& numbers) {
  struct Row {
    double diameter_m, printed_hz, rounding_hz, reference_hz;  // tests/reference/bubble.json: rows[].A_printed.f_d
  };
  constexpr Row kRows[] = {{5e-3, 1300, 50, 1313.0847248863981},
                           {2e-3, 3300, 50, 3282.1774766400963},
                           {1e-3, 6600, 50, 6562.6807784736675},
                           {0.5e-3, 13000, 500, 13118.950482705253}};
  for (const Row& row : kRows) {
    char words[80];
    std::snprintf(words, sizeof words, "frequency [Hz] of a bubble of %.1f mm, read as its diameter (errata 25)",
                  1e3 * row.diameter_m);
    numbers.push_back(
        {"hf.figure1." + std::to_string(static_cast<int>(1e4 * row.diameter_m + 0.5)),
         kPaper,
         "Figure 1",
         words,
         row.printed_hz,
         bubble::bubble_oscillation(0.5 * row.diameter_m, {}, bubble::BubbleTheory::kPaper).damped_frequency_hz,
         row.reference_hz,
         "closed form",
         1e-10,
         row.rounding_hz / row.printed_hz,
         "rounding",
         false,
         {},
         {}});
  }
}

/// The printed formulas evaluated at r = 1 mm (tests/reference/bubble.json: rows[3], A_printed and D_leighton).
void appendix_a(std::vector<PaperNumber>& numbers) {
  const bubble::BubbleOscillation right = bubble::bubble_oscillation(1e-3);
  const auto add = [&](const char* id, const char* words, double printed, double ours, double reference,
                       double tolerance, const char* note) {
    numbers.push_back({std::string("hf.appendix.") + id,
                       kPaper,
                       "Appendix A",
                       words,
                       printed,
                       ours,
                       reference,
                       "closed form",
                       1e-8,
                       tolerance,
                       "exact",
                       true,
                       note,
                       {}});
  };
  add("thermal", "thermal damping at 1 mm, eq. 38", 0.021162153789660926, right.delta_thermal, 0.02623180572203411,
      0.01, "g = 9.8 and omega in psi, errata 23");
  add("decay", "decay [1/s] at 1 mm, eq. 37", 362.05718252320344, right.decay_per_s, 414.7093389027898, 0.01,
      "errata 23");
  add("frequency", "undamped frequency [Hz] at 1 mm, eq. 36", 3282.6832652910107, right.undamped_frequency_hz,
      3285.035288681046, 1e-4, "tension raises it, errata 24");
  // Where the soft attack of eq. 39 has risen to 1, in units of 1 / decay.
  double low = 0.0, high = 1.0;
  for (int i = 0; i < 60; ++i) {
    const double t = 0.5 * (low + high);
    (std::exp(-t) > bubble::kAttackFall ? low : high) = t;
  }
  numbers.push_back(itself({"hf.attack",
                            kPaper,
                            "Appendix A",
                            "length of the attack times the decay, eq. 39",
                            std::log(0.85),
                            low,
                            0.1625189294977749,
                            "closed form",
                            1e-10,
                            0.01,
                            "exact",
                            true,
                            "printed negative, errata 26",
                            {}}));
  const bubble::BubbleMedium m;
  const double g_thermal =
      3 * m.heat_capacity_ratio * m.static_pressure_pa / (4 * kPi * m.liquid_density_kg_m3 * m.gas_diffusivity_m2_s);
  numbers.push_back(itself({"hf.table3.g_th",
                            kPaper,
                            "Table 3",
                            "thermal damping constant [1/s] from the table's other constants",
                            1.60e6,
                            g_thermal,
                            1595918.3166093882,
                            "closed form",
                            1e-10,
                            0.005 / 1.6,
                            "rounding",
                            false,
                            "printed in s/m",
                            {}}));
}

void table_1(std::vector<PaperNumber>& numbers) {
  const acoustics::Medium water{1000.0, 1497.0}, air;
  numbers.push_back(elsewhere({"hf.index",
                               kPaper,
                               "Table 1",
                               "wavenumber in air over that in water",
                               4.4,
                               air.wavenumber_per_m(1000.0) / water.wavenumber_per_m(1000.0),
                               {},
                               {},
                               1e-6,
                               0.05 / 4.4,
                               "rounding",
                               false,
                               {},
                               {}}));
  struct Row {
    const char* name;
    double highest_hz, longest_m, fluid, air;
  };
  constexpr Row kRows[] = {{"Droplet", 4000, 0.18, 0.5, 2.1},
                           {"Splash", 6000, 0.50, 1.9, 8.4},
                           {"Pouring", 6000, 0.40, 1.2, 5.3},
                           {"Water Step", 5000, 1.20, 2.0, 8.7}};
  const Row& droplet = kRows[0];
  for (const bool in_air : {false, true}) {
    const double printed = in_air ? droplet.air : droplet.fluid;
    const double kl = (in_air ? air : water).wavenumber_per_m(droplet.highest_hz) * droplet.longest_m;
    numbers.push_back(
        elsewhere({std::string("hf.table1.droplet.kl.") + (in_air ? "air" : "fluid"),
                   kPaper,
                   "Table 1",
                   std::string("Droplet, max kL in ") + (in_air ? "air" : "water") + " for L = 18 cm, 4 kHz",
                   printed,
                   kl,
                   in_air ? 13.189193647723911 : 3.0219728932326664,
                   "2 pi f L over 343 and 1497 m/s",
                   1e-3,
                   0.05 / printed,
                   "rounding",
                   true,
                   "printed is L over the wavelength, 2 pi smaller",
                   {}}));
  }
  for (const Row& row : kRows) {
    numbers.push_back(elsewhere({std::string("hf.table1.ratio.") + row.name,
                                 kPaper,
                                 "Table 1",
                                 std::string(row.name) + ", max kL in air from that in water",
                                 row.air,
                                 row.fluid * water.sound_speed_m_s / air.sound_speed_m_s,
                                 {},
                                 {},
                                 1e-6,
                                 0.05 / row.fluid + 0.05 / row.air,
                                 "rounding",
                                 false,
                                 {},
                                 {}}));
  }
}

void table_2(std::vector<PaperNumber>& numbers) {
  struct Row {
    const char* name;
    double hours[4], percent[4];
    std::array<double, 4>
        quotient;  ///< of the hours, worked out by hand, where the printed percentage is another; else 0
  };
  constexpr Row kRows[] = {
      {"Droplet", {0.53, 1.08, 0.05, 0.004}, {32, 65, 3, 0.2}, {}},
      {"Splash", {0.91, 2.38, 0.12, 0.009}, {26, 68, 6, 0.3}, {0, 69.61099736765136, 3.5097981866042702, 0}},
      {"Pouring", {2.57, 4.34, 1.86, 0.044}, {29, 49, 21, 0.5}, {}},
      {"Water Step", {2.85, 6.38, 4.21, 0.054}, {21, 47, 31, 0.4}, {}}};
  const char* columns[] = {"fluid", "level set", "radiation", "synthesis"};
  // Half of the last digits printed: of the hours and of the percentages.
  constexpr std::array<double, 4> kHours{0.005, 0.005, 0.005, 0.0005}, kPercent{0.5, 0.5, 0.5, 0.05};
  for (const Row& row : kRows) {
    double sum = 0.0;
    for (const double h : row.hours) sum += h;
    for (std::size_t c = 0; c < 4; ++c) {
      const double share = row.hours[c] / sum;
      double of_hours = kHours[c] * (1.0 - share);  // of the share times the sum
      for (std::size_t k = 0; k < 4; ++k) of_hours += k == c ? 0.0 : kHours[k] * share;
      const bool off = row.quotient[c] > 0.0;
      PaperNumber number{std::string("hf.table2.") + row.name + "." + columns[c],
                         kPaper,
                         "Table 2",
                         std::string(row.name) + ", share of " + columns[c] + " [%] from the hours",
                         row.percent[c],
                         100.0 * share,
                         {},
                         {},
                         1e-6,
                         (kPercent[c] + 100.0 * of_hours / sum) / row.percent[c],
                         "rounding",
                         off,
                         off ? "does not follow from the row's hours" : "",
                         {}};
      if (off) number = held(std::move(number), row.quotient[c], "the quotient");
      numbers.push_back(itself(std::move(number)));
    }
  }
}

}  // namespace

std::vector<PaperNumber> harmonic_fluid_numbers(Monitor&) {
  std::vector<PaperNumber> numbers;
  figure_1(numbers);
  table_1(numbers);
  table_2(numbers);
  appendix_a(numbers);
  return numbers;
}

}  // namespace klang::validate::detail
