#include "core/physics/modal/box_modes.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <bit>
#include <cmath>
#include <functional>

#include "core/foundation/base/check.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/parallel.hpp"
#include "core/foundation/la/lapack.hpp"
#include "core/physics/modal/detail/box_axis.hpp"
#include "core/physics/modal/detail/cluster_orientation.hpp"

namespace klang::modal {

using detail::BoxProducts;

struct BoxBody::Axis : detail::BoxAxis {
  using BoxAxis::BoxAxis;
};

/// Motions of given parities. Bit d of parities: the displacements other than d are odd along axis d, and d is even.
struct BoxBody::System {
  unsigned parities = 0;
  std::array<BoxProducts, 3> products;  ///< of each displacement
  std::array<Eigen::Index, 4> start{};  ///< of its unknowns
};

namespace {

void for_each(std::size_t n, std::size_t grain, const std::function<void(std::size_t)>& body) {
  parallel_for(n, grain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) body(i);
  });
}

/// Eigenvectors of the lowest eigenvalues of a positive semidefinite matrix (lower half; used up), ascending: Krylov space of blocks
/// under the inverse of the matrix, shifted so that rigid motions do not stop it.
Eigen::MatrixXd lowest_vectors(Eigen::MatrixXd& matrix, double shift, Eigen::Index count) {
  constexpr double kTolerance = 1e-7;  // of a vector; the Rayleigh quotient squares it
  const Eigen::Index n = matrix.rows();
  const Eigen::Index block = std::min(std::max(std::clamp<Eigen::Index>(count, 4, 8), count / 3), n);
  matrix.diagonal().array() += std::max(shift, 1e-13 * matrix.diagonal().maxCoeff());
  const int size = static_cast<int>(n);
  int info = 0;
  dpotrf_("L", &size, matrix.data(), &size, &info);
  if (info != 0) throw NumericalError("box: the stiffness of its polynomials is not positive to round-off");
  const auto inverse_times = [&](Eigen::MatrixXd x) {
    const int columns = static_cast<int>(x.cols());
    const double unit = 1.0;
    dtrsm_("L", "L", "N", "N", &size, &columns, &unit, matrix.data(), &size, x.data(), &size);
    dtrsm_("L", "L", "T", "N", &size, &columns, &unit, matrix.data(), &size, x.data(), &size);
    return x;
  };
  Eigen::MatrixXd space(n, 0), images(n, 0), projection(0, 0);
  Eigen::MatrixXd next(n, block);
  for (Eigen::Index j = 0; j < block;
       ++j)  // the low products first, and a little of everything: no random numbers are needed
    for (Eigen::Index i = 0; i < n; ++i)
      next(i, j) = std::cos(0.7 + 1.3 * static_cast<double>((i + 1) * (j + 1))) / (1.0 + 0.1 * static_cast<double>(i));
  for (;;) {
    for (int pass = 0; pass < 2; ++pass) next -= space * (space.transpose() * next);
    const Eigen::HouseholderQR<Eigen::MatrixXd> orthogonal(next);
    next = orthogonal.householderQ() * Eigen::MatrixXd::Identity(n, next.cols());
    for (int pass = 0; pass < 1; ++pass) next -= space * (space.transpose() * next);
    const Eigen::Index old = space.cols();
    space.conservativeResize(Eigen::NoChange, old + next.cols());
    space.rightCols(next.cols()) = next;
    Eigen::MatrixXd image = inverse_times(next);
    images.conservativeResize(Eigen::NoChange, old + next.cols());
    images.rightCols(next.cols()) = image;
    const Eigen::MatrixXd against = space.transpose() * image;
    projection.conservativeResize(space.cols(), space.cols());
    projection.rightCols(next.cols()) = against;
    projection.bottomRows(next.cols()) = against.transpose();
    projection.bottomRightCorner(next.cols(), next.cols()) =
        0.5 * (against.bottomRows(next.cols()) + against.bottomRows(next.cols()).transpose());
    if (space.cols() < count && space.cols() + block <= n) {
      next = std::move(image);
      continue;
    }
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> small(projection);
    const Eigen::MatrixXd best = small.eigenvectors().rowwise().reverse().leftCols(std::min(count, space.cols()));
    const Eigen::VectorXd theta = small.eigenvalues().reverse().head(best.cols());
    const Eigen::MatrixXd vectors = space * best;
    const bool whole = space.cols() + block > n;
    if (best.cols() == count) {
      const Eigen::MatrixXd rest = images * best - vectors * theta.asDiagonal();
      if (whole || ((rest.colwise().norm().transpose().array() / theta.array()).maxCoeff() <= kTolerance))
        return vectors;
    }
    next = std::move(image);
  }
}

