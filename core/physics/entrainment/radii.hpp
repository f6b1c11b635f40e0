#pragma once
#include <vector>

#include "core/foundation/base/random.hpp"

namespace klang::entrainment {

/// How large new bubbles are.
struct RadiusDistribution {
  enum class Kind {
    kDeaneStokes,  ///< n ~ r^-3/2 below the Hinze scale of 1 mm, r^-10/3 above (Deane and Stokes 2002, Nature 418, 839)
    kGaussian,     ///< of mean and std, cut to the limits (as printed, a Gaussian has negative radii: erratum 86)
    kRecorded      ///< one of the radii of a recording, smeared by 0.1 in ln r, within the limits
  };
  Kind kind = Kind::kDeaneStokes;
  double smallest_m = 3e-4, largest_m = 5e-3;
  double mean_m = 1e-3, std_m = 3e-4;
  std::vector<double> recorded_m;
  void validate() const;  ///< InputError

  /// One radius; takes a fixed number of numbers of the stream for all kinds but the Gaussian, which draws again outside its limits.
  double draw(RandomStream& random) const;
};

}  // namespace klang::entrainment
