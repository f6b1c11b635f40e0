#pragma once
#include <Eigen/Core>
#include <array>
#include <complex>
#include <cstdint>
#include <string>
#include <vector>

#include "core/physics/solid/material.hpp"
#include "core/sound/soundbank/ellipsoid.hpp"
#include "core/sound/transfer/transfer_model.hpp"
#include "core/sound/waves/medium.hpp"

namespace klang::soundbank {

/// Shape of an ellipsoid a <= b <= c without its size: u = ln(a/c) <= v = ln(b/c) <= 0. In thin bodies frequencies are powers of
/// the axes, so their logarithms are nearly linear in u and v.
struct ShapePoint {
  double u = 0.0, v = 0.0;
  auto operator<=>(const ShapePoint&) const = default;
};
/// Semi-axes with a^2 + b^2 + c^2 = 1 (SB eq. 11).
Eigen::Vector3d unit_axes(const ShapePoint& shape);
/// Of semi-axes of any size, sorted or not.
ShapePoint shape_point(const Eigen::Vector3d& axes);

/// Frequencies by class without unit: omega |axes| / c_s with c_s = sqrt(mu/rho). They depend on the shape and Poisson's ratio alone.
using ClassFrequencies = std::array<Eigen::VectorXd, kModeClasses>;

/// A mode of a cell: the body with |axes| = 1 m of the bank's material in the bank's medium.
struct CellMode {
  ModeId id;
  double angular_frequency_rad_s = 0.0;
  Eigen::VectorXf coefficients;  ///< of the mass-normalised shape, as EllipsoidModes::coefficients
  int order = 0;                 ///< of the multipole
  std::vector<std::complex<float>>
      packed_pa;  ///< of unit modal velocity; only what the class allows (packed_multipole)
  double radiated_power_w = 0.0, kept_power_fraction = 0.0, boundary_error = 0.0;
};

/// A sample with its sound.
struct Cell {
  ShapePoint shape;
  std::vector<CellMode> modes;  ///< by frequency
};

/// Triangle of the shape plane: six nodes for the quadratic interpolation of the logarithms of the frequencies; base = corners 1, 2.
struct ShapeTriangle {
  std::array<int, 6> nodes{};           ///< corners, then middles of the sides 1-2, 2-0, 0-1
  std::array<int, 2> children{-1, -1};  ///< halves at the middle of the base, with corner 1 and corner 2
};

/// Ellipsoids of all shapes down to a thinnest, of one Poisson's ratio (frequencies, shapes) and one ratio of shear speed to sound
/// speed (radiation). The density of solid and fluid only scales the sound.
struct Soundbank {
  double poissons_ratio = 0.0;
  solid::Material material;
  acoustics::Medium medium;
  double thinnest = 0.0;                     ///< smallest a/c
  double tolerance = 0.0;                    ///< asked for
  int n_checked_modes = 0;                   ///< to which it applies
  double max_interpolation_error = 0.0;      ///< of the first n_checked_modes at shapes that no refinement saw
  double max_interpolation_error_all = 0.0;  ///< of the first modes_per_cell there
  int n_check_shapes = 0;
  int modes_per_cell = 0;
  int degree = 0;  ///< of the polynomials
  std::vector<ShapePoint> nodes;
  std::vector<ClassFrequencies> node_frequencies;
  std::vector<ShapeTriangle> triangles;  ///< [0] is the whole plane; a binary tree
  std::vector<Cell> cells;
  std::string provenance_json = "{}";

  double speed_ratio() const { return material.shear_speed_m_s() / medium.sound_speed_m_s; }
};

/// The place in the tree: leaf and barycentric coordinates. Shapes beyond the thinnest are moved to the border.
struct ShapePlace {
  int triangle = 0;
  Eigen::Vector3d weights;
  bool clamped = false;
};
ShapePlace locate(const Soundbank& bank, const ShapePoint& shape);

/// Weights of the six nodes at barycentric coordinates, and their derivatives with respect to u and v (6 x 2).
Eigen::Matrix<double, 6, 1> node_weights(const Eigen::Vector3d& barycentric);
Eigen::Matrix<double, 6, 2> node_weight_slopes(const Soundbank& bank, const ShapePlace& place);

/// Frequencies without unit at a shape, by class.
ClassFrequencies interpolated_frequencies(const Soundbank& bank, const ShapePlace& place);
/// The lowest frequency without unit: what fixes the scale.
double lowest_frequency(const Soundbank& bank, const ShapePlace& place);

/// The coefficients that the class leaves: m >= 0, n ascending within m.
std::vector<std::complex<float>> packed_multipole(const Eigen::VectorXcd& coefficients, int order, int mode_class);
Eigen::VectorXcd unpacked_multipole(const std::vector<std::complex<float>>& packed, int order, int mode_class);
std::size_t packed_size(int order, int mode_class);

}  // namespace klang::soundbank
