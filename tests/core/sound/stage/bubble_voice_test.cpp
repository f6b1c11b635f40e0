#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/output_file.hpp"
#include "core/foundation/base/parallel.hpp"
#include "core/physics/bubble/bubble_physics.hpp"
#include "core/physics/bubble/ringdown_formulas.hpp"
#include "core/sound/stage/bubble_scene.hpp"
#include "core/sound/stage/ring_sound.hpp"
#include "tests/places.hpp"

namespace klang::stage {
namespace {

using namespace bubble;
using Complex = std::complex<double>;

RingingBubble rising_bubble(double radius_m = 2e-3) {
  RingingBubble bubble;
  bubble.radius_m = radius_m;
  RiseOptions rise;
  rise.kind = RiseKind::kTerminal;
  bubble.motion = analytic_rise({0.1, 0.0, -0.012}, radius_m, rise);
  return bubble;
}

/// A folder of its own for the files of a scene.
struct Folder {
  std::filesystem::path path;
  Folder() : path(std::filesystem::temp_directory_path() / ("klang-bubble-" + std::to_string(::getpid()))) {
    std::filesystem::create_directories(path);
  }
  ~Folder() { std::filesystem::remove_all(path); }
  void write(const std::string& name, const std::string& text) const { std::ofstream(path / name) << text; }
};

BubbleScene scene_of(const std::string& toml, const std::filesystem::path& folder = ".", std::uint64_t seed = 1) {
  return parse_bubble_scene(toml, "scene.toml", folder, seed);
}

const std::string kOneBubble =
    "[[bubble]]\nradius_m = 0.002\nbirth_s = 0.01\nposition_m = [0.1, 0, -0.012]\nrise = \"terminal\"\n";

TEST(RingSound, IsTheTracksExponentialTimesGainAndWindows) {
  const RingTrack track = ring_track(rising_bubble());
  std::vector<Complex> start, end;
  for (const RingBlock& block : track.blocks) {
    start.emplace_back(1.0 + block.start_s, -0.3);
    end.emplace_back(1.0 + block.start_s + block.length_s, -0.3);
  }
  const double rate = 44100.0, onset = 0.0123;
  const RingSound voice{&track, onset, start, end, true};
  const FrameRange range = frames_of(voice, rate);
  std::vector<double> sound(static_cast<std::size_t>(range.end - range.first) + 20, 0.0);
  add_ring(voice, rate, range.first - 10, sound);
  double worst = 0.0;
  for (std::size_t i = 0; i < sound.size(); ++i) {
    const double age = static_cast<double>(range.first - 10 + static_cast<std::int64_t>(i)) / rate - onset;
    double expected = (Complex(1.0 + age, -0.3) * track.value(age)).real();
    if (age >= 0.0) expected *= attack_window(track.decay_start_per_s, age);
    if (age > track.faded_from_s)
      expected *= 0.5 * (1.0 + std::cos(kPi * (age - track.faded_from_s) / (track.end_s - track.faded_from_s)));
    if (age >= track.end_s) expected = 0.0;
    worst = std::max(worst, std::abs(sound[i] - expected));
  }
  EXPECT_LE(worst, 1e-9 * track.amplitude_m);
  EXPECT_EQ(sound[9], 0.0);
}

TEST(RingSound, PiecesOfAnOutputJoinWithoutAStep) {
  const RingTrack track = ring_track(rising_bubble());
  const std::vector<Complex> gain(track.blocks.size(), 1.0);
  const RingSound voice{&track, 0.0, gain, gain, true};
  std::vector<double> whole(3000, 0.0), front(1111, 0.0), back(3000 - 1111, 0.0);
  add_ring(voice, 48000.0, 0, whole);
  add_ring(voice, 48000.0, 0, front);
  add_ring(voice, 48000.0, 1111, back);
  front.insert(front.end(), back.begin(), back.end());
  for (std::size_t i = 0; i < whole.size(); ++i) ASSERT_NEAR(front[i], whole[i], 1e-11 * track.amplitude_m);
}

TEST(RingSound, LongConstantToneDoesNotDrift) {
  RingingBubble bubble;
  bubble.radius_m = 0.04;  // 82 Hz, 2.5 s
  const RingTrack track = ring_track(bubble);
  const std::vector<Complex> gain(track.blocks.size(), 1.0);
  const double rate = 192000.0;
  std::vector<double> sound(static_cast<std::size_t>(0.99 * track.faded_from_s * rate), 0.0);
  add_ring({&track, 0.0, gain, gain, false}, rate, 0, sound);
  for (std::size_t i = 0; i < sound.size(); i += 997) {
    const Complex z = track.value(static_cast<double>(i) / rate);
    ASSERT_NEAR(sound[i], z.real(), 1e-8 * std::abs(z)) << i;
  }
}

TEST(BubbleSound, MonoIsTheModulusOfTheTransferTimesTheOscillation) {
  Folder folder;
  folder.write("p.csv", "time_s,re,im\n0,3,4\n10,3,4\n");
  const BubbleScene scene =
      scene_of("[listener]\nmode = \"mono\"\n[sound]\nattack = \"none\"\n" + kOneBubble + "transfer_file = \"p.csv\"\n",
               folder.path);
  const BubbleSound result = synthesise_bubbles(scene);
  ASSERT_EQ(result.status, BubbleSoundStatus::kDone);
  ASSERT_EQ(result.sound.n_channels(), 1);
  RingingBubble bubble = rising_bubble();
  bubble.onset_velocity_m_s = entrainment_velocity_m_s(2e-3);
  const RingTrack track = ring_track(bubble);
  for (int i = 0; i < 1500; i += 7) {
    const double age = i / 48000.0 - 0.01;
    if (age > track.faded_from_s) break;
    EXPECT_NEAR(result.sound.samples(i, 0), 5.0 * track.value(age).real(), 1e-5 * 5.0 * track.amplitude_m) << i;
  }
}

TEST(BubbleSound, SameBitsOnAnyNumberOfThreads) {
  const std::string toml =
      "[[population]]\ncount = 150\ntime_end_s = 0.2\nbox_low_m = [-0.1, -0.1, -0.05]\nbox_high_m = [0.1, 0.1, "
      "-0.01]\nrise = \"terminal\"\n";
  set_thread_count(1);
  const BubbleSound one = synthesise_bubbles(scene_of(toml));
  set_thread_count(0);
  const BubbleSound all = synthesise_bubbles(scene_of(toml));
  ASSERT_EQ(one.sound.samples.rows(), all.sound.samples.rows());
  EXPECT_EQ(one.sound.samples, all.sound.samples);
  const BubbleSound other = synthesise_bubbles(scene_of(toml, ".", 2));
  EXPECT_NE(other.bubbles[0].frequency_start_hz, all.bubbles[0].frequency_start_hz);
}

TEST(BubbleSound, ConstantPitchAndUnitTransferAreComparisonsOfTheSameBubbles) {
  BubbleScene scene = scene_of(kOneBubble);
  const BubbleSound rising = synthesise_bubbles(scene);
  scene.pitch.kind = PitchKind::kConstant;
  const BubbleSound flat = synthesise_bubbles(scene);
  EXPECT_GT(rising.bubbles[0].frequency_end_hz, 1.3 * rising.bubbles[0].frequency_start_hz);
  EXPECT_EQ(flat.bubbles[0].frequency_end_hz, flat.bubbles[0].frequency_start_hz);
  EXPECT_NEAR(flat.bubbles[0].frequency_start_hz / rising.bubbles[0].frequency_start_hz, 1.0, 1e-4);
  scene.transfer = SceneTransfer::kUnit;
  const BubbleSound unit = synthesise_bubbles(scene);
  EXPECT_NEAR(unit.bubbles[0].peak / unit.bubbles[0].amplitude_m, 1.0, 0.5);  // the head's shadow alone
}

TEST(BubbleSound, BubbleOnTheLeftIsEarlierAndLouderInTheLeftEar) {
  const BubbleSound sound = synthesise_bubbles(
      scene_of("[listener]\nposition_m = [0, -0.5, 0.1]\n[sound]\nattack = \"none\"\n[[bubble]]\nradius_m = "
               "0.001\nbirth_s = 0.01\nposition_m = [-2, -0.5, -0.01]\n"));
  const auto onset = [&](int channel) {
    Eigen::Index i = 0;
    while (sound.sound.samples(i, channel) == 0.0) ++i;
    return static_cast<double>(i) / 48000.0;
  };
  SphericalHead head;
  head.centre_m = {0, -0.5, 0.1};
  const double left = head.delay_s(head.angle_rad(0, {-2, -0.5, -0.01})),
               right = head.delay_s(head.angle_rad(1, {-2, -0.5, -0.01}));
  EXPECT_NEAR(onset(1) - onset(0), right - left, 2.0 / 48000);
  EXPECT_GT(right - left, 5e-4);
  EXPECT_GT(sound.sound.samples.col(0).norm(), 3.0 * sound.sound.samples.col(1).norm());
}

TEST(BubbleSound, ListenerWhoWalksHearsEachBubbleFromWhereHeIs) {
  Folder folder;
  folder.write(
      "walk.csv",
      "time_s,x_m,y_m,z_m,facing_x,facing_y,facing_z\n0,0,-0.5,0.3,0,1,0\n1,0,-0.5,0.3,0,1,0\n2,0,0.5,0.3,0,-1,0\n");
  const auto bubbles = [](double birth_s) {
    return "[[bubble]]\nradius_m = 0.001\nbirth_s = " + std::to_string(birth_s) + "\nposition_m = [-0.3, 0, -0.01]\n";
  };
  const std::string walks = "[listener]\npath_csv = \"walk.csv\"\n[sound]\nduration_s = 3\n";
  const BubbleSound sound = synthesise_bubbles(scene_of(walks + bubbles(0.1) + bubbles(2.5), folder.path));
  const auto level = [&](int channel, Eigen::Index from) {
    return sound.sound.samples.col(channel).segment(from, 48000 / 4).norm();
  };
  EXPECT_GT(level(0, 4800), 1.1 * level(1, 4800));
  // On the other side, turned: left and right are exchanged, all else is the same.
  EXPECT_NEAR(level(1, 120000) / level(0, 4800), 1.0, 1e-3);
  EXPECT_NEAR(level(0, 120000) / level(1, 4800), 1.0, 1e-3);
}

TEST(BubbleSound, ListenerWhoApproachesHearsTheDopplerShift) {
  Folder folder;
  folder.write("rush.csv", "time_s,x_m,y_m,z_m\n0,0,-11,0.5\n1,0,9,0.5\n");  // 20 m/s
  const std::string scene =
      "[sound]\nduration_s = 2\nattack = \"none\"\n[pitch]\nmodel = \"constant\"\n[[bubble]]\nradius_m = "
      "0.005\nbirth_s = 0.02\nposition_m = [0, 0, -0.01]\n";
  const auto frequency = [&](const std::string& listener) {
    const BubbleSound sound =
        synthesise_bubbles(scene_of("[listener]\npropagation_delay = true\n" + listener + scene, folder.path));
    const auto channel = sound.sound.samples.col(0);
    std::vector<double> crossings;
    for (Eigen::Index i = 1; i < channel.size() && crossings.size() < 21; ++i) {
      if (channel[i - 1] < 0.0 && channel[i] >= 0.0)
        crossings.push_back(static_cast<double>(i) - channel[i] / (channel[i] - channel[i - 1]));
    }
    return 48000.0 * static_cast<double>(crossings.size() - 1) / (crossings.back() - crossings.front());
  };
  const double ratio = frequency("path_csv = \"rush.csv\"\n") / frequency("position_m = [0, -10.6, 0.5]\n");
  EXPECT_NEAR(ratio, 1.0 + 20.0 / 343.0, 0.003);
}

TEST(BubbleSound, TooHighBubblesAreLeftOutAndCounted) {
  const BubbleSound sound = synthesise_bubbles(scene_of(
      "[sound]\nsample_rate_hz = 8000\n[[bubble]]\nradius_m = 0.0004\nposition_m = [0, 0, -0.01]\n" + kOneBubble));
  EXPECT_EQ(sound.n_too_high, 1u);
  EXPECT_EQ(sound.status, BubbleSoundStatus::kDone);
}

// One bubble of kOneBubble as an event.
events::EventLog bubble_log() {
  events::EventLog log;
  log.bubbles = {{0.01, 2e-3, 1.0, {0.1, 0, -0.012}}};
  return log;
}

TEST(BubbleVoice, PathOfALogIsThePathOfAFile) {
  Folder folder;
  events::EventLog log = bubble_log();
  std::string path = "time_s,x_m,y_m,z_m\n";
  for (int i = 0; i <= 60; ++i) {
    const double t = 1e-3 * i, z = std::stod(std::to_string(-0.0135 + 0.15 * t));
    path += std::to_string(t) + ",0.1,0," + std::to_string(z) + "\n";
    log.bubble_points.push_back({0, std::stod(std::to_string(t)), {0.1, 0.0, z}, z});
  }
  folder.write("path.csv", path);
  const BubbleScene scene =
      scene_of("[[bubble]]\nradius_m = 0.002\nbirth_s = 0.01\npath_csv = \"path.csv\"\n", folder.path);
  BubbleVoice voice(scene);
  Voice* const voices[] = {&voice};
  const audio::Signal sound = render(log, voices, scene.listener, {scene.sample_rate_hz, std::nullopt});
  EXPECT_EQ(sound.samples, synthesise_bubbles(scene).sound.samples);
}

TEST(BubbleVoice, WithoutAPathABubbleRestsWhereItWasBorn) {
  const BubbleScene scene = scene_of("[[bubble]]\nradius_m = 0.002\nbirth_s = 0.01\nposition_m = [0.1, 0, -0.012]\n");
  BubbleVoice voice(scene);
  Voice* const voices[] = {&voice};
  EXPECT_EQ(render(bubble_log(), voices, scene.listener, {48000.0, std::nullopt}).samples,
            synthesise_bubbles(scene).sound.samples);
}

TEST(BubbleVoice, EarsWithoutAHeadHearTheDifferenceOfTheirWays) {
  BubbleSettings settings;
  settings.pitch.kind = PitchKind::kConstant;
  BubbleVoice voice(settings);
  Voice* const voices[] = {&voice};
  const Eigen::Vector3d left(-1.0, 0.0, 0.3), right(-1.3, 0.0, 0.3), bubble(0.1, 0.0, -0.012);
  for (const bool delay : {false, true}) {
    Listener ears = Listener::ears({0.0}, left, right);
    ears.propagation_delay = delay;
    const Eigen::MatrixXd x = render(bubble_log(), voices, ears, {192000.0, std::nullopt}).samples;
    const auto onset = [&](int channel) {
      Eigen::Index i = 0;
      while (x(i, channel) == 0.0) ++i;
      return static_cast<double>(i) / 192000.0;
    };
    const double way_m = (right - bubble).norm() - (left - bubble).norm();
    EXPECT_LE(std::abs(onset(1) - onset(0) - way_m / 343.0), 1.5 / 192000.0) << delay;
    EXPECT_GE(onset(0), 0.01 + (delay ? (left - bubble).norm() / 343.0 : 0.0) - 1e-9) << delay;
  }
}

TEST(HalfSpace, IsTheRayleighIntegralOfTheFlowThroughTheSurface) {
  const BubbleScene scene = scene_of(kOneBubble);
  const double omega = 2 * kPi * 2000.0, radius = 1e-3, depth = 0.02, far = 5.0;
  const double k_a = omega / scene.air_sound_speed_m_s, k_f = omega / scene.medium.liquid_sound_speed_m_s;
  for (const double theta : {0.05, 0.7, 1.3}) {
    const Eigen::Vector3d listener(far * std::sin(theta), 0.0, far * std::cos(theta));
    // P = -rho_a omega^2 r^2 (d / pi) int (1 + i k_f s) e^{-i k_f s} / s^3 e^{-i k_a R} / R dS, s^2 = rho^2 + d^2; the
    // outer part is faded out, where it oscillates to nothing.
    Complex integral = 0.0;
    const int n_u = 4000, n_phi = 720;
    const double u_end = std::asinh(9.0 / depth);
    for (int i = 0; i < n_u; ++i) {
      const double u = (i + 0.5) * u_end / n_u, rho = depth * std::sinh(u), s = std::hypot(rho, depth);
      const double weight = depth * std::cosh(u) * u_end / n_u * rho * 2 * kPi / n_phi;
      const double fade = rho < 3.0 ? 1.0 : 0.5 * (1.0 + std::cos(kPi * (rho - 3.0) / 6.0));
      const Complex flow = Complex(1.0, k_f * s) * std::polar(1.0, -k_f * s) / (s * s * s) * fade * weight;
      Complex ring = 0.0;
      for (int j = 0; j <= n_phi / 2; ++j) {
        const double phi = 2 * kPi * j / n_phi, times = j == 0 || j == n_phi / 2 ? 1.0 : 2.0;
        const double way = (listener - Eigen::Vector3d(rho * std::cos(phi), rho * std::sin(phi), 0.0)).norm();
        ring += times * std::polar(1.0 / way, -k_a * way);
      }
      integral += flow * ring;
    }
    const Complex exact = -scene.air_density_kg_m3 * omega * omega * radius * radius * depth / kPi * integral;
    const Complex closed =
        half_space_transfer(scene, radius, {0, 0, -depth}, listener, Complex(0.0, omega)) * std::polar(1.0, -k_a * far);
    EXPECT_LE(std::abs(closed - exact), 0.02 * std::abs(exact)) << theta << " " << closed << " " << exact;
  }
}

TEST(Head, DelayIsContinuousAndShadowIsTheModels) {
  SphericalHead head;
  EXPECT_NEAR(head.delay_s(0.5 * kPi - 1e-9), head.delay_s(0.5 * kPi), 1e-12);
  EXPECT_NEAR(head.delay_s(0.0), -0.0875 / 343.0, 1e-15);
  EXPECT_NEAR(head.delay_s(kPi), 0.0875 / 343.0 * 0.5 * kPi, 1e-15);
  EXPECT_NEAR(std::abs(head.shadow(2.0, 0.0)), 1.0, 1e-15);
  EXPECT_NEAR(std::abs(head.shadow(0.0, 1e9)), 2.0, 1e-6);                // +6 dB towards the source
  EXPECT_NEAR(std::abs(head.shadow(150.0 * kPi / 180, 1e9)), 0.1, 1e-6);  // -20 dB in the deepest shadow
  head.centre_m.setZero();
  EXPECT_NEAR(head.angle_rad(0, {0, 1, 0}), head.angle_rad(1, {0, 1, 0}), 1e-12);
  EXPECT_NEAR(head.angle_rad(0, {0, 1, 0}), 100.0 * kPi / 180, 1e-12);
  EXPECT_LT(head.angle_rad(0, {-1, 0, 0}), head.angle_rad(1, {-1, 0, 0}));
}

TEST(Scene, PathAndPhiOfFilesMoveTheBubble) {
  Folder folder;
  std::string path = "time_s,x_m,y_m,z_m\n", phi = "time_s,phi_m\n";
  for (int i = 0; i <= 50; ++i) {
    const double t = 1e-3 * i;
    path += std::to_string(t) + ",0.1,0," + std::to_string(-0.012 + 0.15 * t) + "\n";
    phi += std::to_string(t) + "," + std::to_string(-0.012 + 0.15 * t) + "\n";
  }
  folder.write("path.csv", path);
  folder.write("phi.csv", phi);
  const BubbleScene a =
      scene_of("[[bubble]]\nradius_m = 0.002\nbirth_s = 0.01\npath_csv = \"path.csv\"\n", folder.path);
  const BubbleScene b =
      scene_of("[[bubble]]\nradius_m = 0.002\nbirth_s = 0.01\nposition_m = [0.1, 0, -0.01]\nphi_csv = \"phi.csv\"\n",
               folder.path);
  EXPECT_NEAR(a.bubbles[0].motion->phi_m(0.0).v, -0.0105, 1e-6);
  EXPECT_NEAR(a.bubbles[0].motion->phi_m(0.02).v, -0.0075, 1e-6);
  EXPECT_NEAR(a.bubbles[0].motion->phi_m(1.0).v, -0.0045, 1e-6);  // at rest after the last frame
  EXPECT_NEAR(b.bubbles[0].motion->phi_m(0.02).d, 0.15, 1e-4);
  EXPECT_NEAR(synthesise_bubbles(a).bubbles[0].frequency_end_hz / synthesise_bubbles(b).bubbles[0].frequency_end_hz,
              1.0, 1e-6);
}

TEST(Scene, BadFilesAndKeysAreNamed) {
  Folder folder;
  const auto refused = [&](const std::string& toml, const std::vector<std::string>& words) {
    try {
      scene_of(toml, folder.path);
      ADD_FAILURE() << toml;
    } catch (const InputError& error) {
      for (const std::string& word : words)
        EXPECT_NE(std::string(error.what()).find(word), std::string::npos) << word << " in " << error.what();
    }
  };
  const std::string head = "[[bubble]]\nradius_m = 0.002\n";
  refused("", {"scene.toml", "no bubbles"});
  refused("[[bubble]]\nradius_m = 9223372036854775807\nposition_m = [0, 0, -0.01]\n",
          {"radius_m", "9223372036854775808"});
  refused("[[bubble]]\nradius_m = 0.05\nposition_m = [0, 0, -0.001]\n", {"not in the liquid"});
  refused("[[population]]\ncount = 2.5\ntime_end_s = 1\nbox_low_m = [0, 0, -0.1]\nbox_high_m = [0.1, 0.1, -0.05]\n",
          {"count", "whole"});
  refused("colour = 3\n", {"scene.toml:1", "colour", "liquid"});
  refused("[[bubble]]\nradius_m = 0\nposition_m = [0,0,-0.01]\n", {"scene.toml:2", "radius_m"});
  refused("[[bubble]]\nradius_m = 1.0\nposition_m = [0,0,-0.01]\n", {"radius_m", "0.05"});
  refused(head + "position_m = [0, 0, 0]\n", {"scene.toml:3", "not in the liquid"});
  refused(head + "position_m = [0, 0, 0.01]\n", {"not in the liquid"});
  refused(head + "path_csv = \"gone.csv\"\n", {"scene.toml:3", "gone.csv"});
  refused(head + "position_m = [0, 0, -0.01]\nrise_speed_m_s = 0.1\n", {"rise_speed_m_s"});
  refused("[listener]\nposition_m = [0, 0, -1]\n" + head + "position_m = [0, 0, -0.01]\n", {"position_m", "air"});
  folder.write("gap.csv", "time_s,phi_m\n0,-0.01\n0.001,-0.01\n0.002,-0.01\n0.004,-0.01\n0.005,-0.01\n");
  refused(head + "position_m = [0, 0, -0.01]\nphi_csv = \"gap.csv\"\n", {"gap.csv", "misses frames", "0.002", "0.004"});
  folder.write("late.csv", "time_s,phi_m\n0.1,-0.01\n0.2,-0.01\n");
  refused(head + "position_m = [0, 0, -0.01]\nphi_csv = \"late.csv\"\n", {"late.csv", "after the bubble's birth"});
  folder.write("nan.csv", "time_s,phi_m\n0,-0.01\n0.2,nan\n");
  refused(head + "position_m = [0, 0, -0.01]\nphi_csv = \"nan.csv\"\n", {"nan.csv, line 3", "not finite"});
  folder.write("out.csv", "time_s,phi_m\n0,0.01\n0.2,0.01\n");
  refused(head + "position_m = [0, 0, -0.01]\nphi_csv = \"out.csv\"\n", {"out.csv", "not in the liquid"});
  folder.write("back.csv", "time_s,re,im\n0,1,0\n0,1,0\n");
  refused(head + "position_m = [0, 0, -0.01]\ntransfer_file = \"back.csv\"\n", {"back.csv, line 3", "does not rise"});
  folder.write("t.json", "{\"transfer\": [{\"time_s\": 0, \"re\": 1}]}");
  refused(head + "position_m = [0, 0, -0.01]\ntransfer_file = \"t.json\"\n", {"t.json", "im"});
  refused("[[population]]\ncount = 3\ntime_end_s = 1\nbox_low_m = [0,0,-1]\nbox_high_m = [1,1,1]\n", {"box_high_m"});
}

TEST(Scene, TransferOfJsonIsThatOfCsv) {
  Folder folder;
  folder.write("t.csv", "time_s,re,im\n0,1,2\n1,3,-2\n");
  folder.write("t.json", R"({"transfer": [{"time_s": 0, "re": 1, "im": 2}, {"time_s": 1, "re": 3, "im": -2}]})");
  const TransferSeries csv = read_transfer_series(folder.path / "t.csv"),
                       json = read_transfer_series(folder.path / "t.json");
  for (const double t : {-1.0, 0.0, 0.25, 1.0, 2.0}) EXPECT_EQ(csv.at(t, 1000.0), json.at(t, 1000.0));
  EXPECT_EQ(csv.at(0.25, 1000.0), Complex(1.5, 1.0));
  EXPECT_EQ(csv.at(0.25, 2000.0), Complex(1.5, 1.0));  // no frequency: as it stands
}

TEST(TransferSeries, OfOneFrequencyGoesWithItsSquare) {
  Folder folder;
  folder.write("t.csv", "time_s,frequency_hz,re,im\n0,1000,1,2\n1,1000,3,-2\n");
  folder.write("t.json",
               R"({"provenance": {"options": {"frequency_hz": 1000}}, "transfer": [{"time_s": 0, "re": 1, "im": 2},
                            {"time_s": 1, "re": 3, "im": -2}]})");
  for (const char* name : {"t.csv", "t.json"}) {
    const TransferSeries series = read_transfer_series(folder.path / name);
    for (const double f : {500.0, 1000.0, 2500.0})
      EXPECT_LE(std::abs(series.at(0.25, f) - f * f / 1e6 * Complex(1.5, 1.0)), 1e-14) << name << " " << f;
  }
}

