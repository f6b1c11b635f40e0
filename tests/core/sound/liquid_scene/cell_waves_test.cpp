#include "core/sound/liquid_scene/detail/cell_waves.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <functional>
#include <limits>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/parallel.hpp"
#include "core/physics/liquid/surface.hpp"
#include "core/sound/liquid_scene/detail/cell_ear.hpp"
#include "core/sound/liquid_scene/liquid_transfer.hpp"

namespace klang::liquid_scene {
namespace {

using Complex = std::complex<double>;
using Eigen::Vector3d;

constexpr double kSide_m = 0.2, kDepth_m = 0.1037;  // the surface is no plane between cells

/// One frame of what a distance says in a box of kSide_m.
class OneFrame : public liquid::LiquidFrames {
 public:
  using Distance = std::function<double(const Vector3d&)>;
  OneFrame(int n_cells, Distance phi, const Distance& to_solid = {})
      : cell_m_(kSide_m / n_cells), phi_(std::move(phi)) {
    const liquid::GridShape shape{n_cells, n_cells, n_cells, cell_m_};
    liquid::Field field(n_cells, n_cells, n_cells);
    for (int k = 0; k < n_cells; ++k)
      for (int j = 0; j < n_cells; ++j)
        for (int i = 0; i < n_cells; ++i) field(i, j, k) = phi_(shape.centre_m(i, j, k));
    liquid::Field solid(to_solid ? n_cells : 0, to_solid ? n_cells : 0, to_solid ? n_cells : 0);
    for (int k = 0; to_solid && k < n_cells; ++k)
      for (int j = 0; j < n_cells; ++j)
        for (int i = 0; i < n_cells; ++i) solid(i, j, k) = to_solid(shape.centre_m(i, j, k));
    surface_ = liquid::liquid_surface(shape, field, solid);
  }
  std::span<const double> time_s() const override { return times_; }
  liquid::LiquidSurface boundary(std::size_t) const override { return surface_; }
  double phi_m(std::size_t, const Vector3d& x) const override { return phi_(x); }
  std::optional<Vector3d> velocity_m_s(std::size_t, const Vector3d&) const override { return std::nullopt; }
  double cell_m() const override { return cell_m_; }

