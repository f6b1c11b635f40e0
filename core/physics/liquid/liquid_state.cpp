#include <algorithm>
#include <istream>
#include <ostream>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/sealed_file.hpp"
#include "core/physics/liquid/liquid_step.hpp"

namespace klang::liquid {
namespace {

constexpr std::uint64_t kMagic = 0x3453514c474e4c4bULL;  // "KLNGLQS4"

constexpr const char* kName = "checkpoint";

template <class T>
T get(std::istream& in) {
  return read_value<T>(in, kName);
}
/// @param most  entries that there can be
template <class T>
void get_list(std::istream& in, std::vector<T>& values, std::uint64_t most) {
  const auto n = get<std::uint64_t>(in);
  if (n > most) throw InputError(kName, "does not belong to this scene");
  read_list(in, values, n, kName);
}
void get_field(std::istream& in, Field& field) {
  const std::size_t n = field.size();
  get_list(in, field.data(), n);
  if (field.size() != n) throw InputError(kName, "does not belong to this scene");
}

}  // namespace

void Liquid::save(std::ostream& out) const {
  write_value(out, kMagic);
  write_value(out, time_s_);
  write_value(out, pending_kick_s_);
  write_value(out, n_steps_);
  for (const double value : {volume_, start_volume_, inflow_, outflow_, source_per_s_}) write_value(out, value);
  write_list(out, emitted_);
  for (const Solid& solid : solids_) {
    write_value(out, solid.position_m);
    write_value(out, solid.velocity_m_s);
  }
  write_list(out, phi_.data());
  write_list(out, pressure_.data());
  for (int axis = 0; axis < 3; ++axis) write_list(out, u_[axis].data());
  write_list(out, particles_.x_m);
  write_list(out, particles_.v_m_s);
  write_list(out, particles_.affine_per_s);
  write_list(out, particles_.phi_m);
}

void Liquid::load(std::istream& in) {
  if (get<std::uint64_t>(in) != kMagic) throw InputError(kName, "is none");
  time_s_ = get<double>(in);
  pending_kick_s_ = get<double>(in);
  n_steps_ = get<std::uint64_t>(in);
  for (double* value : {&volume_, &start_volume_, &inflow_, &outflow_, &source_per_s_}) *value = get<double>(in);
  const std::size_t n_inlets = emitted_.size();
  get_list(in, emitted_, n_inlets);
  if (emitted_.size() != n_inlets) throw InputError(kName, "does not belong to this scene");
  for (Solid& solid : solids_) {
    solid.position_m = get<Eigen::Vector3d>(in);
    solid.velocity_m_s = get<Eigen::Vector3d>(in);
  }
  get_field(in, phi_);
  get_field(in, pressure_);
  for (int axis = 0; axis < 3; ++axis) get_field(in, u_[axis]);
  constexpr std::uint64_t kMost = std::uint64_t{1} << 31;
  get_list(in, particles_.x_m, kMost);
  get_list(in, particles_.v_m_s, kMost);
  get_list(in, particles_.affine_per_s, kMost);
  get_list(in, particles_.phi_m, kMost);
  if (particles_.v_m_s.size() != particles_.size() || particles_.affine_per_s.size() != particles_.size() ||
      particles_.phi_m.size() != particles_.size())
    throw InputError(kName, "does not belong to this scene");
  for (const Eigen::Vector3d& x : particles_.x_m)
    if (!x.allFinite()) throw InputError(kName, "is damaged");
  keep_.clear();
  solid_ = setup_.round ? liquid::sector_field(setup_.shape) : liquid::solid_field(setup_.shape, solids_);
  particles_.sort(setup_.shape);
}

double Liquid::centre_of_mass_z_m() const {
  double sum = 0.0;
  for (const Eigen::Vector3d& x : particles_.x_m) sum += x.z();
  return sum / static_cast<double>(std::max<std::size_t>(particles_.size(), 1));
}

}  // namespace klang::liquid
