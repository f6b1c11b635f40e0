#pragma once
#include "core/foundation/config/fields.hpp"
#include "core/sound/soundbank/ellipsoid.hpp"
#include "core/sound/waves/multipole.hpp"

namespace klang::soundbank {

struct EllipsoidRadiationOptions {
  acoustics::Medium medium;
  acoustics::OrderOptions order;
  double boundary_tolerance =
      5e-3;  ///< rms error of the normal velocity at which refinement ends, of its rms or of 3 % of the displacement's, 1e-8 to 0.1
  int max_refinements = 6;  ///< of the sources, 0 to 8
  void validate() const;    ///< InputError

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"medium", "The air around the ellipsoid"}, self.medium);
    visit({"order", "Order of the multipoles"}, self.order);
    visit({"boundary_tolerance", "Root mean square error of the normal velocity at which refinement ends",
           between(1e-8, 0.1)},
          self.boundary_tolerance);
    visit({"max_refinements", "Refinements of the sources at most", between(0.0, 8.0)}, self.max_refinements);
  }
};

struct EllipsoidRadiation {
  acoustics::Multipole multipole;  ///< about the centre, for unit modal velocity
  double radiated_power_w = 0.0;   ///< of the series carried to convergence
  double kept_power_fraction = 0.0;
  double boundary_error =
      0.0;  ///< rms of the normal-velocity error over rms of the velocity, between the points it was fitted at
  bool moves_normally = true;  ///< false: torsion of a body of revolution, no sound at all
  int n_unknowns = 0, n_equations = 0;
};

/// Sound of one mode outside: combined single and double layers (d/dnu + i eta) G with a smooth density on a confocal ellipsoid
/// inside, the density a series of spherical harmonics of the mode's class, fitted to the normal velocity by least squares.
/// Distances to the body are never zero, so nothing is singular; the eight reflections leave an octant of unknowns; quadrature is
/// crowded around each point of the boundary; the error is measured on the boundary itself. In ellipsoidal coordinates both the normal
/// velocity (times the scale factor) and the density are smooth however thin the body is. The multipoles follow from the sources exactly (errata 38),
/// M = -ik int q (d/dnu + i eta) conj(R), by way of the field far away.
/// Source: the "combined source" that has no false resonances: Mautz and Harrington 1979, Radio Sci. 14, 29-36 (there for waves of light);
/// smooth sources inside: Kress and Mohsen 1986, Math. Meth. Appl. Sci. 8, 585-597.
EllipsoidRadiation radiate(const EllipsoidModes& modes, const ModeId& mode,
                           const EllipsoidRadiationOptions& options = {});

}  // namespace klang::soundbank
