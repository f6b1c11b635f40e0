#include "core/physics/fracture/dynamic/explicit_solid.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>

#include "core/foundation/base/check.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/parallel.hpp"
#include "core/physics/fracture/dynamic/detail/at.hpp"
#include "core/physics/fracture/dynamic/detail/element_kernel.hpp"

namespace klang::fracture {
namespace {

using Eigen::Vector3d;

using detail::at;
/// That many at once on a thread: below, what sharing them costs is as much.
constexpr std::size_t kBlocksAtOnce = 32, kNodesAtOnce = 256;

Eigen::Map<Eigen::ArrayXd> flat(std::vector<Vector3d>& values, std::size_t begin, std::size_t end) {
  return {values[begin].data(), 3 * static_cast<Eigen::Index>(end - begin)};
}
Vector3d row(const std::vector<double>& values, std::size_t node) {
  return {values[3 * node], values[3 * node + 1], values[3 * node + 2]};
}

void validate(const SolidOptions& options) {
  solid::validate(options.material);
  options.plasticity.validate();
  const double phi = options.viscosity_lambda_pa_s, psi = options.viscosity_mu_pa_s;
  if (!(psi >= 0.0 && 3.0 * phi + 2.0 * psi >= 0.0 && std::isfinite(phi + psi)))
    throw InputError("viscosity", "gives energy back", to_text(phi) + ", " + to_text(psi),
                     "viscosity_mu_pa_s >= 0 and viscosity_lambda_pa_s + 2/3 of it >= 0");
  if (options.integrator != Integrator::kLeapfrog && !(psi > 0.0))
    throw InputError("integrator", "grows at any step without viscosity (erratum 63)", to_text(options.integrator),
                     "leapfrog, or a viscosity_mu_pa_s above 0");
}

}  // namespace

struct ExplicitSolid::ElementForces {
  detail::CornerForces forces;
  std::vector<detail::BlockSums> sums;
  detail::NodeTerms terms;
};

ExplicitSolid::~ExplicitSolid() = default;
ExplicitSolid::ExplicitSolid(ExplicitSolid&& other) noexcept = default;
ExplicitSolid& ExplicitSolid::operator=(ExplicitSolid&& other) noexcept = default;

ExplicitSolid::ExplicitSolid(CrackMesh mesh, const SolidOptions& options, std::vector<HoldPath> holds, Pushes pushes)
    : mesh_(std::move(mesh)),
      options_(options),
      holds_(std::move(holds)),
      make_pushes_(std::move(pushes)),
      elements_(std::make_unique<ElementForces>()) {
  validate(options_);
  for (std::size_t i = 0; i < mesh_.held.size(); ++i) {
    if (mesh_.held[i] < 0) continue;
    KLANG_CHECK(at(mesh_.held[i]) < holds_.size(), "a node is held by nothing");
    mesh_.velocity_m_s[i] = holds_[at(mesh_.held[i])].velocity_m_s(0.0);
  }
  mean_mass_kg_ = mesh_.mass_kg() / static_cast<double>(mesh_.n_nodes());
  refresh();
}

void ExplicitSolid::refresh() {
  const std::size_t n = mesh_.rest_m.size();
  for (std::size_t i = hold_origin_m_.size(); i < n; ++i) {
    const int hold = mesh_.held[i];
    hold_origin_m_.push_back(hold < 0 ? Vector3d::Zero()
                                      : Vector3d(mesh_.place_m[i] - holds_[at(hold)].displacement_m(time_s_)));
  }
  acceleration_.resize(n, Vector3d::Zero());
  const double term_before = acceleration_term_, pressed_before = contact_ ? contact_->last().energy_j : 0.0;
  update_limits();
  if (options_.self_contact && !contact_) {
    const double dt_s = step_limit_s();
    contact_.emplace(ElementContact::Pairs::kOwn, kElementContactRate / (dt_s * dt_s),
                     [friction = options_.self_friction](int, int) { return friction; });
  }
  compute_forces();
  if (contact_ && last_dt_s_ > 0.0) stepping_lost_j_ += pressed_before - contact_->last().energy_j;
  stepping_lost_j_ += (acceleration_term_ - term_before) * last_dt_s_ * last_dt_s_;
}

void ExplicitSolid::update_limits() {
  if (changes_seen_ == mesh_.n_changes()) return;
  changes_seen_ = mesh_.n_changes();
  elements_->terms.read(mesh_);
  held_.clear();
  for (std::size_t i = 0; i < mesh_.held.size(); ++i)
    if (mesh_.held[i] >= 0) held_.push_back(i);
  const std::size_t n = at(mesh_.n_elements());
  const bool is_first = limit_of_.empty();
  limit_of_.resize(2 * n, 0.0);  // limit and the volume it belongs to
  rest_limit_s_ = HUGE_VAL;
  double largest_ratio = 0.0;
  const double rho = options_.material.density_kg_m3;
  for (std::size_t e = 0; e < n; ++e) {
    const double volume = mesh_.volume_m3(static_cast<int>(e));
    if (limit_of_[2 * e + 1] != volume) {
      const Eigen::Matrix3d beta = mesh_.beta_of(static_cast<int>(e));
      const double omega =
          std::sqrt(element_omega_sq(beta, options_.material.lame_lambda_pa, options_.material.lame_mu_pa, rho));
      const double rate = element_omega_sq(beta, options_.viscosity_lambda_pa_s, options_.viscosity_mu_pa_s, rho);
      const double ratio = 0.5 * rate / omega;
      largest_ratio = std::max(largest_ratio, ratio);
      if (ratio > largest_ratio_) mesh_.set_damping_share(static_cast<int>(e), largest_ratio_ / ratio);
      limit_of_[2 * e] = largest_step_s(options_.integrator, omega, std::min(ratio, largest_ratio_));
      limit_of_[2 * e + 1] = volume;
    }
    rest_limit_s_ = std::min(rest_limit_s_, limit_of_[2 * e]);
  }
  if (is_first && options_.damping_cap > 0.0) largest_ratio_ = std::max(options_.damping_cap, largest_ratio);
}

double ExplicitSolid::step_limit_s() const { return options_.safety * rest_limit_s_ / stretch_; }

/// Elements, then nodes, each on its own and with its sum in the elements' order: any number of threads gives the same bits.
void ExplicitSolid::compute_element_forces() {
  const std::size_t n_blocks = mesh_.blocks.size();
  const bool damped = options_.viscosity_mu_pa_s > 0.0 || options_.viscosity_lambda_pa_s > 0.0;
  elements_->forces.resize(n_blocks, damped);
  elements_->sums.resize(n_blocks);
  stress_sq_.resize(n_blocks * kLanes);
  const detail::KernelConstants constants = {options_.material.lame_lambda_pa, options_.material.lame_mu_pa,
                                             options_.viscosity_lambda_pa_s,   options_.viscosity_mu_pa_s,
                                             options_.plasticity.gamma1,       options_.plasticity.gamma2};
  parallel_for(n_blocks, kBlocksAtOnce, [&](std::size_t begin, std::size_t end) {
    detail::element_forces(mesh_.blocks.data() + begin, end - begin, mesh_.place_m.front().data(),
                           mesh_.velocity_m_s.front().data(), constants,
                           {elements_->forces.of_block(begin), damped, elements_->sums.data() + begin,
                            stress_sq_.data() + begin * kLanes});
  });
  const detail::KernelSums sums = detail::sum_of(elements_->sums);
  if (!(sums.least_det > 0.0)) {
    int element = 0;
    while (element + 1 < mesh_.n_elements() && mesh_.gradient_of(element).determinant() > 0.0) ++element;
    throw NumericalError("element " + std::to_string(element) + " is inverted at " + to_text(time_s_) +
                         " s (St Venant-Kirchhoff gives way below 58 % of its length, erratum 20)");
  }
  energies_.elastic_j = sums.elastic_j;
  energies_.plastic_j += sums.dissipated_j;
  stretch_ = std::sqrt(1.0 + 1.5 * std::sqrt(sums.largest_strain_sq));
}

void ExplicitSolid::compute_forces() {
  compute_element_forces();
  pushes_now_.clear();
  if (make_pushes_) make_pushes_(mesh_, time_s_, pushes_now_);
  rub_now_.clear();
  std::array<const NodeForces*, 2> contacts = {nullptr, nullptr};
  if (contact_) {
    const ElementContact::Forces& forces = contact_->forces({&mesh_}, last_dt_s_ > 0.0 ? last_dt_s_ : step_limit_s());
    if (forces.any()) contacts[0] = &forces.of.front();
  }
  if (mutual_) contacts[1] = &mutual_();
  const std::size_t n = mesh_.rest_m.size();
  const bool damped = elements_->forces.is_damped(), pushed = contacts[0] || contacts[1] || !pushes_now_.empty();
  elastic_.resize(3 * n);
  if (damped) viscous_.resize(3 * n);
  node_terms_.resize(n);
  const double share = options_.integrator == Integrator::kLeapfrog ? 0.125 : 0.0;
  const auto finish = [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      acceleration_[i] = acceleration_[i] / mesh_.mass_kg_of[i] + options_.gravity_m_s2;
      node_terms_[i] = mesh_.held[i] < 0 ? share * mesh_.mass_kg_of[i] * acceleration_[i].squaredNorm() : 0.0;
    }
  };
  parallel_for(n, kNodesAtOnce, [&](std::size_t begin, std::size_t end) {
    detail::gather_forces(elements_->terms, begin, end, elements_->forces, elastic_.data(), viscous_.data());
    for (std::size_t i = begin; i < end; ++i) {
      acceleration_[i] = row(elastic_, i);
      if (damped) acceleration_[i] += row(viscous_, i);
    }
    if (!pushed) finish(begin, end);
  });
  if (pushed) {
    for (const NodePush& push : pushes_now_) acceleration_[at(push.node)] += push.normal_n + push.friction_n;
    for (const NodeForces* forces : contacts)
      if (forces != nullptr) add_contact(*forces);
    parallel_for(n, kNodesAtOnce, finish);
  }
  acceleration_term_ = 0.0;
  for (const double term : node_terms_) acceleration_term_ += term;
}

