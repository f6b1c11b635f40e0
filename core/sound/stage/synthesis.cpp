#include <Eigen/Geometry>
#include <array>
#include <cmath>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/parallel.hpp"
#include "core/sound/stage/oscillator_bank.hpp"

namespace klang::modal {
namespace {

constexpr double kHighestOfSampleRate = 0.499;  // modes above this fraction would fold back

// Radon's rule of 7 points and degree 5 on the reference triangle (Radon 1948); weights sum to the area 1/2.
struct TrianglePoint {
  double xi, eta, weight;
};
std::array<TrianglePoint, 7> triangle_rule() {
  const double root = std::sqrt(15.0);
  const double a = (6.0 - root) / 21.0, b = (6.0 + root) / 21.0;
  const double wa = (155.0 - root) / 2400.0, wb = (155.0 + root) / 2400.0;
  return {{{1.0 / 3, 1.0 / 3, 9.0 / 80},
           {a, a, wa},
           {1 - 2 * a, a, wa},
           {a, 1 - 2 * a, wa},
           {b, b, wb},
           {1 - 2 * b, b, wb},
           {b, 1 - 2 * b, wb}}};
}

struct TriangleShape {
  std::array<double, 6> value{}, by_xi{}, by_eta{};
  int n = 3;
};

// Order of nodes: corners, then the middles of 01, 12, 20.
TriangleShape triangle_shape(double xi, double eta, bool quadratic) {
  const double zeta = 1.0 - xi - eta;
  if (!quadratic) return {{zeta, xi, eta}, {-1, 1, 0}, {-1, 0, 1}, 3};
  return {{zeta * (2 * zeta - 1), xi * (2 * xi - 1), eta * (2 * eta - 1), 4 * zeta * xi, 4 * xi * eta, 4 * eta * zeta},
          {1 - 4 * zeta, 4 * xi - 1, 0, 4 * (zeta - xi), 4 * eta, -4 * eta},
          {1 - 4 * zeta, 0, 4 * eta - 1, -4 * xi, 4 * xi, 4 * (zeta - eta)},
          6};
}

void check_node(const ModalModel& model, int node, const char* what) {
  if (node >= 0 && node < model.mesh.n_nodes()) return;
  throw InputError(what, "no such node", std::to_string(node), "0 to " + std::to_string(model.mesh.n_nodes() - 1));
}

}  // namespace

Eigen::VectorXd surface_coupling(const ModalModel& model) {
  const mesh::SurfaceMesh surface = mesh::boundary_surface(model.mesh);
  const bool quadratic = surface.triangles.cols() == 6;
  std::vector<TriangleShape> shapes;
  const auto rule = triangle_rule();
  for (const TrianglePoint& p : rule) shapes.push_back(triangle_shape(p.xi, p.eta, quadratic));

  const Eigen::Index n_modes = model.n_modes(), n_triangles = surface.triangles.rows();
  Eigen::VectorXd coupling = Eigen::VectorXd::Zero(n_modes);
  std::vector<Eigen::Vector3d> area_vectors(static_cast<std::size_t>(n_triangles) * rule.size());
  for (Eigen::Index t = 0; t < n_triangles; ++t) {
    for (std::size_t q = 0; q < rule.size(); ++q) {
      Eigen::Vector3d by_xi = Eigen::Vector3d::Zero(), by_eta = Eigen::Vector3d::Zero();
      for (int i = 0; i < shapes[q].n; ++i) {
        const Eigen::Vector3d x = surface.vertices_m.row(surface.triangles(t, i));
        by_xi += shapes[q].by_xi[static_cast<std::size_t>(i)] * x;
        by_eta += shapes[q].by_eta[static_cast<std::size_t>(i)] * x;
      }
      area_vectors[static_cast<std::size_t>(t) * rule.size() + q] = rule[q].weight * by_xi.cross(by_eta);
    }
  }
  parallel_for(static_cast<std::size_t>(n_modes), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t m = begin; m < end; ++m) {
      const auto mode = static_cast<Eigen::Index>(m);
      double sum = 0.0;
      for (Eigen::Index t = 0; t < n_triangles; ++t) {
        for (std::size_t q = 0; q < rule.size(); ++q) {
          Eigen::Vector3d u = Eigen::Vector3d::Zero();
          for (int i = 0; i < shapes[q].n; ++i) {
            u += shapes[q].value[static_cast<std::size_t>(i)] *
                 model.shapes.block<3, 1>(3 * surface.triangles(t, i), mode);
          }
          sum += std::abs(u.dot(area_vectors[static_cast<std::size_t>(t) * rule.size() + q]));
        }
      }
      coupling[mode] = sum * model.angular_frequency_rad_s[mode] / (2.0 * kPi);
    }
  });
  return coupling;
}

audio::Signal synthesise(const ModalModel& model, const Eigen::VectorXd& decay_per_s,
                         const std::vector<Strike>& strikes, const SynthesisOptions& options) {
  checked("synthesis", "sample_rate_hz", options.sample_rate_hz, 1000.0, 768000.0);
  checked("synthesis", "duration_s", options.duration_s, 0.0, 3600.0);
  if (decay_per_s.size() != model.n_modes()) {
    throw InputError("synthesis", "needs one decay a mode", std::to_string(decay_per_s.size()),
                     std::to_string(model.n_modes()));
  }
  for (const Strike& strike : strikes) check_node(model, strike.node, "strike");
  Eigen::VectorXd gain;
  if (options.couple_to_air) {
    gain = surface_coupling(model);
  } else {
    check_node(model, options.pickup_node, "pickup");
    gain = model.shapes.middleRows<3>(3 * options.pickup_node).transpose() * options.pickup_direction.normalized();
  }

  // Filtered by the frequency that is heard, |Im p| / 2 pi in Hz (errata 3): over-damped modes do not ring
  // and stay.
  std::vector<Oscillator> oscillators;
  std::vector<Eigen::Index> kept;
  for (Eigen::Index m = 0; m < model.n_modes(); ++m) {
    const double omega = model.angular_frequency_rad_s[m], decay = decay_per_s[m];
    const double heard_hz = std::sqrt(std::max(0.0, (omega - decay) * (omega + decay))) / (2.0 * kPi);
    if (!(heard_hz < kHighestOfSampleRate * options.sample_rate_hz)) continue;
    kept.push_back(m);
    oscillators.push_back({omega, decay, gain[m]});
  }
  std::vector<ModalImpulse> impulses;
  for (const Strike& strike : strikes) {
    ModalImpulse impulse{strike.time_s, Eigen::VectorXd(kept.size()), strike.contact_duration_s};
    for (std::size_t i = 0; i < kept.size(); ++i) {
      impulse.impulse[static_cast<Eigen::Index>(i)] =
          model.shapes.block<3, 1>(3 * strike.node, kept[i]).dot(strike.impulse_n_s);
    }
    impulses.push_back(std::move(impulse));
  }
  audio::Signal signal;
  signal.sample_rate_hz = options.sample_rate_hz;
  signal.origin = "synthesis";
  signal.samples = render(oscillators, impulses, options.sample_rate_hz,
                          static_cast<Eigen::Index>(std::llround(options.duration_s * options.sample_rate_hz)));
  return signal;
}

}  // namespace klang::modal
