#include "fit/proxy/proxy_target.hpp"

#include "core/base/conventions.hpp"
#include "core/base/errors.hpp"
#include "core/mesh/inertia.hpp"

namespace klang::fit {

ProxyTarget target_of_model(const modal::ModalModel& model, double rayleigh_mass_per_s, double rayleigh_stiffness_s) {
  if (model.n_modes() < 3) throw InputError("target", "a proxy needs at least 3 modes", std::to_string(model.n_modes()));
  checked("target", "rayleigh_mass_per_s", rayleigh_mass_per_s, 0.0, 1e6);
  checked("target", "rayleigh_stiffness_s", rayleigh_stiffness_s, 0.0, 1.0);
  if (!(rayleigh_mass_per_s + rayleigh_stiffness_s > 0.0)) throw InputError("target", "a model needs damping to sound", {}, "Rayleigh's two, not both 0");
  ProxyTarget target;
  target.moments = mesh::principal_moments(mesh::mass_properties(model.mesh));
  target.shear_speed_m_s = model.material.shear_speed_m_s();
  target.rayleigh_mass_per_s = rayleigh_mass_per_s;
  target.rayleigh_stiffness_s = rayleigh_stiffness_s;
  const double lowest = model.angular_frequency_rad_s[0];
  for (const double omega : model.angular_frequency_rad_s)
    target.voice.push_back({omega / (2.0 * kPi), 0.5 * (rayleigh_mass_per_s + rayleigh_stiffness_s * omega * omega), lowest / omega});
  return target;
}

ProxyTarget target_of_partials(const PartialTable& table) {
  ProxyTarget target;
  for (const Partial& p : table.partials) {
    if (!p.decay_per_s || !p.amplitude || !(*p.decay_per_s > 0.0) || !(*p.amplitude > 0.0)) continue;
    target.voice.push_back({p.frequency_hz, *p.decay_per_s, *p.amplitude});
  }
  if (target.voice.size() < 3)
    throw InputError(table.origin, "a proxy needs at least 3 partials with decay and amplitude", std::to_string(target.voice.size()));
  return target;
}

}  // namespace klang::fit
