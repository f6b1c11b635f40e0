#include "core/physics/liquid/pressure.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/foundation/base/parallel.hpp"
#include "core/physics/liquid/level_set.hpp"

namespace klang::liquid {
namespace {

constexpr double kLeastTheta = 1e-6;
constexpr std::size_t kGrain = 8192;
constexpr int kNone = -1;

/// The equations of the liquid cells, numbered in the order of the grid: A q = b, q = p kick / h.
struct System {
  std::vector<std::size_t> cell;                 ///< of each unknown
  std::vector<double> diagonal, right;           ///< diagonal includes the free surface
  std::array<std::vector<double>, 3> upper;      ///< coupling to the next unknown along each axis, >= 0, subtracted
  std::array<std::vector<int>, 3> next, before;  ///< number of that unknown; kNone
  struct Pull {                                  ///< of one component of a free solid: sum over its cells
    std::vector<std::pair<int, double>> entries;
    double factor = 0.0;  ///< rho h^3 / mass
  };
  std::vector<std::array<Pull, 3>> pulls;
  std::size_t n() const { return cell.size(); }
};

double dot(const std::vector<double>& a, const std::vector<double>& b) {
  std::vector<double> sums((a.size() + kGrain - 1) / kGrain, 0.0);
  parallel_for(a.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    double sum = 0.0;
    for (std::size_t i = begin; i < end; ++i) sum += a[i] * b[i];
    sums[begin / kGrain] = sum;
  });
  double sum = 0.0;
  for (const double s : sums) sum += s;
  return sum;
}

double largest(const std::vector<double>& a) {
  double most = 0.0;
  for (const double value : a) most = std::max(most, std::abs(value));
  return most;
}

void multiply(const System& system, const std::vector<double>& q, std::vector<double>& result) {
  parallel_for(system.n(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      double sum = system.diagonal[i] * q[i];
      // Along x the neighbours are numbered before and after; couplings across a gap are 0.
      if (i + 1 < system.n()) sum -= system.upper[0][i] * q[i + 1];
      if (i > 0) sum -= system.upper[0][i - 1] * q[i - 1];
      for (std::size_t a = 1; a < 3; ++a) {
        const int up = system.next[a][i], down = system.before[a][i];
        if (up != kNone) sum -= system.upper[a][i] * q[static_cast<std::size_t>(up)];
        if (down != kNone) sum -= system.upper[a][static_cast<std::size_t>(down)] * q[static_cast<std::size_t>(down)];
      }
      result[i] = sum;
    }
  });
  for (const auto& solid : system.pulls)
    for (const System::Pull& pull : solid) {
      double sum = 0.0;
      for (const auto& [i, weight] : pull.entries) sum += weight * q[static_cast<std::size_t>(i)];
      for (const auto& [i, weight] : pull.entries) result[static_cast<std::size_t>(i)] += pull.factor * weight * sum;
    }
}

/// Modified incomplete Cholesky, level 0. Factors are kept divided by the squares of their diagonals, so that an unknown waits for the
/// one before it by one multiplication and one addition.
class Preconditioner {
 public:
  explicit Preconditioner(const System& system) : inverse_sq_(system.n()), y_(system.n()) {
    constexpr double kModified = 0.97, kSafe = 0.25;
    const std::size_t n = system.n();
    for (std::size_t i = 0; i < n; ++i) {
      double e = system.diagonal[i];
      for (std::size_t a = 0; a < 3; ++a) {
        const int down = system.before[a][i];
        if (down == kNone) continue;
        const auto d = static_cast<std::size_t>(down);
        const double up = system.upper[a][d], inverse_sq = inverse_sq_[d];
        double others = 0.0;
        for (std::size_t b = 0; b < 3; ++b)
          if (b != a && system.next[b][d] != kNone) others += system.upper[b][d];
        e -= (up * up + kModified * up * others) * inverse_sq;
      }
      if (!(e >= kSafe * system.diagonal[i])) e = system.diagonal[i];
      inverse_sq_[i] = 1.0 / e;
    }
    for (std::size_t a = 0; a < 3; ++a) {
      lower_[a].resize(n);
      upper_[a].resize(n);
      before_[a].resize(n);
      next_[a].resize(n);
    }
    parallel_for(n, kGrain, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i)
        for (std::size_t a = 0; a < 3; ++a) {  // where there is none, 0 times itself
          const int down = system.before[a][i], up = system.next[a][i];
          before_[a][i] = down == kNone ? static_cast<int>(i) : down;
          next_[a][i] = up == kNone ? static_cast<int>(i) : up;
          lower_[a][i] = down == kNone ? 0.0 : inverse_sq_[i] * system.upper[a][static_cast<std::size_t>(down)];
          upper_[a][i] = up == kNone ? 0.0 : inverse_sq_[i] * system.upper[a][i];
        }
    });
  }

  void apply(const std::vector<double>& r, std::vector<double>& z) {
    const std::size_t n = inverse_sq_.size();
    const auto at = [](const std::vector<double>& v, int i) { return v[static_cast<std::size_t>(i)]; };
    double last = 0.0;  // of the unknown before, which along x is the one numbered before
    for (std::size_t i = 0; i < n; ++i) {
      const double known =
          inverse_sq_[i] * r[i] + lower_[1][i] * at(y_, before_[1][i]) + lower_[2][i] * at(y_, before_[2][i]);
      last = known + lower_[0][i] * last;
      y_[i] = last;
    }
    last = 0.0;
    for (std::size_t i = n; i-- > 0;) {
      const double known = y_[i] + upper_[1][i] * at(z, next_[1][i]) + upper_[2][i] * at(z, next_[2][i]);
      last = known + upper_[0][i] * last;
      z[i] = last;
    }
  }

 private:
  std::vector<double> inverse_sq_, y_;
  std::array<std::vector<double>, 3> lower_, upper_;
  std::array<std::vector<int>, 3> before_, next_;
};

