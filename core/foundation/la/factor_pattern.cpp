#include "core/foundation/la/factor_pattern.hpp"

#include <new>

#include "core/foundation/la/detail/analysed_pattern.hpp"
#include "core/foundation/la/detail/cholmod_session.hpp"

namespace klang::la {

detail::AnalysedPattern::AnalysedPattern(cholmod_factor* analysed, const SparseMatrix& lower)
    : symbolic(analysed), tree(*analysed, lower) {}

detail::AnalysedPattern::~AnalysedPattern() {
  CholmodSession session;
  cholmod_free_factor(&symbolic, &session.common);
}

FactorPattern::FactorPattern(const SparseMatrix& lower, const std::vector<int>& order) : order_(order) {
  detail::CholmodSession session;
  cholmod_factor* factor = session.analyse_supernodal(lower, order);
  out_of_memory_ = session.common.status == CHOLMOD_OUT_OF_MEMORY;
  if (factor != nullptr && factor->is_super != 0) {
    try {
      analysed_ = std::make_shared<const detail::AnalysedPattern>(factor, lower);
      return;
    } catch (const std::bad_alloc&) {  // nothing has taken the factor
      out_of_memory_ = true;
    }
  }
  cholmod_free_factor(&factor, &session.common);
}

}  // namespace klang::la
