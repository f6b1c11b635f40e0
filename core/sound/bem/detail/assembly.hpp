#pragma once
#include <Eigen/Core>
#include <array>
#include <complex>
#include <vector>

#include "core/foundation/la/dense_solve.hpp"
#include "core/sound/bem/detail/device_system.hpp"
#include "core/sound/bem/detail/far_kernel.hpp"
#include "core/sound/bem/detail/mirror_classes.hpp"
#include "core/sound/bem/detail/near_field.hpp"
#include "core/sound/bem/radiating_surface.hpp"

namespace klang::acoustics::detail {

/// What no frequency changes. The matrix has a row for each vertex of the own part of a surface with mirrors, a column for each of all.
struct BemGeometry {
  explicit BemGeometry(RadiatingSurface radiating);

  RadiatingSurface surface;
  MirrorClasses classes;
  std::vector<int> row_of_vertex;     ///< -1: an image of one that has a row
  std::vector<int> column_of_vertex;  ///< without mirrors the same
  Eigen::Matrix3Xi corner_rows;       ///< 3 x n_triangles
  Eigen::Matrix3Xi corner_columns;
  std::vector<std::vector<int>> triangles_of_row;  ///< ascending
  TriangleColumns columns;
  NearField near;
  std::vector<std::array<Eigen::Vector3d, 3>> curls;  ///< n x grad phi of each corner
};

/// Matrix and right-hand sides of one frequency for q = normal derivative at the corners (3 n_triangles x n_columns).
class Assembly {
 public:
  Assembly(const BemGeometry& geometry, double wavenumber_per_m, const Eigen::MatrixXcd& derivative);

  /// Rows begin, ... end - 1 of both, scaled so that they are of equal size whatever the triangles; matrix and right hold zeros there.
  void rows(std::size_t begin, std::size_t end, la::RowMatrixXcd& matrix, Eigen::MatrixXcd& right) const;

  /// The near pairs' share of the whole, scaled as well; adds to right. In parallel.
  NearRows near_rows(Eigen::MatrixXcd& right) const;
  FarProblem far_problem() const;                                   ///< refers to this
  const Eigen::MatrixXcd& at_points() const { return at_points_; }  ///< of the normal derivative: row 3 t + q

 private:
  /// Rows that are being made: matrix.row(0) is row first of the whole.
  struct Target {
    int first;
    la::RowMatrixXcd& matrix;
    Eigen::MatrixXcd& right;  ///< n_rows x n_columns, of the whole
  };
  struct Tests {
    int triangle;
    int rows[3];  ///< matrix row of each corner, or -1 where another block owns it
  };
  std::vector<Tests> tests_of(std::size_t begin, std::size_t end) const;
  void far(const Tests& tests, const Target& target, std::vector<double>& keep, FarBlock& block) const;
  void close(const Tests& tests, const Target& target) const;
  void scale(std::size_t begin, std::size_t end, const Target& target) const;

  const BemGeometry& geometry_;
  double wavenumber_per_m_, eta_m_;
  const Eigen::MatrixXcd& derivative_;
  Eigen::MatrixXcd at_points_;
  std::vector<double> point_values_;  ///< the same: [column][q][re, im][triangle, padded]
  Eigen::VectorXd row_scale_;
};

}  // namespace klang::acoustics::detail
