#include "fit/proxy/proxy_model.hpp"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/errors.hpp"
#include "fit/damping/damping.hpp"
#include "fit/proxy/proxy_cost.hpp"

namespace klang::fit {
namespace {

constexpr double kCentsPerNeper = 1200.0 / 0.6931471805599453;

constexpr double kSameRatio = 0.01;

double sq(double x) { return x * x; }

/// Of a cell's mode at |axes| = 1 m; where the cell has not that mode, of its nearest in frequency.
double radiated_power(const soundbank::Cell& cell, const soundbank::ModeId& id, double angular_frequency_rad_s) {
  const soundbank::CellMode* nearest = nullptr;
  for (const soundbank::CellMode& mode : cell.modes) {
    if (mode.id == id) return mode.radiated_power_w;
    if (!nearest || std::abs(mode.angular_frequency_rad_s - angular_frequency_rad_s) <
                        std::abs(nearest->angular_frequency_rad_s - angular_frequency_rad_s))
      nearest = &mode;
  }
  return nearest ? nearest->radiated_power_w : 0.0;
}

}  // namespace

ProxyModel::ProxyModel(const soundbank::Soundbank& bank, const ProxyTarget& target, int n_partials)
    : bank_(bank),
      target_(target),
      speed_(target.shear_speed_m_s > 0.0 ? target.shear_speed_m_s : bank.material.shear_speed_m_s()),
      ln_speed_(std::log(speed_ / (2.0 * kPi))),
      first_(bank, std::min(n_partials, static_cast<int>(target.voice.size()))),
      all_(bank, static_cast<int>(target.voice.size())) {
  const std::size_t n = std::min(static_cast<std::size_t>(n_partials), target.voice.size());
  for (std::size_t k = 0; k < n; ++k) {
    hz_.push_back(target.voice[k].frequency_hz);
    ln_hz_.push_back(std::log(hz_.back()));
  }
  if (!target.radiation) return;
  bool sounds = false;  // single modes may be silent: torsions of bodies of revolution
  for (const soundbank::Cell& cell : bank.cells)
    for (const soundbank::CellMode& mode : cell.modes) sounds = sounds || mode.radiated_power_w > 0.0;
  if (!sounds) throw InputError("bank", "has no sound, but the target has transfer", {}, "a bank built with radiation");
  const double ratio = speed_ / target.radiation->medium.sound_speed_m_s;
  if (!(std::abs(ratio / bank.speed_ratio() - 1.0) <= kSameRatio))
    throw InputError(
        "bank", "its sound is for another ratio of shear speed to sound speed, " + klang::to_text(bank.speed_ratio()),
        klang::to_text(ratio), "the same to 1 %");
  cells_ = std::make_unique<soundbank::ProxyFinder>(bank);
  // At equal ka and unit modal velocity P = 1/2 rho c sigma int v^2 dS, with v^2 as 1 / density of the solid.
  const acoustics::Medium& gas = target.radiation->medium;
  power_factor_ = gas.density_kg_m3 * gas.sound_speed_m_s / (bank.medium.density_kg_m3 * bank.medium.sound_speed_m_s) *
                  bank.material.density_kg_m3 / target.radiation->solid_density_kg_m3;
}

ProxyPoint ProxyModel::at_axes(const Eigen::Vector3d& axes) const {
  const double depth = -std::log(bank_.thinnest);
  Eigen::Vector3d sorted = axes.cwiseMax(1e-12);
  std::sort(sorted.begin(), sorted.end());
  const double u = std::clamp(std::log(sorted[0] / sorted[2]), -depth, 0.0),
               v = std::clamp(std::log(sorted[1] / sorted[2]), u, 0.0);
  ProxyPoint point;
  point.s = -u / depth;
  point.t = u < 0.0 ? v / u : 0.5;
  const auto place = soundbank::locate(bank_, shape_of_square(bank_, point.s, point.t));
  point.ln_scale = std::log(soundbank::lowest_frequency(bank_, place)) + ln_speed_ - ln_hz_[0];
  return point;
}

void ProxyModel::log_ratios(double s, double t, std::vector<double>& ratios) const {
  thread_local std::vector<ProxyFrequencies::Line> lines;
  first_.lowest(soundbank::locate(bank_, shape_of_square(bank_, s, t)), lines);
  ratios.clear();
  if (lines.size() < ln_hz_.size()) return;
  for (std::size_t k = 0; k < ln_hz_.size(); ++k) ratios.push_back(lines[k].ln_frequency + ln_speed_ - ln_hz_[k]);
}

double ProxyModel::rms_cents(const ProxyPoint& point) const {
  thread_local std::vector<double> ratios;
  log_ratios(point.s, point.t, ratios);
  if (ratios.empty()) return HUGE_VAL;
  double sum = 0.0;
  for (const double ratio : ratios) sum += sq(ratio - point.ln_scale);
  return kCentsPerNeper * std::sqrt(sum / static_cast<double>(ratios.size()));
}

RayleighDamping ProxyModel::damping(const ProxyPoint& point, const RayleighDamping& kept) const {
  if (point.refitted_mass == 0.0 && point.refitted_stiffness == 0.0) return kept;
  // Least squares of x mass + y stiffness = 1 with x = 1 / (2 d), y = omega^2 / (2 d), neither negative.
  double xx = 0.0, xy = 0.0, yy = 0.0, x1 = 0.0, y1 = 0.0;
  const Voice proxy = voice(point, {});
  for (std::size_t k = 0; k < std::min(ln_hz_.size(), proxy.size()); ++k) {
    const double d = target_.voice[k].decay_per_s;
    const double x = 0.5 / d, y = x * sq(2.0 * kPi * proxy[k].frequency_hz), one = 1.0 - proxy[k].decay_per_s / d;
    xx += x * x;
    xy += x * y;
    yy += y * y;
    x1 += x * one;
    y1 += y * one;
  }
  const double determinant = xx * yy - xy * xy;
  RayleighDamping best;
  if (determinant > 1e-12 * xx * yy) {
    best = {.stiffness_s = (y1 * xx - x1 * xy) / determinant, .mass_per_s = (x1 * yy - y1 * xy) / determinant};
  }
  if (!(best.mass_per_s > 0.0)) best = {.stiffness_s = std::max(y1 / yy, 0.0), .mass_per_s = 0.0};
  if (!(best.stiffness_s > 0.0)) best = {.stiffness_s = 0.0, .mass_per_s = std::max(x1 / xx, 0.0)};
  return {
      .stiffness_s = std::max(kept.stiffness_s + point.refitted_stiffness * (best.stiffness_s - kept.stiffness_s), 0.0),
      .mass_per_s = std::max(kept.mass_per_s + point.refitted_mass * (best.mass_per_s - kept.mass_per_s), 0.0)};
}

RayleighDamping ProxyModel::measured_damping(const ProxyPoint& point) const {
  std::vector<DecayPoint> decays;
  const Voice proxy = voice(point, {});
  for (std::size_t k = 0; k < std::min(ln_hz_.size(), proxy.size()); ++k)
    decays.push_back({proxy[k].frequency_hz, target_.voice[k].decay_per_s, 0.0, 0.0, 0.0});
  std::vector<std::string> unheard;
  const DampingResult damping = fit_damping(decays, unheard);
  const DampingCandidate* rayleigh = find_candidate(damping, damping::rayleigh_law());
  if (!rayleigh) return {};
  return {.stiffness_s = rayleigh->parameters[0].value, .mass_per_s = rayleigh->parameters[1].value};
}

Voice ProxyModel::voice(const ProxyPoint& point, const RayleighDamping& damping) const {
  thread_local std::vector<ProxyFrequencies::Line> lines;
  all_.lowest(soundbank::locate(bank_, shape_of_square(bank_, point.s, point.t)), lines);
  const soundbank::Cell* cell = nullptr;
  if (cells_) {
    double distance = 0.0;
    cell = &bank_.cells[static_cast<std::size_t>(
        cells_->nearest_cell(soundbank::unit_axes(shape_of_square(bank_, point.s, point.t)), distance))];
  }
  Voice voice;
  for (const ProxyFrequencies::Line& line : lines) {
    const double hz = std::exp(line.ln_frequency + ln_speed_ - point.ln_scale), omega = 2.0 * kPi * hz;
    VoicePartial partial{hz, damping.decay_per_s(omega), 1.0 / omega};
    if (cell) {
      const double power =
          power_factor_ *
          radiated_power(*cell, line.id, std::exp(line.ln_frequency) * bank_.material.shear_speed_m_s()) /
          std::exp(point.ln_scale);
      partial.amplitude = far_amplitude_pa(power, target_.radiation->medium);
      partial.decay_per_s += power;  // over twice the energy of unit modal velocity, 1 J
    }
    voice.push_back(partial);
  }
  return voice;
}

}  // namespace klang::fit
