#include "core/physics/solid/material_range.hpp"
#include "fit/judge/detail/reasons.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace klang::fit::detail {
namespace {

constexpr double kGuessFactor = 1.4;  // a guess further off than this was hardly meant
constexpr double kWildGuessFactor = 2.2;
constexpr double kFarBeyond = 0.15;  // relative, beyond a range's end: no grade of the material
constexpr double kPoissonFarBeyond = 0.06;

struct Quantity {
  const char* name;
  const char* words;
  const char* unit;
  double scale;
  std::array<double, 2> range;
};

const FitParameter* determined(const JudgeInput& input, const std::string& name) {
  for (const FitParameter& parameter : input.parameters) {
    const bool same = parameter.name == name || (name == "lame_mu_pa" && parameter.name == "shear_modulus_pa");
    if (same && parameter.std && (parameter.identifiable || parameter.ci95)) return &parameter;
  }
  return nullptr;
}

/// "height_m 8.01 mm instead of 6" for those dimensions whose error could have done it, at most three.
std::string dimensions_instead(const JudgeInput& input, double wanted_ratio) {
  const std::vector<double> powers = stiffness_powers(input.residuals);
  struct Way {
    double change = 0.0;
    std::string text;
  };
  std::vector<Way> ways;
  for (std::size_t d = 0; d < powers.size(); ++d) {
    if (std::abs(powers[d]) < 0.5 || input.residuals.given[d].kind != GivenKind::kDimension) continue;
    const GivenValue& dimension = input.residuals.given[d];
    const double change = std::log(wanted_ratio) / powers[d];
    if (std::abs(change) > 1.0) continue;
    const bool mm = dimension.value < 1.0;
    ways.push_back({std::abs(change),
                    dimension.name + " " + shown("%.4g", (mm ? 1e3 : 1.0) * dimension.value * std::exp(change)) +
                        (mm ? " mm" : " m") + " instead of " + shown("%.4g", (mm ? 1e3 : 1.0) * dimension.value) +
                        " (E goes with its power " + shown("%.2g", powers[d]) + ")"});
  }
  std::stable_sort(ways.begin(), ways.end(), [](const Way& a, const Way& b) { return a.change < b.change; });
  std::string text;
  for (std::size_t i = 0; i < std::min<std::size_t>(3, ways.size()); ++i) text += (i ? ", or " : "") + ways[i].text;
  return text;
}

void hold_against_range(const JudgeInput& input, const Quantity& q, double value, double std,
                        const std::string& specimen, std::vector<Reason>& reasons) {
  const double low = q.range[0], high = q.range[1];
  const double beyond = value > high ? value - high : low - value;
  if (!(beyond > 2.0 * std) || !(beyond > 0.0)) return;
  const bool poisson = std::string_view(q.name) == "poissons_ratio";
  const bool far = poisson ? beyond > kPoissonFarBeyond : beyond > kFarBeyond * (value > high ? high : low);
  Reason reason{ReasonKind::kMaterialRange,
                far ? Verdict::kContradicted : Verdict::kDoubtful,
                specimen,
                q.name,
                "",
                value,
                low,
                high};
  reason.text = std::string(q.words) + " = " + shown("%.4g", value / q.scale) + q.unit + " is no " + input.start.name +
                ", which has " + shown("%.4g", low / q.scale) + " to " + shown("%.4g", high / q.scale) + q.unit;
  if (std::string_view(q.name) == "youngs_modulus_pa") {
    const std::string ways = dimensions_instead(input, 0.5 * (low + high) / value);
    if (!ways.empty()) reason.text += "; it would be with " + ways;
  }
  if (std::string_view(q.name) == "density_kg_m3")
    reason.text += ": by mass and dimensions, one of which may be mistaken";
  reasons.push_back(std::move(reason));
}

void hold_against_preset(const JudgeInput& input, const solid::MaterialRange& range, std::vector<Reason>& reasons) {
  const Quantity young{"youngs_modulus_pa", "E", " GPa", 1e9, range.youngs_modulus_pa};
  const Quantity poisson{"poissons_ratio", "Poisson's ratio", "", 1.0, range.poissons_ratio};
  const Quantity density{"density_kg_m3", "the density", " kg/m3", 1.0, range.density_kg_m3};
  for (const Quantity& q : {young, poisson}) {
    if (const FitParameter* p = determined(input, q.name)) hold_against_range(input, q, p->value, *p->std, "", reasons);
  }
  for (const JudgedSpecimen& specimen : input.specimens) {
    if (specimen.density_kg_m3)
      hold_against_range(input, density, *specimen.density_kg_m3, 0.0, specimen.name, reasons);
  }
}

/// A material of one's own: within what the guess said, and what solids are.
void hold_against_guess(const JudgeInput& input, std::vector<Reason>& reasons) {
  if (const FitParameter* young = determined(input, "youngs_modulus_pa")) {
    const double factor = young->value / input.start.youngs_modulus_pa();
    const double off = std::max(factor, 1.0 / factor);
    if (off > kGuessFactor) {
      Reason reason{ReasonKind::kGuess,
                    off > kWildGuessFactor ? Verdict::kContradicted : Verdict::kDoubtful,
                    "",
                    "youngs_modulus_pa",
                    "",
                    young->value,
                    input.start.youngs_modulus_pa() / kGuessFactor,
                    input.start.youngs_modulus_pa() * kGuessFactor};
      reason.text = "E = " + shown("%.4g GPa", young->value / 1e9) + " is " + shown("%.2f", factor) +
                    " times the guess of " + shown("%.4g GPa", input.start.youngs_modulus_pa() / 1e9);
      const std::string ways = dimensions_instead(input, 1.0 / factor);
      if (!ways.empty()) reason.text += "; the guess would be right with " + ways;
      reasons.push_back(std::move(reason));
    }
  }
  if (const FitParameter* poisson = determined(input, "poissons_ratio")) {
    const double off = std::abs(poisson->value - input.start.poissons_ratio()) - 2.0 * *poisson->std;
    if (off > 0.1)
      reasons.push_back({ReasonKind::kGuess, Verdict::kDoubtful, "", "poissons_ratio",
                         "Poisson's ratio = " + shown("%.3f", poisson->value) + " lies far from the guess of " +
                             shown("%.3f", input.start.poissons_ratio()),
                         poisson->value, input.start.poissons_ratio() - 0.1, input.start.poissons_ratio() + 0.1});
    if (poisson->value + 2.0 * *poisson->std < 0.08 || poisson->value - 2.0 * *poisson->std > 0.46)
      reasons.push_back({ReasonKind::kMaterialRange, Verdict::kDoubtful, "", "poissons_ratio",
                         "Poisson's ratio = " + shown("%.3f", poisson->value) + " is that of hardly any solid",
                         poisson->value, 0.08, 0.46});
  }
  for (const JudgedSpecimen& specimen : input.specimens) {
    if (!specimen.density_kg_m3) continue;
    const double density = *specimen.density_kg_m3, speed = std::sqrt(input.found.youngs_modulus_pa() / density);
    if (density >= 100.0 && density <= 23000.0 && speed >= 700.0 && speed <= 13000.0) continue;
    reasons.push_back({ReasonKind::kUnits, Verdict::kContradicted, specimen.name, "density_kg_m3",
                       "a density of " + shown("%.4g", density) +
                           " kg/m3 with E = " + shown("%.3g", input.found.youngs_modulus_pa() / 1e9) +
                           " GPa is no known solid: are mass and "
                           "dimensions in kg and m?",
                       density, 100.0, 23000.0});
  }
}

/// A guess that is a known material's: some known material has what was found and the density, which was given, or follows from
/// the mass (and is then as unsure as the dimensions).
void hold_against_all(const JudgeInput& input, std::vector<Reason>& reasons) {
  const bool given = input.start.density_kg_m3 > 0.0;
  const double slack = given ? 0.03 : 0.08;
  const double poisson = input.start.poissons_ratio(), young = input.found.youngs_modulus_pa();
  for (const JudgedSpecimen& specimen : input.specimens) {
    if (!specimen.density_kg_m3) continue;
    const double density = *specimen.density_kg_m3;
    bool guess_is_known = false, found_is_known = false;
    std::string nearest;
    for (const std::string& name : solid::material_preset_names()) {
      const auto range = solid::material_range(name);
      if (!range) continue;
      const auto in = [](double value, const std::array<double, 2>& r, double beyond) {
        return value >= r[0] / (1.0 + beyond) && value <= r[1] * (1.0 + beyond);
      };
      if (in(input.start.youngs_modulus_pa(), range->youngs_modulus_pa, 0.05) &&
          in(poisson, range->poissons_ratio, 0.08) && (!given || in(density, range->density_kg_m3, 0.02))) {
        guess_is_known = true;
        nearest += (nearest.empty() ? "" : ", ") + name;
      }
      found_is_known =
          found_is_known || (in(young, range->youngs_modulus_pa, slack) && in(density, range->density_kg_m3, 0.02));
    }
    if (!guess_is_known || found_is_known) continue;
    reasons.push_back({ReasonKind::kMaterialRange,
                       Verdict::kDoubtful,
                       specimen.name,
                       "density_kg_m3",
                       "E = " + shown("%.4g", young / 1e9) + " GPa at " + shown("%.4g", density) + " kg/m3 " +
                           (given ? "" : "(by mass and dimensions) ") + "is no known material; the guess is that of " +
                           nearest + (given ? ": are all dimensions too large or too small?" : ""),
                       density,
                       {},
                       {}});
  }
}

}  // namespace

void judge_material(const JudgeInput& input, std::vector<Reason>& reasons) {
  if (const auto range = solid::material_range(input.start.name)) {
    hold_against_preset(input, *range, reasons);
  } else if (!input.start.name.starts_with("s02_")) {
    hold_against_guess(input, reasons);
    hold_against_all(input, reasons);
  }
}

}  // namespace klang::fit::detail
