#include "core/sound/stage/radiating_voice.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/output_file.hpp"
#include "core/foundation/base/parallel.hpp"
#include "core/sound/stage/listener_file.hpp"
#include "core/sound/waves/multipole.hpp"
#include "tests/core/sound/transfer/transfer_samples.hpp"

namespace klang::stage {
namespace {

using acoustics::ModeTransfer;
using acoustics::random_transfer;
using acoustics::TransferModel;
using Complex = std::complex<double>;
constexpr double kRate = 48000.0;

// A body of six points 0.1 m from the centre and the given modes; the strike at node 0 drives mode i by 1 + i.
struct Body {
  modal::ModalModel model;
  TransferModel transfer;
  Eigen::VectorXd decay_per_s;
  std::vector<events::Strike> strikes;
};

Body body_of(const std::vector<double>& frequency_hz, double decay, int order = 0) {
  Body body;
  const auto n = static_cast<Eigen::Index>(frequency_hz.size());
  body.model.mesh.nodes_m.resize(6, 3);
  body.model.mesh.nodes_m << 0.1, 0, 0, -0.1, 0, 0, 0, 0.1, 0, 0, -0.1, 0, 0, 0, 0.1, 0, 0, -0.1;
  body.model.angular_frequency_rad_s = 2 * kPi * Eigen::Map<const Eigen::VectorXd>(frequency_hz.data(), n);
  body.model.mesh.elements.resize(4, 4);  // an octahedron about the z axis
  body.model.mesh.elements << 4, 5, 2, 0, 4, 5, 1, 2, 4, 5, 3, 1, 4, 5, 0, 3;
  body.model.shapes = Eigen::MatrixXd::Zero(18, n);
  body.decay_per_s = Eigen::VectorXd::Constant(n, decay);
  body.strikes.resize(1);
  body.strikes[0].point_m = {0.1, 0, 0};
  body.strikes[0].impulse_n_s = {1, 0, 0};
  const TransferModel random = random_transfer(std::vector<int>(frequency_hz.size(), order), 81);
  for (Eigen::Index i = 0; i < n; ++i) {
    body.model.shapes(0, i) = 1.0 + static_cast<double>(i);
    ModeTransfer mode = random.modes[static_cast<std::size_t>(i)];
    mode.frequency_hz = frequency_hz[static_cast<std::size_t>(i)];
    mode.multipole.centre_m.setZero();
    mode.multipole.wavenumber_per_m = body.transfer.medium.wavenumber_per_m(mode.frequency_hz);
    body.transfer.modes.push_back(mode);
  }
  return body;
}

Listener line(const Eigen::Vector3d& from, const Eigen::Vector3d& to, double duration_s) {
  Eigen::Matrix3Xd places(3, 2);
  places << from, to;
  return Listener::ears({0.0, duration_s}, places);
}

TransferSynthesisResult render(const Body& body, const Listener& listener, const TransferSynthesisOptions& options) {
  TransferSynthesisResult result =
      synthesise_at_ears(body.model, body.transfer, body.decay_per_s, body.strikes, listener, options);
  EXPECT_EQ(result.status, TransferSynthesisResult::Status::kDone);
  return result;
}

Listener delayed(Listener listener) {
  listener.propagation_delay = true;
  return listener;
}

// Amplitude and phase of one frequency in [from, from + n) by least squares with its decay.
Complex partial(const Eigen::VectorXd& x, double frequency_hz, double decay, Eigen::Index from, Eigen::Index n) {
  Eigen::MatrixXd basis(n, 2);
  for (Eigen::Index i = 0; i < n; ++i) {
    const double t = static_cast<double>(from + i) / kRate, a = std::exp(-decay * t);
    basis(i, 0) = a * std::cos(2 * kPi * frequency_hz * t);
    basis(i, 1) = -a * std::sin(2 * kPi * frequency_hz * t);
  }
  const Eigen::Vector2d c = (basis.transpose() * basis).ldlt().solve(basis.transpose() * x.segment(from, n));
  return {c[0], c[1]};
}

TEST(TransferSynthesis, OneEarAtRestIsTheModulusTimesOmegaTimesEachMode) {
  const Body body = body_of({300.0, 1234.5, 7000.0}, 5.0, 6);
  const Eigen::Vector3d x(0.7, -0.5, 0.4);
  const TransferSynthesisResult result =
      render(body, listener_at(x, {}, {}), {.sample_rate_hz = kRate, .duration_s = 0.5});
  Eigen::VectorXd expected = Eigen::VectorXd::Zero(24000);
  for (std::size_t i = 0; i < 3; ++i) {
    const double omega = body.model.angular_frequency_rad_s[static_cast<Eigen::Index>(i)];
    const double gain = std::abs(pressure_pa(body.transfer.modes[i].multipole, x)) * omega;
    expected += oscillation({{omega, 5.0, gain}},
                            {{0.0, Eigen::VectorXd::Constant(1, 1.0 + static_cast<double>(i)), 0.0}}, kRate, 24000);
  }
  EXPECT_LE((result.sound_pa.samples.col(0) - expected).cwiseAbs().maxCoeff(), 1e-11 * expected.cwiseAbs().maxCoeff());
  EXPECT_EQ(result.heard.n_modes_heard, 3);
}

// A round body: cos 2 phi and sin 2 phi of one pitch, or nearly one, each radiating by its own two lobes, struck at an angle.
Body round_body_struck_at(double angle_rad, double apart_hz = 0.0) {
  Body body = body_of({1000.0, 1000.0 + apart_hz}, 20.0, 2);
  for (int i = 0; i < 2; ++i) {
    body.model.shapes(0, i) = i == 0 ? std::cos(2 * angle_rad) : std::sin(2 * angle_rad);
    acoustics::Multipole& multipole = body.transfer.modes[static_cast<std::size_t>(i)].multipole;
    // Y_2^{-2} + Y_2^2 is cos 2 phi; -i (Y_2^2 - Y_2^{-2}) is sin 2 phi. The phase 0.7 is common to both.
    multipole.coefficients_pa.setZero(9);
    const Complex phase = std::polar(1.0, 0.7);
    multipole.coefficients_pa[4] = i == 0 ? phase : phase * Complex(0.0, 1.0);
    multipole.coefficients_pa[8] = i == 0 ? phase : phase * Complex(0.0, -1.0);
  }
  return body;
}

TEST(TransferSynthesis, OneEarHearsARoundBodyAlikeForBlowAndListenerTurnedTogether) {
  const TransferSynthesisOptions options{.sample_rate_hz = kRate, .duration_s = 0.2};
  const auto heard = [&](double blow, double listener, double apart_hz) {
    const Body body = round_body_struck_at(blow, apart_hz);
    const Listener at = listener_at({std::cos(listener), std::sin(listener), 0.1}, {}, {});
    return render(body, at, options).sound_pa.samples.col(0).eval();
  };
  const Eigen::VectorXd expected = heard(0.0, 0.0, 0.0);
  for (const double turn : {0.3, kPi / 4, 1.1, 3 * kPi / 4, 3.0}) {
    const Eigen::VectorXd turned = heard(turn, turn, 0.0);
    const double sign = turned.dot(expected) < 0.0 ? -1.0 : 1.0;  // of a sound as a whole: means nothing
    EXPECT_LE((sign * turned - expected).cwiseAbs().maxCoeff(), 1e-9 * expected.cwiseAbs().maxCoeff()) << turn;
    // Between lobes of the blow nothing is heard: cos(2 (listener - blow)) = 0.
    EXPECT_LE(heard(turn, turn + kPi / 4, 0.0).cwiseAbs().maxCoeff(), 1e-9 * expected.cwiseAbs().maxCoeff()) << turn;
    // A pair that a mesh parts by 0.1 % starts alike and beats later.
    EXPECT_GE(heard(turn, turn, 1.0).head(1000).norm(), 0.98 * expected.head(1000).norm()) << turn;
  }
}

TEST(TransferSynthesis, OneEarThatGoesRoundARoundBodyHearsItsLobesWithoutAClick) {
  const Body body = round_body_struck_at(0.2);
  std::vector<double> times;
  Eigen::Matrix3Xd places(3, 201);
  for (int k = 0; k <= 200; ++k) {
    times.push_back(0.001 * k);
    places.col(k) << std::cos(0.02 * k), std::sin(0.02 * k), 0.1;  // 20 rad/s
  }
  const Eigen::VectorXd x =
      render(body, Listener::ears(times, places), {.sample_rate_hz = kRate, .duration_s = 0.2, .voice = {1000.0}})
          .sound_pa.samples.col(0);
  const Eigen::VectorXd still = render(body, listener_at({std::cos(0.2), std::sin(0.2), 0.1}, {}, {}),
                                       {.sample_rate_hz = kRate, .duration_s = 0.2})
                                    .sound_pa.samples.col(0);
  double sign = 0.0;
  for (Eigen::Index n = 0; n < x.size(); ++n) {
    const double expected = std::cos(2 * (20.0 * static_cast<double>(n) / kRate - 0.2)) * still[n];
    if (sign == 0.0 && std::abs(expected) > 0.1 * still.cwiseAbs().maxCoeff())
      sign = x[n] * expected < 0.0 ? -1.0 : 1.0;
    ASSERT_LE(std::abs((sign == 0.0 ? 1.0 : sign) * x[n] - expected), 2e-3 * still.cwiseAbs().maxCoeff()) << n;
  }
}

TEST(TransferSynthesis, DelayShiftsTheSoundByDistanceOverSpeed) {
  Body body = body_of({440.0, 2345.0}, 3.0, 2);
  body.transfer.medium.sound_speed_m_s = 340.0;
  for (ModeTransfer& mode : body.transfer.modes)
    mode.multipole.wavenumber_per_m = body.transfer.medium.wavenumber_per_m(mode.frequency_hz);
  Listener path = listener_at({0.0, 0.0, 3.4}, {}, {});  // 10 ms, 480 samples
  TransferSynthesisOptions options{.sample_rate_hz = kRate, .duration_s = 0.3};
  const Eigen::VectorXd now = render(body, path, options).sound_pa.samples;
  path.propagation_delay = true;
  const Eigen::VectorXd late = render(body, path, options).sound_pa.samples;
  EXPECT_LE(late.head(480).cwiseAbs().maxCoeff(), 0.0);
  EXPECT_LE((late.tail(late.size() - 481) - now.segment(1, now.size() - 481)).cwiseAbs().maxCoeff(),
            1e-9 * now.cwiseAbs().maxCoeff());
}

TEST(TransferSynthesis, DelayBetweenSamplesIsExact) {
  const Body body = body_of({5000.0}, 40.0);
  const double r = 1.2345;
  const Eigen::VectorXd x =
      render(body, delayed(listener_at({r, 0, 0}, {}, {})), {.sample_rate_hz = kRate, .duration_s = 0.1})
          .sound_pa.samples;
  const double omega = 2 * kPi * 5000.0, damped = std::sqrt(omega * omega - 1600.0),
               c = body.transfer.medium.sound_speed_m_s;
  const double gain = std::abs(pressure_pa(body.transfer.modes[0].multipole, {r, 0, 0})) * omega;
  for (Eigen::Index n = 0; n < x.size(); ++n) {
    const double t = static_cast<double>(n) / kRate - r / c;
    const double expected = t < 0.0 ? 0.0 : gain / damped * std::exp(-40.0 * t) * std::sin(damped * t);
    EXPECT_LE(std::abs(x[n] - expected), 1e-9 * gain / damped) << n;
  }
}

TEST(TransferSynthesis, MovingListenerHearsTheDopplerShiftOnlyWithDelay) {
  const Body body = body_of({1000.0}, 0.5);
  const double speed = 20.0, c = body.transfer.medium.sound_speed_m_s;
  Listener path = line({2.0, 0, 0}, {2.0 + speed, 0, 0}, 1.0);
  TransferSynthesisOptions options{.sample_rate_hz = kRate, .duration_s = 1.0};
  for (const bool delay : {false, true}) {
    path.propagation_delay = delay;
    const Eigen::VectorXd x = render(body, path, options).sound_pa.samples;
    // Frequency from the phases of two stretches of 20 ms, 0.3 s apart.
    const double expected = delay ? 1000.0 * (1.0 - speed / c) : 1000.0;
    const Complex first = partial(x, expected, 0.5, 24000, 960), second = partial(x, expected, 0.5, 38400, 960);
    const double drift_hz = std::arg(second / first) / (2 * kPi * 0.3);
    EXPECT_LE(std::abs(drift_hz), 0.01) << delay;  // 1e-5 of the frequency; the shift is 58 Hz
    // Spherical spreading: r goes from 12.2 to 18.2 m between the middles of the stretches; what was made earlier is louder.
    EXPECT_LE(std::abs(std::abs(second / first) * 18.2 / 12.2 * (delay ? std::exp(-0.5 * 0.3 * speed / c) : 1.0) - 1.0),
              0.01)
        << delay;
  }
}

TEST(TransferSynthesis, TwoEarsDifferByThePhaseAndSpreadingOfTheirPaths) {
  const Body body = body_of({800.0}, 2.0);
  Listener path =
      listener_at({1.0, 1.0, 0.0}, 0.18, Eigen::Vector3d(3.0, 1.0, 0.0));  // faces +x, body to the left behind
  ASSERT_TRUE(path.stereo());
  EXPECT_LE((path.ear_m(0, 0.0) - Eigen::Vector3d(1.0, 1.09, 0.0)).norm(), 1e-12);
  for (const bool delay : {false, true}) {
    path.propagation_delay = delay;
    const Eigen::MatrixXd x = render(body, path, {.sample_rate_hz = kRate, .duration_s = 0.5}).sound_pa.samples;
    ASSERT_EQ(x.cols(), 2);
    const double left = path.ear_m(0, 0.0).norm(), right = path.ear_m(1, 0.0).norm();
    const double damped_hz = std::sqrt(800.0 * 800.0 - std::pow(2.0 / (2 * kPi), 2));
    const Complex ratio = partial(x.col(0), damped_hz, 2.0, 4800, 9600) / partial(x.col(1), damped_hz, 2.0, 4800, 9600);
    const double k = body.transfer.modes[0].multipole.wavenumber_per_m;
    const Complex expected = right / left * std::polar(1.0, -k * (left - right));
    // The exact delay also carries the decay over the path: e^{b (left - right) / c} = 1 + 5e-4.
    EXPECT_LE(std::abs(ratio - expected), 1e-3 * std::abs(expected)) << delay;
  }
}

TEST(TransferSynthesis, PathAt200HzIsAsGoodAsAtTheSampleRateAlmost) {
  // A walk of 3 m/s round a source of order 8, ka = 6: what interpolation from 200 Hz loses.
  const Body body = body_of({700.0, 3275.0}, 2.0, 8);
  const Eigen::Index n = 400;
  std::vector<double> times_s;
  Eigen::Matrix3Xd left_m(3, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    times_s.push_back(static_cast<double>(i) / static_cast<double>(n - 1));
    left_m.col(i) << std::cos(3.0 * times_s.back()), std::sin(3.0 * times_s.back()), 0.2;
  }
  const Listener path = Listener::ears(times_s, left_m, 1.1 * left_m);
  TransferSynthesisOptions options{.sample_rate_hz = kRate, .duration_s = 1.0};
  const Eigen::MatrixXd coarse = render(body, path, options).sound_pa.samples;
  options.voice.update_rate_hz = 10000.0;
  const Eigen::MatrixXd fine = render(body, path, options).sound_pa.samples;
  EXPECT_LE((coarse - fine).norm(), 1e-3 * fine.norm());
}

TEST(TransferSynthesis, UnitTransferIsTheSumOfModalCoordinates) {
  const Body body = body_of({300.0, 1234.5}, 5.0, 3);
  const TransferSynthesisResult result =
      render(body, listener_at({1, 0, 0}, {}, {}),
             {.sample_rate_hz = kRate, .duration_s = 0.2, .voice = {.unit_transfer = true}});
  Eigen::VectorXd expected = oscillation(
      {{body.model.angular_frequency_rad_s[0], 5.0, 1.0}, {body.model.angular_frequency_rad_s[1], 5.0, 1.0}},
      {{0.0, Eigen::Vector2d(1.0, 2.0), 0.0}}, kRate, 9600);
  EXPECT_LE((result.sound_pa.samples.col(0) - expected).cwiseAbs().maxCoeff(), 1e-12 * expected.cwiseAbs().maxCoeff());
}

TEST(TransferSynthesis, SameBitsOnOneAndOnTwoThreadsAndCloseOnOpenCl) {
  const Body body = body_of(std::vector<double>{300, 500, 700, 900, 1100, 1300, 1500, 1700, 1900, 2100}, 5.0, 4);
  const Listener path = delayed(line({1.0, 0.3, 0.2}, {-1.0, 0.5, 0.4}, 0.3));
  TransferSynthesisOptions options{.sample_rate_hz = kRate, .duration_s = 0.3};
  set_thread_count(1);
  const Eigen::MatrixXd one = render(body, path, options).sound_pa.samples;
  set_thread_count(2);
  const Eigen::MatrixXd two = render(body, path, options).sound_pa.samples;
  set_thread_count(0);
  EXPECT_EQ((one - two).cwiseAbs().maxCoeff(), 0.0);
  options.voice.device.used = true;
  const TransferSynthesisResult device = render(body, path, options);
  EXPECT_NE(device.heard.device_name, "processor");
  EXPECT_LE((device.sound_pa.samples - one).cwiseAbs().maxCoeff(), 1e-11 * one.cwiseAbs().maxCoeff());
}

TEST(TransferSynthesis, MovingBodyIsAListenerWhoMovesTheOtherWay) {
  const Body body = body_of({800.0, 1700.0}, 2.0, 3);
  RadiatingVoice voice(0, body.model, body.transfer, body.decay_per_s);
  Voice* const voices[] = {&voice};
  events::EventLog log = log_of(body.strikes);
  const auto sound = [&](const Listener& listener) {
    return stage::render(log, voices, delayed(listener), {kRate, 0.4}).samples.col(0).eval();
  };
  const Eigen::VectorXd expected = sound(line({1.0, 0.3, 0.2}, {3.0, 0.7, 0.2}, 0.4));
  log.poses = {{0, 0.0, {1.0, 2.0, 3.0}, {1, 0, 0, 0}}, {0, 0.4, {-1.0, 1.6, 3.0}, {1, 0, 0, 0}}};
  const Eigen::VectorXd moved = sound(listener_at({2.0, 2.3, 3.2}, {}, {}));
  EXPECT_LE((moved - expected).cwiseAbs().maxCoeff(), 1e-9 * expected.cwiseAbs().maxCoeff());
}

TEST(TransferSynthesis, TurnedBodyIsHeardFromItsOtherSide) {
  const Body body = body_of({800.0}, 2.0, 4);
  RadiatingVoice voice(0, body.model, body.transfer, body.decay_per_s);
  Voice* const voices[] = {&voice};
  events::EventLog log = log_of(body.strikes);
  const auto sound = [&](const Eigen::Vector3d& at) {
    return stage::render(log, voices, listener_at(at, {}, {}), {kRate, 0.1}).samples.col(0).eval();
  };
  const Eigen::VectorXd expected = sound({0.0, -1.0, 0.5});
  const double c = std::sqrt(0.5);
  log.poses = {{0, 0.0, {0, 0, 0}, {c, 0, 0, c}}};  // 90 degrees about z: what was at -y is at +x
  EXPECT_LE((sound({1.0, 0.0, 0.5}) - expected).cwiseAbs().maxCoeff(), 1e-12 * expected.cwiseAbs().maxCoeff());
}

TEST(TransferSynthesis, HeadShadesAndDelaysWhatItsCentreHears) {
  const Body body = body_of({900.0}, 2.0);
  SphericalHead head;
  head.centre_m = {1.5, 0.0, 0.0};
  head.facing = {0.0, 1.0, 0.0};  // the body is to the left
  const double damped_hz = std::sqrt(900.0 * 900.0 - std::pow(2.0 / (2 * kPi), 2)), omega = 2 * kPi * damped_hz;
  for (const bool delay : {false, true}) {
    Listener listener = Listener::head({0.0}, head.centre_m, {}, head);
    listener.propagation_delay = delay;
    const Eigen::MatrixXd x = render(body, listener, {.sample_rate_hz = kRate, .duration_s = 0.5}).sound_pa.samples;
    const double left = head.angle_rad(0, {0, 0, 0}), right = head.angle_rad(1, {0, 0, 0});
    const Complex ratio = partial(x.col(0), damped_hz, 2.0, 4800, 9600) / partial(x.col(1), damped_hz, 2.0, 4800, 9600);
    const Complex expected = head.shadow(left, omega) / head.shadow(right, omega) *
                             std::polar(1.0, -omega * (head.delay_s(left) - head.delay_s(right)));
    EXPECT_LE(std::abs(ratio - expected), 2e-3 * std::abs(expected))
        << delay;  // the decay over the delay: 2 / s x 0.8 ms
  }
}

TEST(TransferSynthesis, ListenerWithoutAPlaceIsBadInput) {
  const Body body = body_of({300.0}, 5.0);
  EXPECT_THROW(render(body, Listener::without_place(), {}), InputError);
}

TEST(TransferSynthesis, DropsModesThatWouldFoldBackAndCountsThoseWithoutTransfer) {
  Body body = body_of({300.0, 3000.0, 900.0}, 5.0);
  body.transfer.modes.pop_back();
  const TransferSynthesisResult result =
      render(body, listener_at({1, 0, 0}, {}, {}), {.sample_rate_hz = 4000.0, .duration_s = 0.1});
  EXPECT_EQ(result.heard.n_modes_heard, 1);
  EXPECT_EQ(result.heard.n_modes_too_high, 1);
  EXPECT_EQ(result.heard.n_modes_without_transfer, 1);
}

TEST(TransferSynthesis, ListenerWithinTheBodysSphereIsBadInput) {
  const Body body = body_of({300.0}, 5.0);
  EXPECT_THROW(render(body, listener_at({0.0, 0.0, 0.099}, {}, {}), {}), InputError);
  EXPECT_NO_THROW(render(body, listener_at({0.0, 0.0, 0.101}, {}, {}), {.sample_rate_hz = kRate, .duration_s = 0.01}));
  EXPECT_THROW(render(body, line({1.0, 0.0, 0.0}, {0.01, 0.0, 0.0}, 1.0), {}), InputError);
}

TEST(DefaultListener, DefaultStandsWhereTheStrongestModeIsLoudest) {
  TransferModel model = random_transfer({1, 1}, 82);
  for (ModeTransfer& mode : model.modes) mode.multipole.coefficients_pa.setZero();
  model.modes[0].multipole.coefficients_pa[acoustics::basis_index(1, 0)] = 100.0;
  model.modes[0].radiated_power_w = 1.0;
  model.modes[1].multipole.coefficients_pa[acoustics::basis_index(1, 1)] = 1.0;  // a dipole along x:  Y_1^1 - Y_1^-1
  model.modes[1].multipole.coefficients_pa[acoustics::basis_index(1, -1)] = -1.0;
  model.modes[1].radiated_power_w = 2.0;
  const Eigen::Vector3d d = default_listener_m(model, 1.0) - model.modes[0].multipole.centre_m;
  EXPECT_LE(std::abs(d.norm() - 1.0), 1e-12);
  EXPECT_GE(std::abs(d.x()), 0.97);
  model.modes[1].radiated_power_w = 0.5;
  EXPECT_GE(std::abs((default_listener_m(model, 1.0) - model.modes[0].multipole.centre_m).z()), 0.97);
  EXPECT_EQ(default_listener_m({}, 1.0), Eigen::Vector3d(0, 0, 1));
}

class PathFile : public testing::Test {
 protected:
  Listener read(const std::string& text, std::optional<double> ears_m = {}) {
    const auto path =
        std::filesystem::path(testing::TempDir()) /
        (std::string("klang-path-") + testing::UnitTest::GetInstance()->current_test_info()->name() + ".csv");
    write_file(path, text);
    return read_listener(path, ears_m, Eigen::Vector3d::Zero());
  }
  void expect_refused(const std::string& text, const std::string& word, std::optional<double> ears_m = {}) {
    try {
      read(text, ears_m);
      FAIL() << text;
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find(word), std::string::npos) << error.what();
      EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
    }
  }
};

TEST_F(PathFile, ReadsEachKindOfColumns) {
  Listener path = read("time_s,x_m,y_m,z_m\n0,1,2,3\r\n# half way\n\n2, 3,2,3\n");
  EXPECT_FALSE(path.stereo());
  EXPECT_EQ(path.ear_m(0, 1.0), Eigen::Vector3d(2, 2, 3));
  EXPECT_EQ(path.ear_m(0, -1.0), Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(path.ear_m(0, 9.0), Eigen::Vector3d(3, 2, 3));
  EXPECT_EQ(read("0,1,2,3").ear_m(0, 0.0), Eigen::Vector3d(1, 2, 3));
  path = read("time_s,x_m,y_m,z_m,right_x_m,right_y_m,right_z_m\n0,1,2,3,4,5,6\n");
  EXPECT_EQ(path.ear_m(1, 0.0), Eigen::Vector3d(4, 5, 6));
  path = read("time_s,x_m,y_m,z_m,facing_x,facing_y,facing_z\n0,1,2,3,0,5,0\n", 0.2);  // faces +y: right is +x
  EXPECT_LE((path.ear_m(1, 0.0) - Eigen::Vector3d(1.1, 2, 3)).norm(), 1e-12);
  path = read("0,-2,0,0\n", 0.2);  // faces the origin, +x: right is -y
  EXPECT_LE((path.ear_m(1, 0.0) - Eigen::Vector3d(-2, -0.1, 0)).norm(), 1e-12);
}

TEST_F(PathFile, RefusesWhatIsNoPathAndNamesTheLine) {
  expect_refused("", "no position");
  expect_refused("time_s,x_m,y_m,z_m\n", "no position");
  expect_refused("time_s,x_m,y_m,z_m\n0,1,2,3\n0,1,2,3\n", ":3");
  expect_refused("time_s,x_m,y_m,z_m\n0,1,2\n", ":2");
  expect_refused("time_s,x_m,y_m,z_m\n0,1,two,3\n", "two");
  expect_refused("time_s,x_m,y_m,z_m\n0,1,nan,3\n", ":2");
  expect_refused("time_s,x_m,y_m,z_m\n0,1,1e9,3\n", "1e9");
  expect_refused("t,x,y,z\n0,1,2,3\n", "columns");
  expect_refused("time_s,x_m,y_m,z_m,facing_x,facing_y,facing_z\n0,1,2,3,0,5,0\n", "ears_m");
  expect_refused("time_s,x_m,y_m,z_m,facing_x,facing_y,facing_z\n0,1,2,3,0,0,0\n", "facing", 0.2);
  expect_refused("0,1,2,3,4,5,6\n", "right ear", 0.2);
  expect_refused("0,1,2,3,4\n", ":1");
}

}  // namespace
}  // namespace klang::stage
