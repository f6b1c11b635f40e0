#include "apps/kit/strike_options.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "apps/kit/body_options.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/physics/modal/damping/damping_laws.hpp"
#include "fit/instrument/banks.hpp"

namespace klang::apps {

namespace {

const auto& laws() { return damping::damping_laws(damping::LawUse::kOptions); }

std::string option_of(const damping::LawParameter& parameter) {
  std::string option = "--" + std::string(parameter.name);
  std::replace(option.begin(), option.end(), '_', '-');
  return option;
}

/// visit(parameter, value) of every law's parameters in order.
template <class Options, class Visit>
void for_each_parameter(Options& options, Visit&& visit) {
  for (std::size_t i = 0; i < laws().size(); ++i) {
    const auto parameters = laws()[i]->parameters();
    for (std::size_t j = 0; j < parameters.size(); ++j) visit(parameters[j], options.parameters[i][j]);
  }
}

}  // namespace

DampingOptions::DampingOptions() {
  for (const damping::DampingLaw* law : laws()) parameters.emplace_back(law->parameters().size(), 0.0);
}

bool DampingOptions::any() const {
  bool any = false;
  for_each_parameter(*this, [&](const damping::LawParameter&, double value) { any = any || value != 0.0; });
  return any;
}

void DampingOptions::validate() const {
  for_each_parameter(*this, [](const damping::LawParameter& p, double value) {
    checked("command line", option_of(p), value, p.low, p.high);
  });
}

void DampingOptions::write(nlohmann::json& options) const {
  for_each_parameter(*this,
                     [&](const damping::LawParameter& p, double value) { options[std::string(p.name)] = value; });
}

void add_damping_options(CLI::App& app, DampingOptions& damping) {
  for_each_parameter(damping, [&](const damping::LawParameter& p, double& value) {
    app.add_option(option_of(p), value, std::string(p.option_meaning))
        ->capture_default_str()
        ->each([&damping](const std::string&) { damping.given = true; });
  });
}

std::string damping_option_names() {
  std::vector<std::string> names;
  const DampingOptions all;
  for_each_parameter(all, [&](const damping::LawParameter& p, double) { names.push_back(option_of(p)); });
  std::string text;
  for (std::size_t i = 0; i < names.size(); ++i)
    text += (i == 0 ? "" : i + 1 < names.size() ? ", " : " or ") + names[i];
  return text;
}

void add_strike_option(CLI::App& app, std::vector<std::string>& strikes) {
  app.add_option("--strike", strikes,
                 "A strike, may be repeated: time_s=..,x_m=..,y_m=..,z_m=..,fx_n_s=..,fy_n_s=..,fz_n_s=..,contact_s=.. "
                 "(the nearest node is struck; contact_s: standard deviation of the Gaussian force)");
}

Eigen::VectorXd decay_per_s(const DampingOptions& damping, const modal::ModalModel& model) {
  const Eigen::VectorXd& omega = model.angular_frequency_rad_s;
  Eigen::VectorXd decay = laws()[0]->decay_per_s(omega, damping.parameters[0].data());
  for (std::size_t i = 1; i < laws().size(); ++i) decay += laws()[i]->decay_per_s(omega, damping.parameters[i].data());
  return decay;
}

std::vector<events::Strike> read_strikes(const std::vector<std::string>& texts, double duration_s,
                                         const modal::ModalModel& model) {
  std::vector<events::Strike> strikes;
  for (const std::string& text : texts) {
    auto values = parse_assignments("--strike", text);
    const auto take = [&](const char* name, double fallback) {
      const auto found = values.find(name);
      if (found == values.end()) return fallback;
      const double value = found->second;
      values.erase(found);
      return checked("--strike", name, value, -1e6, 1e6);
    };
    events::Strike strike;
    strike.shape = events::PulseShape::kGaussian;
    strike.time_s = checked("--strike", "time_s", take("time_s", 0.0), 0.0, duration_s);
    const double x_m = take("x_m", 0.0), y_m = take("y_m", 0.0), z_m = take("z_m", 0.0);
    strike.point_m = {x_m, y_m, z_m};
    const double fx = take("fx_n_s", 0.0), fy = take("fy_n_s", 0.0), fz = take("fz_n_s", 0.0);
    strike.impulse_n_s = {fx, fy, fz};
    strike.duration_s = checked("--strike", "contact_s", take("contact_s", 0.0), 0.0, 0.1);
    if (!values.empty()) {
      throw InputError("--strike", "has an unknown name", values.begin()->first,
                       "time_s, x_m, y_m, z_m, fx_n_s, fy_n_s, fz_n_s, contact_s");
    }
    if (!(strike.impulse_n_s.norm() > 0.0))
      throw InputError("--strike", "has no impulse", text, "fx_n_s, fy_n_s, fz_n_s");
    strikes.push_back(strike);
  }
  if (strikes.empty()) {
    strikes.push_back(fit::default_strike(model));
  }
  return strikes;
}

}  // namespace klang::apps