/// Legendre coefficients of a displacement, or of its derivative along one axis, as a tensor (x fastest).
class Tensor {
 public:
  Tensor(const std::array<const detail::BoxAxis*, 3>& axes, const BoxProducts& products, int derived,
         const Eigen::VectorXd& unknowns) {
    std::array<Eigen::Index, 3> n{}, size{};
    for (std::size_t d = 0; d < 3; ++d) n[d] = axes[d]->degree + 1, size[d] = axes[d]->size();
    // One axis after the other: from the index of phi to that of p.
    Eigen::VectorXd values = Eigen::VectorXd::Zero(size[0] * size[1] * size[2]);
    for (std::size_t i = 0; i < products.size(); ++i)
      values[products[i][0] + size[0] * (products[i][1] + size[1] * products[i][2])] =
          unknowns[static_cast<Eigen::Index>(i)];
    const auto map = [&](int d) -> const Eigen::MatrixXd& {
      return d == derived ? axes[d]->derivative : axes[d]->legendre;
    };
    const Eigen::MatrixXd along_x = map(0) * values.reshaped(size[0], size[1] * size[2]);
    Eigen::MatrixXd along_y(n[0] * n[1], size[2]);
    for (Eigen::Index k = 0; k < size[2]; ++k)
      along_y.col(k) = (along_x.middleCols(k * size[1], size[1]) * map(1).transpose()).reshaped();
    coefficients_ = (along_y * map(2).transpose()).reshaped();
  }
  const Eigen::VectorXd& coefficients() const { return coefficients_; }

 private:
  Eigen::VectorXd coefficients_;
};

}  // namespace

BoxBody::~BoxBody() = default;
BoxBody::BoxBody(BoxBody&&) noexcept = default;

BoxBody::BoxBody(const Eigen::Vector3d& half_lengths_m, const BoxDegrees& degrees, const HeldFaces& held)
    : half_lengths_m_(half_lengths_m) {
  for (int d = 0; d < 3; ++d) {
    checked_open("box", "half length", half_lengths_m[d], 0.0, 1e6);
    const int degree = degrees[static_cast<std::size_t>(d)];
    if (degree < 2 || degree > 60) throw InputError("box", "degree", std::to_string(degree), "2 to 60");
    axes_.emplace_back(degree, held[static_cast<std::size_t>(2 * d)], held[static_cast<std::size_t>(2 * d + 1)]);
  }
  for (unsigned parities = 0; parities < 8; ++parities) {
    bool is_new = true;
    for (unsigned d = 0; d < 3; ++d) is_new = is_new && (axes_[d].has_parity || (parities >> d & 1U) == 0);
    if (!is_new) continue;
    System system;
    system.parities = parities;
    for (unsigned c = 0; c < 3; ++c) {
      const auto takes_part = [&](unsigned d, int i) {
        return !axes_[d].has_parity || (static_cast<unsigned>(i) & 1U) == ((parities >> d & 1U) ^ (d == c ? 1U : 0U));
      };
      for (int k = 0; k < axes_[2].size(); ++k)
        for (int j = 0; j < axes_[1].size(); ++j)
          for (int i = 0; i < axes_[0].size(); ++i) {
            const double share = std::pow(static_cast<double>(i) / degrees[0], 2) +
                                 std::pow(static_cast<double>(j) / degrees[1], 2) +
                                 std::pow(static_cast<double>(k) / degrees[2], 2);
            if (share <= 1.0 + 1e-12 && takes_part(0, i) && takes_part(1, j) && takes_part(2, k))
              system.products[c].emplace_back(i, j, k);
          }
      system.start[c + 1] = system.start[c] + static_cast<Eigen::Index>(system.products[c].size());
    }
    systems_.push_back(std::move(system));
  }
}

std::size_t BoxBody::n_systems() const { return systems_.size(); }
Eigen::Index BoxBody::size(std::size_t system) const { return systems_[system].start[3]; }

int BoxBody::n_rigid(std::size_t system) const {
  for (const Axis& axis : axes_)
    if (axis.size() <= axis.degree) return 0;
  const int odd = std::popcount(systems_[system].parities);
  return odd == 1 || odd == 2 ? 1 : 0;
}

