#include "core/physics/solid/enriched_space.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <tuple>

#include "core/foundation/base/parallel.hpp"
#include "core/foundation/base/vector_clones.hpp"
#include "core/foundation/la/lapack.hpp"
#include "core/foundation/math/tet_rule.hpp"

namespace klang::solid {
namespace {

constexpr int kPoints = TetRule::kPoints;
constexpr int kMaxFunctions = 20;
constexpr int kBatch = 512;  // elements whose parts are held before they are added in order
constexpr std::size_t kGrain = 16;

/// Values and reference derivatives of all functions of an element, those of the mesh first.
struct Tables {
  int n_own = 0, n_added = 0;
  std::array<double, kPoints> weight;
  std::array<std::array<double, kMaxFunctions>, kPoints> value;
  std::array<Eigen::Matrix<double, kMaxFunctions, 3>, kPoints> derivative;
};

Tables make_tables(int order) {
  using Gradient = Eigen::RowVector3d;
  Tables t;
  t.n_own = order == 2 ? 10 : 4;
  t.n_added = order == 2 ? 10 : 6;
  const TetRule rule = make_tet_rule();
  t.weight = rule.weight;
  for (int q = 0; q < kPoints; ++q) {
    const auto& l = rule.point[q];
    const auto dl = [](int i) { return i == 0 ? Gradient(-1, -1, -1) : Gradient(Gradient::Unit(i - 1)); };
    int n = 0;
    const auto add = [&](double value, const Gradient& derivative) {
      t.value[q][n] = value;
      t.derivative[q].row(n++) = derivative;
    };
    for (int i = 0; i < 4; ++i) {
      if (order == 2)
        add(l[i] * (2 * l[i] - 1), (4 * l[i] - 1) * dl(i));
      else
        add(l[i], dl(i));
    }
    for (const auto& [i, j] : mesh::kTetEdges) add(4 * l[i] * l[j], 4 * (l[i] * dl(j) + l[j] * dl(i)));
    if (order == 1) continue;
    for (const auto& [i, j] : mesh::kTetEdges) {
      add(l[i] * l[j] * (l[i] - l[j]), (l[i] * dl(j) + l[j] * dl(i)) * (l[i] - l[j]) + l[i] * l[j] * (dl(i) - dl(j)));
    }
    for (const auto& [i, j, k] : mesh::kTetFaces) {
      add(l[i] * l[j] * l[k], l[j] * l[k] * dl(i) + l[i] * l[k] * dl(j) + l[i] * l[j] * dl(k));
    }
  }
  return t;
}

const Tables& tables(int order) {
  static const Tables linear = make_tables(1), quadratic = make_tables(2);
  return order == 2 ? quadratic : linear;
}

/// Gradients of all functions of an element at the points (function fastest, then axis, then point), and weights
/// times the Jacobian determinant. sign: of the added functions.
void evaluate(const mesh::TetMesh& mesh, const Tables& t, int e, const signed char* sign, double* gradient,
              double* weight) {
  const int n_functions = t.n_own + t.n_added;
  Eigen::Matrix<double, Eigen::Dynamic, 3, 0, 10, 3> nodes(t.n_own, 3);
  for (int i = 0; i < t.n_own; ++i) nodes.row(i) = mesh.nodes_m.row(mesh.elements(e, i));
  for (int q = 0; q < kPoints; ++q) {
    const Eigen::Matrix3d jacobian = nodes.transpose() * t.derivative[q].topRows(t.n_own);
    weight[q] = t.weight[q] * jacobian.determinant();
    Eigen::Map<Eigen::MatrixXd> g(gradient + 3 * q * n_functions, n_functions, 3);
    g.noalias() = t.derivative[q].topRows(n_functions).lazyProduct(jacobian.inverse());
    for (int j = 0; j < t.n_added; ++j) {
      if (sign[j] < 0) g.row(t.n_own + j) *= -1;
    }
  }
}

/// lambda tr(e) 1 + 2 mu e in place of the gradients of m vectors: entry (3 b + a) m + v is du_a/dx_b of vector v.
KLANG_CLONES void to_stress(int m, double lambda, double mu, double* gradient) {
  double* const xx = gradient;
  double* const yx = xx + m;
  double* const zx = yx + m;
  double* const xy = zx + m;
  double* const yy = xy + m;
  double* const zy = yy + m;
  double* const xz = zy + m;
  double* const yz = xz + m;
  double* const zz = yz + m;
#pragma GCC ivdep
  for (int v = 0; v < m; ++v) {
    const double pressure = lambda * (xx[v] + yy[v] + zz[v]);
    xx[v] = pressure + 2 * mu * xx[v];
    yy[v] = pressure + 2 * mu * yy[v];
    zz[v] = pressure + 2 * mu * zz[v];
    xy[v] = yx[v] = mu * (xy[v] + yx[v]);
    xz[v] = zx[v] = mu * (xz[v] + zx[v]);
    yz[v] = zy[v] = mu * (yz[v] + zy[v]);
  }
}

}  // namespace

EnrichedSpace::EnrichedSpace(const mesh::TetMesh& mesh, const AssembledSolid& assembled, const Material& material)
    : mesh_(mesh), material_(material), n_nodes_(mesh.n_nodes()), n_local_(tables(mesh.order()).n_added) {
  std::vector<char> held(n_nodes_, 1);
  for (const int node : assembled.free_nodes) held[node] = 0;
  number_added(held);
  make_diagonal();
}

void EnrichedSpace::number_added(const std::vector<char>& held) {
  struct Place {
    std::array<int, 3> corners;  // ascending; -1 first for an edge
    int slot;
  };
  const bool quadratic = mesh_.order() == 2;
  const std::size_t n_slots = static_cast<std::size_t>(mesh_.n_elements()) * n_local_;
  std::vector<Place> places(n_slots);
  added_.resize(n_slots);
  sign_.assign(n_slots, 1);
  parallel_for(static_cast<std::size_t>(mesh_.n_elements()), 1024, [&](std::size_t begin, std::size_t end) {
    for (std::size_t e = begin; e < end; ++e) {
      const auto corner = [&](int c) { return mesh_.elements(static_cast<Eigen::Index>(e), c); };
      for (int j = 0; j < n_local_; ++j) {
        const std::size_t slot = e * n_local_ + j;
        std::array<int, 3> corners{};
        if (j < 6) {
          const auto [a, b] = mesh::kTetEdges[j];
          corners = {-1, std::min(corner(a), corner(b)), std::max(corner(a), corner(b))};
          if (quadratic && corner(a) > corner(b)) sign_[slot] = -1;
        } else {
          const auto [a, b, c] = mesh::kTetFaces[j - 6];
          corners = {corner(a), corner(b), corner(c)};
          std::sort(corners.begin(), corners.end());
        }
        places[slot] = {corners, static_cast<int>(slot)};
      }
    }
  });
  std::sort(places.begin(), places.end(),
            [](const Place& a, const Place& b) { return std::tie(a.corners, a.slot) < std::tie(b.corners, b.slot); });
  n_added_ = 0;
  for (std::size_t k = 0; k < n_slots; ++k) {
    if (k == 0 || places[k].corners != places[k - 1].corners) {
      ++n_added_;
      // Held when all its nodes are; the mid-node of an edge tells one in a held face from one through the body.
      const int e = places[k].slot / n_local_, j = places[k].slot % n_local_;
      bool all = true;
      for (const int c : places[k].corners) all = all && (c < 0 || held[c] != 0);
      if (quadratic && j < 6) all = all && held[mesh_.elements(e, 4 + j)] != 0;
      added_held_.push_back(all ? 1 : 0);
    }
    added_[places[k].slot] = n_added_ - 1;
  }
}

void EnrichedSpace::make_diagonal() {
  const Tables& t = tables(mesh_.order());
  const int n_functions = t.n_own + t.n_added;
  const auto n = static_cast<std::size_t>(mesh_.n_elements());
  std::vector<Eigen::Matrix3d> part(n * n_local_);
  parallel_for(n, kGrain, [&](std::size_t begin, std::size_t end) {
    std::vector<double> gradient(3 * kPoints * n_functions);
    std::array<double, kPoints> weight;
    for (std::size_t e = begin; e < end; ++e) {
      evaluate(mesh_, t, static_cast<int>(e), &sign_[e * n_local_], gradient.data(), weight.data());
      for (int j = 0; j < n_local_; ++j) {
        Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
        for (int q = 0; q < kPoints; ++q) {
          const double* at = gradient.data() + 3 * q * n_functions + t.n_own + j;
          const Eigen::Vector3d g(at[0], at[n_functions], at[2 * n_functions]);
          sum += weight[q] * g * g.transpose();
        }
        // int lambda g g^T + mu (g g^T + |g|^2 1)
        part[e * n_local_ + j] = (material_.lame_lambda_pa + material_.lame_mu_pa) * sum +
                                 material_.lame_mu_pa * sum.trace() * Eigen::Matrix3d::Identity();
      }
    }
  });
  inverse_diagonal_.assign(n_added_, Eigen::Matrix3d::Zero());
  for (std::size_t slot = 0; slot < part.size(); ++slot) inverse_diagonal_[added_[slot]] += part[slot];
  for (Eigen::Matrix3d& block : inverse_diagonal_) block = block.inverse().eval();
}

void EnrichedSpace::apply(const Fields& in, const Eigen::VectorXd* value, Eigen::MatrixXd* on_nodes,
                          Eigen::MatrixXd* on_added) const {
  const Tables& t = tables(mesh_.order());
  const int n_functions = t.n_own + t.n_added;
  const auto rows = static_cast<int>(in.nodes != nullptr ? in.nodes->rows() : in.added->rows());
  const int m = rows / 3;
  const int first_in = in.nodes != nullptr ? 0 : t.n_own, last_in = in.added != nullptr ? n_functions : t.n_own;
  const int first_out = on_nodes != nullptr ? 0 : t.n_own, last_out = on_added != nullptr ? n_functions : t.n_own;
  const int n_in = last_in - first_in, n_out = last_out - first_out;
  if (on_nodes != nullptr) on_nodes->setZero(rows, n_nodes_);
  if (on_added != nullptr) on_added->setZero(rows, n_added_);
  const auto n = static_cast<std::size_t>(mesh_.n_elements());
  std::vector<double> part(static_cast<std::size_t>(kBatch) * n_out * rows);
  const BlasThreads one_each(1);
  for (std::size_t first = 0; first < n; first += kBatch) {
    const std::size_t n_batch = std::min<std::size_t>(kBatch, n - first);
    parallel_for(n_batch, kGrain, [&](std::size_t begin, std::size_t end) {
      std::vector<double> gradient(3 * kPoints * n_functions), x(static_cast<std::size_t>(rows) * n_in),
          strain(3 * static_cast<std::size_t>(kPoints) * rows), at_points(static_cast<std::size_t>(kPoints) * rows),
          inertia(static_cast<std::size_t>(rows) * n_out), values(kPoints * n_functions);
      std::array<double, kPoints> weight;
      for (std::size_t k = begin; k < end; ++k) {
        const auto e = static_cast<Eigen::Index>(first + k);
        const signed char* sign = &sign_[static_cast<std::size_t>(e) * n_local_];
        evaluate(mesh_, t, static_cast<int>(e), sign, gradient.data(), weight.data());
        for (int i = first_in; i < last_in; ++i) {
          const double* from = i < t.n_own ? in.nodes->col(mesh_.elements(e, i)).data()
                                           : in.added->col(added_[e * n_local_ + i - t.n_own]).data();
          std::copy(from, from + rows, x.data() + static_cast<std::size_t>(i - first_in) * rows);
        }
        la::gemm('N', 'N', rows, 3 * kPoints, n_in, 1.0, x.data(), rows, gradient.data() + first_in, n_functions, 0.0,
                 strain.data(), rows);
        for (int q = 0; q < kPoints; ++q) {
          to_stress(m, weight[q] * material_.lame_lambda_pa, weight[q] * material_.lame_mu_pa,
                    strain.data() + static_cast<std::size_t>(3 * q) * rows);
        }
        double* out = part.data() + k * static_cast<std::size_t>(n_out) * rows;
        la::gemm('N', 'T', rows, n_out, 3 * kPoints, 1.0, strain.data(), rows, gradient.data() + first_out, n_functions,
                 0.0, out, rows);
        if (value == nullptr) continue;
        for (int q = 0; q < kPoints; ++q) {
          for (int i = 0; i < n_functions; ++i)
            values[q * n_functions + i] = t.value[q][i] * (i < t.n_own ? 1 : sign[i - t.n_own]);
        }
        la::gemm('N', 'N', rows, kPoints, n_in, 1.0, x.data(), rows, values.data() + first_in, n_functions, 0.0,
                 at_points.data(), rows);
        for (int q = 0; q < kPoints; ++q) {
          for (int r = 0; r < rows; ++r)
            at_points[static_cast<std::size_t>(q) * rows + r] *= weight[q] * material_.density_kg_m3 * (*value)[r % m];
        }
        la::gemm('N', 'T', rows, n_out, kPoints, 1.0, at_points.data(), rows, values.data() + first_out, n_functions,
                 0.0, inertia.data(), rows);
        for (std::size_t i = 0; i < inertia.size(); ++i) out[i] -= inertia[i];
      }
    });
    for (std::size_t k = 0; k < n_batch; ++k) {
      const auto e = static_cast<Eigen::Index>(first + k);
      const double* from = part.data() + k * static_cast<std::size_t>(n_out) * rows;
      for (int i = first_out; i < last_out; ++i, from += rows) {
        const Eigen::Map<const Eigen::VectorXd> term(from, rows);
        if (i < t.n_own)
          on_nodes->col(mesh_.elements(e, i)) += term;
        else
          on_added->col(added_[e * n_local_ + i - t.n_own]) += term;
      }
    }
  }
  if (on_added == nullptr) return;
  for (int j = 0; j < n_added_; ++j) {
    if (added_held_[j] != 0) on_added->col(j).setZero();
  }
}

Eigen::MatrixXd EnrichedSpace::residual(const Eigen::MatrixXd& u, const Eigen::VectorXd& value) const {
  Eigen::MatrixXd result;
  apply({&u, nullptr}, &value, nullptr, &result);
  return result;
}

void EnrichedSpace::stiffness_of_added(const Eigen::MatrixXd& w, Eigen::MatrixXd& on_nodes,
                                       Eigen::MatrixXd& on_added) const {
  apply({nullptr, &w}, nullptr, &on_nodes, &on_added);
}

Eigen::MatrixXd EnrichedSpace::stiffness_on_added(const Eigen::MatrixXd& v) const {
  Eigen::MatrixXd result;
  apply({&v, nullptr}, nullptr, nullptr, &result);
  return result;
}

Eigen::MatrixXd EnrichedSpace::block_jacobi(const Eigen::MatrixXd& w) const {
  const Eigen::Index m = w.rows() / 3;
  Eigen::MatrixXd result(w.rows(), w.cols());
  parallel_for(static_cast<std::size_t>(n_added_), 4096, [&](std::size_t begin, std::size_t end) {
    for (auto j = static_cast<Eigen::Index>(begin); j < static_cast<Eigen::Index>(end); ++j) {
      const Eigen::Map<const Eigen::MatrixXd> in(w.col(j).data(), m, 3);
      Eigen::Map<Eigen::MatrixXd>(result.col(j).data(), m, 3).noalias() =
          in.lazyProduct(inverse_diagonal_[static_cast<std::size_t>(j)]);
    }
  });
  return result;
}

}  // namespace klang::solid
