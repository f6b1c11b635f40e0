#pragma once
#include <cstdint>

#include "core/sound/scene/heard_document.hpp"
#include "core/sound/scene/scene_sound.hpp"

namespace klang::scene {

/// How a fitted material might be otherwise: elastic constants and damping drawn from the fit's covariance. Damping's parameters are
/// drawn without their correlation, which fit.json does not say.
struct MaterialDraw {
  double lame_lambda_pa = 0.0, lame_mu_pa = 0.0;
  std::vector<double> damping_parameters;
};
/// @throws NumericalError where a hundred draws in a row are no material
MaterialDraw draw_material(const SceneMaterial& material, std::uint64_t seed, std::uint64_t number);

/// Bodies of a scene with other materials: frequencies by omega'^2 / omega^2 = u^T (lambda' K_lambda + mu' K_mu) u / u^T (lambda K_lambda +
/// mu K_mu) u, first order in the change; a proxy's by the root of the ratio of shear moduli. Shapes and radiation stay.
class DrawnBodies {
 public:
  /// Only bodies of materials with a spread change. heard must outlive it; numbers: each body's material.
  DrawnBodies(const Scene& scene, const std::vector<HeardBody>& heard, std::vector<int> materials);
  std::vector<HeardBody> draw(std::uint64_t seed, std::uint64_t number) const;

 private:
  struct Slopes {
    Eigen::VectorXd lambda, mu;  ///< shares of the stiffness, their sum 1; empty: a proxy
  };
  const Scene& scene_;
  const std::vector<HeardBody>& heard_;
  std::vector<int> materials_;
  std::vector<Slopes> slopes_;  ///< of each heard body
};

/// Whether a scene has a material that can be drawn.
bool has_spread(const Scene& scene);

struct Drawing {
  int n = 0;
  std::uint64_t seed = 1;
  const stage::ImpactPulses* pulses = nullptr;  ///< impact_pulses() of the estimate, which draws keep
};

/// The sound of the bodies again for n draws, and how it spreads.
/// @param sound  of the estimate, bodies alone
DrawsRecord draw_sounds(const Scene& scene, const events::EventLog& log, const std::vector<HeardBody>& heard,
                        const audio::Signal& sound, const Drawing& drawing, Monitor& monitor = silent_monitor());

}  // namespace klang::scene
