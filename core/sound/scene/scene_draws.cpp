#include "core/sound/scene/scene_draws.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <map>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/random.hpp"
#include "core/physics/modal/eigen_solver.hpp"
#include "core/physics/solid/assembly.hpp"

namespace klang::scene {
namespace {

double estimate_of(const std::string& name, const solid::Material& material) {
  if (name == "youngs_modulus_pa") return material.youngs_modulus_pa();
  if (name == "poissons_ratio") return material.poissons_ratio();
  return name == "lame_lambda_pa" ? material.lame_lambda_pa : material.lame_mu_pa;
}

/// Lame's constants where some constants are drawn and the rest is the estimate's.
std::optional<std::pair<double, double>> lame_of(const std::map<std::string, double>& drawn,
                                                 const solid::Material& estimate) {
  const auto value = [&](const char* name) {
    const auto found = drawn.find(name);
    return found == drawn.end() ? std::optional<double>() : found->second;
  };
  std::optional<double> mu = value("shear_modulus_pa");
  if (!mu) mu = value("lame_mu_pa");
  const std::optional<double> e = value("youngs_modulus_pa"), lambda = value("lame_lambda_pa");
  double nu = value("poissons_ratio").value_or(estimate.poissons_ratio());
  if (e && mu) nu = *e / (2.0 * *mu) - 1.0;
  double shear = mu.value_or(e ? *e / (2.0 * (1.0 + nu)) : estimate.lame_mu_pa);
  if (!(nu > -1.0 && nu < 0.5 && shear > 0.0) || !std::isfinite(shear)) return {};
  return std::pair(lambda.value_or(2.0 * shear * nu / (1.0 - 2.0 * nu)), shear);
}

}  // namespace

MaterialDraw draw_material(const SceneMaterial& material, std::uint64_t seed, std::uint64_t number) {
  const FitSpread& spread = *material.spread;
  RandomStream random(seed, number);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> root(spread.covariance);
  const Eigen::VectorXd widths = root.eigenvalues().cwiseMax(0.0).cwiseSqrt();
  for (int attempt = 0; attempt < 100; ++attempt) {
    Eigen::VectorXd z(widths.size());
    for (double& value : z) value = random.normal();
    const Eigen::VectorXd offset = root.eigenvectors() * widths.cwiseProduct(z);
    std::map<std::string, double> drawn;
    for (std::size_t i = 0; i < spread.names.size(); ++i)
      drawn[spread.names[i]] = estimate_of(spread.names[i], material.elastic) + offset[static_cast<Eigen::Index>(i)];
    MaterialDraw draw;
    bool good = true;
    draw.damping_parameters = material.damping_heard().parameters;
    for (std::size_t i = 0; i < spread.damping_std.size(); ++i) {
      draw.damping_parameters[i] += spread.damping_std[i] * random.normal();
      good = good && draw.damping_parameters[i] >= 0.0;
    }
    const auto lame = lame_of(drawn, material.elastic);
    if (!good || !lame) continue;
    draw.lame_lambda_pa = lame->first;
    draw.lame_mu_pa = lame->second;
    return draw;
  }
  throw NumericalError("material " + material.name + ": its fit is so wide that draws of it are no material");
}

DrawnBodies::DrawnBodies(const Scene& scene, const std::vector<HeardBody>& heard, std::vector<int> materials)
    : scene_(scene), heard_(heard), materials_(std::move(materials)) {
  std::map<const SoundModel*, Slopes> known;
  for (std::size_t i = 0; i < heard.size(); ++i) {
    const SoundModel& model = *heard[i].model;
    slopes_.emplace_back();
    if (model.proxy || !scene.materials[static_cast<std::size_t>(materials_[i])].spread) continue;
    const auto [slopes, is_new] = known.try_emplace(&model);
    if (is_new) {
      const Eigen::MatrixXd by =
          modal::eigenvalue_lame_derivatives(model.modes, solid::assemble(model.modes.mesh, model.modes.support));
      const Eigen::VectorXd lambda = model.modes.material.lame_lambda_pa * by.col(0),
                            mu = model.modes.material.lame_mu_pa * by.col(1);
      slopes->second = {lambda.cwiseQuotient(lambda + mu), mu.cwiseQuotient(lambda + mu)};
    }
    slopes_.back() = slopes->second;
  }
}

std::vector<HeardBody> DrawnBodies::draw(std::uint64_t seed, std::uint64_t number) const {
  std::vector<std::optional<MaterialDraw>> draws(scene_.materials.size());
  for (std::size_t m = 0; m < draws.size(); ++m)
    if (scene_.materials[m].spread)
      draws[m] = draw_material(scene_.materials[m], seed, (static_cast<std::uint64_t>(m) << 32) + number);
  std::map<const SoundModel*, std::shared_ptr<const SoundModel>> changed;
  std::vector<HeardBody> bodies = heard_;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const auto& draw = draws[static_cast<std::size_t>(materials_[i])];
    if (!draw) continue;
    bodies[i].damping.parameters = draw->damping_parameters;
    auto& model = changed[heard_[i].model.get()];
    if (!model) {
      auto other = std::make_shared<SoundModel>(*heard_[i].model);
      const solid::Material& was = other->modes.material;
      const double by_lambda = was.lame_lambda_pa != 0.0 ? draw->lame_lambda_pa / was.lame_lambda_pa : 1.0,
                   by_mu = draw->lame_mu_pa / was.lame_mu_pa;
      const Slopes& slopes = slopes_[i];
      for (Eigen::Index k = 0; k < other->modes.n_modes(); ++k) {
        const double square = slopes.mu.size() == 0 ? by_mu : by_lambda * slopes.lambda[k] + by_mu * slopes.mu[k];
        other->modes.angular_frequency_rad_s[k] *= std::sqrt(std::max(square, 1e-6));
      }
      for (acoustics::ModeTransfer& mode : other->transfer.modes)
        mode.frequency_hz = other->modes.angular_frequency_rad_s[mode.mode] / (2.0 * kPi);
      model = std::move(other);
    }
    bodies[i].model = model;
  }
  return bodies;
}

