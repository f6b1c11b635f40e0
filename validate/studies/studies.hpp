#pragma once
#include "validate/studies/study.hpp"

/// The studies themselves; run_study judges what they return.
namespace klang::validate {

/// Eigenvalues of linear and quadratic tetrahedra, straight and curved, against exact and Ritz solutions.
Study fem_study(const StudyOptions& options, Monitor& monitor);

/// Surface pressure of the boundary elements on spheres against the exact series, interior resonances included.
Study bem_study(const StudyOptions& options, Monitor& monitor);

/// Multipole series of a source off the centre: error over the order, lost power, and equivalent sources beside it.
Study multipole_study(const StudyOptions& options, Monitor& monitor);

/// The oscillator bank against closed forms, and beside step-by-step integrators.
Study synthesis_study(const StudyOptions& options, Monitor& monitor);

/// Bubbles in liquids: both passes of the dual-domain solver over their sources, and what the one-way coupling leaves out.
Study dual_domain_study(const StudyOptions& options, Monitor& monitor);

}  // namespace klang::validate