TEST(TransferSeries, TakesRowsInAnyOrderAndIsAPowerBetweenFrequencies) {
  // P = c f^2.5 e^{-2 pi i f tau}, less than half a turn between frequencies; at 1 s one frequency less and twice as loud.
  const auto exact = [](double t, double f) {
    return (1.0 + t) * std::pow(f, 2.5) * std::polar(1.0, -2 * kPi * f * 1e-3);
  };
  std::vector<TransferSeries::Row> rows;
  for (const double f : {1500.0, 900.0, 1200.0})
    for (const double t : {1.0, 0.0})
      if (f != 1500.0 || t == 0.0) rows.push_back({t, f, exact(t, f)});
  const TransferSeries series(rows, "rows");
  for (const double f : {900.0, 1000.0, 1200.0})
    for (const double t : {0.0, 0.25, 1.0})
      EXPECT_LE(std::abs(series.at(t, f) - exact(t, f)), 1e-12 * std::abs(exact(t, f))) << t << " " << f;
  EXPECT_LE(std::abs(series.at(0.0, 1350.0) - exact(0.0, 1350.0)), 1e-12 * std::abs(exact(0.0, 1350.0)));
  EXPECT_LE(std::abs(series.at(1.0, 1500.0)) / (std::abs(exact(1.0, 1200.0)) * 1.5625) - 1.0, 1e-12);
}

