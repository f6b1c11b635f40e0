#include "core/physics/modal/damping/loss_factor.hpp"

#include <array>

namespace klang::damping {
namespace {

constexpr std::array kParameters = {LawParameter{"loss_factor", 0.0, 1.0, true, 1e9, "η of decay = η ω / 2",
                                                 "Constant loss factor: decay_per_s = loss_factor omega / 2",
                                                 "loss factor", "η"}};

class LossFactor final : public DampingLaw {
 public:
  using DampingLaw::decay_per_s;
  std::string_view name() const override { return "loss_factor"; }
  std::string_view words() const override { return "constant loss factor"; }
  std::span<const LawParameter> parameters() const override { return kParameters; }
  double decay_per_s(double omega, const double* p) const override { return 0.5 * p[0] * omega; }
  void log_gradient(double, const double* p, double* gradient) const override { gradient[0] = 1.0 / p[0]; }
  std::vector<Eigen::VectorXd> starts(const Eigen::ArrayXd& omega, const Eigen::ArrayXd& decay) const override {
    return {Eigen::VectorXd::Constant(1, geometric_mean(2.0 * decay / omega))};
  }
};

}  // namespace

const DampingLaw& loss_factor_law() {
  static const LossFactor law;
  return law;
}

}  // namespace klang::damping
