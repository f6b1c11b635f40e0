#include "fit/proxy/proxy_cost.hpp"

#include <ceres/cost_function.h>
#include <ceres/sized_cost_function.h>

#include <algorithm>
#include <cmath>

#include "core/base/conventions.hpp"

namespace klang::fit {
namespace {

constexpr double kSemitonesPerNeper = 12.0 / 0.6931471805599453;  // 100 cents

class FrequencyCost : public ceres::CostFunction {
 public:
  FrequencyCost(const soundbank::Soundbank& bank, std::vector<double> target_hz, double speed)
      : bank_(bank), target_hz_(std::move(target_hz)), speed_(speed), depth_(-std::log(bank.thinnest)) {
    set_num_residuals(static_cast<int>(target_hz_.size()));
    *mutable_parameter_block_sizes() = {2, 1};
  }
  bool Evaluate(double const* const* p, double* residuals, double** jacobians) const override {
    const double s = p[0][0], t = p[0][1];
    const soundbank::ShapePlace place = soundbank::locate(bank_, shape_of_square(bank_, s, t));
    const auto& nodes = bank_.triangles[static_cast<std::size_t>(place.triangle)].nodes;
    const auto weights = soundbank::node_weights(place.weights);
    const auto slopes = soundbank::node_weight_slopes(bank_, place);
    struct Line {
      double value, by_u, by_v;
    };
    std::vector<Line> lines;
    for (int c = 0; c < soundbank::kModeClasses; ++c) {
      const Eigen::Index count = bank_.node_frequencies[static_cast<std::size_t>(nodes[0])][c].size();
      for (Eigen::Index k = 0; k < count; ++k) {
        Line line{0.0, 0.0, 0.0};
        for (int i = 0; i < 6; ++i) {
          const double value = std::log(bank_.node_frequencies[static_cast<std::size_t>(nodes[i])][c][k]);
          line.value += weights[i] * value;
          line.by_u += slopes(i, 0) * value;
          line.by_v += slopes(i, 1) * value;
        }
        lines.push_back(line);
      }
    }
    const std::size_t n = target_hz_.size();
    if (lines.size() < n) return false;
    std::stable_sort(lines.begin(), lines.end(), [](const Line& a, const Line& b) { return a.value < b.value; });
    for (std::size_t k = 0; k < n; ++k) {
      const double ln_hz = lines[k].value + std::log(speed_ / (2.0 * kPi)) - p[1][0];
      residuals[k] = kSemitonesPerNeper * (ln_hz - std::log(target_hz_[k]));
      if (jacobians == nullptr) continue;
      if (jacobians[0] != nullptr) {  // u = -depth s, v = -depth s t
        jacobians[0][2 * k] = -kSemitonesPerNeper * depth_ * (lines[k].by_u + t * lines[k].by_v);
        jacobians[0][2 * k + 1] = -kSemitonesPerNeper * depth_ * s * lines[k].by_v;
      }
      if (jacobians[1] != nullptr) jacobians[1][k] = -kSemitonesPerNeper;
    }
    return true;
  }

 private:
  const soundbank::Soundbank& bank_;
  std::vector<double> target_hz_;
  double speed_, depth_;
};

}  // namespace

soundbank::ShapePoint shape_of_square(const soundbank::Soundbank& bank, double s, double t) {
  const double u = std::log(bank.thinnest) * s;
  return {u, u * t};
}

std::unique_ptr<ceres::CostFunction> proxy_frequency_cost(const soundbank::Soundbank& bank, std::vector<double> target_hz, double shear_speed_m_s) {
  return std::make_unique<FrequencyCost>(bank, std::move(target_hz), shear_speed_m_s);
}

}  // namespace klang::fit
