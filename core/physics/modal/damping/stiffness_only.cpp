#include "core/physics/modal/damping/stiffness_only.hpp"

#include "core/physics/modal/damping/rayleigh.hpp"

namespace klang::damping {
namespace {

class StiffnessOnly final : public DampingLaw {
 public:
  using DampingLaw::decay_per_s;
  std::string_view name() const override { return "stiffness_only"; }
  std::string_view words() const override { return "stiffness only"; }
  std::span<const LawParameter> parameters() const override { return {&rayleigh_stiffness_parameter(), 1}; }
  double decay_per_s(double omega, const double* p) const override { return 0.5 * p[0] * omega * omega; }
  void log_gradient(double, const double* p, double* gradient) const override { gradient[0] = 1.0 / p[0]; }
  std::vector<Eigen::VectorXd> starts(const Eigen::ArrayXd& omega, const Eigen::ArrayXd& decay) const override {
    return {Eigen::VectorXd::Constant(1, geometric_mean(2.0 * decay / omega.square()))};
  }
};

}  // namespace

const DampingLaw& stiffness_only_law() {
  static const StiffnessOnly law;
  return law;
}

}  // namespace klang::damping
