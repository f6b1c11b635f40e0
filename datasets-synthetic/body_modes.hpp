#pragma once
#include <Eigen/Core>
#include <string>
#include <vector>

#include "core/foundation/base/monitor.hpp"
#include "core/geometry/shapes/shape.hpp"
#include "core/physics/solid/material.hpp"
#include "core/physics/solid/support.hpp"

namespace klang::datasets {

/// A body's true modes, seen at given places.
struct BodyModes {
  Eigen::VectorXd angular_frequency_rad_s;  ///< undamped, ascending
  std::vector<Eigen::MatrixXd> shapes;      ///< one per place: 3 x n_modes, mass-normalised [1/sqrt(kg)]
  std::vector<Eigen::Vector3d> places_m;    ///< the points that were taken
  std::vector<std::string> labels;          ///< "n=2 odd", "parity 110", "mode 3"
  std::string method;                       ///< in words, with orders or mesh size
  double pair_tolerance = 1e-6;             ///< neighbours closer than this (relative) are one pair by symmetry
};

/// Modes up to highest_hz at places given in half extents from the centre. Free boxes and tubes by the Ritz
/// method; other bodies of revolution by the harmonics of their section, ellipsoids and boxes held at a face by polynomials; the rest by
/// quadratic finite elements, one refinement finer than the default.
/// @throws InputError; NumericalError when the eigensolver does not converge
BodyModes body_modes(const mesh::ShapeSpec& shape, const solid::Material& material, const solid::Support& support,
                     double highest_hz, const std::vector<Eigen::Vector3d>& places,
                     Monitor& monitor = silent_monitor());

/// Splits every pair of neighbours closer than 1e-4: frequencies f (1 -+ detuning / 2), shapes turned by the
/// angle.
void split_pairs(BodyModes& modes, double relative_detuning, double angle_rad);

}  // namespace klang::datasets
