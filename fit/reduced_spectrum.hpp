#pragma once
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "core/base/monitor.hpp"
#include "core/mesh/shape.hpp"
#include "core/modal/reduced_model.hpp"
#include "fit/specimen.hpp"
#include "fit/spectrum_model.hpp"

namespace klang::fit {

/// A specimen as finite elements.
struct SpecimenBody {
  mesh::TetMesh mesh;
  std::optional<mesh::ShapeDivisions> divisions;  ///< of an analytic shape
  double volume_m3 = 0.0;
  double mass_kg = 0.0;
  solid::Material material;  ///< the start, with the density that the mass gives
};

/// Meshes or loads the specimen. highest_hz: the highest frequency that its mesh has to carry.
SpecimenBody make_body(const Specimen& specimen, const solid::Material& material, double highest_hz);
/// As make_body with the divisions of another mesh of the same specimen.
SpecimenBody make_body(const Specimen& specimen, const solid::Material& material,
                       const mesh::ShapeDivisions& divisions);

/// The body's spectrum through modal::reduce; without free dimensions.
class ReducedSpectrum : public SpectrumModel {
 public:
  ReducedSpectrum(modal::ReducedModel model, std::optional<double> fixed_density_kg_m3);
  Eigen::Index n_modes() const override { return model_.n_modes; }
  Spectrum spectrum(const SpectrumPoint& point) const override;
  Eigen::VectorXd visibility() const override { return visibility_; }
  double density_kg_m3(const SpectrumPoint& point) const override;
  const modal::EigenResult& nominal() const { return model_.nominal; }

 private:
  modal::ReducedModel model_;
  std::optional<double> fixed_density_;
  Eigen::VectorXd visibility_;
};

/// The spectrum of a shape whose dimensions vary. The matrices of the nominal mesh and of meshes with the same topology and
/// one dimension changed by +-step are projected onto one basis (modes of several Poisson's ratios and of the changed
/// shapes); between them each projected matrix is the parabola in ln(dimension) through its three values. Eigenvalue
/// derivatives are exact for that model: d(omega^2)/d(d) = u^T (K' - omega^2 M') u.
class ShapeSpectrum : public SpectrumModel {
 public:
  ShapeSpectrum(const Specimen& specimen, const SpecimenBody& body, const std::vector<std::string>& free_dimensions,
                int count, double low_hz, double relative_step = 0.01, Monitor& monitor = silent_monitor());
  Eigen::Index n_modes() const override { return n_modes_; }
  Spectrum spectrum(const SpectrumPoint& point) const override;
  Eigen::VectorXd visibility() const override { return visibility_; }
  double density_kg_m3(const SpectrumPoint& point) const override;
  const modal::EigenResult& nominal() const { return nominal_; }

 private:
  struct Matrices {
    Eigen::MatrixXd stiffness_lambda, stiffness_mu, mass;
    double log_volume = 0.0;
  };
  struct Axis {
    double start_m = 0.0, step = 0.0;   // step of ln(dimension)
    Matrices slope, curvature;          // by ln(dimension), halves included
  };
  double log_volume(const SpectrumPoint& point, Eigen::VectorXd* gradient) const;

  int n_modes_ = 0, n_skipped_ = 0;
  std::optional<double> mass_kg_;
  Matrices centre_;
  std::vector<Axis> axes_;
  modal::EigenResult nominal_;
  Eigen::VectorXd visibility_;
};

/// Surface motion of each mode relative to the most visible one.
Eigen::VectorXd mode_visibility(const modal::ModalModel& model);

}  // namespace klang::fit
