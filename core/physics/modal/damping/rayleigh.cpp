#include "core/physics/modal/damping/rayleigh.hpp"

#include <array>

namespace klang::damping {
namespace {

constexpr std::array kParameters = {
    LawParameter{"rayleigh_stiffness_s", 0.0, 1.0, false, 1e9, "a of decay = (a ω² + b) / 2",
                 "Damping C = this K + rayleigh_mass_per_s M", "stiffness damping", "α"},
    LawParameter{"rayleigh_mass_per_s", 0.0, 1e6, false, 1e9, "b of decay = (a ω² + b) / 2",
                 "Damping proportional to the mass", "mass damping", "β"},
};

class Rayleigh final : public DampingLaw {
 public:
  std::string_view name() const override { return "rayleigh"; }
  std::string_view words() const override { return "Rayleigh"; }
  std::span<const LawParameter> parameters() const override { return kParameters; }
  double decay_per_s(double omega, const double* p) const override { return of(p).decay_per_s(omega); }
  Eigen::VectorXd decay_per_s(const Eigen::VectorXd& omega, const double* p) const override {
    return of(p).decay_per_s(omega);
  }
  void log_gradient(double omega, const double* p, double* gradient) const override {
    const double decay = decay_per_s(omega, p);
    gradient[0] = 0.5 * omega * omega / decay;
    gradient[1] = 0.5 / decay;
  }
  std::vector<Eigen::VectorXd> starts(const Eigen::ArrayXd& omega, const Eigen::ArrayXd& decay) const override {
    const double stiffness = geometric_mean(2.0 * decay / omega.square()), mass = geometric_mean(2.0 * decay);
    return {Eigen::Vector2d(0.5 * stiffness, 0.5 * mass), Eigen::Vector2d(stiffness, 0.05 * mass),
            Eigen::Vector2d(0.05 * stiffness, mass)};
  }

 private:
  static RayleighDamping of(const double* p) { return {.stiffness_s = p[0], .mass_per_s = p[1]}; }
};

}  // namespace

double RayleighDamping::decay_per_s(double omega) const { return 0.5 * (stiffness_s * omega * omega + mass_per_s); }

Eigen::VectorXd RayleighDamping::decay_per_s(const Eigen::VectorXd& omega) const {
  return 0.5 * (stiffness_s * omega.array().square() + mass_per_s);
}

const DampingLaw& rayleigh_law() {
  static const Rayleigh law;
  return law;
}

const LawParameter& rayleigh_stiffness_parameter() { return kParameters[0]; }
const LawParameter& rayleigh_mass_parameter() { return kParameters[1]; }

}  // namespace klang::damping
