#include "core/sound/liquid_scene/detail/cell_waves.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "core/foundation/base/check.hpp"
#include "core/foundation/base/parallel.hpp"
#include "core/sound/liquid_scene/detail/solid_cells.hpp"

namespace klang::liquid_scene {
namespace {

using Complex = std::complex<double>;
using detail::kLanes;
using detail::kWide;
using detail::LaneNumbers;
using detail::LaneValues;
using Eigen::Index;
using Eigen::Vector3d;

constexpr double kLeastTheta = 1e-3;
constexpr double kSmallSolids = 0.01;  // a mouthpiece, of the whole surface: taken as liquid or air, whatever phi says
constexpr std::size_t kSmallHollow = 27, kMostCells = 30'000'000;
constexpr int kNone = -1;
constexpr int kStandstill = 200;  // iterations without a residual that is smaller by a tenth
constexpr double kNearer = 0.9;

Vector3d corner(const liquid::LiquidSurface& s, Index t, int c) {
  return s.surface.vertices_m.row(s.surface.triangles(t, c)).transpose();
}

}  // namespace

bool has_solids(const liquid::LiquidSurface& surface) {
  double all_m2 = 0.0, solid_m2 = 0.0;
  for (Index t = 0; t < surface.surface.triangles.rows(); ++t) {
    const Vector3d a = corner(surface, t, 0);
    const double area = 0.5 * (corner(surface, t, 1) - a).cross(corner(surface, t, 2) - a).norm();
    all_m2 += area;
    if (surface.region[static_cast<std::size_t>(t)] >= 2) solid_m2 += area;
  }
  return solid_m2 > kSmallSolids * all_m2;
}

std::optional<CellBox> cell_box(const liquid::LiquidSurface& surface, double cell_m) {
  const Index n_triangles = surface.surface.triangles.rows();
  if (n_triangles == 0) return std::nullopt;
  Vector3d low = Vector3d::Constant(HUGE_VAL), high = -low;
  for (Index t = 0; t < n_triangles; ++t)
    for (int c = 0; c < 3; ++c) {
      low = low.cwiseMin(corner(surface, t, c));
      high = high.cwiseMax(corner(surface, t, c));
    }
  CellBox box;
  box.cell_m = cell_m;
  box.low_m = low;
  double n_cells = 1.0;
  for (int a = 0; a < 3; ++a) {
    const double n = std::ceil((high[a] - low[a]) / cell_m - 0.02);
    if (!(n >= 1.0 && n <= 10000.0)) return std::nullopt;
    box.n[static_cast<std::size_t>(a)] = static_cast<int>(n);
    n_cells *= n;
  }
  if (n_cells > static_cast<double>(kMostCells)) return std::nullopt;
  // At edges of the box and where the surface meets it a wall's triangles go from one side to another, half a cell inside.
  const double on = 0.1 * cell_m, near = 0.55 * cell_m;
  for (Index t = 0; t < n_triangles; ++t) {
    if (surface.region[static_cast<std::size_t>(t)] != 1) continue;
    std::array<bool, 3> corner_near{};
    for (std::size_t axis = 0; axis < 3; ++axis)
      for (const std::size_t upper : {0U, 1U}) {
        const auto i = static_cast<Index>(axis);
        const double side = upper != 0 ? low[i] + cell_m * box.n[axis] : low[i];
        int n_on = 0;
        for (int c = 0; c < 3; ++c) {
          const double away = std::abs(corner(surface, t, c)[i] - side);
          if (away <= near) corner_near[static_cast<std::size_t>(c)] = true;
          if (away <= on) ++n_on;
        }
        if (n_on == 3) box.wall[axis][upper] = true;
      }
    if (!corner_near[0] || !corner_near[1] || !corner_near[2]) return std::nullopt;
  }
  return box;
}

std::optional<CellBox> coarser_box(const CellBox& box) {
  for (const auto& [times, per] :
       {std::pair(3, 2), std::pair(2, 1), std::pair(5, 3), std::pair(4, 3), std::pair(5, 4)}) {
    CellBox coarse = box;
    coarse.cell_m = box.cell_m * times / per;
    bool fits = true;
    for (std::size_t a = 0; a < 3; ++a) {
      coarse.n[a] = (box.n[a] * per + times - 1) / times;
      const bool whole = box.n[a] * per % times == 0;
      fits = fits && (whole || !box.wall[a][1]);
    }
    if (fits) return coarse;
  }
  return std::nullopt;
}

LiquidCells::LiquidCells(const liquid::LiquidFrames& frames, std::size_t frame, const CellBox& box) : box_(box) {
  const std::size_t nx = static_cast<std::size_t>(box.n[0]) + 2, ny = static_cast<std::size_t>(box.n[1]) + 2,
                    nz = static_cast<std::size_t>(box.n[2]) + 2;
  std::vector<float> phi(nx * ny * nz);  // with a layer around
  Kinds kinds;
  kinds.liquid.resize(index(0, 0, box.n[2]), 0);
  kinds.open.resize(kinds.liquid.size(), 0);
  kinds.solid = box.with_solids ? detail::solid_cells(frames.boundary(frame), box.low_m, box.cell_m, box.n)
                                : std::vector<std::uint8_t>(kinds.liquid.size(), 0);
  const liquid::HeldFrames held(frames, frame, frame);
  parallel_for(nz, 1, [&](std::size_t k, std::size_t) {
    for (std::size_t j = 0; j < ny; ++j)
      for (std::size_t i = 0; i < nx; ++i) {
        const Vector3d centre =
            box.low_m + box.cell_m * (Vector3d(static_cast<double>(i), static_cast<double>(j), static_cast<double>(k)) -
                                      Vector3d::Constant(0.5));
        phi[i + nx * (j + ny * k)] = static_cast<float>((*held).phi_m(frame, centre));
      }
  });
  for (int k = 0; k < box.n[2]; ++k)
    for (int j = 0; j < box.n[1]; ++j)
      for (int i = 0; i < box.n[0]; ++i)
        kinds.liquid[index(i, j, k)] =
            kinds.solid[index(i, j, k)] == 0 &&
                    phi[static_cast<std::size_t>(i) + 1 +
                        nx * (static_cast<std::size_t>(j) + 1 + ny * (static_cast<std::size_t>(k) + 1))] < 0.0F
                ? 1
                : 0;
  find_body(kinds);
  assemble(phi, kinds);
  matrix_.factor();
}

std::vector<int> LiquidCells::components(const std::vector<std::uint8_t>& member,
                                         std::vector<std::size_t>& sizes) const {
  const std::array<std::size_t, 3> step{1, index(0, 1, 0), index(0, 0, 1)};
  std::vector<int> part(member.size(), kNone);
  std::vector<std::size_t> stack;
  sizes.clear();
  for (std::size_t start = 0; start < member.size(); ++start) {
    if (member[start] == 0 || part[start] != kNone) continue;
    const int number = static_cast<int>(sizes.size());
    sizes.push_back(0);
    stack.assign(1, start);
    part[start] = number;
    while (!stack.empty()) {
      const std::size_t c = stack.back();
      stack.pop_back();
      ++sizes.back();
      const std::array<std::size_t, 3> at{c % step[1], c % step[2] / step[1], c / step[2]};
      for (std::size_t a = 0; a < 3; ++a) {
        const auto visit = [&](std::size_t other) {
          if (member[other] == 0 || part[other] != kNone) return;
          part[other] = number;
          stack.push_back(other);
        };
        if (at[a] > 0) visit(c - step[a]);
        if (at[a] + 1 < static_cast<std::size_t>(box_.n[a])) visit(c + step[a]);
      }
    }
  }
  return part;
}

void LiquidCells::find_body(Kinds& kinds) const {
  std::vector<std::uint8_t>&liquid = kinds.liquid, &open = kinds.open;
  std::vector<std::uint8_t> dry(liquid.size());
  for (std::size_t c = 0; c < liquid.size(); ++c) dry[c] = liquid[c] == 0 && kinds.solid[c] == 0 ? 1 : 0;
  std::vector<std::size_t> sizes;
  std::vector<int> part = components(dry, sizes);
  std::vector<std::uint8_t> reached(sizes.size(), 0);  // from a side that is no wall
  const std::array<std::size_t, 3> step{1, index(0, 1, 0), index(0, 0, 1)};
  bool any_side = false;
  for (std::size_t a = 0; a < 3; ++a)
    for (const std::size_t upper : {0U, 1U}) any_side = any_side || !box_.wall[a][upper];
  for (std::size_t c = 0; c < liquid.size(); ++c) {
    if (part[c] == kNone) continue;
    const std::array<std::size_t, 3> at{c % step[1], c % step[2] / step[1], c / step[2]};
    for (std::size_t a = 0; a < 3; ++a)
      if ((at[a] == 0 && !box_.wall[a][0]) || (at[a] + 1 == static_cast<std::size_t>(box_.n[a]) && !box_.wall[a][1]))
        reached[static_cast<std::size_t>(part[c])] = 1;
  }
  if (!any_side && !sizes.empty())
    reached[static_cast<std::size_t>(std::max_element(sizes.begin(), sizes.end()) - sizes.begin())] = 1;
  for (std::size_t c = 0; c < liquid.size(); ++c) {
    if (part[c] == kNone) continue;
    const auto p = static_cast<std::size_t>(part[c]);
    open[c] = reached[p];
    if (reached[p] == 0 && sizes[p] < kSmallHollow) liquid[c] = 1;
  }
  part = components(liquid, sizes);
  if (sizes.empty()) return;
  const int body = static_cast<int>(std::max_element(sizes.begin(), sizes.end()) - sizes.begin());
  for (std::size_t c = 0; c < liquid.size(); ++c)
    if (part[c] != body) liquid[c] = 0;
}

void LiquidCells::assemble(const std::vector<float>& phi, const Kinds& kinds) {
  const std::vector<std::uint8_t>&liquid = kinds.liquid, &open = kinds.open;
  const std::array<std::size_t, 3> step{1, index(0, 1, 0), index(0, 0, 1)};
  const std::array<std::size_t, 3> phi_step{
      1, static_cast<std::size_t>(box_.n[0]) + 2,
      (static_cast<std::size_t>(box_.n[0]) + 2) * (static_cast<std::size_t>(box_.n[1]) + 2)};
  number_.assign(liquid.size(), kNone);
  for (std::size_t c = 0; c < liquid.size(); ++c)
    if (liquid[c] != 0) {
      number_[c] = static_cast<int>(cell_.size());
      cell_.push_back(c);
    }
  const std::size_t n = cell_.size();
  matrix_.diagonal.assign(n, 0.0F);
  matrix_.n_wall.assign(n, 0.0F);
  for (std::size_t a = 0; a < 3; ++a) {
    matrix_.before[a].assign(n, static_cast<int>(n));
    matrix_.next[a].assign(n, static_cast<int>(n));
  }
  std::vector<Vector3d> points;
  for (std::size_t row = 0; row < n; ++row) {
    crossing_from_.push_back(crossings_.size());
    const std::size_t c = cell_[row];
    const std::array<std::size_t, 3> at{c % step[1], c % step[2] / step[1], c / step[2]};
    const std::size_t here = (at[0] + 1) * phi_step[0] + (at[1] + 1) * phi_step[1] + (at[2] + 1) * phi_step[2];
    for (std::size_t a = 0; a < 3; ++a)
      for (const bool upper : {false, true}) {
        const bool edge = upper ? at[a] + 1 == static_cast<std::size_t>(box_.n[a]) : at[a] == 0;
        if (edge && box_.wall[a][upper ? 1 : 0]) {
          matrix_.n_wall[row] += 1.0F;
          continue;
        }
        const std::size_t other = upper ? c + step[a] : c - step[a];
        if (!edge && number_[other] != kNone) {
          matrix_.diagonal[row] += 1.0F;
          (upper ? matrix_.next : matrix_.before)[a][row] = number_[other];
          continue;
        }
        if (!edge && kinds.solid[other] != 0) continue;
        const double wet = phi[here], dry = phi[upper ? here + phi_step[a] : here - phi_step[a]];
        // Not so for a small hollow that counts as liquid and for what touches another body.
        const double theta = wet < 0.0 && dry > 0.0 ? std::clamp(wet / (wet - dry), kLeastTheta, 1.0) : 0.5;
        matrix_.diagonal[row] += static_cast<float>(1.0 / theta);
        crossings_.push_back({static_cast<int>(row), static_cast<float>(1.0 / theta), edge || open[other] != 0});
        Vector3d x(static_cast<double>(at[0]) + 0.5, static_cast<double>(at[1]) + 0.5,
                   static_cast<double>(at[2]) + 0.5);
        x[static_cast<Index>(a)] += upper ? theta : -theta;
        points.push_back(box_.low_m + box_.cell_m * x);
      }
  }
  crossing_from_.push_back(crossings_.size());
  surface_m_.resize(3, static_cast<Index>(points.size()));
  for (std::size_t i = 0; i < points.size(); ++i) surface_m_.col(static_cast<Index>(i)) = points[i];
}

bool LiquidCells::holds(const Vector3d& x_m) const {
  const Vector3d g = (x_m - box_.low_m) / box_.cell_m;
  std::array<int, 3> low{};
  for (std::size_t a = 0; a < 3; ++a) {
    if (!(g[static_cast<Index>(a)] >= 0.0 && g[static_cast<Index>(a)] <= box_.n[a])) return false;
    low[a] = std::clamp(static_cast<int>(std::floor(g[static_cast<Index>(a)] - 0.5)), 0, box_.n[a] - 1);
  }
  for (int k = low[2]; k <= std::min(low[2] + 1, box_.n[2] - 1); ++k)
    for (int j = low[1]; j <= std::min(low[1] + 1, box_.n[1] - 1); ++j)
      for (int i = low[0]; i <= std::min(low[0] + 1, box_.n[0] - 1); ++i)
        if (number_[index(i, j, k)] != kNone) return true;
  return false;
}

/// Start and right side of one frequency.
void LiquidCells::load(const Question& question, std::size_t lane, LaneValues& x, LaneValues& right) const {
  KLANG_CHECK(question.q.size() == static_cast<Index>(crossings_.size()), "q at each crossing");
  if (question.start != nullptr && question.start->size() == number_.size())
    for (std::size_t i = 0; i < n_unknowns(); ++i) {
      x[kWide * i + lane] = (*question.start)[cell_[i]].real();
      x[kWide * i + lane + kLanes] = (*question.start)[cell_[i]].imag();
    }
  for (std::size_t c = 0; c < crossings_.size(); ++c) {
    if (!crossings_[c].open) continue;
    float* const to = right.data() + kWide * static_cast<std::size_t>(crossings_[c].unknown);
    const Complex q = question.q[static_cast<Index>(c)];
    to[lane] += crossings_[c].weight * static_cast<float>(q.real());
    to[lane + kLanes] += crossings_[c].weight * static_cast<float>(q.imag());
  }
}

namespace {

using LaneFlags = std::array<bool, kLanes>;
using LaneSums = std::array<double, kWide>;

/// over / under of the lanes that are not done. @return those whose quotient is no number; theirs stays as it is
LaneFlags quotients(const LaneSums& over, const LaneSums& under, const LaneFlags& done, LaneNumbers& result) {
  LaneFlags no_numbers{};
  for (std::size_t l = 0; l < kLanes; ++l) {
    if (done[l]) continue;
    const Complex quotient = Complex(over[l], over[l + kLanes]) / Complex(under[l], under[l + kLanes]);
    no_numbers[l] = !std::isfinite(std::abs(quotient));
    if (no_numbers[l]) continue;
    result.re[l] = static_cast<float>(quotient.real());
    result.im[l] = static_cast<float>(quotient.imag());
  }
  return no_numbers;
}

}  // namespace

void LiquidCells::solve_lanes(const Question* questions, std::size_t n_questions, const Limits& limits, Waves* waves,
                              const Monitor& monitor) const {
  const double tolerance = limits.tolerance;
  const int most_iterations = limits.iterations;
  const std::size_t n = n_unknowns(), size = kWide * (n + 1);
  // Kept by the thread: pages of new memory would cost as much as some of the iterations.
  static thread_local std::array<LaneValues, 8> room;
  for (LaneValues& values : room) values.assign(size, 0.0F);
  auto& [x, z, p, az, ap, map, right, r] = room;
  LaneNumbers give, shift, minus_one;
  minus_one.re.fill(-1.0F);
  LaneFlags done{};
  for (std::size_t l = 0; l < kLanes; ++l) {
    done[l] = l >= n_questions;
    const Question& q = questions[std::min(l, n_questions - 1)];
    const Complex g = box_.cell_m * q.give_per_m, k = box_.cell_m * q.wavenumber_per_m, s = k * k;
    give.re[l] = static_cast<float>(g.real());
    give.im[l] = static_cast<float>(g.imag());
    shift.re[l] = static_cast<float>(s.real());
    shift.im[l] = static_cast<float>(s.imag());
    if (!done[l]) load(q, l, x, right);
  }
  int iterations = 0;
  // Started again from the true residual where none comes nearer any more: what was learnt of the waves below a high pitch, dozens of them,
  // is lost each time.
  for (bool again = true; again && iterations < most_iterations;) {
    detail::multiply(matrix_, give, shift, x, az);
    r = right;
    detail::add(minus_one, az, r);
    detail::precondition(matrix_, r, z);
    p = z;
    detail::multiply(matrix_, give, shift, z, az);
    ap = az;
    LaneSums rho{}, mu{}, rho_next{};
    detail::sums(z, az, rho);
    again = false;
    int since = 0, stale = 0;
    std::array<double, kLanes> nearest;
    nearest.fill(HUGE_VAL);
    while (iterations < most_iterations && !monitor.stop_requested()) {
      const auto left = detail::norms_sq(z), all = detail::norms_sq(x);
      bool every = true;
      for (std::size_t l = 0; l < n_questions; ++l) {
        if (left[l] <= tolerance * tolerance * all[l] && !done[l]) {
          done[l] = true;
          waves[l].converged = true;
          waves[l].iterations = iterations;
        }
        every = every && done[l];
        if (!done[l] && left[l] < kNearer * kNearer * nearest[l]) {
          nearest[l] = left[l];
          stale = 0;
        }
      }
      if (every) break;
      detail::precondition(matrix_, ap, map);
      detail::sums(ap, map, mu);
      bool broken = false;
      // What is no number right after a start never will be one; the others go on.
      const auto set_aside = [&](const LaneFlags& no_numbers) {
        for (std::size_t l = 0; l < kLanes; ++l) {
          broken = broken || (no_numbers[l] && since > 0);
          done[l] = done[l] || (no_numbers[l] && since == 0);
        }
      };
      LaneNumbers step, back, share;
      set_aside(quotients(rho, mu, done, step));
      for (std::size_t l = 0; l < kLanes; ++l) {
        back.re[l] = -step.re[l];
        back.im[l] = -step.im[l];
      }
      detail::add(step, p, x);
      detail::add(back, map, z);
      detail::multiply(matrix_, give, shift, z, az);
      detail::sums(z, az, rho_next);
      set_aside(quotients(rho_next, rho, done, share));
      rho = rho_next;
      detail::add_to(z, share, p);
      detail::add_to(az, share, ap);
      ++iterations;
      ++since;
      if (broken || ++stale >= kStandstill) {
        again = since > 0;
        break;
      }
    }
  }
  for (std::size_t l = 0; l < n_questions; ++l) {
    if (!waves[l].converged) waves[l].iterations = iterations;
    waves[l].w.assign(number_.size(), {});
    for (std::size_t i = 0; i < n; ++i) waves[l].w[cell_[i]] = {x[kWide * i + l], x[kWide * i + l + kLanes]};
  }
}

std::vector<LiquidCells::Waves> LiquidCells::solve(const std::vector<Question>& questions, const Limits& limits,
                                                   Monitor& monitor) const {
  std::vector<Waves> result(questions.size());
  if (n_unknowns() == 0) return result;
  parallel_for((questions.size() + kLanes - 1) / kLanes, 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t group = begin; group < end; ++group) {
      const std::size_t first = group * kLanes, n = std::min(kLanes, questions.size() - first);
      solve_lanes(questions.data() + first, n, limits, result.data() + first, monitor);
    }
  });
  monitor.throw_if_stopped();
  return result;
}