Eigen::MatrixXd BoxBody::stiffness(const System& system, const solid::Material& material) const {
  const double lambda = material.lame_lambda_pa, mu = material.lame_mu_pa;
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(system.start[3], system.start[3]);
  for (unsigned d = 0; d < 3; ++d)  // columns: displacement d; rows: displacement c
    for (unsigned c = d; c < 3; ++c) {
      const unsigned e = 3 - c - d;  // the third axis, where c != d
      const double scale = 1.0 / (half_lengths_m_[c] * half_lengths_m_[d]);
      for_each(system.products[d].size(), 16, [&](std::size_t column) {
        const Eigen::Vector3i& q = system.products[d][column];
        for (std::size_t row = c == d ? column : 0; row < system.products[c].size(); ++row) {
          const Eigen::Vector3i& p = system.products[c][row];
          double& entry = matrix(system.start[c] + static_cast<Eigen::Index>(row),
                                 system.start[d] + static_cast<Eigen::Index>(column));
          if (c != d) {
            // lambda d_c u_c d_d u_d + mu d_d u_c d_c u_d
            if (p[e] == q[e])
              entry = scale * (lambda * axes_[c].coupling(q[c], p[c]) * axes_[d].coupling(p[d], q[d]) +
                               mu * axes_[d].coupling(q[d], p[d]) * axes_[c].coupling(p[c], q[c]));
            continue;
          }
          for (unsigned axis = 0; axis < 3; ++axis) {
            const unsigned one = (axis + 1) % 3, two = (axis + 2) % 3;
            if (p[one] == q[one] && p[two] == q[two])
              entry += (axis == c ? lambda + 2.0 * mu : mu) * axes_[axis].slope(p[axis], q[axis]) /
                       (half_lengths_m_[axis] * half_lengths_m_[axis]);
          }
        }
      });
    }
  return matrix;
}

BoxBody::Stiffness BoxBody::projected(std::size_t index, const Eigen::MatrixXd& basis) const {
  const System& system = systems_[index];
  const std::array<const detail::BoxAxis*, 3> axes{&axes_[0], &axes_[1], &axes_[2]};
  const Eigen::Index n = (axes_[0].degree + 1) * (axes_[1].degree + 1) * (axes_[2].degree + 1);
  Eigen::MatrixXd divergence(n, basis.cols()), strain(6 * n, basis.cols());
  for_each(static_cast<std::size_t>(basis.cols()), 1, [&](std::size_t at) {
    const auto mode = static_cast<Eigen::Index>(at);
    const auto slope = [&](unsigned c, unsigned d) -> Eigen::VectorXd {
      const auto part = basis.col(mode).segment(system.start[c], system.start[c + 1] - system.start[c]);
      return Tensor(axes, system.products[c], static_cast<int>(d), part).coefficients() / half_lengths_m_[d];
    };
    divergence.col(mode).setZero();
    for (unsigned c = 0; c < 3; ++c) {
      const Eigen::VectorXd stretch = slope(c, c);
      divergence.col(mode) += stretch;
      strain.col(mode).segment(c * n, n) = std::sqrt(2.0) * stretch;
      const unsigned d = (c + 1) % 3;
      strain.col(mode).segment((3 + c) * n, n) = slope(c, d) + slope(d, c);
    }
  });
  const double factor = half_lengths_m_.prod();
  return {factor * divergence.transpose() * divergence, factor * strain.transpose() * strain};
}

int BoxBody::count_below(std::size_t index, const solid::Material& material, double frequency_hz) const {
  Eigen::MatrixXd matrix = stiffness(systems_[index], material);
  matrix.diagonal().array() -= material.density_kg_m3 * std::pow(2.0 * kPi * frequency_hz, 2);
  const int n = static_cast<int>(matrix.rows()), n_work = 64 * n;
  std::vector<int> pivots(static_cast<std::size_t>(n));
  std::vector<double> work(static_cast<std::size_t>(n_work));
  int info = 0;
  dsytrf_("L", &n, matrix.data(), &n, pivots.data(), work.data(), &n_work, &info);
  KLANG_CHECK(info == 0, "dsytrf met a zero pivot");
  int negative = 0;
  for (int i = 0; i < n; ++i) {
    if (pivots[static_cast<std::size_t>(i)] < 0) {  // a block of two rows has one eigenvalue of each sign
      ++negative;
      ++i;
    } else if (matrix(i, i) < 0.0) {
      ++negative;
    }
  }
  return negative;
}

