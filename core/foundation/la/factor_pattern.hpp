#pragma once
#include <memory>
#include <vector>

#include "core/foundation/la/sparse_matrix.hpp"

namespace klang::la {

namespace detail {
struct AnalysedPattern;
}

/// What the factors of all matrices of one pattern have in common: order, elimination tree and places of their entries. Made once
/// for K - shift M at any shift. Copies share it; reading it is safe from several threads.
class FactorPattern {
 public:
  /// lower: lower triangle of a symmetric matrix; order[k] = row that comes k-th.
  FactorPattern(const SparseMatrix& lower, const std::vector<int>& order);

  /// False when memory or 32-bit indices do not reach.
  explicit operator bool() const { return analysed_ != nullptr; }
  const detail::AnalysedPattern& analysed() const { return *analysed_; }
  const std::vector<int>& order() const { return order_; }
  bool out_of_memory() const { return out_of_memory_; }

 private:
  std::vector<int> order_;
  std::shared_ptr<const detail::AnalysedPattern> analysed_;
  bool out_of_memory_ = false;
};

}  // namespace klang::la
