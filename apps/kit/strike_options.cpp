#include "apps/kit/strike_options.hpp"

#include "apps/kit/body_options.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/sound/stage/oscillator_bank.hpp"

namespace klang::apps {

void DampingOptions::validate() const {
  checked("command line", "--rayleigh-stiffness-s", rayleigh_stiffness_s, 0.0, 1.0);
  checked("command line", "--rayleigh-mass-per-s", rayleigh_mass_per_s, 0.0, 1e6);
  checked("command line", "--loss-factor", loss_factor, 0.0, 1.0);
}

void add_damping_options(CLI::App& app, DampingOptions& damping) {
  app.add_option("--rayleigh-stiffness-s", damping.rayleigh_stiffness_s, "Damping C = this K + rayleigh_mass_per_s M")
      ->capture_default_str();
  app.add_option("--rayleigh-mass-per-s", damping.rayleigh_mass_per_s, "Damping proportional to the mass")
      ->capture_default_str();
  app.add_option("--loss-factor", damping.loss_factor, "Constant loss factor: decay_per_s = loss_factor omega / 2")
      ->capture_default_str();
}

void add_strike_option(CLI::App& app, std::vector<std::string>& strikes) {
  app.add_option("--strike", strikes,
                 "A strike, may be repeated: time_s=..,x_m=..,y_m=..,z_m=..,fx_n_s=..,fy_n_s=..,fz_n_s=..,contact_s=.. "
                 "(the nearest node is struck; contact_s: standard deviation of the Gaussian force)");
}

Eigen::VectorXd decay_per_s(const DampingOptions& damping, const modal::ModalModel& model) {
  return modal::rayleigh_decay_per_s(model.angular_frequency_rad_s, damping.rayleigh_stiffness_s,
                                     damping.rayleigh_mass_per_s) +
         0.5 * damping.loss_factor * model.angular_frequency_rad_s;
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
    const Eigen::RowVector3d low = model.mesh.nodes_m.colwise().minCoeff();
    const Eigen::RowVector3d size = model.mesh.nodes_m.colwise().maxCoeff() - low;
    Eigen::Index thin = 0, along = 0;
    size.minCoeff(&thin);
    size.maxCoeff(&along);
    events::Strike strike;
    strike.shape = events::PulseShape::kGaussian;
    Eigen::Vector3d end = (low + 0.5 * size).transpose();
    end[along] = low[along] + size[along];
    strike.point_m = end;
    strike.impulse_n_s[thin] = 1.0;
    strike.duration_s = 2e-5;
    strikes.push_back(strike);
  }
  return strikes;
}

}  // namespace klang::apps
