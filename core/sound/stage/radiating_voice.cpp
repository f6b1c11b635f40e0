#include "core/sound/stage/radiating_voice.hpp"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/parallel.hpp"
#include "core/foundation/math/sphere_quadrature.hpp"
#include "core/sound/audio/nyquist.hpp"
#include "core/sound/stage/one_pitch.hpp"
#include "core/sound/transfer/transfer_model_file.hpp"

namespace klang::stage {
namespace {

using acoustics::ModeTransfer;
using acoustics::TransferModel;
using Complex = std::complex<double>;
constexpr std::size_t kModesATime = 8;

// Free oscillation of one mode, as an analytic signal q + i (its quadrature): Z(t + s) = Z(t) e^{(-b + i w) s}.
struct Ringing {
  const ModeTransfer* transfer = nullptr;
  double omega = 0.0, decay = 0.0, damped_omega = 0.0;
  bool has_phase = false;     // at one ear too: one of several of this pitch
  Eigen::VectorXcd analytic;  // at the samples
};

// From two neighbouring samples of z(t + h) = e^{-bh} (z cos wh + c sin wh) follows c = (dz/dt + b z) / w, and Z = z -
// i c. During a contact, and in the one interval before a strike, c is not that of a free oscillation; z is right
// always.
void fill_analytic(Ringing& mode, const Eigen::VectorXd& z, double step_s) {
  const double angle = mode.damped_omega * step_s, grow = std::exp(mode.decay * step_s);
  const double c = std::cos(angle), s = std::sin(angle);
  mode.analytic.resize(z.size() - 1);
  for (Eigen::Index n = 0; n < mode.analytic.size(); ++n) mode.analytic[n] = {z[n], -(z[n + 1] * grow - z[n] * c) / s};
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

void check_distances(const modal::ModalModel& model, const std::vector<Ringing>& modes,
                     const Eigen::Matrix3Xd& places) {
  std::vector<Eigen::Vector3d> centres;
  for (const Ringing& mode : modes) {
    const Eigen::Vector3d& c = mode.transfer->multipole.centre_m;
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

// A listener as a body hears it: places in the body's frame, which is the world's where it has no poses.
class Hearing {
 public:
  Hearing(const Listener& listener, events::Motion motion, double sound_speed_m_s)
      : listener_(listener), motion_(std::move(motion)), sound_speed_m_s_(sound_speed_m_s) {}
  bool moves() const { return listener_.moves() || motion_.moves(); }
  Eigen::Vector3d ear_m(int ear, double t) const { return in_body(listener_.ear_m(ear, t), t); }
  Eigen::Vector3d centre_m(double t) const { return in_body(listener_.centre_m(t), t); }
  double way_s(int ear, double t, const Eigen::Vector3d& source_m) const {
    return listener_.way_s(ear, t, in_world(source_m, t), sound_speed_m_s_);
  }
  Complex shadow(int ear, double t, const Eigen::Vector3d& source_m, double omega) const {
    return listener_.shadow(ear, t, in_world(source_m, t), omega);
  }

 private:
  Eigen::Vector3d in_body(const Eigen::Vector3d& x, double t) const {
    return motion_.poses().empty() ? x : motion_.at(t).to_body(x);
  }
  Eigen::Vector3d in_world(const Eigen::Vector3d& x, double t) const {
    return motion_.poses().empty() ? x : motion_.at(t).to_world(x);
  }
  const Listener& listener_;
  events::Motion motion_;
  double sound_speed_m_s_;
};

// A body that breaks rings no more: half a millisecond's raised cosine, so that it does not click.
void fade_out(Eigen::MatrixXd& sound, double end_s, double rate_hz) {
  constexpr double kFadeS = 5e-4;
  for (Eigen::Index n = 0; n < sound.rows(); ++n) {
    const double age = (static_cast<double>(n) / rate_hz - end_s) / kFadeS;
    if (age > 0.0) sound.row(n) *= age >= 1.0 ? 0.0 : 0.5 + 0.5 * std::cos(kPi * age);
  }
}

}  // namespace

// What add_to() shares between its steps.
struct RadiatingVoice::Work {
  Hearing hearing;
  TransferModel transfer;      // of the modes that are heard
  std::vector<Ringing> modes;  // as many
  Knots knots;
  Eigen::MatrixXcd gains[2];  // of each ear, n_knots x n_modes, a mode contiguous
};

RadiatingVoice::RadiatingVoice(int body, const modal::ModalModel& model, const TransferModel& transfer,
                               Eigen::VectorXd decay_per_s, const RadiatingVoiceOptions& options)
    : body_(body), model_(model), transfer_(transfer), decay_per_s_(std::move(decay_per_s)), options_(options) {
  checked("synthesis", "update_rate_hz", options.update_rate_hz, 10.0, 10000.0);
  check_belongs(transfer, model, "transfer");
  if (decay_per_s_.size() != model.n_modes()) {
    throw InputError("synthesis", "needs one decay for each mode", std::to_string(decay_per_s_.size()),
                     std::to_string(model.n_modes()));
  }
}

void RadiatingVoice::choose_modes(Work& work, double sample_rate_hz) {
  for (const ModeTransfer& mode : transfer_.modes) {
    const double omega = model_.angular_frequency_rad_s[mode.mode], decay = decay_per_s_[mode.mode];
    const double damped = std::sqrt(std::max(0.0, (omega - decay) * (omega + decay)));
    if (!(damped < audio::highest_rendered_hz(sample_rate_hz) * 2.0 * kPi)) {
      ++report_.n_modes_too_high;
    } else if (damped > 0.0) {  // over-damped: does not ring
      work.transfer.modes.push_back(mode);
    }
  }
  for (const ModeTransfer& mode : work.transfer.modes) {
    const double omega = model_.angular_frequency_rad_s[mode.mode], decay = decay_per_s_[mode.mode];
    work.modes.push_back({&mode, omega, decay, std::sqrt((omega - decay) * (omega + decay)), false, {}});
  }
  report_.n_modes_heard = static_cast<int>(work.modes.size());
}

// p without its carrier is at one ear the modulus, or for several of one pitch p against a phase that all of them share.
void RadiatingVoice::align_one_ear(Work& work) const {
  Eigen::MatrixXcd& gains = work.gains[0];
  const auto n_modes = static_cast<Eigen::Index>(work.modes.size());
  Eigen::VectorXd omega(n_modes), decay(n_modes);
  for (Eigen::Index m = 0; m < n_modes; ++m) {
    omega[m] = work.modes[static_cast<std::size_t>(m)].omega;
    decay[m] = work.modes[static_cast<std::size_t>(m)].decay;
  }
  for (const std::vector<std::size_t>& group : modes_of_one_pitch(omega, decay)) {
    std::vector<Complex> heard;
    for (const std::size_t m : group) {
      const auto column = gains.col(static_cast<Eigen::Index>(m));
      heard.insert(heard.end(), column.begin(), column.end());
    }
    const Complex unturned = std::conj(common_phase(heard));
    for (const std::size_t m : group) {
      gains.col(static_cast<Eigen::Index>(m)) *= unturned;
      work.modes[m].has_phase = true;
    }
  }
  for (Eigen::Index m = 0; m < n_modes; ++m) {
    if (!work.modes[static_cast<std::size_t>(m)].has_phase) gains.col(m) = gains.col(m).cwiseAbs().cast<Complex>();
  }
}

// Gains at the knots: as align_one_ear() says, or p without its carrier (two ears).
void RadiatingVoice::fill_gains(Work& work, const Listener& listener) {
  const Hearing& hearing = work.hearing;
  const int n_ears = listener.n_channels();
  acoustics::AnyTransferEvaluator evaluator(work.transfer, options_.device);
  for (int ear = 0; ear < n_ears; ++ear) {
    Eigen::Matrix3Xd places(3, work.knots.n);
    for (Eigen::Index k = 0; k < work.knots.n; ++k) places.col(k) = hearing.ear_m(ear, work.knots.time_s(k));
    check_distances(model_, work.modes, places);
    Eigen::MatrixXcd pressures;
    evaluator.evaluate(places, pressures);
    work.gains[ear] = pressures.transpose();
    for (std::size_t m = 0; m < work.modes.size(); ++m) {
      const acoustics::Multipole& multipole = work.modes[m].transfer->multipole;
      auto column = work.gains[ear].col(static_cast<Eigen::Index>(m));
      for (Eigen::Index k = 0; k < work.knots.n; ++k) {
        const double t = work.knots.time_s(k), r_ear = (places.col(k) - multipole.centre_m).norm();
        const double r = listener.propagation_delay ? r_ear : (hearing.centre_m(t) - multipole.centre_m).norm();
        if (options_.unit_transfer) {
          column[k] = Complex(1.0);
        } else {
          column[k] = column[k] * std::polar(1.0, multipole.wavenumber_per_m * r);
          if (listener.has_head()) column[k] *= head_gain(work, listener, ear, m, t);
        }
      }
    }
  }
  if (n_ears == 1 && !options_.unit_transfer) align_one_ear(work);
  report_.device_name = evaluator.device_name();
  report_.message = evaluator.message();
}

std::complex<double> RadiatingVoice::head_gain(const Work& work, const Listener& listener, int ear, std::size_t m,
                                               double time_s) const {
  const Ringing& mode = work.modes[m];
  const Eigen::Vector3d& source = mode.transfer->multipole.centre_m;
  const Complex shadow = work.hearing.shadow(ear, time_s, source, mode.damped_omega);
  if (listener.propagation_delay) return shadow;  // the way is in the time of hearing
  return shadow * std::polar(1.0, -mode.damped_omega * work.hearing.way_s(ear, time_s, source));
}

void RadiatingVoice::add_stretch(const Work& work, const Listener& listener, double sample_rate_hz, Stretch stretch,
                                 Eigen::MatrixXd& sound) const {
  const double step_s = 1.0 / sample_rate_hz;
  const int n_ears = listener.n_channels();
  for (int ear = 0; ear < n_ears; ++ear) {
    double* const out = sound.col(ear).data();
    for (Eigen::Index n = stretch.begin; n < stretch.end; ++n) {
      const double t = static_cast<double>(n) * step_s;
      const Knots::Place place = work.knots.at(t);
      double sum = 0.0, way_s = 0.0;
      const Eigen::Vector3d* source = nullptr;  // whose way that is: most modes have the same centre
      for (std::size_t m = stretch.first_mode; m < stretch.last_mode; ++m) {
        const Ringing& mode = work.modes[m];
        Complex z;
        if (listener.propagation_delay) {
          const Eigen::Vector3d& centre = mode.transfer->multipole.centre_m;
          if (source == nullptr || *source != centre) way_s = work.hearing.way_s(ear, t, centre);
          source = &centre;
          const double made = t - way_s;
          if (made < 0.0) continue;
          const auto before = static_cast<Eigen::Index>(made * sample_rate_hz);
          const double late = made - static_cast<double>(before) * step_s;
          z = mode.analytic[before] * std::exp(-mode.decay * late) * std::polar(1.0, mode.damped_omega * late);
        } else {
          z = mode.analytic[n];
        }
        Complex gain = interpolated(work.gains[ear].col(static_cast<Eigen::Index>(m)), work.knots, place);
        if (options_.unit_transfer) {
          sum += z.real();
        } else if (n_ears == 1 && !mode.has_phase) {
          sum += std::max(0.0, gain.real()) * mode.omega * z.real();
        } else if (n_ears == 1) {
          sum += mode.omega * (gain.real() * z.real() - gain.imag() * z.imag());
        } else {
          gain *= Complex(-mode.decay, mode.damped_omega);  // V = dZ/dt
          sum += gain.real() * z.real() - gain.imag() * z.imag();
        }
      }
      out[n] += sum;
    }
  }
}

void RadiatingVoice::add_to(Mix& mix, const events::EventLog& log, const Listener& listener, Monitor& monitor) {
  if (!listener.has_place()) throw InputError("listener", "has no place, which a transfer needs");
  const double rate = mix.sample_rate_hz();
  const Eigen::Index n_frames = mix.known_frames();
  report_ = {};
  report_.n_modes_without_transfer = static_cast<int>(model_.n_modes()) - static_cast<int>(transfer_.modes.size());
  Work work{Hearing(listener, log.motion_of(body_), transfer_.medium.sound_speed_m_s),
            TransferModel{transfer_.medium, {}},
            {},
            {options_.update_rate_hz, 1},
            {}};
  choose_modes(work, rate);
  if (work.hearing.moves()) {
    work.knots.n = static_cast<Eigen::Index>(std::ceil(*mix.duration_s() * options_.update_rate_hz)) + 4;
  }
  fill_gains(work, listener);

  PushedModes pushed;
  for (const ModeTransfer& mode : work.transfer.modes) pushed.numbers.push_back(mode.mode);
  pushed.angular_frequency_rad_s = model_.angular_frequency_rad_s(pushed.numbers);
  pushed.decay_per_s = decay_per_s_(pushed.numbers);
  pushed.sample_rate_hz = rate;
  const std::vector<ModalImpulse> impulses =
      modal_impulses(log, body_, push_at_nearest_node(model_), pushed, options_.pulses);
  Eigen::MatrixXd sound = Eigen::MatrixXd::Zero(n_frames, listener.n_channels());
  // A few modes at a time: first their oscillations, mode by mode, then the sum, stretch of time by stretch.
  for (std::size_t first = 0; first < work.modes.size(); first += kModesATime) {
    monitor.throw_if_stopped();
    const std::size_t last = std::min(work.modes.size(), first + kModesATime);
    parallel_for(last - first, 1, [&](std::size_t begin, std::size_t end) {
      for (std::size_t m = first + begin; m < first + end; ++m) {
        std::vector<ModalImpulse> own;
        for (const ModalImpulse& impulse : impulses) {
          const double push = impulse.impulse[static_cast<Eigen::Index>(m)];
          own.push_back(
              {impulse.time_s, Eigen::VectorXd::Constant(1, push), impulse.contact_duration_s, impulse.pulse});
        }
        Ringing& mode = work.modes[m];
        fill_analytic(mode, oscillation({{mode.omega, mode.decay, 1.0}}, own, rate, n_frames + 1, Heard::kRinging),
                      1.0 / rate);
      }
    });
    parallel_for(static_cast<std::size_t>(n_frames), 4096, [&](std::size_t begin, std::size_t end) {
      const Stretch stretch{static_cast<Eigen::Index>(begin), static_cast<Eigen::Index>(end), first, last};
      add_stretch(work, listener, rate, stretch, sound);
    });
    for (std::size_t m = first; m < last; ++m) work.modes[m].analytic.resize(0);
  }
  if (const auto end_s = log.broken_s(body_)) fade_out(sound, *end_s, rate);
  for (int ear = 0; ear < listener.n_channels(); ++ear)
    mix.add(ear, 0, {sound.col(ear).data(), static_cast<std::size_t>(n_frames)});
}

TransferSynthesisResult synthesise_at_ears(const modal::ModalModel& model, const TransferModel& transfer,
                                           const Eigen::VectorXd& decay_per_s,
                                           const std::vector<events::Strike>& strikes, const Listener& listener,
                                           const TransferSynthesisOptions& options) {
  checked("synthesis", "sample_rate_hz", options.sample_rate_hz, 1000.0, 768000.0);
  checked("synthesis", "duration_s", options.duration_s, 0.0, 600.0);
  RadiatingVoice voice(0, model, transfer, decay_per_s, options.voice);
  Voice* const voices[] = {&voice};
  TransferSynthesisResult result;
  result.sound_pa = render(log_of(strikes), voices, listener, {options.sample_rate_hz, options.duration_s});
  result.heard = voice.report();
  result.status = TransferSynthesisResult::Status::kDone;
  return result;
}

Eigen::Vector3d default_listener_m(const TransferModel& model, double distance_m) {
  const ModeTransfer* strongest = nullptr;
  for (const ModeTransfer& mode : model.modes) {
    if (mode.radiated_power_w > (strongest == nullptr ? 0.0 : strongest->radiated_power_w)) strongest = &mode;
  }
  if (strongest == nullptr) {
    const Eigen::Vector3d centre =
        model.modes.empty() ? Eigen::Vector3d(Eigen::Vector3d::Zero()) : model.modes[0].multipole.centre_m;
    return centre + distance_m * Eigen::Vector3d::UnitZ();
  }
  const Eigen::Matrix3Xd directions = sphere_quadrature(4 * strongest->multipole.order + 8).directions;
  Eigen::Vector3d best = Eigen::Vector3d::UnitZ();
  double loudest =
      1.000001 * std::abs(far_field_pa_m(strongest->multipole, best));  // z unless another is really louder
  for (Eigen::Index i = 0; i < directions.cols(); ++i) {
    const double level = std::abs(far_field_pa_m(strongest->multipole, directions.col(i)));
    if (level > loudest * 1.000001) {
      loudest = level;
      best = directions.col(i);
    }
  }
  return strongest->multipole.centre_m + distance_m * best;
}

}  // namespace klang::stage
