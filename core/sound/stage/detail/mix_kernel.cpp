#include "core/sound/stage/detail/mix_kernel.hpp"

#include <algorithm>
#include <cstring>

// Sanitizers cannot run before the resolvers that pick a clone.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__)
#define KLANG_CLONES __attribute__((target_clones("avx512f", "avx2", "default")))
#else
#define KLANG_CLONES
#endif

namespace klang::stage::detail {
namespace {

using Vector = double __attribute__((vector_size(kLane * sizeof(double))));

}  // namespace

KLANG_CLONES void mix_columns(const double* table, const double* states, std::size_t n_rows, const Column* columns,
                              std::size_t n_groups, double* output) {
  for (std::size_t panel = 0; panel < kBlockFrames / kLane; ++panel) {
    const double* const rows = table + panel * n_rows * kLane;
    const std::size_t first = panel * kLane;
    for (std::size_t group = 0; group < n_groups; ++group) {
      const double* const state = states + group * n_rows * kColumnGroup;
      Vector sum0{}, sum1{}, sum2{}, sum3{};
      for (std::size_t r = 0; r < n_rows; ++r) {
        Vector row;
        std::memcpy(&row, rows + r * kLane, sizeof row);
        sum0 += row * state[r * kColumnGroup];
        sum1 += row * state[r * kColumnGroup + 1];
        sum2 += row * state[r * kColumnGroup + 2];
        sum3 += row * state[r * kColumnGroup + 3];
      }
      double sums[kColumnGroup][kLane];
      std::memcpy(sums[0], &sum0, sizeof sum0);
      std::memcpy(sums[1], &sum1, sizeof sum1);
      std::memcpy(sums[2], &sum2, sizeof sum2);
      std::memcpy(sums[3], &sum3, sizeof sum3);
      for (std::size_t k = 0; k < kColumnGroup; ++k) {
        const Column& column = columns[group * kColumnGroup + k];
        if (column.length <= first) continue;
        double* const out = output + column.offset + first;
        const std::size_t n = std::min(kLane, column.length - first);
        for (std::size_t j = 0; j < n; ++j) out[j] += sums[k][j];
      }
    }
  }
}

}  // namespace klang::stage::detail