HarmonicModes BoxBody::lowest(std::size_t index, const solid::Material& material, int count, double highest_hz) const {
  const System& system = systems_[index];
  const int rigid = n_rigid(index), most = static_cast<int>(system.start[3]);
  // Of the order of the lowest eigenvalue, that of a beam.
  const double slender = std::min(1.0, 4.0 * half_lengths_m_.minCoeff() / half_lengths_m_.maxCoeff());
  const double shift = material.lame_mu_pa * std::pow(0.5 * kPi * slender / half_lengths_m_.maxCoeff(), 2);
  HarmonicModes modes;
  if (count <= 0) {
    modes.vectors.resize(most, 0);
    return modes;
  }
  const Eigen::MatrixXd lower = stiffness(system, material);
  for (int wanted = std::min(count + rigid, most);; wanted = std::min(2 * wanted, most)) {
    Eigen::MatrixXd matrix = lower;
    const Eigen::MatrixXd vectors = lowest_vectors(matrix, shift, wanted).rightCols(wanted - rigid);
    const Stiffness projection = projected(index, vectors);
    const double mass = material.density_kg_m3 * half_lengths_m_.prod();
    modes.angular_frequency_sq =
        (material.lame_lambda_pa * projection.lambda.diagonal() + material.lame_mu_pa * projection.mu.diagonal()) /
        mass;
    modes.vectors = vectors / std::sqrt(mass);
    const double last = wanted > rigid ? std::sqrt(modes.angular_frequency_sq.tail<1>()[0]) / (2.0 * kPi) : 0.0;
    if (highest_hz <= 0.0 || last > highest_hz || wanted == most) break;
  }
  if (highest_hz > 0.0) {
    const auto kept = (modes.angular_frequency_sq.array() <= std::pow(2.0 * kPi * highest_hz, 2)).count();
    modes.angular_frequency_sq.conservativeResize(kept);
    modes.vectors.conservativeResize(Eigen::NoChange, kept);
  }
  const Eigen::MatrixXd image = half_lengths_m_.prod() * (lower.selfadjointView<Eigen::Lower>() * modes.vectors);
  const double mass = material.density_kg_m3 * half_lengths_m_.prod();
  modes.relative_residual.resize(modes.vectors.cols());
  for (Eigen::Index k = 0; k < modes.vectors.cols(); ++k) {
    if (detail::turns_over(modes.vectors.col(k))) modes.vectors.col(k) *= -1.0;
    const Eigen::VectorXd inertia = modes.angular_frequency_sq[k] * mass * modes.vectors.col(k);
    modes.relative_residual[k] =
        std::min((image.col(k) - inertia).norm(), (image.col(k) + inertia).norm()) / inertia.norm();
  }
  return modes;
}

std::vector<HarmonicModes> BoxBody::lowest(const solid::Material& material, const std::vector<int>& counts) const {
  KLANG_CHECK(counts.size() == systems_.size(), "a count for each system");
  const BlasThreads one(1);  // a few hundred unknowns: threads only wait for each other
  std::vector<HarmonicModes> modes(systems_.size());
  for_each(systems_.size(), 1, [&](std::size_t s) { modes[s] = lowest(s, material, counts[s], 0.0); });
  return modes;
}

std::vector<HarmonicModes> BoxBody::modes_up_to(const solid::Material& material, double high_hz,
                                                const std::vector<int>& expected) const {
  KLANG_CHECK(expected.empty() || expected.size() == systems_.size(), "a number for each system");
  constexpr int kUnknown = 10, kAbove = 2;  // what lies above the band tells that nothing below it is left
  const BlasThreads one(1);
  std::vector<HarmonicModes> modes(systems_.size());
  for_each(systems_.size(), 1, [&](std::size_t s) {
    modes[s] = lowest(s, material, kAbove + (expected.empty() ? kUnknown : expected[s]), high_hz);
  });
  return modes;
}

namespace {

/// The distinct values of a coordinate, ascending, and which of them each point has. Meshes of boxes have few: they are lattices.
struct Lattice {
  std::vector<double> values;
  std::vector<Eigen::Index> of_point;

