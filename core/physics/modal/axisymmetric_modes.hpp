#pragma once
#include <memory>
#include <vector>

#include "core/physics/modal/eigen_solver.hpp"
#include "core/physics/solid/axisymmetric.hpp"

namespace klang::modal {

/// Elastic modes of one harmonic, in order of frequency.
struct HarmonicModes {
  Eigen::VectorXd angular_frequency_sq;  ///< n
  Eigen::MatrixXd vectors;               ///< n_dofs x n, M-orthonormal with the material's density
  Eigen::VectorXd relative_residual;     ///< as in EigenResult
};

/// A free body of revolution as one system for each harmonic: torsion, m = 0, 1, 2, ... as many as needed. The angle is
/// exact and the section's elements are of high degree, so that thin walls, which straight tetrahedra resolve slowly, cost
/// a few thousand unknowns. Every count of modes is a Sturm count.
class AxisymmetricBody {
 public:
  explicit AxisymmetricBody(mesh::Section section);
  const mesh::Section& section() const { return section_; }
  double volume_m3() const { return volume_m3_; }
  std::size_t n_systems() const { return systems_.size(); }
  const solid::HarmonicSystem& system(std::size_t i) const { return systems_[i]; }

  /// All elastic modes up to high_hz, a set for each system; systems are added until three harmonics in a row, none below
  /// harmonic 4, have no mode there. @throws NumericalError when an iteration does not converge or disagrees with its count
  std::vector<HarmonicModes> modes_up_to(const solid::Material& material, double high_hz);
  /// The lowest counts[i] elastic modes of each system.
  std::vector<HarmonicModes> lowest(const solid::Material& material, const std::vector<int>& counts) const;
  /// Adds systems until there are n.
  void extend(std::size_t n);

 private:
  mesh::Section section_;
  double volume_m3_ = 0.0;
  std::vector<solid::HarmonicSystem> systems_;
};

/// The modes as a ModalModel on the nodes of a tetrahedral mesh of the same body: frequencies of the section, shapes
/// sampled from it (mass-normalised over the exact body), both members of each pair.
struct SampledModes {
  ModalModel model;
  std::vector<int> system;  ///< which system each mode is of
  std::vector<int> index;   ///< and its number there
  Eigen::VectorXd relative_residual;
};
SampledModes sample_modes(const AxisymmetricBody& body, const std::vector<HarmonicModes>& modes,
                          const mesh::TetMesh& mesh, const solid::Material& material);

}  // namespace klang::modal
