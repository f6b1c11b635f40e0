#include "core/sound/stage/transfer_synthesis.hpp"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/parallel.hpp"
#include "core/sound/transfer/transfer_model_file.hpp"

namespace klang::acoustics {
namespace {

using Complex = std::complex<double>;
constexpr double kHighestOfSampleRate = 0.499;  // as modal::synthesise
constexpr std::size_t kModesATime = 8;

// Free oscillation of one mode, as an analytic signal q + i (its quadrature): Z(t + s) = Z(t) e^{(-b + i w) s}.
struct Voice {
  const ModeTransfer* transfer = nullptr;
  double omega = 0.0, decay = 0.0, damped_omega = 0.0;
  Eigen::Index mode = 0;
  Eigen::VectorXcd analytic;  // at the samples
};

// From two neighbouring samples of z(t + h) = e^{-bh} (z cos wh + c sin wh) follows c = (dz/dt + b z) / w, and Z = z - i c.
// During a contact, and in the one interval before a strike, c is not that of a free oscillation; z is right always.
void fill_analytic(Voice& voice, const Eigen::VectorXd& z, double step_s) {
  const double angle = voice.damped_omega * step_s, grow = std::exp(voice.decay * step_s);
  const double c = std::cos(angle), s = std::sin(angle);
  voice.analytic.resize(z.size() - 1);
  for (Eigen::Index n = 0; n < voice.analytic.size(); ++n)
    voice.analytic[n] = {z[n], -(z[n + 1] * grow - z[n] * c) / s};
}

// p at the knots, interpolated by a cubic through four of them (Catmull and Rom 1974). A listener at rest has one knot.
struct Knots {
  double rate_hz = 0.0;
  Eigen::Index n = 1;
  struct Place {
    Eigen::Index first;
    double weight[4];
  };
  double time_s(Eigen::Index k) const {
    return n == 1 ? 0.0 : (static_cast<double>(k) - 1.0) / rate_hz;
  }  // one before 0
  Place at(double t) const {
    if (n == 1) return {0, {1.0, 0.0, 0.0, 0.0}};
    const double place = t * rate_hz;
    const auto k = std::clamp<Eigen::Index>(static_cast<Eigen::Index>(place), 0, n - 4);
    const double u = place - static_cast<double>(k);
    return {k,
            {0.5 * u * (-1.0 + u * (2.0 - u)), 1.0 + u * u * (-2.5 + 1.5 * u), 0.5 * u * (1.0 + u * (4.0 - 3.0 * u)),
             0.5 * u * u * (u - 1.0)}};
  }
};

template <typename Row>
auto interpolated(const Row& row, const Knots& knots, const Knots::Place& place) {
  auto value = place.weight[0] * row[place.first];
  if (knots.n == 1) return value;
  for (int j = 1; j < 4; ++j) value += place.weight[j] * row[place.first + j];
  return value;
}

double body_radius_m(const modal::ModalModel& model, const Eigen::Vector3d& centre) {
  return (model.mesh.nodes_m.rowwise() - centre.transpose()).rowwise().norm().maxCoeff();
}

void check_distances(const modal::ModalModel& model, const std::vector<Voice>& voices, const Eigen::Matrix3Xd& places) {
  std::vector<Eigen::Vector3d> centres;
  for (const Voice& voice : voices) {
    const Eigen::Vector3d& c = voice.transfer->multipole.centre_m;
    if (std::find(centres.begin(), centres.end(), c) == centres.end()) centres.push_back(c);
  }
  for (const Eigen::Vector3d& centre : centres) {
    const double radius = model.mesh.n_nodes() > 0 ? body_radius_m(model, centre) : 0.0;
    const double nearest = (places.colwise() - centre).colwise().norm().minCoeff();
    if (!(nearest > radius)) {
      throw InputError("listener", "comes too close to the body: distance from its centre", to_text(nearest) + " m",
                       "more than " + to_text(radius) + " m");
    }
  }
}

}  // namespace

void TransferSynthesisOptions::validate() const {
  checked("synthesis", "sample_rate_hz", sample_rate_hz, 1000.0, 768000.0);
  checked("synthesis", "duration_s", duration_s, 0.0, 600.0);
  checked("synthesis", "update_rate_hz", update_rate_hz, 10.0, 10000.0);
}

TransferSynthesisResult synthesise_at_ears(const modal::ModalModel& model, const TransferModel& transfer,
                                           const Eigen::VectorXd& decay_per_s,
                                           const std::vector<modal::Strike>& strikes, const ListenerPath& path,
                                           const TransferSynthesisOptions& options) {
  options.validate();
  check_belongs(transfer, model, "transfer");
  if (decay_per_s.size() != model.n_modes()) {
    throw InputError("synthesis", "needs one decay a mode", std::to_string(decay_per_s.size()),
                     std::to_string(model.n_modes()));
  }
  for (const modal::Strike& strike : strikes) {
    if (strike.node < 0 || strike.node >= model.mesh.n_nodes())
      throw InputError("strike", "no such node", std::to_string(strike.node));
  }
  const double rate = options.sample_rate_hz, step_s = 1.0 / rate, c = transfer.medium.sound_speed_m_s;
  const auto n_frames = static_cast<Eigen::Index>(std::llround(options.duration_s * rate));
  TransferSynthesisResult result;
  result.n_modes_without_transfer = static_cast<int>(model.n_modes()) - static_cast<int>(transfer.modes.size());

  TransferModel heard{transfer.medium, {}};
  for (const ModeTransfer& mode : transfer.modes) {
    const double omega = model.angular_frequency_rad_s[mode.mode], decay = decay_per_s[mode.mode];
    const double damped = std::sqrt(std::max(0.0, (omega - decay) * (omega + decay)));
    if (!(damped < kHighestOfSampleRate * rate * 2.0 * kPi)) {
      ++result.n_modes_too_high;
    } else if (damped > 0.0) {  // over-damped: does not ring
      heard.modes.push_back(mode);
    }
  }
  std::vector<Voice> voices;
  for (const ModeTransfer& mode : heard.modes) {
    const double omega = model.angular_frequency_rad_s[mode.mode], decay = decay_per_s[mode.mode];
    voices.push_back({&mode, omega, decay, std::sqrt((omega - decay) * (omega + decay)), mode.mode, {}});
  }
  result.n_modes_heard = static_cast<int>(voices.size());

  // Gains at the knots: the modulus (one ear), or p without its carrier (two ears).
  const int n_ears = path.stereo() ? 2 : 1;
  Knots knots{options.update_rate_hz, 1};
  if (path.moves()) knots.n = static_cast<Eigen::Index>(std::ceil(options.duration_s * options.update_rate_hz)) + 4;
  Eigen::MatrixXcd gains[2];  // n_knots x n_voices, a mode contiguous
  AnyTransferEvaluator evaluator(heard, options.device);
  for (int ear = 0; ear < n_ears; ++ear) {
    Eigen::Matrix3Xd places(3, knots.n);
    for (Eigen::Index k = 0; k < knots.n; ++k) places.col(k) = path.ear_m(ear, knots.time_s(k));
    check_distances(model, voices, places);
    Eigen::MatrixXcd pressures;
    evaluator.evaluate(places, pressures);
    gains[ear] = pressures.transpose();
    for (std::size_t v = 0; v < voices.size(); ++v) {
      const Multipole& multipole = voices[v].transfer->multipole;
      auto column = gains[ear].col(static_cast<Eigen::Index>(v));
      for (Eigen::Index k = 0; k < knots.n; ++k) {
        const double r_ear = (places.col(k) - multipole.centre_m).norm();
        const double r = options.delay ? r_ear : (path.head_m(knots.time_s(k)) - multipole.centre_m).norm();
        column[k] = options.unit_transfer ? Complex(1.0)
                    : n_ears == 1         ? Complex(std::abs(column[k]))
                                          : column[k] * std::polar(1.0, multipole.wavenumber_per_m * r);
      }
    }
  }
  result.device_name = evaluator.device_name();
  result.message = evaluator.message();

  result.sound_pa.sample_rate_hz = rate;
  result.sound_pa.origin = "synthesis";
  result.sound_pa.samples = Eigen::MatrixXd::Zero(n_frames, n_ears);
  // A few modes at a time: first their oscillations, mode by mode, then the sum, stretch of time by stretch.
  for (std::size_t first = 0; first < voices.size(); first += kModesATime) {
    const std::size_t last = std::min(voices.size(), first + kModesATime);
    parallel_for(last - first, 1, [&](std::size_t begin, std::size_t end) {
      for (std::size_t v = first + begin; v < first + end; ++v) {
        std::vector<modal::ModalImpulse> impulses;
        for (const modal::Strike& strike : strikes) {
          const double push = model.shapes.block<3, 1>(3 * strike.node, voices[v].mode).dot(strike.impulse_n_s);
          impulses.push_back({strike.time_s, Eigen::VectorXd::Constant(1, push), strike.contact_duration_s});
        }
        fill_analytic(voices[v], modal::render({{voices[v].omega, voices[v].decay, 1.0}}, impulses, rate, n_frames + 1),
                      step_s);
      }
    });
    parallel_for(static_cast<std::size_t>(n_frames), 4096, [&](std::size_t begin, std::size_t end) {
      for (int ear = 0; ear < n_ears; ++ear) {
        double* const out = result.sound_pa.samples.col(ear).data();
        for (auto n = static_cast<Eigen::Index>(begin); n < static_cast<Eigen::Index>(end); ++n) {
          const double t = static_cast<double>(n) * step_s;
          const Knots::Place place = knots.at(t);
          const Eigen::Vector3d x = options.delay ? path.ear_m(ear, t) : Eigen::Vector3d(Eigen::Vector3d::Zero());
          double sum = 0.0;
          for (std::size_t v = first; v < last; ++v) {
            const Voice& voice = voices[v];
            Complex z;
            if (options.delay) {
              const double made = t - (x - voice.transfer->multipole.centre_m).norm() / c;
              if (made < 0.0) continue;
              const auto before = static_cast<Eigen::Index>(made * rate);
              const double late = made - static_cast<double>(before) * step_s;
              z = voice.analytic[before] * std::exp(-voice.decay * late) * std::polar(1.0, voice.damped_omega * late);
            } else {
              z = voice.analytic[n];
            }
            Complex gain = interpolated(gains[ear].col(static_cast<Eigen::Index>(v)), knots, place);
            if (options.unit_transfer) {
              sum += z.real();
            } else if (n_ears == 1) {
              sum += std::max(0.0, gain.real()) * voice.omega * z.real();
            } else {
              gain *= Complex(-voice.decay, voice.damped_omega);  // V = dZ/dt
              sum += gain.real() * z.real() - gain.imag() * z.imag();
            }
          }
          out[n] += sum;
        }
      }
    });
    for (std::size_t v = first; v < last; ++v) voices[v].analytic.resize(0);
  }
  result.status = TransferSynthesisResult::Status::kDone;
  return result;
}

}  // namespace klang::acoustics
