#pragma once
#include <Eigen/Core>
#include <vector>

#include "core/physics/modal/modal_model.hpp"
#include "core/sound/bem/radiating_surface.hpp"

namespace klang::acoustics {

/// The surface of a modal model that faces the fluid outside, cut finely enough to be measured by boundary elements of a
/// given size, with the normal velocity of its modes. Slits are shut (mesh/slits.hpp): their lips touch, and the air that a slit takes in
/// where it gapes is left out.
class ModalSurface {
 public:
  /// @param element_m  size of the smallest boundary elements: the curved faces of the mesh are cut until their pieces (of 7
  ///                   samples each) are no larger, or until there are max_triangles of them (at least the mesh's own
  ///                   corners and mid-nodes)
  /// @throws InputError when the boundary is no closed surface
  ModalSurface(const modal::ModalModel& model, double element_m, int max_triangles = 200000);

  /// Straight triangles between points on the curved faces.
  const mesh::SurfaceMesh& triangles() const { return triangles_; }
  double area_m2() const { return area_m2_; }

  /// Volume flow [m^3/s] of a mode of unit modal velocity through the whole surface, exact for its finite elements.
  double volume_flow_m3_s(int mode) const;

  /// Wavelength of the mode's own pattern on the surface, 2 pi sqrt(int v_n^2 / int |grad v_n|^2) [m]; infinite where
  /// v_n is constant.
  double pattern_wavelength_m(int mode) const;

  /// Where the velocity of a surface of boundary elements comes from.
  struct Carrier {
    std::vector<int> element_of_sample;
    Eigen::Matrix3Xd hats_of_sample;  ///< barycentric coordinates of its foot on the element's plane
    std::vector<Eigen::Matrix3d>
        inverse;                          ///< by element: of sum area hats hats^T; zero where the samples do not fix it
    Eigen::VectorXd area_of_element_m2;   ///< of the samples it was given
    Eigen::VectorXd height_of_element_m;  ///< their mean height over its plane
  };
  /// Gives every sample of this surface to the nearest element that faces the same way.
  Carrier carrier(const RadiatingSurface& elements) const;

  /// The elements with their vertices moved so that the surface lies in the mean as high over them as below: flat elements
  /// between points of a curved surface enclose too little.
  RadiatingSurface settled(const RadiatingSurface& elements) const;

  /// Normal velocity of a mode at the corners of the elements (row 3 t + c, 3 n_triangles): on each element the linear
  /// function nearest to the samples given to it in the mean square; their mean where they are too few; the mean of the
  /// triangles around where there are none. Then the volume flow through all elements is made that of the mode, by a change
  /// in proportion to |v_n|.
  Eigen::VectorXd corner_velocity_m_s(int mode, const Carrier& carrier, const RadiatingSurface& elements) const;

 private:
  struct Sample {
    int face;  ///< row of faces_
    Eigen::Vector3d at_m;
    Eigen::Vector3d area_m2;  ///< n dA
    Eigen::Matrix<double, 6, 1> shape;
  };
  double flow_of(const Sample& sample, int mode) const;

  const modal::ModalModel& model_;
  mesh::IndexRows faces_;  ///< 3 or 6 nodes each
  mesh::SurfaceMesh triangles_;
  std::vector<Sample> samples_;
  double area_m2_ = 0.0;
};

}  // namespace klang::acoustics
