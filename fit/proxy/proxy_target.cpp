#include "fit/proxy/proxy_target.hpp"

#include <cmath>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/geometry/mesh/mass_properties.hpp"

namespace klang::fit {

ProxyTarget target_of_model(const modal::ModalModel& model, const damping::RayleighDamping& damping) {
  if (model.n_modes() < 3)
    throw InputError("target", "a proxy needs at least 3 modes", std::to_string(model.n_modes()));
  checked("target", "rayleigh_mass_per_s", damping.mass_per_s, 0.0, 1e6);
  checked("target", "rayleigh_stiffness_s", damping.stiffness_s, 0.0, 1.0);
  if (!(damping.mass_per_s + damping.stiffness_s > 0.0))
    throw InputError("target", "a model needs damping to sound", {}, "Rayleigh's two, not both 0");
  ProxyTarget target;
  target.moments = mesh::principal_moments(mesh::mass_properties(model.mesh));
  target.shear_speed_m_s = model.material.shear_speed_m_s();
  target.damping = damping;
  const double lowest = model.angular_frequency_rad_s[0];
  for (const double omega : model.angular_frequency_rad_s)
    target.voice.push_back({omega / (2.0 * kPi), damping.decay_per_s(omega), lowest / omega});
  return target;
}

double far_amplitude_pa(double radiated_power_w, const acoustics::Medium& medium) {
  return std::sqrt(2.0 * medium.density_kg_m3 * medium.sound_speed_m_s * radiated_power_w / (4.0 * kPi));
}

ProxyTarget target_of_model(const modal::ModalModel& model, const acoustics::TransferModel& transfer,
                            const damping::RayleighDamping& damping) {
  ProxyTarget target = target_of_model(model, damping);
  std::size_t n = 0;
  while (n < transfer.modes.size() && n < target.voice.size() && transfer.modes[n].mode == static_cast<int>(n)) {
    target.voice[n].amplitude = far_amplitude_pa(transfer.modes[n].radiated_power_w, transfer.medium);
    target.voice[n].decay_per_s += transfer.modes[n].decay_radiation_per_s;
    ++n;
  }
  if (n < 3) throw InputError("target", "a proxy needs the transfer of the first 3 modes", std::to_string(n));
  target.voice.resize(n);
  target.radiation = {transfer.medium, model.material.density_kg_m3};
  return target;
}

ProxyTarget target_of_partials(const PartialTable& table) {
  ProxyTarget target;
  for (const Partial& p : table.partials) {
    if (!p.decay_per_s || !p.amplitude || !(*p.decay_per_s > 0.0) || !(*p.amplitude > 0.0)) continue;
    target.voice.push_back({p.frequency_hz, *p.decay_per_s, *p.amplitude});
  }
  if (target.voice.size() < 3)
    throw InputError(table.origin, "a proxy needs at least 3 partials with decay and amplitude",
                     std::to_string(target.voice.size()));
  return target;
}

}  // namespace klang::fit
