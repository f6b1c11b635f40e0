#pragma once
#include <Eigen/Core>
#include <array>

namespace klang::liquid {

/// A level set as a file has it: cubic voxels along the file's axes.
struct VdbExtent {
  double voxel = 0.0;                                 ///< edge, in the file's unit
  Eigen::Vector3d first = Eigen::Vector3d::Zero();    ///< centre of voxel (0, 0, 0), in the file's unit
  std::array<int, 3> low{0, 0, 0}, high{-1, -1, -1};  ///< voxels that are stored one by one
  double band_voxels = 0.0;                           ///< how far from the surface values are distances
};

}  // namespace klang::liquid
