#include "core/physics/modal/damping/mass_only.hpp"

#include "core/physics/modal/damping/rayleigh.hpp"

namespace klang::damping {
namespace {

class MassOnly final : public DampingLaw {
 public:
  using DampingLaw::decay_per_s;
  std::string_view name() const override { return "mass_only"; }
  std::string_view words() const override { return "mass only"; }
  std::span<const LawParameter> parameters() const override { return {&rayleigh_mass_parameter(), 1}; }
  double decay_per_s(double, const double* p) const override { return 0.5 * p[0]; }
  void log_gradient(double, const double* p, double* gradient) const override { gradient[0] = 1.0 / p[0]; }
  std::vector<Eigen::VectorXd> starts(const Eigen::ArrayXd&, const Eigen::ArrayXd& decay) const override {
    return {Eigen::VectorXd::Constant(1, geometric_mean(2.0 * decay))};
  }
};

}  // namespace

const DampingLaw& mass_only_law() {
  static const MassOnly law;
  return law;
}

}  // namespace klang::damping