void ExplicitSolid::add_contact(const NodeForces& forces) {
  for (std::size_t i = 0; i < forces.normal_n.size(); ++i) {
    acceleration_[i] += forces.normal_n[i] + forces.friction_n[i];
    if (!forces.friction_n[i].isZero(0.0))
      rub_now_.push_back({static_cast<int>(i), Vector3d::Zero(), forces.friction_n[i]});
  }
}

void ExplicitSolid::move_held(double dt_s, bool places) {
  for (const std::size_t i : held_) {
    const HoldPath& hold = holds_[at(mesh_.held[i])];
    if (places) {
      mesh_.place_m[i] = hold_origin_m_[i] + hold.displacement_m(time_s_ + dt_s);
      mesh_.velocity_m_s[i] = (mesh_.place_m[i] - place_before_[i]) / dt_s;
    } else {
      mesh_.velocity_m_s[i] = hold.velocity_m_s(time_s_);
    }
  }
}

void ExplicitSolid::step(double dt_s) {
  go(dt_s);
  arrive();
}

void ExplicitSolid::go(double dt_s) {
  const std::size_t n = mesh_.rest_m.size();
  stepping_lost_j_ += acceleration_term_ * (dt_s * dt_s - last_dt_s_ * last_dt_s_);
  last_dt_s_ = dt_s;
  std::swap(viscous_before_, viscous_);  // viscous_ is made anew on arrival
  pushes_before_ = pushes_now_;
  rub_before_ = rub_now_;
  total_before_.resize(n);
  for (const std::size_t i : held_) total_before_[i] = mesh_.mass_kg_of[i] * acceleration_[i];
  const bool leapfrog = options_.integrator == Integrator::kLeapfrog;
  const double drift = options_.integrator == Integrator::kTaylor ? 0.5 * dt_s * dt_s : 0.0;
  place_before_.resize(n);
  velocity_before_.resize(n);
  parallel_for(n, kNodesAtOnce, [&](std::size_t begin, std::size_t end) {
    Eigen::Map<Eigen::ArrayXd> place = flat(mesh_.place_m, begin, end), velocity = flat(mesh_.velocity_m_s, begin, end);
    const Eigen::Map<Eigen::ArrayXd> acceleration = flat(acceleration_, begin, end);
    flat(place_before_, begin, end) = place;
    flat(velocity_before_, begin, end) = velocity;
    if (leapfrog) {
      velocity += (0.5 * dt_s) * acceleration;
      place += dt_s * velocity;
    } else {
      place += dt_s * velocity + drift * acceleration;
      velocity += dt_s * acceleration;
    }
  });
  move_held(dt_s, true);
  time_s_ += dt_s;
}

