#pragma once
#include <array>
#include <filesystem>
#include <optional>
#include <vector>

#include "core/foundation/config/result_header.hpp"
#include "core/physics/fracture/dynamic/plasticity.hpp"

/// One element driven through deformations that are given: `klang stress --history`.
namespace klang::fracture {

/// A deformation gradient by rows: f11, f12, f13, f21, ... f33.
using Gradient = std::array<double, 9>;

/// B99's strain F^T F - I.
Sym doubled_green_strain(const Gradient& f);

/// Columns f11 ... f33 by their names, in any order; others are passed over.
/// @throws InputError with file and line: a column missing, no number, an inverted element (det F <= 0), no rows
std::vector<Gradient> read_gradients(const std::filesystem::path& csv);

struct HistoryState {
  std::array<double, 6> pk2_pa{}, plastic_strain{};
  double elastic_energy_j_m3 = 0.0, dissipated_j_m3 = 0.0;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"pk2_pa", "second Piola-Kirchhoff stress xx, yy, zz, xy, yz, zx"}, self.pk2_pa);
    visit({"plastic_strain", "Green's, half of D02's eps_p; same order"}, self.plastic_strain);
    visit({"elastic_energy_j_m3", "per rest volume"}, self.elastic_energy_j_m3);
    visit({"dissipated_j_m3", "by plastic flow since the start"}, self.dissipated_j_m3);
  }
};

struct HistoryDocument {
  ResultHeader header;
  std::optional<double> gamma1, gamma2, yield_stress_pa, plastic_strain_limit;
  double max_plastic_strain = 0.0;
  std::vector<HistoryState> states;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    ResultHeader::describe(self.header, visit);
    visit({"gamma1", "D02's threshold of flow, doubled strain; null: elastic"}, self.gamma1);
    visit({"gamma2", "D02's limit of plastic strain, doubled; null: elastic"}, self.gamma2);
    visit({"yield_stress_pa", "of von Mises that gamma1 is, sqrt(3/2) mu gamma1"}, self.yield_stress_pa);
    visit({"plastic_strain_limit", "norm of Green's plastic strain, gamma2 / 2"}, self.plastic_strain_limit);
    visit({"max_plastic_strain", "largest norm of Green's plastic strain in the history"}, self.max_plastic_strain);
    visit({"states", "one per row of the history"}, self.states);
  }
};

/// Drives one StVK element, at rest and without plastic strain before the first row.
HistoryDocument strain_history(const std::vector<Gradient>& gradients, const solid::Material& material,
                               const Plasticity& plasticity);

}  // namespace klang::fracture
