#pragma once
#include <cstddef>

namespace klang::stage::detail {

inline constexpr std::size_t kBlockFrames = 256;  ///< samples that one column of states yields
inline constexpr std::size_t kLane = 8;           ///< doubles handled as one vector
inline constexpr std::size_t kColumnGroup = 4;    ///< columns that share one load of the table

/// One column of states yields length samples from offset on.
struct Column {
  std::size_t offset = 0;
  std::size_t length = kBlockFrames;
};

/// output[offset_k + j] += sum_r table(r, j) states(r, k), j < length_k, for every column k: the product of
/// the rows' block responses with the states at the blocks' starts. The sum runs over r in order, whatever
/// the processor, and without fused multiply-add: same bits everywhere.
/// @param table   [kBlockFrames / kLane][n_rows][kLane]
/// @param states  [n_groups][n_rows][kColumnGroup]
/// @param columns n_groups * kColumnGroup, padded with length 0
void mix_columns(const double* table, const double* states, std::size_t n_rows, const Column* columns,
                 std::size_t n_groups, double* output);

}  // namespace klang::stage::detail
