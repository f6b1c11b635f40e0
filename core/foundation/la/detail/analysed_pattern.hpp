#pragma once
#include "core/foundation/la/detail/front_tree.hpp"

namespace klang::la::detail {

/// CHOLMOD's symbolic factor, which this owns, and the tree made of it.
struct AnalysedPattern {
  AnalysedPattern(cholmod_factor_struct* analysed, const SparseMatrix& lower);
  ~AnalysedPattern();
  AnalysedPattern(const AnalysedPattern&) = delete;
  AnalysedPattern& operator=(const AnalysedPattern&) = delete;

  cholmod_factor_struct* symbolic;
  FrontTree tree;  // refers to symbolic's arrays
};

}  // namespace klang::la::detail
