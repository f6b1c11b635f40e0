#pragma once
#include <Eigen/Core>
#include <complex>
#include <cstdint>
#include <map>
#include <vector>

namespace klang::liquid_scene {

/// What a CellEar carries from one frame to the next, besides the elements of the air, which are made again from the surface they came from.
struct CellEarState {
  struct Wave {
    double frequency_hz = 0.0;
    std::vector<std::complex<float>> w;  ///< of the wet cells
  };
  double made_s = -1e300, life_s = 0.0, change = 0.0, changed_hz = 0.0;
  std::map<int, Eigen::MatrixXcd> q;  ///< of bins, at the vertices of their elements
  std::uint64_t n_cells = 0;          ///< of the box
  std::vector<std::uint32_t> wet;     ///< cells in which any wave is not 0: in the body of liquid
  std::map<std::size_t, Wave> waves;  ///< of bubbles
};

}  // namespace klang::liquid_scene
