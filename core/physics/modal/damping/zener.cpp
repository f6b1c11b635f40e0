#include "core/physics/modal/damping/zener.hpp"

#include <array>

namespace klang::damping {
namespace {

constexpr std::array kParameters = {
    LawParameter{"zener_strength", 0.0, 1.0, true, 1e9, "Δ of decay = Δ/2 · ω · ωτ / (1 + (ωτ)²)",
                 "Strength of a relaxation", "relaxation strength", "Δ"},
    LawParameter{"zener_relaxation_time_s", 0.0, 1e3, true, 1e3, "τ of the same", "Time of the relaxation",
                 "relaxation time", "τ"},
};

class Zener final : public DampingLaw {
 public:
  using DampingLaw::decay_per_s;
  std::string_view name() const override { return "zener"; }
  std::string_view words() const override { return "Zener"; }
  std::span<const LawParameter> parameters() const override { return kParameters; }
  double decay_per_s(double omega, const double* p) const override {
    const double x = omega * p[1];
    return 0.5 * p[0] * omega * x / (1.0 + x * x);
  }
  void log_gradient(double omega, const double* p, double* gradient) const override {
    const double x = omega * p[1];
    gradient[0] = 1.0 / p[0];
    gradient[1] = (1.0 - x * x) / (1.0 + x * x) / p[1];
  }
  std::vector<Eigen::VectorXd> starts(const Eigen::ArrayXd& omega, const Eigen::ArrayXd& decay) const override {
    std::vector<Eigen::VectorXd> all;
    for (const double factor : {0.03, 0.3, 1.0, 3.0, 30.0}) {
      const double tau = factor / geometric_mean(omega);
      const Eigen::ArrayXd x = omega * tau;
      all.emplace_back(Eigen::Vector2d(geometric_mean(2.0 * decay * (1.0 + x.square()) / (omega * x)), tau));
    }
    return all;
  }
};

}  // namespace

const DampingLaw& zener_law() {
  static const Zener law;
  return law;
}

}  // namespace klang::damping