struct Assembly {
  const GridShape& shape;
  const Field& phi;
  const SolidField& open;
  const std::vector<Solid>& solids;
  const PressureOptions& options;
  Grid3<std::uint8_t> liquid;
  Grid3<int> number;

  int solid_at(int i, int j, int k) const { return open.any ? open.nearest(i, j, k) : -1; }
};

/// Which solid closes a face: the nearest of the cell in it that is deeper.
int closing_solid(const Assembly& a, const std::array<int, 3>& low, const std::array<int, 3>& high) {
  const int first = a.solid_at(low[0], low[1], low[2]), second = a.solid_at(high[0], high[1], high[2]);
  if (first == second || second < 0) return first;
  if (first < 0) return second;
  const Eigen::Vector3d middle =
      0.5 * (a.shape.centre_m(low[0], low[1], low[2]) + a.shape.centre_m(high[0], high[1], high[2]));
  return a.solids[static_cast<std::size_t>(first)].distance_m(middle) <=
                 a.solids[static_cast<std::size_t>(second)].distance_m(middle)
             ? first
             : second;
}

double surface_pressure(const Assembly& a, const std::array<int, 3>& wet, const std::array<int, 3>& dry, double theta) {
  if (a.options.tension_m3_s2 <= 0.0) return 0.0;
  const double h = a.shape.cell_m;
  const auto curvature = [&](const std::array<int, 3>& c) {
    double sum = curvature_per_m(a.phi, h, c[0], c[1], c[2]);
    if (!a.open.round) return sum;
    const Eigen::Vector3d slope =
        slope_at(a.phi, h, c[0], c[1], c[2]);  // and around the axis: its share across it over the distance
    const double length = slope.norm();
    if (length > 1e-6) sum += slope.x() / length / (h * (c[0] + 0.5));
    return sum;
  };
  const double inside = curvature(wet), outside = curvature(dry);
  const double most = 1.0 / a.shape.cell_m;
  return a.options.tension_m3_s2 * std::clamp((1.0 - theta) * inside + theta * outside, -2.0 * most, 2.0 * most);
}

double theta_of(double wet, double dry) { return std::clamp(wet / (wet - dry), kLeastTheta, 1.0); }

/// A face of a cell: across which axis, and on its lower (-1) or upper side.
struct CellFace {
  int axis = 0, side = 0;
};

void add_face(const Assembly& a, const MacGrid& u, CellFace at, const std::array<int, 3>& c, std::size_t row,
              System& system) {
  const int axis = at.axis, side = at.side;
  std::array<int, 3> other = c, face = c;
  const auto ax = static_cast<std::size_t>(axis);
  other[ax] += side;
  face[ax] += side > 0 ? 1 : 0;
  if (other[ax] < 0 || other[ax] >= a.shape.n(axis)) return;
  const double share = a.open.open[axis](face[0], face[1], face[2]);
  double flux = share * u[axis](face[0], face[1], face[2]);
  if (share < 1.0) {
    const int s = side > 0 ? closing_solid(a, c, other) : closing_solid(a, other, c);
    if (s >= 0) {
      const Solid& solid = a.solids[static_cast<std::size_t>(s)];
      flux += (1.0 - share) * solid.velocity_m_s[axis];
      if (solid.motion == SolidMotion::kFree)
        system.pulls[static_cast<std::size_t>(s)][ax].entries.emplace_back(static_cast<int>(row), side * (1.0 - share));
    }
  }
  system.right[row] -= side * flux;
  if (share <= 0.0) return;
  if (a.liquid(other[0], other[1], other[2]) != 0) {
    system.diagonal[row] += share;
    if (side > 0) {
      system.upper[ax][row] = share;
      system.next[ax][row] = a.number(other[0], other[1], other[2]);
    } else {
      system.before[ax][row] = a.number(other[0], other[1], other[2]);
    }
  } else {
    const double wet = a.phi(c[0], c[1], c[2]), dry = a.phi(other[0], other[1], other[2]);
    if (dry < 0.0) return;  // all closed around it: no cell of the liquid
    const double theta = theta_of(wet, dry);
    system.diagonal[row] += share / theta;
    system.right[row] += share / theta * surface_pressure(a, c, other, theta) * a.options.kick_s / a.shape.cell_m;
  }
}