TEST(TransferSeries, RefusesWhatIsTwiceOrHalfThere) {
  Folder folder;
  const auto refused = [&](const std::string& rows, const std::string& word) {
    folder.write("t.csv", rows);
    try {
      read_transfer_series(folder.path / "t.csv");
      ADD_FAILURE() << rows;
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find(word), std::string::npos) << error.what();
    }
  };
  refused("time_s,frequency_hz,re,im\n0,1000,1,0\n1,1000,1,0\n0,1000,2,0\n", "says a time twice");
  refused("time_s,frequency_hz,re,im\n0,-1000,1,0\n", "frequency_hz");
  refused("time_s,frequency_hz,re,im\n0,0,1,0\n0,1000,1,0\n", "frequency_hz");
  refused("time_s,frequency_hz,re\n0,1,1\n", "im");
}

TEST(BubbleSound, RisingBubbleInABallIsTheExactTransferAtItsMomentaryPitch) {
  // Centre of a ball of liquid, radius a, heard at R: in closed form, without images or sums.
  constexpr double kBall_m = 0.03, kListener_m = 0.8, kDensityRatio = 1.2041 / 1000.0;
  const auto exact = [&](double f) {
    const double omega = 2 * kPi * f, kf = omega / 1497.0, ka = omega / 343.0, r0 = 2e-3;
    const double strength = 4 * kPi * 1000.0 * omega * omega * r0 * r0;
    const double slope = -strength * kf / (4 * kPi * kBall_m * std::sin(kf * kBall_m));
    return kDensityRatio * slope * kBall_m * kBall_m / (-Complex(1.0, ka * kBall_m)) *
           std::polar(1.0, -ka * (kListener_m - kBall_m)) / kListener_m;
  };
  Folder folder;
  std::string transfer = "time_s,frequency_hz,re,im\n", phi = "time_s,phi_m\n";
  for (int bin = 0; bin <= 12; ++bin) {  // 6 an octave, 1 to 4 kHz
    const double f = 1000.0 * std::pow(2.0, bin / 6.0);
    for (const double t : {0.0, 10.0})
      transfer +=
          to_text(t) + "," + to_text(f) + "," + to_text(exact(f).real()) + "," + to_text(exact(f).imag()) + "\n";
  }
  for (int i = 0; i <= 100; ++i) phi += to_text(1e-3 * i) + "," + to_text(-0.012 + 3.3e-4 * std::min(i, 30)) + "\n";
  folder.write("p.csv", transfer);
  folder.write("phi.csv", phi);
  const BubbleScene scene = scene_of(
      "[listener]\nmode = \"mono\"\n[sound]\nattack = \"none\"\n[pitch]\nphi0_m = -0.012\n[[bubble]]\n"
      "radius_m = 0.002\nposition_m = [0, 0, -0.012]\nphi_csv = \"phi.csv\"\ntransfer_file = \"p.csv\"\n",
      folder.path);
  const BubbleSound result = synthesise_bubbles(scene);
  RingingBubble bubble;
  bubble.motion = scene.bubbles[0].motion;
  bubble.pitch = scene.pitch;
  bubble.radius_m = 2e-3;
  bubble.onset_velocity_m_s = entrainment_velocity_m_s(2e-3);
  const RingTrack track = ring_track(bubble);
  double worst = 0.0, loudest = 0.0, lowest = 1e9, highest = 0.0;
  for (int i = 0; i / 48000.0 < track.faded_from_s; i += 3) {
    const double age = i / 48000.0, f = track.block_at(age).rate_at(age).imag() / (2 * kPi);
    const double heard = std::abs(exact(f));
    worst = std::max(worst, std::abs(result.sound.samples(i, 0) - heard * track.value(age).real()) /
                                (heard * std::abs(track.value(age))));
    loudest = std::max(loudest, heard);
    lowest = std::min(lowest, f);
    highest = std::max(highest, f);
  }
  EXPECT_GE(highest, 1.9 * lowest);  // frozen at birth it would end 11 dB too quiet
  EXPECT_LE(worst, 0.01);
}

TEST(Scene, EveryCommittedSceneParses) {
  int n = 0;
  for (const auto& entry : std::filesystem::directory_iterator(std::filesystem::path(klang::test::source_dir()) /
                                                               "datasets-synthetic/scenes")) {
    if (entry.path().extension() != ".toml") continue;
    EXPECT_NO_THROW(read_bubble_scene(entry.path(), 1)) << entry.path();
    ++n;
  }
  EXPECT_GE(n, 2);
}

TEST(Scene, DocumentationHasTheSchema) {
  const std::string page = read_file(std::filesystem::path(klang::test::source_dir()) / "docs/bubbles.md");
  EXPECT_NE(page.find(bubble_scene_schema_markdown()), std::string::npos);
}

}  // namespace
}  // namespace klang::stage
