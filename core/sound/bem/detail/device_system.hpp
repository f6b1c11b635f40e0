#pragma once
#include <Eigen/Core>
#include <complex>
#include <vector>

#include "core/foundation/la/dense_solve.hpp"
#include "core/foundation/opencl/session.hpp"
#include "core/sound/bem/detail/far_kernel.hpp"
#include "core/sound/bem/detail/near_field.hpp"

namespace klang::acoustics::detail {

/// What the far field of one frequency is made of; all by the row of a vertex in the matrix.
struct FarProblem {
  const TriangleColumns& columns;
  const Eigen::Matrix3Xi& corner_rows;                    ///< 3 x n_triangles: row of each corner
  const std::vector<std::vector<int>>& triangles_of_row;  ///< ascending
  const NearField& near;                                  ///< whose pairs are left out
  const Eigen::VectorXd& row_scale;                       ///< n_rows: factors of the rows
  double wavenumber_per_m, eta_m;
};

/// Rows of a sparse matrix, one after the other.
struct NearRows {
  std::vector<int> first;  ///< n_rows + 1
  std::vector<int> column;
  std::vector<std::complex<double>> value;
};

/// The system of HelmholtzBem on an OpenCL device: far pairs are integrated there and gathered into the dense matrix, which stays
/// there; near pairs come from the processor. Double precision: the processor's entries to 1e-12 of the largest of their row; single:
/// to 1e-5. No sum depends on the order in which the device works.
/// Memory: the matrix, n_rows^2 pairs of numbers, and 2 GB (a GPU) or 0.25 GB for the triangles in work.
class DeviceSystem {
 public:
  /// @throws opencl::Error when the device has no memory for it
  DeviceSystem(const opencl::DeviceChoice& where, FarProblem problem, const NearRows& near);

  /// Far pairs' share of the right-hand side, rows scaled.
  /// @param at_points  of the normal derivative: row 3 t + q, n_columns
  Eigen::MatrixXcd far_right(const Eigen::MatrixXcd& at_points);
  Eigen::MatrixXcd times(const Eigen::MatrixXcd& x);  ///< n_rows x n_columns
  /// The square block of rows and columns first, ... first + count - 1.
  Eigen::MatrixXcd block(int first, int count);
  la::RowMatrixXcd matrix();
  const opencl::Device& device() const { return session_.device(); }
  bool double_precision() const { return session_.precision() == opencl::Precision::kDouble; }

 private:
  template <typename Real>
  void assemble(const NearRows& near);
  template <typename Real>
  void assemble_rows(int begin, int end, const std::vector<int>& tests);
  std::vector<std::uint32_t> near_bits(const std::vector<int>& tests) const;
  template <typename Real>
  Eigen::MatrixXcd far_right_of(const Eigen::MatrixXcd& at_points);
  template <typename Real>
  Eigen::MatrixXcd times_of(const Eigen::MatrixXcd& x);
  template <typename Real>
  Eigen::MatrixXcd read_rows(int first, int count, int n_columns);

  opencl::Session session_;
  const FarProblem problem_;
  int n_triangles_, n_rows_, words_;
  std::size_t pair_bytes_;  ///< of the triangles in work, at most
  opencl::Buffer geometry_, corners_at_, corners_, row_scale_, pairs_, matrix_;
};

}  // namespace klang::acoustics::detail
