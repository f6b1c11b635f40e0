#pragma once
#include <memory>
#include <vector>

#include "fit/proxy/proxy_frequencies.hpp"

namespace ceres {
class CostFunction;
}

namespace klang::fit {

/// Two shape numbers in the unit square: u = -depth s, v = u t, depth = -ln(thinnest); s = 0 is the ball, t = 0 the spheroid b = c,
/// t = 1 the one with a = b.
soundbank::ShapePoint shape_of_square(const soundbank::Soundbank& bank, double s, double t);

/// Residuals ln(f_proxy / f_target) in cents / 100 of the first partials, rank by rank; parameters: {s, t} and ln scale.
/// The slopes are those of the bank's interpolation; at equal frequencies of two classes they jump.
/// @param frequencies  of at least as many; must outlive the cost
std::unique_ptr<ceres::CostFunction> proxy_frequency_cost(const ProxyFrequencies& frequencies,
                                                          std::vector<double> target_hz, double shear_speed_m_s);

}  // namespace klang::fit
