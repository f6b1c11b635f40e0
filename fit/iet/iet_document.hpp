#pragma once
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "core/foundation/config/result_header.hpp"

/// iet.json of `klang iet`: specimens by impulse excitation, by the standard's closed forms and by the full model.
namespace klang::fit {

enum class IetShape { kBar, kRod, kDisc };
constexpr auto words_of(IetShape) {
  return std::array{Word{IetShape::kBar, "bar"}, Word{IetShape::kRod, "rod"}, Word{IetShape::kDisc, "disc"}};
}

/// A line of the specimens' file.
struct IetSpecimen {
  std::string specimen;
  IetShape shape = IetShape::kBar;
  std::optional<double> length_m, width_m, thickness_m, diameter_m;
  double mass_kg = 0.0;
  std::string recording;  ///< relative to the file's folder
  std::string operator_name, date, support, device;
  std::optional<double> temperature_c;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit(needed({"specimen", "its name"}), self.specimen);
    visit(needed({"shape", "bar (length, width, thickness), rod (length, diameter) or disc (diameter, thickness)"}),
          self.shape);
    visit({"length_m", "of a bar or rod", inside(0.0, 100.0)}, self.length_m);
    visit({"width_m", "of a bar", inside(0.0, 100.0)}, self.width_m);
    visit({"thickness_m", "of a bar or disc: the direction of the blow", inside(0.0, 100.0)}, self.thickness_m);
    visit({"diameter_m", "of a rod or disc", inside(0.0, 100.0)}, self.diameter_m);
    visit(needed({"mass_kg", "weighed", inside(0.0, 1e5)}), self.mass_kg);
    visit(needed({"recording", "sound file, relative to this file's folder"}), self.recording);
    visit({"operator", "who measured"}, self.operator_name);
    visit({"date", "of the measurement"}, self.date);
    visit({"temperature_c", "of the specimen", between(-273.15, 3000.0)}, self.temperature_c);
    visit({"support", "what it lay on"}, self.support);
    visit({"device", "microphone or instrument"}, self.device);
  }
};

/// What was found of one specimen.
struct IetRow {
  IetSpecimen given;
  std::optional<double> flexural_hz, torsional_hz, second_hz;
  std::optional<double> e_e1876_pa, g_e1876_pa, nu_e1876, e_model_pa, g_model_pa, nu_model;
  std::optional<double> difference_percent;
  std::optional<double> q_inverse_flexural, density_kg_m3, explained_share;
  bool nu_assumed = false, outlier = false, implausible = false;
  /// Part of the summary.
  bool counts() const { return !outlier && !implausible; }

  std::string remark;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    IetSpecimen::describe(self.given, visit);
    visit({"flexural_hz", "first flexural frequency; of a disc the first natural one (two nodal diameters)"},
          self.flexural_hz);
    visit({"torsional_hz", "first torsional frequency of a bar or rod"}, self.torsional_hz);
    visit({"second_hz", "second natural frequency of a disc (one nodal circle)"}, self.second_hz);
    visit({"e_e1876_pa", "Young's modulus by the closed form of ASTM E1876"}, self.e_e1876_pa);
    visit({"g_e1876_pa", "shear modulus by the closed form"}, self.g_e1876_pa);
    visit({"nu_e1876", "Poisson's ratio of these two"}, self.nu_e1876);
    visit({"e_model_pa", "Young's modulus by the full three-dimensional model"}, self.e_model_pa);
    visit({"g_model_pa", "shear modulus by the full model"}, self.g_model_pa);
    visit({"nu_model", "Poisson's ratio of these two"}, self.nu_model);
    visit({"difference_percent", "of E: closed form over full model"}, self.difference_percent);
    visit({"q_inverse_flexural", "damping: decay / (pi f) of the flexural partial"}, self.q_inverse_flexural);
    visit({"density_kg_m3", "mass over volume"}, self.density_kg_m3);
    visit({"explained_share", "of the partials' strength: those that are modes of this body, 0 to 1"},
          self.explained_share);
    visit({"nu_assumed", "no second frequency was found: 0.3 is assumed for the closed form"}, self.nu_assumed);
    visit({"outlier", "modified z-score of E or G above 3.5: left out of the summary"}, self.outlier);
    visit({"implausible",
           "Poisson's ratio or stiffness of no solid, or closed form and model more than 5 % apart: left out of the "
           "summary"},
          self.implausible);
    visit({"remark", "empty, or what is doubtful"}, self.remark);
  }
};

struct IetSummary {
  IetShape shape = IetShape::kBar;
  std::string quantity;
  double mean = 0.0;
  std::optional<double> std;
  int n = 0;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"shape", "of these specimens"}, self.shape);
    visit({"quantity", "a column of iet.csv"}, self.quantity);
    visit({"mean", "without outliers and what is implausible"}, self.mean);
    visit({"std", "standard deviation of one specimen, n - 1 in the divisor; null for one"}, self.std);
    visit({"n", "specimens"}, self.n);
  }
};

struct IetDocument {
  ResultHeader header;
  std::string name;
  std::vector<IetRow> specimens;
  std::vector<IetSummary> summary;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    ResultHeader::describe(self.header, visit);
    visit({"name", "of the specimens' file"}, self.name);
    visit({"specimens", "as in the file"}, self.specimens);
    visit({"summary", "mean and standard deviation by shape, without outliers and what is implausible"}, self.summary);
  }
};

}  // namespace klang::fit
