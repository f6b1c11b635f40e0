#pragma once
#include <Eigen/Core>
#include <array>
#include <optional>
#include <vector>

#include "core/geometry/shapes/shape.hpp"
#include "core/physics/modal/axisymmetric_modes.hpp"
#include "core/physics/modal/eigen_solver.hpp"

namespace klang::modal {

/// The faces of a box that are held: of axis d the lower one at [2 d], the upper one at [2 d + 1].
using HeldFaces = std::array<bool, 6>;

/// Which faces a support holds: none when it is free, one for "clamped:x=min" and the like; empty when it holds anything else.
std::optional<HeldFaces> held_faces(const solid::Support& support, const Eigen::Vector3d& half_lengths_m);

/// Highest degree of the polynomials along each axis, 2 to 60.
using BoxDegrees = std::array<int, 3>;

/// Degrees to begin with: they carry the shortest wave at highest_hz, a bending wave of the thinnest side or a shear wave.
BoxDegrees box_degrees(const Eigen::Vector3d& half_lengths_m, const solid::Material& material, double highest_hz);

/// A homogeneous isotropic box by the Rayleigh-Ritz method: the displacements are sums of products of Legendre polynomials, orthonormal
/// on the box, so that the mass matrix is volume / 8 times the unit matrix (unit density). Along an axis with a held face only the
/// polynomials that vanish there take part. Of the products those with (i/n_x)^2 + (j/n_y)^2 + (k/n_z)^2 <= 1 are kept (n: degrees), which of
/// all cuts tried gave a tile and a block their digits with the fewest unknowns.
/// Each motion is even or odd about the middle of every axis whose two faces are alike: up to eight systems that do not couple.
/// Eigenvalues are upper bounds that fall geometrically with the degrees; with a held face, along whose edges stress is singular,
/// by a power of them.
/// Source: Demarest 1971, J. Acoust. Soc. Am. 49, 768-775; Visscher, Migliori, Bell and Reinert 1991, ibid. 90, 2154-2162.
class BoxBody {
 public:
  /// @throws InputError for lengths that are not positive, degrees out of range
  BoxBody(const Eigen::Vector3d& half_lengths_m, const BoxDegrees& degrees, const HeldFaces& held = {});
  ~BoxBody();
  BoxBody(BoxBody&&) noexcept;

  std::size_t n_systems() const;
  Eigen::Index size(std::size_t system) const;  ///< unknowns
  int n_rigid(std::size_t system) const;        ///< rigid motions of a free body that have its parities: 0 or 1
  double volume_m3() const { return 8.0 * half_lengths_m_.prod(); }

  /// The lowest elastic modes of each system (fewer where it has no more); as HarmonicModes, vectors of unit length.
  /// Each frequency is the Rayleigh quotient of its vector, so that thin bodies lose no digits.
  std::vector<HarmonicModes> lowest(const solid::Material& material, const std::vector<int>& counts) const;
  /// Eigenvalues of a system below a frequency, rigid ones included: a Sturm count (inertia by LAPACK's LDL^T).
  int count_below(std::size_t system, const solid::Material& material, double frequency_hz) const;
  /// All elastic modes below a frequency; sooner where it is known about how many of each system these are.
  std::vector<HarmonicModes> modes_up_to(const solid::Material& material, double high_hz,
                                         const std::vector<int>& expected = {}) const;

  /// basis^T K basis for K = dK/dlambda and dK/dmu, as sums of squares of strains.
  struct Stiffness {
    Eigen::MatrixXd lambda, mu;
  };
  Stiffness projected(std::size_t system, const Eigen::MatrixXd& basis) const;

  /// Displacements of unknowns (size(system) x n) at points [m] about the middle of the box: 3 n_points x n, (x, y, z) by point.
  Eigen::MatrixXd displacements(std::size_t system, const Eigen::MatrixXd& unknowns,
                                const mesh::Points& points_m) const;

 private:
  struct Axis;
  struct System;
  Eigen::MatrixXd stiffness(const System& system, const solid::Material& material) const;
  HarmonicModes lowest(std::size_t system, const solid::Material& material, int count, double highest_hz) const;

  Eigen::Vector3d half_lengths_m_;
  std::vector<Axis> axes_;
  std::vector<System> systems_;
};

/// Degrees after so many raises (below 0: lowered): by 2 each, along sides below 0.3 of the longest by 1, where edges ask for less
/// than the faces do. 2 to 60.
BoxDegrees box_degrees_raised(const Eigen::Vector3d& half_lengths_m, BoxDegrees degrees, int raises = 1);

/// Half the lengths of a box's sides. @throws InputError for another shape
Eigen::Vector3d box_half_lengths_m(const mesh::ShapeSpec& shape);

/// Bound on (f_h - f) / f of the modes of the raised degrees by what the raise took off each: errors fall with the fourth power of the
/// degrees at least (edge layers of free plates), with the second where a face is held and stress is singular at its edges.
std::vector<Eigen::VectorXd> box_error_bound(const std::vector<HarmonicModes>& before,
                                             const std::vector<HarmonicModes>& raised, const BoxDegrees& degrees,
                                             const HeldFaces& held);

/// Modes up to a frequency and the bounds on their errors.
struct BoxModes {
  BoxDegrees degrees{};
  std::vector<HarmonicModes> modes;    ///< by system
  std::vector<Eigen::VectorXd> bound;  ///< by system, of each mode
};

/// Raises the degrees until the bound on the error of no mode from low_hz to high_hz is above 1e-5, or a system has 1,000 unknowns.
/// With a held face until 2e-4 or 3,200 unknowns, and frequencies are extrapolated: the power of the degrees with which each
/// falls over the last two raises gives what is left, and the range of powers that it may still become gives the bound, to both sides.
/// @throws InputError where the band would need more than 8,000 unknowns in a system
BoxModes box_modes(const Eigen::Vector3d& half_lengths_m, const HeldFaces& held, const solid::Material& material,
                   const Band& band, Monitor& monitor = silent_monitor());

/// All modes as a ModalModel on the nodes of a mesh of the box, as sample_modes() does it.
SampledModes sample_box_modes(const BoxBody& body, const std::vector<HarmonicModes>& modes, const mesh::TetMesh& mesh,
                              const solid::Material& material, const solid::Support& support = {});

/// What solve_modes gives, for a box that is free or held at whole faces, by BoxBody: the shapes are sampled to the nodes of the
/// mesh. Of the options count, band, most, prove_none_missing and estimate_mesh_error (the bound) are used.
/// @throws InputError for another shape or support
EigenResult solve_box_modes(const mesh::ShapeSpec& shape, const mesh::TetMesh& mesh, const solid::Material& material,
                            const solid::Support& support = {}, const EigenOptions& options = {},
                            Monitor& monitor = silent_monitor());

}  // namespace klang::modal