System assemble(Assembly& a, const MacGrid& u) {
  System system;
  a.number = Grid3<int>(a.shape.nx, a.shape.ny, a.shape.nz, kNone);
  for (std::size_t c = 0; c < a.liquid.size(); ++c)
    if (a.liquid[c] != 0) {
      a.number[c] = static_cast<int>(system.cell.size());
      system.cell.push_back(c);
    }
  const std::size_t n = system.n();
  system.diagonal.assign(n, 0.0);
  system.right.assign(n, 0.0);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    system.upper[axis].assign(n, 0.0);
    system.next[axis].assign(n, kNone);
    system.before[axis].assign(n, kNone);
  }
  system.pulls.resize(a.solids.size());
  bool any_free = false;
  for (std::size_t s = 0; s < a.solids.size(); ++s) {
    if (a.solids[s].motion != SolidMotion::kFree) continue;
    any_free = true;
    for (auto& pull : system.pulls[s])
      pull.factor =
          a.options.density_kg_m3 * std::pow(a.shape.cell_m, 3) / (a.solids[s].density_kg_m3 * a.solids[s].volume_m3());
  }
  parallel_for(n, any_free ? std::max<std::size_t>(n, 1) : kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t row = begin; row < end; ++row) {
      const std::size_t c = system.cell[row], layer = static_cast<std::size_t>(a.shape.nx) * a.shape.ny;
      const std::array<int, 3> at{static_cast<int>(c % a.shape.nx), static_cast<int>(c % layer / a.shape.nx),
                                  static_cast<int>(c / layer)};
      for (int axis = 0; axis < 3; ++axis)
        for (const int side : {-1, 1}) add_face(a, u, {axis, side}, at, row, system);
    }
  });
  return system;
}

/// Asks for a divergence wherever flow can come from or get to a free surface.
void add_source(const Assembly& a, System& system) {
  const std::size_t n = system.n();
  std::vector<std::uint8_t> reached(n, 0);
  std::vector<std::size_t> front;
  for (std::size_t i = 0; i < n; ++i) {
    double coupled = 0.0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (system.next[axis][i] != kNone) coupled += system.upper[axis][i];
      if (system.before[axis][i] != kNone)
        coupled += system.upper[axis][static_cast<std::size_t>(system.before[axis][i])];
    }
    if (system.diagonal[i] > coupled + 1e-9) {
      reached[i] = 1;
      front.push_back(i);
    }
  }
  while (!front.empty()) {
    const std::size_t i = front.back();
    front.pop_back();
    system.right[i] += a.options.source_per_s * a.shape.cell_m * a.open.open_volume[system.cell[i]];
    for (std::size_t axis = 0; axis < 3; ++axis)
      for (const int other : {system.next[axis][i], system.before[axis][i]})
        if (other != kNone && reached[static_cast<std::size_t>(other)] == 0) {
          reached[static_cast<std::size_t>(other)] = 1;
          front.push_back(static_cast<std::size_t>(other));
        }
  }
}

void solve(const System& system, double limit, const PressureOptions& options, std::vector<double>& q,
           PressureSolve& result) {
  const std::size_t n = system.n();
  std::vector<double> r(n), z(n), s(n), as(n);
  multiply(system, q, as);
  for (std::size_t i = 0; i < n; ++i) r[i] = system.right[i] - as[i];
  double left = largest(r);
  if (!(left <= limit)) {
    Preconditioner preconditioner(system);
    preconditioner.apply(r, z);
    s = z;
    double rz = dot(r, z);
    while (!(left <= limit) && result.iterations < options.most_iterations) {
      ++result.iterations;
      multiply(system, s, as);
      const double curvature = dot(s, as);
      if (!(curvature > 0.0)) break;
      const double step = rz / curvature;
      parallel_for(n, kGrain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
          q[i] += step * s[i];
          r[i] -= step * as[i];
        }
      });
      left = largest(r);
      if (left <= limit) break;
      preconditioner.apply(r, z);
      const double rz_next = dot(r, z), share = rz_next / rz;
      rz = rz_next;
      parallel_for(n, kGrain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) s[i] = z[i] + share * s[i];
      });
    }
  }
  result.converged = left <= limit;
}

