#pragma once
#include "core/physics/modal/axisymmetric_modes.hpp"

namespace klang::modal {

/// Divisions with elements as long as 0.8 of the shortest wave that highest_hz bends the wall in, or shears: degree 4
/// carries it to 1e-6. @throws InputError for a body that is not one of revolution
mesh::SectionDivisions section_divisions_for(const mesh::ShapeSpec& shape, const solid::Material& material,
                                             double highest_hz);

/// Estimate of (f_h - f) / f of the first n sampled modes: a tenth of the difference to elements one degree lower, which
/// is more than what is left of it.
Eigen::VectorXd section_mesh_error(const mesh::ShapeSpec& shape, const mesh::SectionDivisions& divisions,
                                   const solid::Material& material, const std::vector<HarmonicModes>& modes,
                                   const SampledModes& sampled, Eigen::Index n);

/// What solve_modes gives, for a free body of revolution by its harmonics: frequencies to about 1e-6 whatever the mesh, to
/// whose nodes the shapes are sampled. Of the options count, band and estimate_mesh_error are used; every harmonic's count is
/// a Sturm count, so none is missing.
/// @throws InputError for a body that is not one of revolution; NumericalError as AxisymmetricBody
EigenResult solve_revolution_modes(const mesh::ShapeSpec& shape, const mesh::TetMesh& mesh,
                                   const solid::Material& material, const EigenOptions& options = {},
                                   Monitor& monitor = silent_monitor());

}  // namespace klang::modal
