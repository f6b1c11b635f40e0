#pragma once
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "core/foundation/base/monitor.hpp"
#include "core/foundation/config/fields.hpp"
#include "core/geometry/shapes/section.hpp"
#include "core/physics/modal/box_modes.hpp"
#include "core/physics/modal/eigen_solver.hpp"
#include "fit/elastic/spectrum_model.hpp"
#include "fit/specimen/specimen.hpp"

namespace klang::fit {

namespace detail {
class ElasticBlocks;
}

/// A specimen as finite elements.
struct SpecimenBody {
  mesh::TetMesh mesh;
  std::optional<mesh::ShapeDivisions> divisions;  ///< of an analytic shape
  std::optional<mesh::SectionDivisions> section;  ///< of a free body of revolution: frequencies come from its section
  std::optional<modal::BoxDegrees>
      polynomials;                           ///< of a box, free or held at a face: frequencies come from polynomials
  std::map<std::string, double> shape_dims;  ///< what it was meshed with
  double volume_m3 = 0.0;
  double mass_kg = 0.0;
  solid::Material material;        ///< the start, with the density that the mass gives
  std::vector<std::string> notes;  ///< of a body from a file: what was mended
};

/// Meshes or loads the specimen. highest_hz: the highest frequency that its mesh has to carry.
SpecimenBody make_body(const Specimen& specimen, const solid::Material& material, double highest_hz);
/// As make_body with the divisions of another body of the same specimen (an analytic shape), whose dimensions have changed.
SpecimenBody make_body_like(const Specimen& specimen, const solid::Material& material, const SpecimenBody& like);

/// The lowest eigenvalues of a body without further large solves, for any Lame pair and a few dimensions. The matrices of
/// the nominal mesh, and of meshes with the same topology and one dimension changed by +-step, are projected onto one
/// basis: the modes at two Poisson's ratios and those of the changed shapes. Between the shapes each projected matrix is
/// the parabola in ln(dimension) through its three values. Eigenvalue errors are of second order in what the basis lacks;
/// derivatives are exact for the projected model, d(omega^2) = u^T (dK - omega^2 dM) u, and in a cluster of equal
/// eigenvalues those of its mean. Harmonics of a body of revolution are projected one by one, so that their modes keep
/// their numbers where they cross.
struct ReducedSpectrumOptions {
  Band band;
  int count = 0;
  int max_count = 80;
  int min_count = 0;
  double relative_step = 0.01;
  bool vary_ratio = true;
  bool watch_given = false;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"band.low_hz", "Modes below are left out", at_least(0.0)}, self.band.low_hz);
    visit({"band.high_hz", "Modes are wanted up to here", above(0.0)}, self.band.high_hz);
    visit({"count", "Modes; 0: as many as reach band.high_hz, at most max_count", at_least(0.0)}, self.count);
    visit({"max_count", "Of tetrahedra's modes; a section gives four times as many", at_least(1.0)}, self.max_count);
    visit({"min_count", "Modes that are wanted whatever the band", at_least(0.0)}, self.min_count);
    visit({"relative_step", "Of dimensions, for their derivatives", inside(0.0, 0.1)}, self.relative_step);
    visit({"watch_given", "Slopes by the dimensions that are not free too"}, self.watch_given);
    visit({"vary_ratio", "Poisson's ratio may change; otherwise a solve is saved"}, self.vary_ratio);
  }
};

class ReducedSpectrum : public SpectrumModel {
 public:
  ReducedSpectrum(const Specimen& specimen, const SpecimenBody& body, const std::vector<std::string>& free_dimensions,
                  const ReducedSpectrumOptions& options, Monitor& monitor = silent_monitor());
  Eigen::Index n_modes() const override { return n_modes_; }
  Spectrum spectrum(const SpectrumPoint& point) const override;
  Eigen::VectorXd visibility() const override { return visibility_; }
  Eigen::VectorXd relative_error() const override { return relative_error_; }
  std::vector<std::string> given_dimensions() const override { return given_names_; }
  Eigen::MatrixXd given_slopes(const SpectrumPoint& point) const override;
  bool mass_is_given() const override { return mass_kg_.has_value(); }
  /// The full solve at the start, modes below the band left out.
  const modal::EigenResult& nominal() const { return nominal_; }
  int n_skipped() const { return n_skipped_; }  ///< elastic modes below the band

 private:
  struct Matrices {
    Eigen::MatrixXd stiffness_lambda, stiffness_mu, mass;
  };
  struct Axis {
    double start_m = 0.0, step = 0.0;                   // step of ln(dimension)
    std::vector<Matrices> slope, curvature;             // of each block by ln(dimension), halves included
    double volume_slope = 0.0, volume_curvature = 0.0;  // of ln(volume)
    void add_block(const Matrices& low, const Matrices& centre, const Matrices& high);
  };
  /// What a block's matrices are projected onto, and the correction of its mesh errors there.
  struct Projection {
    Eigen::MatrixXd basis, softer;
    Matrices matrices(const detail::ElasticBlocks& from, std::size_t block) const;
  };
  using BlockVectors = std::vector<std::vector<Eigen::MatrixXd>>;  // of each material or shape, by block
  static Projection projection(const detail::ElasticBlocks& system, std::size_t block, Eigen::Index n_modes,
                               const BlockVectors& vectors, const Eigen::MatrixXd& rigid,
                               const std::vector<Eigen::VectorXd>& correction);
  struct Block {
    int multiplicity = 1;
    Eigen::Index n_modes = 0;
    Eigen::Index n_rigid = 0;  // eigenvalues below the modes: rigid motions in the basis
    Matrices centre;
  };
  /// Meshes with one dimension changed down and up.
  struct Changed {
    std::vector<SpecimenBody> bodies;
    std::vector<std::unique_ptr<detail::ElasticBlocks>> blocks;  // they keep references to the bodies
  };
  Changed changed_about(const Specimen& specimen, const SpecimenBody& body, const std::vector<std::string>& dimensions,
                        const ReducedSpectrumOptions& options, Monitor& monitor, std::vector<Axis>& axes) const;
  Matrices matrices_at(const SpectrumPoint& point, std::size_t block) const;
  std::vector<Eigen::Index> order_at_start(const solid::Material& material) const;
  double log_volume(const SpectrumPoint& point, Eigen::VectorXd* gradient) const;
  double density_kg_m3(const SpectrumPoint& point) const;  // the material's, or mass over volume

  int n_modes_ = 0, n_skipped_ = 0;
  std::optional<double> mass_kg_;
  std::vector<Block> blocks_;
  std::size_t n_blocks_ = 0;
  std::vector<Eigen::Index> order_;  // of the blocks' modes one after the other, by frequency at the start
  double log_volume_ = 0.0;
  std::vector<Axis> axes_, given_;  // free dimensions; those that are given, about which slopes alone are right
  std::vector<std::string> given_names_;
  modal::EigenResult nominal_;
  Eigen::VectorXd visibility_, relative_error_;
};

/// Surface motion of each mode relative to the most visible one.
Eigen::VectorXd mode_visibility(const modal::ModalModel& model);

}  // namespace klang::fit
