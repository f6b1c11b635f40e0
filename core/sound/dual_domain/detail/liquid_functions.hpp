#pragma once
#include <complex>
#include <optional>
#include <vector>

#include "core/sound/dual_domain/detail/wave_rows.hpp"
#include "core/sound/dual_domain/dual_domain.hpp"

namespace klang::bubble::detail {

/// Functions of pass 1 at a sample or point: value, or derivative along normal where it is given. Real for a real k.
class FluidFunctions {
 public:
  FluidFunctions(std::complex<double> k, int order, const std::vector<Eigen::Vector3d>& points,
                 const std::vector<Eigen::Vector3d>& solid);
  Eigen::Index size() const;
  std::optional<RegularRows::Scratch> scratch() const;
  void row(const Eigen::Vector3d& x, const Eigen::Vector3d* normal, std::optional<RegularRows::Scratch>& scratch,
           double* out) const;  ///< for a real k
  void row(const Eigen::Vector3d& x, const Eigen::Vector3d* normal, std::optional<RegularRows::Scratch>& scratch,
           std::complex<double>* out) const;

 private:
  Eigen::Index n_regular() const;
  template <class Number, class Scalar>
  void regular_row(Number k, const Eigen::Vector3d& x, const Eigen::Vector3d* normal,
                   std::optional<RegularRows::Scratch>& scratch, Scalar* out) const;

  std::complex<double> k_;
  const std::vector<Eigen::Vector3d>& points_;
  const std::vector<Eigen::Vector3d>& solid_;
  std::optional<RegularRows> rows_;
};

/// Bubble and images: value, or derivative along normal.
std::complex<double> incident(const FluidField& field, const Eigen::Vector3d& x, const Eigen::Vector3d* normal);

/// Images in free surface and rigid surface, and the image of the one in the other.
void add_images(const LiquidBoundary& boundary, FluidField& field);

}  // namespace klang::bubble::detail