bool has_spread(const Scene& scene) {
  return std::any_of(scene.materials.begin(), scene.materials.end(),
                     [](const SceneMaterial& material) { return material.spread.has_value(); });
}

namespace {

/// Below which a share of the values lies, linear between them.
double quantile(std::vector<double> values, double share) {
  std::sort(values.begin(), values.end());
  const double at = share * static_cast<double>(values.size() - 1);
  const auto below = static_cast<std::size_t>(at);
  const std::size_t above = std::min(below + 1, values.size() - 1);
  return values[below] + (at - static_cast<double>(below)) * (values[above] - values[below]);
}

constexpr std::size_t kPartialsOfABody = 10, kMostPartials = 100;
constexpr double kLowShare = 0.05, kHighShare = 0.95;

/// One partial of a body, and which of its modes that is.
struct FollowedPartial {
  std::size_t heard;
  Eigen::Index mode;
  std::vector<double> hz, decay_per_s;
};

std::vector<FollowedPartial> followed(const Scene& scene, const std::vector<HeardBody>& heard,
                                      const std::vector<int>& materials) {
  std::vector<FollowedPartial> partials;
  for (std::size_t i = 0; i < heard.size(); ++i) {
    if (!scene.materials[static_cast<std::size_t>(materials[i])].spread) continue;
    const auto n = std::min<Eigen::Index>(static_cast<Eigen::Index>(kPartialsOfABody), heard[i].model->modes.n_modes());
    for (Eigen::Index k = 0; k < n && partials.size() < kMostPartials; ++k) partials.push_back({i, k, {}, {}});
  }
  return partials;
}

}  // namespace

DrawsRecord draw_sounds(const Scene& scene, const events::EventLog& log, const std::vector<HeardBody>& heard,
                        const audio::Signal& sound, const Drawing& drawing, Monitor& monitor) {
  const int n = drawing.n;
  std::vector<int> materials;
  for (const HeardBody& body : heard) {
    auto row = static_cast<std::size_t>(body.body);
    while (row >= scene.bodies.size()) row = static_cast<std::size_t>(log.bodies[row].parent);
    materials.push_back(scene.bodies[row].material);
  }
  const DrawnBodies drawn(scene, heard, materials);
  const bool damped = scene.sound.radiation_damping;
  std::vector<FollowedPartial> partials = followed(scene, heard, materials);
  DrawsRecord record;
  record.n = n;
  for (std::size_t m = 0; m < scene.materials.size(); ++m)
    if (scene.materials[m].spread &&
        std::find(materials.begin(), materials.end(), static_cast<int>(m)) != materials.end())
      record.materials.push_back(scene.materials[m].name);
  const double level = sound.samples.norm();
  for (int i = 0; i < n; ++i) {
    monitor.throw_if_stopped();
    monitor.progress("draws", static_cast<double>(i) / n);
    const std::vector<HeardBody> bodies = drawn.draw(drawing.seed, static_cast<std::uint64_t>(i));
    const audio::Signal other = sound_of(log, bodies, scene.sound, sound.duration_s(), monitor, drawing.pulses);
    record.peak_pressure_pa.push_back(other.n_frames() > 0 ? other.samples.cwiseAbs().maxCoeff() : 0.0);
    record.level_db.push_back(
        level > 0.0 && other.samples.norm() > 0.0 ? 20.0 * std::log10(other.samples.norm() / level) : 0.0);
    for (FollowedPartial& partial : partials) {
      partial.hz.push_back(bodies[partial.heard].model->modes.angular_frequency_rad_s[partial.mode] / (2.0 * kPi));
      partial.decay_per_s.push_back(decay_per_s(bodies[partial.heard], damped)[partial.mode]);
    }
  }
  record.low_level_db = quantile(record.level_db, kLowShare);
  record.high_level_db = quantile(record.level_db, kHighShare);
  record.low_peak_pressure_pa = quantile(record.peak_pressure_pa, kLowShare);
  record.high_peak_pressure_pa = quantile(record.peak_pressure_pa, kHighShare);
  for (const FollowedPartial& partial : partials) {
    const HeardBody& body = heard[partial.heard];
    record.partials.push_back({log.bodies[static_cast<std::size_t>(body.body)].name,
                               body.model->modes.angular_frequency_rad_s[partial.mode] / (2.0 * kPi),
                               quantile(partial.hz, kLowShare), quantile(partial.hz, kHighShare),
                               decay_per_s(body, damped)[partial.mode], quantile(partial.decay_per_s, kLowShare),
                               quantile(partial.decay_per_s, kHighShare)});
  }
  return record;
}

}  // namespace klang::scene
