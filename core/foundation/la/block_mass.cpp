#include "core/foundation/la/block_mass.hpp"

#include "core/foundation/base/parallel.hpp"

namespace klang::la {

BlockMass::BlockMass(const SparseMatrix& mass, double density_kg_m3) {
  const int n_nodes = static_cast<int>(mass.cols() / 3);
  const int* outer = mass.outerIndexPtr();
  const int* inner = mass.innerIndexPtr();
  const double* value = mass.valuePtr();
  // Entries (3 i, 3 j) of column 3 j: the diagonal, then every third one after the diagonal block.
  const auto for_each_lower = [&](const auto& visit) {
    for (int j = 0; j < n_nodes; ++j) {
      for (int k = outer[3 * j]; k < outer[3 * j + 1]; ++k) {
        if (inner[k] % 3 == 0) visit(inner[k] / 3, j, value[k]);
      }
    }
  };
  start_.assign(n_nodes + 1, 0);
  for_each_lower([&](int i, int j, double) {
    ++start_[i + 1];
    if (i != j) ++start_[j + 1];
  });
  for (int i = 0; i < n_nodes; ++i) start_[i + 1] += start_[i];
  column_.resize(start_[n_nodes]);
  value_.resize(start_[n_nodes]);
  std::vector<int> next(start_.begin(), start_.end() - 1);
  const auto put = [&](int i, int j, double v) {
    column_[next[i]] = j;
    value_[next[i]++] = density_kg_m3 * v;
  };
  for_each_lower([&](int i, int j, double v) {
    put(i, j, v);
    if (i != j) put(j, i, v);
  });
}

void BlockMass::multiply(const double* x, double* y) const {
  parallel_for(start_.size() - 1, 4096, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      double sum[3] = {0, 0, 0};
      for (int k = start_[i]; k < start_[i + 1]; ++k) {
        const double* from = x + 3 * static_cast<std::size_t>(column_[k]);
        for (int a = 0; a < 3; ++a) sum[a] += value_[k] * from[a];
      }
      for (int a = 0; a < 3; ++a) y[3 * i + a] = sum[a];
    }
  });
}

Eigen::MatrixXd BlockMass::times(const Eigen::MatrixXd& x) const {
  constexpr Eigen::Index kGroup = 4;  // columns for which one entry of M is read once
  Eigen::MatrixXd y(x.rows(), x.cols());
  const Eigen::Index n_grouped = x.cols() / kGroup * kGroup;
  for (Eigen::Index first = 0; first < n_grouped; first += kGroup) {
    parallel_for(start_.size() - 1, 2048, [&](std::size_t begin, std::size_t end) {
      const double* from[kGroup];
      double* to[kGroup];
      for (Eigen::Index c = 0; c < kGroup; ++c) {
        from[c] = x.col(first + c).data();
        to[c] = y.col(first + c).data();
      }
      for (std::size_t i = begin; i < end; ++i) {
        double sum[kGroup][3] = {};
        for (int k = start_[i]; k < start_[i + 1]; ++k) {
          const std::size_t place = 3 * static_cast<std::size_t>(column_[k]);
          for (Eigen::Index c = 0; c < kGroup; ++c) {
            for (int a = 0; a < 3; ++a) sum[c][a] += value_[k] * from[c][place + a];
          }
        }
        for (Eigen::Index c = 0; c < kGroup; ++c) {
          for (int a = 0; a < 3; ++a) to[c][3 * i + a] = sum[c][a];
        }
      }
    });
  }
  for (Eigen::Index k = n_grouped; k < x.cols(); ++k) multiply(x.col(k).data(), y.col(k).data());
  return y;
}

Eigen::MatrixXd symmetric_times(const SparseMatrix& lower, const Eigen::MatrixXd& x) {
  Eigen::MatrixXd y(x.rows(), x.cols());
  parallel_for(static_cast<std::size_t>(x.cols()), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      const auto c = static_cast<Eigen::Index>(k);
      y.col(c).noalias() = lower.selfadjointView<Eigen::Lower>() * x.col(c);
    }
  });
  return y;
}

}  // namespace klang::la
