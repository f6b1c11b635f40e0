#include "core/physics/modal/revolution_modes.hpp"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/stopwatch.hpp"

namespace klang::modal {
namespace {

constexpr double kLeftOfLowerDegree = 0.1;  // of the difference to elements one degree lower

/// Modes from low_hz to high_hz, members of pairs each.
int count_in(const AxisymmetricBody& body, const std::vector<HarmonicModes>& modes, double low_hz) {
  const double lowest = std::pow(2.0 * kPi * low_hz, 2);
  int n = 0;
  for (std::size_t s = 0; s < modes.size(); ++s)
    n += body.system(s).multiplicity * static_cast<int>((modes[s].angular_frequency_sq.array() >= lowest).count());
  return n;
}

/// Where to look first for the lowest modes: a free beam's first bending frequency, and no more than the first shear wave.
double first_guess_hz(const mesh::ShapeSpec& shape, const solid::Material& material, const mesh::Section& section) {
  const double size_m = (section.nodes_m.colwise().maxCoeff() - section.nodes_m.colwise().minCoeff()).norm();
  const double shear_hz = std::sqrt(material.lame_mu_pa / material.density_kg_m3) / (2.0 * size_m);
  return std::min(shear_hz, 20.0 * shear_hz * mesh::section_thickness_m(shape) / size_m);
}

}  // namespace

mesh::SectionDivisions section_divisions_for(const mesh::ShapeSpec& shape, const solid::Material& material,
                                             double highest_hz) {
  const double omega = 2.0 * kPi * highest_hz, ratio = material.poissons_ratio();
  const double plate = material.youngs_modulus_pa() / (12.0 * material.density_kg_m3 * (1.0 - ratio * ratio));
  const double bending_m = 2.0 * kPi * std::pow(plate * std::pow(mesh::section_thickness_m(shape) / omega, 2), 0.25);
  const double shear_m = 0.9 * 2.0 * kPi * std::sqrt(material.lame_mu_pa / material.density_kg_m3) / omega;
  return mesh::section_divisions(shape, 0.8 * std::min(bending_m, shear_m));
}

Eigen::VectorXd section_mesh_error(const mesh::ShapeSpec& shape, const mesh::SectionDivisions& divisions,
                                   const solid::Material& material, const std::vector<HarmonicModes>& modes,
                                   const SampledModes& sampled, Eigen::Index n) {
  mesh::SectionDivisions lower = divisions;
  --lower.degree;
  AxisymmetricBody coarse(mesh::mesh_section(shape, lower));
  coarse.extend(modes.size());
  std::vector<int> counts;
  for (const auto& harmonic : modes) counts.push_back(static_cast<int>(harmonic.angular_frequency_sq.size()));
  const auto other = coarse.lowest(material, counts);
  Eigen::VectorXd error(n);
  for (Eigen::Index k = 0; k < n; ++k) {
    const auto s = static_cast<std::size_t>(sampled.system[static_cast<std::size_t>(k)]);
    const int i = sampled.index[static_cast<std::size_t>(k)];
    error[k] = kLeftOfLowerDegree * 0.5 *
               std::abs(std::log(other[s].angular_frequency_sq[i] / modes[s].angular_frequency_sq[i]));
  }
  return error;
}

EigenResult solve_revolution_modes(const mesh::ShapeSpec& shape, const mesh::TetMesh& mesh,
                                   const solid::Material& material, const EigenOptions& options, Monitor& monitor) {
  options.validate();
  const Stopwatch total;
  EigenResult result;
  result.method_used = EigenMethod::kHarmonics;
  result.n_rigid_modes = 6;
  double high_hz = options.band.high_hz;
  if (options.count > 0) {  // a band may then be open to infinity
    const mesh::SectionDivisions coarse = mesh::section_divisions(shape, mesh::section_thickness_m(shape));
    high_hz = std::max(first_guess_hz(shape, material, mesh::mesh_section(shape, coarse)), options.band.low_hz);
  }
  mesh::SectionDivisions divisions;
  std::vector<HarmonicModes> modes;
  std::optional<AxisymmetricBody> body;
  for (;; high_hz *= 2.0) {
    monitor.throw_if_stopped();
    monitor.progress("modes", 0.0);
    divisions = section_divisions_for(shape, material, high_hz);
    body.emplace(mesh::mesh_section(shape, divisions));
    modes = body->modes_up_to(material, high_hz);
    if (options.count == 0 || count_in(*body, modes, options.band.low_hz) >= options.count) break;
  }
  result.wall_time_s["iterate"] = total.seconds();

  // Only what is asked for is sampled.
  std::vector<double> omega_sq;
  for (std::size_t s = 0; s < modes.size(); ++s)
    for (const double value : modes[s].angular_frequency_sq)
      omega_sq.insert(omega_sq.end(), static_cast<std::size_t>(body->system(s).multiplicity), value);
  std::sort(omega_sq.begin(), omega_sq.end());
  const auto below = std::lower_bound(omega_sq.begin(), omega_sq.end(), std::pow(2.0 * kPi * options.band.low_hz, 2)) -
                     omega_sq.begin();
  const auto n_all = static_cast<std::ptrdiff_t>(omega_sq.size());
  const auto wanted = options.count > 0  ? below + options.count
                      : options.most > 0 ? std::min(below + options.most, n_all)
                                         : n_all;
  result.n_below_band = static_cast<int>(below);
  if (options.count == 0) result.n_left_out = static_cast<int>(n_all - wanted);
  const auto n = static_cast<Eigen::Index>(wanted - below);
  result.sturm_count = static_cast<long>(omega_sq.size()) + result.n_rigid_modes;
  result.none_missing = true;
  const double last = wanted > 0 ? omega_sq[static_cast<std::size_t>(wanted - 1)] : 0.0;
  for (auto& harmonic : modes) {
    const auto kept = (harmonic.angular_frequency_sq.array() <= last * (1.0 + 1e-12)).count();
    harmonic.angular_frequency_sq.conservativeResize(kept);
    harmonic.vectors.conservativeResize(Eigen::NoChange, kept);
  }
  Stopwatch watch;
  SampledModes sampled = sample_modes(*body, modes, mesh, material);
  result.wall_time_s["sample"] = watch.seconds();
  if (options.estimate_mesh_error) {
    monitor.throw_if_stopped();
    watch.restart();
    result.mesh_relative_error = section_mesh_error(shape, divisions, material, modes, sampled, wanted).tail(n);
    result.wall_time_s["mesh_error"] = watch.seconds();
  }
  result.model = std::move(sampled.model);
  result.model.angular_frequency_rad_s = result.model.angular_frequency_rad_s.segment(below, n).eval();
  result.model.shapes = result.model.shapes.middleCols(below, n).eval();
  result.relative_residual = sampled.relative_residual.segment(below, n);
  result.status = EigenStatus::kConverged;
  result.wall_time_s["total"] = total.seconds();
  return result;
}

}  // namespace klang::modal
