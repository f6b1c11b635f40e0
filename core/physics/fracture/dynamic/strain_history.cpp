#include "core/physics/fracture/dynamic/strain_history.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/config/csv.hpp"

namespace klang::fracture {
namespace {

constexpr std::size_t kMostRows = 5'000'000;

double determinant(const Gradient& f) {
  return f[0] * (f[4] * f[8] - f[5] * f[7]) - f[1] * (f[3] * f[8] - f[5] * f[6]) + f[2] * (f[3] * f[7] - f[4] * f[6]);
}

std::array<std::size_t, 9> columns_of(const CsvFile& file) {
  std::array<std::size_t, 9> columns{};
  for (std::size_t i = 0; i < 9; ++i) {
    const std::string name = "f" + std::to_string(i / 3 + 1) + std::to_string(i % 3 + 1);
    const auto found = std::find(file.cells().begin(), file.cells().end(), name);
    if (found == file.cells().end())
      throw InputError(file.place(), "lacks a column", name, "f11,f12,f13,f21,f22,f23,f31,f32,f33");
    if (std::count(file.cells().begin(), file.cells().end(), name) > 1)
      throw InputError(file.place(), "has a column twice", name);
    columns[i] = static_cast<std::size_t>(found - file.cells().begin());
  }
  return columns;
}

}  // namespace

Sym doubled_green_strain(const Gradient& f) {
  const auto dot = [&](std::size_t a, std::size_t b) {
    return f[a] * f[b] + f[3 + a] * f[3 + b] + f[6 + a] * f[6 + b];
  };
  return {dot(0, 0) - 1.0, dot(1, 1) - 1.0, dot(2, 2) - 1.0, dot(0, 1), dot(1, 2), dot(2, 0)};
}

std::vector<Gradient> read_gradients(const std::filesystem::path& csv) {
  CsvFile file(csv);
  if (!file.next()) throw InputError(csv.string(), "is empty", "", "a head line and rows");
  const std::array<std::size_t, 9> columns = columns_of(file);
  const std::size_t n_columns = file.cells().size();
  std::vector<Gradient> gradients;
  while (file.next()) {
    if (file.cells().size() != n_columns)
      throw InputError(file.place(), "has another number of cells than the head", std::to_string(file.cells().size()),
                       std::to_string(n_columns));
    if (gradients.size() == kMostRows)
      throw InputError(file.place(), "has too many rows", "", std::to_string(kMostRows));
    Gradient f;
    for (std::size_t i = 0; i < 9; ++i) f[i] = csv_number(file.cells()[columns[i]], file.place());
    for (const double entry : f)
      if (!(std::abs(entry) <= 1e6)) throw InputError(file.place(), "is too large", to_text(entry), "-1e6 to 1e6");
    if (!(determinant(f) > 0.0))
      throw InputError(file.place(), "the element is inverted", "det F = " + to_text(determinant(f)), "det F > 0");
    gradients.push_back(f);
  }
  if (gradients.empty()) throw InputError(csv.string(), "has no rows", "", "at least one deformation gradient");
  return gradients;
}

HistoryDocument strain_history(const std::vector<Gradient>& gradients, const solid::Material& material,
                               const Plasticity& plasticity) {
  plasticity.validate();
  HistoryDocument document;
  if (plasticity.flows()) {
    document.gamma1 = plasticity.gamma1;
    document.gamma2 = plasticity.gamma2;
    document.yield_stress_pa = std::sqrt(1.5) * material.lame_mu_pa * plasticity.gamma1;
    document.plastic_strain_limit = plasticity.gamma2 / 2.0;
  }
  PlasticState state;
  for (const Gradient& f : gradients) {
    plastic_update(doubled_green_strain(f), material, plasticity, state);
    HistoryState row;
    for (std::size_t i = 0; i < 6; ++i) {
      row.pk2_pa[i] = state.stress[i] / 2.0;
      row.plastic_strain[i] = state.plastic_strain[i] / 2.0;
    }
    row.elastic_energy_j_m3 = state.elastic_energy_j_m3;
    row.dissipated_j_m3 = state.dissipated_j_m3;
    document.states.push_back(row);
    document.max_plastic_strain =
        std::max(document.max_plastic_strain, std::sqrt(inner(row.plastic_strain, row.plastic_strain)));
  }
  return document;
}

}  // namespace klang::fracture