void ExplicitSolid::arrive() {
  compute_forces();
  if (options_.integrator == Integrator::kLeapfrog)
    parallel_for(acceleration_.size(), kNodesAtOnce, [&](std::size_t begin, std::size_t end) {
      flat(mesh_.velocity_m_s, begin, end) += (0.5 * last_dt_s_) * flat(acceleration_, begin, end);
    });
  move_held(last_dt_s_, false);
  book(last_dt_s_);
}

/// Work of the mean force over what each node moved (Euler and Taylor: of the first force over the mean velocity): what they do to the
/// kinetic energy as energies() has it, exactly.
void ExplicitSolid::book(double dt_s) {
  const bool leapfrog = options_.integrator == Integrator::kLeapfrog;
  const double before = leapfrog ? 0.5 : 1.0, after = leapfrog ? 0.5 : 0.0;
  const auto moved = [&](std::size_t i) -> Vector3d {
    if (leapfrog || mesh_.held[i] >= 0) return mesh_.place_m[i] - place_before_[i];
    return 0.5 * dt_s * (velocity_before_[i] + mesh_.velocity_m_s[i]);
  };
  if (!viscous_.empty()) {
    parallel_for(mesh_.rest_m.size(), kNodesAtOnce, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i)
        node_terms_[i] = (before * row(viscous_before_, i) + after * row(viscous_, i)).dot(moved(i));
    });
    for (const double term : node_terms_) energies_.viscous_j -= term;
  }
  for (const std::size_t i : held_) {
    const double mass = mesh_.mass_kg_of[i];
    energies_.work_j += 0.5 * mass * (mesh_.velocity_m_s[i].squaredNorm() - velocity_before_[i].squaredNorm()) -
                        (before * total_before_[i] + after * mass * acceleration_[i]).dot(moved(i));
  }
  for (const bool now : {false, true}) {
    const double share = now ? after : before;
    for (const NodePush& push : now ? pushes_now_ : pushes_before_) {
      const Vector3d d = moved(at(push.node));
      energies_.contact_j -= share * push.normal_n.dot(d);
      energies_.friction_j -= share * push.friction_n.dot(d);
    }
    for (const NodePush& rub : now ? rub_now_ : rub_before_)
      energies_.friction_j -= share * rub.friction_n.dot(moved(at(rub.node)));
  }
}

SolidEnergies ExplicitSolid::energies() const {
  SolidEnergies now = energies_;
  for (std::size_t i = 0; i < mesh_.rest_m.size(); ++i) {
    now.kinetic_j += 0.5 * mesh_.mass_kg_of[i] * mesh_.velocity_m_s[i].squaredNorm();
    now.potential_j -= mesh_.mass_kg_of[i] * options_.gravity_m_s2.dot(mesh_.place_m[i]);
  }
  now.kinetic_j -= acceleration_term_ * last_dt_s_ * last_dt_s_;
  now.lost_j = mesh_.lost_j() + stepping_lost_j_;
  if (contact_) now.contact_j += contact_->last().energy_j;
  return now;
}

double ExplicitSolid::largest_plastic_strain() const {
  double largest = 0.0;
  for (int e = 0; e < mesh_.n_elements(); ++e) {
    const Sym strain = mesh_.plastic_of(e);
    largest = std::max(largest, inner(strain, strain));
  }
  return 0.5 * std::sqrt(largest);
}

}  // namespace klang::fracture
