#include "fit/proxy/proxy_cost.hpp"

#include <ceres/cost_function.h>

#include <cmath>

#include "core/foundation/base/conventions.hpp"

namespace klang::fit {
namespace {

constexpr double kSemitonesPerNeper = 12.0 / 0.6931471805599453;  // 100 cents

class FrequencyCost : public ceres::CostFunction {
 public:
  FrequencyCost(const ProxyFrequencies& frequencies, std::vector<double> target_hz, double speed)
      : frequencies_(frequencies),
        target_hz_(std::move(target_hz)),
        speed_(speed),
        depth_(-std::log(frequencies.bank().thinnest)) {
    set_num_residuals(static_cast<int>(target_hz_.size()));
    *mutable_parameter_block_sizes() = {2, 1};
  }
  bool Evaluate(double const* const* p, double* residuals, double** jacobians) const override {
    const double s = p[0][0], t = p[0][1];
    const soundbank::ShapePlace place =
        soundbank::locate(frequencies_.bank(), shape_of_square(frequencies_.bank(), s, t));
    std::vector<ProxyFrequencies::Line> lines;
    frequencies_.lowest(place, lines);
    const std::size_t n = target_hz_.size();
    if (lines.size() < n) return false;
    std::vector<std::array<double, 2>> slopes;
    if (jacobians != nullptr && jacobians[0] != nullptr) frequencies_.slopes(place, lines, slopes);
    for (std::size_t k = 0; k < n; ++k) {
      const double ln_hz = lines[k].ln_frequency + std::log(speed_ / (2.0 * kPi)) - p[1][0];
      residuals[k] = kSemitonesPerNeper * (ln_hz - std::log(target_hz_[k]));
      if (jacobians == nullptr) continue;
      if (jacobians[0] != nullptr) {  // u = -depth s, v = -depth s t
        jacobians[0][2 * k] = -kSemitonesPerNeper * depth_ * (slopes[k][0] + t * slopes[k][1]);
        jacobians[0][2 * k + 1] = -kSemitonesPerNeper * depth_ * s * slopes[k][1];
      }
      if (jacobians[1] != nullptr) jacobians[1][k] = -kSemitonesPerNeper;
    }
    return true;
  }

 private:
  const ProxyFrequencies& frequencies_;
  std::vector<double> target_hz_;
  double speed_, depth_;
};

}  // namespace

soundbank::ShapePoint shape_of_square(const soundbank::Soundbank& bank, double s, double t) {
  const double u = std::log(bank.thinnest) * s;
  return {u, u * t};
}

std::unique_ptr<ceres::CostFunction> proxy_frequency_cost(const ProxyFrequencies& frequencies,
                                                          std::vector<double> target_hz, double shear_speed_m_s) {
  return std::make_unique<FrequencyCost>(frequencies, std::move(target_hz), shear_speed_m_s);
}

}  // namespace klang::fit
