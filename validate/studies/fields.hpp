#pragma once
#include <Eigen/Core>
#include <string>
#include <vector>

#include "core/geometry/mesh/tet_mesh.hpp"

/// What a study leaves to be looked at. Numbers only: how they are drawn is the business of reports.
namespace klang::validate {

/// A number at each vertex of a surface (an error, a pressure).
struct SurfaceField {
  std::string name;      ///< file name without extension: letters, digits, '-'
  std::string title;     ///< "Error of the torsional mode, linear elements"
  std::string caption;   ///< one or two sentences
  std::string quantity;  ///< with unit in the name: "relative_error"
  mesh::Points vertices_m;
  mesh::IndexRows triangles;  ///< n x 3
  Eigen::VectorXd values;     ///< n_vertices, >= 0
};

/// |p| on a rectangle: corner + i/(columns - 1) side_u + j/(rows - 1) side_v.
struct SliceField {
  std::string name, title, caption;
  std::string quantity;  ///< "pressure_magnitude_pa"
  Eigen::Vector3d corner_m = Eigen::Vector3d::Zero(), side_u_m = Eigen::Vector3d::UnitX(),
                  side_v_m = Eigen::Vector3d::UnitZ();
  Eigen::MatrixXd values;  ///< rows (along v) x columns (along u); NaN inside a body
  bool decibels = false;   ///< draw 20 log10 of the values over their largest
  double floor = 0.0;      ///< smallest value worth a colour of its own (same unit), 0: the smallest there is
};

/// Far-field level in every direction, for directivity balloons.
struct BalloonField {
  std::string name, title, caption;
  Eigen::MatrixXd magnitude;  ///< (n_polar + 1) x n_azimuth: theta = i pi / n_polar, phi = 2 pi k / n_azimuth; >= 0
};

struct Fields {
  std::vector<SurfaceField> surfaces;
  std::vector<SliceField> slices;
  std::vector<BalloonField> balloons;
};

}  // namespace klang::validate