 private:
  double cell_m_;
  std::function<double(const Vector3d&)> phi_;
  std::vector<double> times_ = {0.0};
  liquid::LiquidSurface surface_;
};

double level(const Vector3d& x) { return x.z() - kDepth_m; }

/// cos(pi x / L) on the surface of a tank: cos(pi x / L) cosh(kappa z) / cosh(kappa H) in it.
double largest_error(int n_cells, double frequency_hz, double half_waves, double tolerance = 1e-4) {
  const OneFrame frames(n_cells, level);
  const std::optional<CellBox> box = cell_box(frames.boundary(0), frames.cell_m());
  if (!box) return HUGE_VAL;
  const LiquidCells cells(frames, 0, *box);
  const double across = half_waves * kPi / kSide_m;
  const Complex k = 2.0 * kPi * frequency_hz / 1497.0 * std::sqrt(Complex(1.0, -0.02)),
                kappa = std::sqrt(across * across - k * k);
  LiquidCells::Question question{k, 0.0, {}, nullptr};
  question.q.resize(cells.surface_m().cols());
  for (Eigen::Index i = 0; i < question.q.size(); ++i) question.q[i] = std::cos(across * cells.surface_m()(0, i));
  const auto waves = cells.solve({question}, {tolerance});
  if (!waves[0].converged) return HUGE_VAL;
  double largest = 0.0, scale = 0.0;
  for (const double z : {0.004, 0.03, 0.06, 0.09, 0.102})
    for (const double x : {0.013, 0.1, 0.171}) {
      const Complex exact = std::cos(across * x) * std::cosh(kappa * z) / std::cosh(kappa * kDepth_m);
      scale = std::max(scale, std::abs(exact));
      largest = std::max(largest, std::abs(cells.at({x, 0.07, z}, waves[0], question.q) - exact));
    }
  return largest / scale;
}

TEST(LiquidCells, WavesOfATankAreTheClosedFormAlsoAtResonance) {
  const double mode_hz = 1497.0 / (4.0 * kDepth_m);
  for (const double f : {0.99 * mode_hz, mode_hz}) EXPECT_LE(largest_error(40, f, 0.0), 0.03) << f;  // Q is 50
  const double next_hz = 1497.0 * std::hypot(1.0 / (2.0 * kSide_m), 1.0 / (4.0 * kDepth_m));
  for (const double times : {0.95, 0.98, 1.0, 1.02, 1.05})
    EXPECT_LE(largest_error(40, times * next_hz, 1.0), 0.03) << times;
  for (const double f : {500.0, 1.3 * mode_hz, 2.5 * mode_hz}) EXPECT_LE(largest_error(40, f, 0.0), 0.01) << f;
  for (const double f : {500.0, 5000.0}) EXPECT_LE(largest_error(40, f, 3.0), 0.01) << f;
}

// Of the 300 modes below none may be learnt anew: started again every 200 iterations it took 627, and Splash did not converge in 1000.
TEST(LiquidCells, ConvergesFarAboveItsFirstModes) {
  const OneFrame frames(40, level);
  const LiquidCells cells(frames, 0, *cell_box(frames.boundary(0), frames.cell_m()));
  const Vector3d ear(0.07, -0.5, 0.8);
  LiquidCells::Question question{2.0 * kPi * 20000.0 / 1497.0 * std::sqrt(Complex(1.0, -0.02)), 0.0, {}, nullptr};
  question.q.resize(cells.surface_m().cols());
  for (Eigen::Index i = 0; i < question.q.size(); ++i) {
    const double way = (cells.surface_m().col(i) - ear).norm();
    question.q[i] = std::polar(1.0 / way, -2.0 * kPi * 20000.0 / 343.0 * way);
  }
  const auto waves = cells.solve({question}, {1e-4, 600});
  EXPECT_TRUE(waves[0].converged);
  question.start = &waves[0].w;
  EXPECT_EQ(cells.solve({question}, {2e-4, 600})[0].iterations, 0) << "the true residual is as small";
}

// It made its neighbours start again after each iteration, without end.
TEST(LiquidCells, AQuestionThatIsNoNumberFailsAloneAndItsNeighboursKeepTheirBits) {
  const OneFrame frames(20, level);
  const LiquidCells cells(frames, 0, *cell_box(frames.boundary(0), frames.cell_m()));
  std::vector<LiquidCells::Question> questions;
  for (int i = 0; i < 4; ++i)
    questions.push_back({5.0 + i, 0.0, Eigen::VectorXcd::Constant(cells.surface_m().cols(), Complex(1.0, i)), nullptr});
  const auto whole = cells.solve(questions, {1e-4});
  questions[1].q[7] = std::numeric_limits<double>::quiet_NaN();
  const auto spoilt = cells.solve(questions, {1e-4});
  for (const std::size_t i : {0, 2, 3}) {
    EXPECT_TRUE(spoilt[i].converged);
    EXPECT_EQ(spoilt[i].iterations, whole[i].iterations);
    EXPECT_EQ(spoilt[i].w, whole[i].w);
  }
  EXPECT_FALSE(spoilt[1].converged);
}

TEST(LiquidCells, AStopIsHeededBetweenTwoIterations) {
  struct Stop : Monitor {
    mutable std::atomic<int> n_asked = 0;
    bool stop_requested() const override { return ++n_asked > 3; }
  } monitor;
  const OneFrame frames(20, level);
  const LiquidCells cells(frames, 0, *cell_box(frames.boundary(0), frames.cell_m()));
  const LiquidCells::Question question{80.0, 0.0, Eigen::VectorXcd::Ones(cells.surface_m().cols()), nullptr};
  EXPECT_THROW(cells.solve({question}, {1e-30, 1000000}, monitor), Interrupted);
  EXPECT_LE(monitor.n_asked, 8);
}

// The cut faces' distances differ from grid to grid, so that the ratio is not 4 sharp.
TEST(LiquidCells, ErrorFallsAboutAsTheSquareOfTheCells) {
  EXPECT_LE(largest_error(40, 2000.0, 1.0, 1e-6), largest_error(20, 2000.0, 1.0, 1e-6) / 2.5);
}

// A floor of solid makes the tank less deep; a block in it stands at a side, so that the tank is less wide.
TEST(LiquidCells, SolidsInTheLiquidAreItsWalls) {
  constexpr double kFloor_m = 0.03, kBlock_m = 0.05;  // six and ten cells
  const OneFrame frames(40, level, [](const Vector3d& x) { return std::min(x.z() - kFloor_m, x.x() - kBlock_m); });
  std::optional<CellBox> box = cell_box(frames.boundary(0), frames.cell_m());
  ASSERT_TRUE(box && has_solids(frames.boundary(0)));
  box->with_solids = true;
  const LiquidCells cells(frames, 0, *box);
  EXPECT_FALSE(cells.holds({0.04, 0.1, 0.06}));
  EXPECT_FALSE(cells.holds({0.1, 0.1, 0.02}));
  EXPECT_EQ(cells.n_unknowns(), 30U * 40U * 15U);
  const double deep = kDepth_m - kFloor_m, across = kPi / (kSide_m - kBlock_m);
  const double mode_hz = 1497.0 / (4.0 * deep);  // Q is 50, 15 cells deep
  for (const double hz : {500.0, mode_hz, 6000.0}) {
    const Complex k = 2.0 * kPi * hz / 1497.0 * std::sqrt(Complex(1.0, -0.02)),
                  kappa = std::sqrt(across * across - k * k);
    LiquidCells::Question question{k, 0.0, Eigen::VectorXcd(cells.surface_m().cols()), nullptr};
    for (Eigen::Index i = 0; i < question.q.size(); ++i)
      question.q[i] = 1.0 + std::cos(across * (cells.surface_m()(0, i) - kBlock_m));
    const auto waves = cells.solve({question}, {1e-4});
    double largest = 0.0, scale = 0.0;
    for (const double z : {0.034, 0.06, 0.09})
      for (const double x : {0.06, 0.1, 0.18}) {
        const Complex exact =
            std::cos(k * (z - kFloor_m)) / std::cos(k * deep) +
            std::cos(across * (x - kBlock_m)) * std::cosh(kappa * (z - kFloor_m)) / std::cosh(kappa * deep);
        scale = std::max(scale, std::abs(exact));
        largest = std::max(largest, std::abs(cells.at({x, 0.07, z}, waves[0], question.q) - exact));
      }
    EXPECT_LE(largest, (hz == mode_hz ? 0.06 : 0.02) * scale) << hz;
  }
}

TEST(LiquidCells, BesideASurfaceItIsWhatTheSurfaceHears) {
  const OneFrame frames(20, level);
  const LiquidCells cells(frames, 0, *cell_box(frames.boundary(0), frames.cell_m()));
  const LiquidCells::Question question{10.0, 0.0,
                                       Eigen::VectorXcd::Constant(cells.surface_m().cols(), Complex(0.3, -2)), nullptr};
  const auto waves = cells.solve({question}, {1e-4});
  EXPECT_LE(std::abs(cells.at({0.1, 0.1, kDepth_m - 1e-5}, waves[0], question.q) - Complex(0.3, -2)), 0.01);
}

TEST(LiquidCells, AFrameThatHasNotChangedTakesNoIterations) {
  const OneFrame frames(20, level);
  const LiquidCells cells(frames, 0, *cell_box(frames.boundary(0), frames.cell_m()));
  LiquidCells::Question question{10.0, 0.0, Eigen::VectorXcd::Constant(cells.surface_m().cols(), 1.0), nullptr};
  const auto first = cells.solve({question}, {1e-4});
  EXPECT_GT(first[0].iterations, 3);
  question.start = &first[0].w;
  EXPECT_LE(cells.solve({question}, {1e-3})[0].iterations, 1);
}

TEST(LiquidCells, DropsAreNoPartSmallHollowsAreLiquidAndLargeOnesHearNothing) {
  const auto with = [](double radius_m) {
    return [=](const Vector3d& x) {
      const double hollow = radius_m - (x - Vector3d(0.105, 0.105, 0.055)).norm(),
                   drop = (x - Vector3d(0.1, 0.1, 0.16)).norm() - 0.02;
      return std::min(std::max(level(x), hollow), drop);
    };
  };
  std::vector<std::size_t> unknowns;
  for (const double radius_m : {0.0, 0.012, 0.03}) {
    const OneFrame frames(20, with(radius_m));
    const LiquidCells cells(frames, 0, *cell_box(frames.boundary(0), frames.cell_m()));
    unknowns.push_back(cells.n_unknowns());
    EXPECT_FALSE(cells.holds({0.1, 0.1, 0.16}));
    EXPECT_TRUE(cells.holds({0.05, 0.05, 0.05}));
    const LiquidCells::Question question{4.0, 0.0, Eigen::VectorXcd::Constant(cells.surface_m().cols(), 1.0), nullptr};
    const auto waves = cells.solve({question}, {1e-4});
    const double beside = std::abs(cells.at({0.105 + 0.035, 0.105, 0.055}, waves[0], question.q));
    if (radius_m < 0.02) {
      EXPECT_NEAR(beside, 1.0, 0.2);
    } else {
      EXPECT_LE(beside, 0.5);
    }
  }
  EXPECT_EQ(unknowns[0], 20U * 20U * 10U);
  EXPECT_EQ(unknowns[1], unknowns[0]);
  EXPECT_LT(unknowns[2], unknowns[0]);
}

TEST(LiquidCells, WallsThatAreNoSidesAreNotForThem) {
  const OneFrame frames(20, level);
  liquid::LiquidSurface surface = frames.boundary(0);
  ASSERT_TRUE(cell_box(surface, frames.cell_m()).has_value());
  EXPECT_TRUE(cell_box(surface, frames.cell_m())->wall[0][0]);
  EXPECT_FALSE(cell_box(surface, frames.cell_m())->wall[2][1]);
  liquid::LiquidSurface walled = surface, solid = surface;
  std::fill(walled.region.begin(), walled.region.end(), 1);
  for (Eigen::Index v = 0; v < walled.surface.vertices_m.rows(); ++v)  // walls that lean
    walled.surface.vertices_m(v, 0) += 0.3 * walled.surface.vertices_m(v, 2);
  EXPECT_FALSE(cell_box(walled, frames.cell_m()).has_value());
  for (std::size_t t = 0; t < solid.region.size() / 10; ++t) solid.region[t] = 2;
  EXPECT_FALSE(has_solids(surface));
  EXPECT_TRUE(has_solids(solid));
}

/// How long the air of a still tank lives after it has been solved twice for a bubble of a pitch.
double second_life_s(double pitch_hz) {
  const OneFrame frames(16, level);
  bubble::ReciprocalOptions options;
  options.air_vertices = 300;
  CellEar ear(frames, options, 6, silent_monitor());
  for (const double time_s : {0.0, 0.08}) {
    EXPECT_TRUE(ear.due(time_s));
    bubble::BoundaryMesh mesh = main_body(frames.boundary(0), frames.cell_m());
    const bubble::LiquidBoundary boundary(mesh);
    EXPECT_TRUE(
        ear.renew(boundary, {{std::move(mesh.surface), std::move(mesh.region)}, false}, {0.1, 0.1, 0.4}, time_s));
    ear.enter(0);
    ear.solve({{0, pitch_hz}});
  }
  double life_s = 0.0;
  while (!ear.due(0.08 + life_s)) life_s += 0.01;
  return life_s;
}

TEST(LiquidCells, TheAirOfAStillTankLivesLongerAlsoWhereTheBubblesPitchIsHigh) {
  EXPECT_NEAR(second_life_s(400.0), 0.16, 0.011);
  EXPECT_NEAR(second_life_s(9000.0), 0.16, 0.011);  // no bin of it has four elements per wavelength
}

TEST(LiquidCells, TheSameBitsOnOneThreadAndTwo) {
  const OneFrame frames(20, level);
  std::vector<std::vector<std::complex<float>>> found;
  for (const int n_threads : {1, 2}) {
    set_thread_count(n_threads);
    const LiquidCells cells(frames, 0, *cell_box(frames.boundary(0), frames.cell_m()));
    std::vector<LiquidCells::Question> questions;
    for (int i = 0; i < 6; ++i)
      questions.push_back(
          {5.0 + i, 0.0, Eigen::VectorXcd::Constant(cells.surface_m().cols(), Complex(1.0, i)), nullptr});
    for (auto& waves : cells.solve(questions, {1e-3})) found.push_back(waves.w);
  }
  set_thread_count(0);
  for (std::size_t i = 0; i < 6; ++i) EXPECT_EQ(found[i], found[i + 6]);
}

}  // namespace
}  // namespace klang::liquid_scene
