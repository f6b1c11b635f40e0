#include "core/physics/modal/damping/damping_laws.hpp"

#include <algorithm>
#include <array>

#include "core/physics/modal/damping/loss_factor.hpp"
#include "core/physics/modal/damping/mass_only.hpp"
#include "core/physics/modal/damping/rayleigh.hpp"
#include "core/physics/modal/damping/stiffness_only.hpp"
#include "core/physics/modal/damping/zener.hpp"

namespace klang::damping {
namespace {

struct RegisteredLaw {
  const DampingLaw& (*law)();
  LawUse use;
};

constexpr std::array kLaws = {
    RegisteredLaw{rayleigh_law, LawUse::kOptions},     //
    RegisteredLaw{loss_factor_law, LawUse::kOptions},  //
    RegisteredLaw{mass_only_law, LawUse::kFits},       // Rayleigh's with one number: a question to the data, no more
    RegisteredLaw{stiffness_only_law, LawUse::kFits},  //
    RegisteredLaw{zener_law, LawUse::kRecipes},        //
};

std::vector<const DampingLaw*> laws_for(LawUse use) {
  std::vector<const DampingLaw*> laws;
  for (const RegisteredLaw& entry : kLaws) {
    if (entry.use >= use) laws.push_back(&entry.law());
  }
  return laws;
}

}  // namespace

double geometric_mean(const Eigen::ArrayXd& values) { return std::exp(values.log().mean()); }

Eigen::VectorXd DampingLaw::decay_per_s(const Eigen::VectorXd& omega_rad_s, const double* p) const {
  return omega_rad_s.unaryExpr([&](double omega) { return decay_per_s(omega, p); });
}

const std::vector<const DampingLaw*>& damping_laws(LawUse use) {
  static const std::array laws = {laws_for(LawUse::kFits), laws_for(LawUse::kRecipes), laws_for(LawUse::kOptions)};
  return laws[static_cast<std::size_t>(use)];
}

const DampingLaw* find_law(std::string_view name, LawUse use) {
  for (const DampingLaw* law : damping_laws(use)) {
    if (law->name() == name) return law;
  }
  return nullptr;
}

const DampingLaw* law_of_parameters(const std::vector<std::string>& names) {
  for (const DampingLaw* law : damping_laws()) {
    const auto has = [&](const LawParameter& p) { return std::count(names.begin(), names.end(), p.name) == 1; };
    const auto parameters = law->parameters();
    if (parameters.size() == names.size() && std::all_of(parameters.begin(), parameters.end(), has)) return law;
  }
  return nullptr;
}

bool is_law_parameter(std::string_view name) {
  for (const DampingLaw* law : damping_laws()) {
    for (const LawParameter& parameter : law->parameters()) {
      if (parameter.name == name) return true;
    }
  }
  return false;
}

std::string law_names(LawUse use) {
  std::string text;
  for (const DampingLaw* law : damping_laws(use)) text.append(text.empty() ? "" : ", ").append(law->name());
  return text;
}

}  // namespace klang::damping