  explicit Lattice(const Eigen::VectorXd& coordinate) : values(coordinate.begin(), coordinate.end()) {
    std::sort(values.begin(), values.end());
    values.erase(std::unique(values.begin(), values.end()), values.end());
    of_point.reserve(static_cast<std::size_t>(coordinate.size()));
    for (const double x : coordinate)
      of_point.push_back(std::lower_bound(values.begin(), values.end(), x) - values.begin());
  }
  Eigen::Index size() const { return static_cast<Eigen::Index>(values.size()); }
  Eigen::VectorXd places() const { return Eigen::Map<const Eigen::VectorXd>(values.data(), size()); }
};

/// Coefficients of products of phi as a tensor, x fastest, to values on a lattice, x fastest: one axis after the other.
Eigen::VectorXd on_lattice(const Eigen::VectorXd& coefficients, const std::array<Eigen::MatrixXd, 3>& phi) {
  const Eigen::Index ni = phi[0].cols(), nj = phi[1].cols(), nk = phi[2].cols();
  const Eigen::Index nx = phi[0].rows(), ny = phi[1].rows(), nz = phi[2].rows();
  const Eigen::MatrixXd along_z = coefficients.reshaped(ni * nj, nk) * phi[2].transpose();
  Eigen::MatrixXd along_y(ni, ny * nz);
  for (Eigen::Index k = 0; k < nz; ++k)
    along_y.middleCols(k * ny, ny).noalias() = along_z.col(k).reshaped(ni, nj) * phi[1].transpose();
  Eigen::MatrixXd values(nx, ny * nz);
  values.noalias() = phi[0] * along_y;
  return values.reshaped();
}

}  // namespace

Eigen::MatrixXd BoxBody::displacements(std::size_t index, const Eigen::MatrixXd& unknowns,
                                       const mesh::Points& points_m) const {
  const System& system = systems_[index];
  const auto phi_at = [&](unsigned d, const Eigen::VectorXd& x) -> Eigen::MatrixXd {
    return detail::legendre_values(axes_[d].degree, (x / half_lengths_m_[d]).cwiseMax(-1.0).cwiseMin(1.0)) *
           axes_[d].legendre;
  };
  const std::array<Lattice, 3> lattice{Lattice(points_m.col(0)), Lattice(points_m.col(1)), Lattice(points_m.col(2))};
  const Eigen::Index nx = lattice[0].size(), ny = lattice[1].size(), n_places = nx * ny * lattice[2].size();
  Eigen::MatrixXd moved(3 * points_m.rows(), unknowns.cols());
  if (n_places <= 4 * points_m.rows()) {
    const std::array<Eigen::MatrixXd, 3> phi{phi_at(0, lattice[0].places()), phi_at(1, lattice[1].places()),
                                             phi_at(2, lattice[2].places())};
    for_each(static_cast<std::size_t>(unknowns.cols()), 1, [&](std::size_t at) {
      const auto mode = static_cast<Eigen::Index>(at);
      for (unsigned c = 0; c < 3; ++c) {
        const BoxProducts& products = system.products[c];
        Eigen::VectorXd tensor = Eigen::VectorXd::Zero(phi[0].cols() * phi[1].cols() * phi[2].cols());
        for (std::size_t i = 0; i < products.size(); ++i)
          tensor[products[i][0] + phi[0].cols() * (products[i][1] + phi[1].cols() * products[i][2])] =
              unknowns(system.start[c] + static_cast<Eigen::Index>(i), mode);
        const Eigen::VectorXd values = on_lattice(tensor, phi);
        for (std::size_t p = 0; p < lattice[0].of_point.size(); ++p)
          moved(3 * static_cast<Eigen::Index>(p) + c, mode) =
              values[lattice[0].of_point[p] + nx * (lattice[1].of_point[p] + ny * lattice[2].of_point[p])];
      }
    });
    return moved;
  }
  const std::array<Eigen::MatrixXd, 3> values{phi_at(0, points_m.col(0)), phi_at(1, points_m.col(1)),
                                              phi_at(2, points_m.col(2))};
  parallel_for(static_cast<std::size_t>(points_m.rows()), 512, [&](std::size_t begin, std::size_t end) {
    const auto first = static_cast<Eigen::Index>(begin), n = static_cast<Eigen::Index>(end - begin);
    for (unsigned c = 0; c < 3; ++c) {
      const BoxProducts& products = system.products[c];
      Eigen::MatrixXd at(n, static_cast<Eigen::Index>(products.size()));
      for (std::size_t i = 0; i < products.size(); ++i)
        at.col(static_cast<Eigen::Index>(i)) = values[0].col(products[i][0]).segment(first, n).array() *
                                               values[1].col(products[i][1]).segment(first, n).array() *
                                               values[2].col(products[i][2]).segment(first, n).array();
      const Eigen::MatrixXd u = at * unknowns.middleRows(system.start[c], system.start[c + 1] - system.start[c]);
      for (Eigen::Index i = 0; i < n; ++i) moved.row(3 * (first + i) + c) = u.row(i);
    }
  });
  return moved;
}

}  // namespace klang::modal
