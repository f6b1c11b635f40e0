#include "core/physics/modal/damping/square_root.hpp"

#include <array>
#include <cmath>

namespace klang::damping {
namespace {

constexpr std::array kParameters = {LawParameter{"root_factor", 0.0, 1e3, true, 1e9, "a of decay = a sqrt(ω)",
                                                 "Decay by the root: decay_per_s = root_factor sqrt(omega)",
                                                 "root factor", "a"}};

class SquareRoot final : public DampingLaw {
 public:
  using DampingLaw::decay_per_s;
  std::string_view name() const override { return "square_root"; }
  std::string_view words() const override { return "square root of the frequency"; }
  std::span<const LawParameter> parameters() const override { return kParameters; }
  double decay_per_s(double omega, const double* p) const override { return p[0] * std::sqrt(omega); }
  void log_gradient(double, const double* p, double* gradient) const override { gradient[0] = 1.0 / p[0]; }
  std::vector<Eigen::VectorXd> starts(const Eigen::ArrayXd& omega, const Eigen::ArrayXd& decay) const override {
    return {Eigen::VectorXd::Constant(1, geometric_mean(decay / omega.sqrt()))};
  }
};

}  // namespace

const DampingLaw& square_root_law() {
  static const SquareRoot law;
  return law;
}

}  // namespace klang::damping