void subtract_gradient(const Assembly& a, const std::vector<double>& q, MacGrid& u) {
  const double per = a.options.kick_s / a.shape.cell_m;
  for (int axis = 0; axis < 3; ++axis) {
    Field& field = u[axis];
    parallel_for(static_cast<std::size_t>(field.nz()), 1, [&](std::size_t begin, std::size_t) {
      const int k = static_cast<int>(begin);
      for (int j = 0; j < field.ny(); ++j)
        for (int i = 0; i < field.nx(); ++i) {
          if (!(a.open.open[axis](i, j, k) > 0.0)) continue;
          const std::array<int, 3> high{i, j, k};
          std::array<int, 3> low = high;
          --low[static_cast<std::size_t>(axis)];
          const int lower = a.number(low[0], low[1], low[2]), upper = a.number(i, j, k);
          if (lower == kNone && upper == kNone) continue;
          if (lower != kNone && upper != kNone) {
            field(i, j, k) -= q[static_cast<std::size_t>(upper)] - q[static_cast<std::size_t>(lower)];
            continue;
          }
          const std::array<int, 3>&wet = lower != kNone ? low : high, &dry = lower != kNone ? high : low;
          const double phi_dry = a.phi(dry[0], dry[1], dry[2]);
          if (phi_dry < 0.0) continue;
          const double theta = theta_of(a.phi(wet[0], wet[1], wet[2]), phi_dry);
          const double inside = q[static_cast<std::size_t>(lower != kNone ? lower : upper)];
          const double slope = (surface_pressure(a, wet, dry, theta) * per - inside) / theta;
          field(i, j, k) -= lower != kNone ? slope : -slope;
        }
    });
  }
}

}  // namespace

Grid3<std::uint8_t> liquid_cells(const GridShape& shape, const Field& phi_m, const SolidField& open) {
  Grid3<std::uint8_t> liquid(shape.nx, shape.ny, shape.nz, 0);
  parallel_for(static_cast<std::size_t>(shape.nz), 1, [&](std::size_t begin, std::size_t) {
    const int k = static_cast<int>(begin);
    for (int j = 0; j < shape.ny; ++j)
      for (int i = 0; i < shape.nx; ++i) {
        if (!(phi_m(i, j, k) < 0.0)) continue;
        const MacGrid& o = open.open;
        const double sum =
            o[0](i, j, k) + o[0](i + 1, j, k) + o[1](i, j, k) + o[1](i, j + 1, k) + o[2](i, j, k) + o[2](i, j, k + 1);
        liquid(i, j, k) = sum > 0.0 ? 1 : 0;
      }
  });
  return liquid;
}

PressureSolve project(const GridShape& shape, const Field& phi_m, const SolidField& open, std::vector<Solid>& solids,
                      const Flowing& flow, const PressureOptions& options) {
  MacGrid& u = flow.u;
  Field& pressure = flow.pressure;
  Assembly a{shape, phi_m, open, solids, options, liquid_cells(shape, phi_m, open), {}};
  System system = assemble(a, u);
  if (options.source_per_s != 0.0) add_source(a, system);
  PressureSolve result;
  result.n_unknowns = system.n();
  const double per = options.kick_s / shape.cell_m;
  std::vector<double> q(system.n());
  for (std::size_t i = 0; i < q.size(); ++i) q[i] = pressure[system.cell[i]] * per;
  double speed = 9.81 * options.kick_s;
  for (int axis = 0; axis < 3; ++axis)
    for (std::size_t f = 0; f < u[axis].size(); ++f)
      if (open.open[axis][f] > 0.0) speed = std::max(speed, std::abs(u[axis][f]));
  const double limit = options.tolerance * speed;
  solve(system, limit, options, q, result);
  std::fill(pressure.data().begin(), pressure.data().end(), 0.0);
  for (std::size_t i = 0; i < q.size(); ++i) pressure[system.cell[i]] = q[i] / per;
  std::vector<double> left(system.n());
  multiply(system, q, left);
  for (std::size_t i = 0; i < left.size(); ++i) left[i] -= system.right[i];
  result.max_divergence = (largest(left) / shape.cell_m + std::abs(options.source_per_s)) * options.kick_s;
  subtract_gradient(a, q, u);
  for (std::size_t s = 0; s < solids.size(); ++s)
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const System::Pull& pull = system.pulls[s][axis];
      double sum = 0.0;
      for (const auto& [i, weight] : pull.entries) sum += weight * q[static_cast<std::size_t>(i)];
      solids[s].velocity_m_s[static_cast<int>(axis)] += pull.factor * sum;
    }
  return result;
}

}  // namespace klang::liquid