Complex LiquidCells::at(const Vector3d& x_m, const Waves& waves, const Eigen::VectorXcd& q) const {
  constexpr int kTerms = 9;  // harmonic polynomials to the second degree
  constexpr double kReach_cells = 2.2, kNarrow = 1.0;
  using Terms = Eigen::Matrix<double, kTerms, 1>;
  const Vector3d g = (x_m - box_.low_m) / box_.cell_m;
  Eigen::Matrix<double, kTerms, kTerms> normal = Eigen::Matrix<double, kTerms, kTerms>::Zero();
  Eigen::Matrix<Complex, kTerms, 1> right = Eigen::Matrix<Complex, kTerms, 1>::Zero();
  const auto take = [&](const Vector3d& d, Complex value) {
    const double distance_sq = d.squaredNorm();
    if (distance_sq > kReach_cells * kReach_cells) return;
    Terms t;
    t << 1.0, d.x(), d.y(), d.z(), d.x() * d.y(), d.x() * d.z(), d.y() * d.z(), d.x() * d.x() - d.y() * d.y(),
        2.0 * d.z() * d.z() - d.x() * d.x() - d.y() * d.y();
    const double weight = std::exp(-kNarrow * distance_sq);
    normal += weight * t * t.transpose();
    right += (weight * value) * t;
  };
  std::array<int, 3> low{}, high{};
  for (std::size_t a = 0; a < 3; ++a) {
    low[a] = std::max(0, static_cast<int>(std::floor(g[static_cast<Index>(a)] - kReach_cells - 1.0)));
    high[a] = std::min(box_.n[a] - 1, static_cast<int>(std::floor(g[static_cast<Index>(a)] + kReach_cells + 1.0)));
  }
  for (int k = low[2]; k <= high[2]; ++k)
    for (int j = low[1]; j <= high[1]; ++j)
      for (int i = low[0]; i <= high[0]; ++i) {
        const int row = number_[index(i, j, k)];
        if (row == kNone) continue;
        take(Vector3d(i + 0.5, j + 0.5, k + 0.5) - g, Complex(waves.w[index(i, j, k)]));
        const auto r = static_cast<std::size_t>(row);
        for (std::size_t c = crossing_from_[r]; c < crossing_from_[r + 1]; ++c)
          take((surface_m_.col(static_cast<Index>(c)) - box_.low_m) / box_.cell_m - g,
               crossings_[c].open ? q[static_cast<Index>(c)] : Complex());
      }
  if (!(normal(0, 0) > 0.0)) return {};
  // Where few cells are around, the higher terms are held down rather than guessed.
  for (int t = 0; t < kTerms; ++t) normal(t, t) += (t < 4 ? 1e-6 : 1e-3) * normal(0, 0);
  normal(0, 0) /= 1.0 + 1e-6;
  const Eigen::LDLT<Eigen::Matrix<double, kTerms, kTerms>> factor(normal);
  const Terms re = factor.solve(right.real()), im = factor.solve(right.imag());
  return {re[0], im[0]};
}

}  // namespace klang::liquid_scene
