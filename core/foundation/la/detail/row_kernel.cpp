#include "core/foundation/la/detail/row_kernel.hpp"

#include <cstring>

#include "core/foundation/base/vector_clones.hpp"

// Sums run in kLane partial sums whatever the machine's registers: the same bits on every machine.
namespace klang::la::detail {
namespace {

using Vector = double __attribute__((vector_size(kLane * sizeof(double))));

double sum(const double* v) { return ((v[0] + v[4]) + (v[2] + v[6])) + ((v[1] + v[5]) + (v[3] + v[7])); }

}  // namespace

// Macros, because GCC lowers the vectors of a helper function to the oldest machine's before it is inlined into a clone.
#define KLANG_LOAD(v, at) \
  Vector v;               \
  std::memcpy(&v, (at), sizeof v)
#define KLANG_STORE(at, v) std::memcpy((at), &(v), sizeof(Vector))

// Two rows a, b against one pair of vectors x: sums to ya, yb (two numbers each).
#define KLANG_DOT2(a, b, n, x, ya, yb)                     \
  do {                                                     \
    const double *const ra_ = (a), *const rb_ = (b);       \
    const double *const x0_ = (x), *const x1_ = x0_ + (n); \
    Vector a0_{}, a1_{}, b0_{}, b1_{};                     \
    for (std::size_t j_ = 0; j_ < (n); j_ += kLane) {      \
      KLANG_LOAD(u0_, x0_ + j_);                           \
      KLANG_LOAD(u1_, x1_ + j_);                           \
      KLANG_LOAD(ma_, ra_ + j_);                           \
      KLANG_LOAD(mb_, rb_ + j_);                           \
      a0_ += ma_ * u0_;                                    \
      a1_ += ma_ * u1_;                                    \
      b0_ += mb_ * u0_;                                    \
      b1_ += mb_ * u1_;                                    \
    }                                                      \
    double sums_[4][kLane];                                \
    KLANG_STORE(sums_[0], a0_);                            \
    KLANG_STORE(sums_[1], a1_);                            \
    KLANG_STORE(sums_[2], b0_);                            \
    KLANG_STORE(sums_[3], b1_);                            \
    (ya)[0] = sum(sums_[0]);                               \
    (ya)[1] = sum(sums_[1]);                               \
    (yb)[0] = sum(sums_[2]);                               \
    (yb)[1] = sum(sums_[3]);                               \
  } while (false)

// w += a ya + b yb for the pair w.
#define KLANG_ADD2(a, b, n, ya, yb, w)                                           \
  do {                                                                           \
    const double *const ra_ = (a), *const rb_ = (b);                             \
    double *const w0_ = (w), *const w1_ = w0_ + (n);                             \
    const double ya0_ = (ya)[0], ya1_ = (ya)[1], yb0_ = (yb)[0], yb1_ = (yb)[1]; \
    for (std::size_t j_ = 0; j_ < (n); j_ += kLane) {                            \
      KLANG_LOAD(ma_, ra_ + j_);                                                 \
      KLANG_LOAD(mb_, rb_ + j_);                                                 \
      KLANG_LOAD(s0_, w0_ + j_);                                                 \
      KLANG_LOAD(s1_, w1_ + j_);                                                 \
      s0_ += ma_ * ya0_ + mb_ * yb0_;                                            \
      s1_ += ma_ * ya1_ + mb_ * yb1_;                                            \
      KLANG_STORE(w0_ + j_, s0_);                                                \
      KLANG_STORE(w1_ + j_, s1_);                                                \
    }                                                                            \
  } while (false)

// An odd last row goes with itself: its second copy counts 0.
KLANG_CLONES void rows_times(const double* m, std::size_t n_rows, std::size_t n, const double* x, std::size_t n_pairs,
                             double* y) {
  for (std::size_t i = 0; i < n_rows; i += 2)
    for (std::size_t p = 0; p < n_pairs; ++p) {
      const std::size_t second = i + 1 < n_rows ? i + 1 : i;
      double ya[2], yb[2];
      KLANG_DOT2(m + i * n, m + second * n, n, x + 2 * p * n, ya, yb);
      std::memcpy(y + 2 * (i * n_pairs + p), ya, sizeof ya);
      if (second != i) std::memcpy(y + 2 * (second * n_pairs + p), yb, sizeof yb);
    }
}

KLANG_CLONES void rows_add(const double* m, std::size_t n_rows, std::size_t n, const double* y, std::size_t n_pairs,
                           double* w) {
  for (std::size_t i = 0; i < n_rows; i += 2)
    for (std::size_t p = 0; p < n_pairs; ++p) {
      const std::size_t second = i + 1 < n_rows ? i + 1 : i;
      double yb[2] = {0.0, 0.0};
      if (second != i) std::memcpy(yb, y + 2 * (second * n_pairs + p), sizeof yb);
      KLANG_ADD2(m + i * n, m + second * n, n, y + 2 * (i * n_pairs + p), yb, w + 2 * p * n);
    }
}

KLANG_CLONES void rows_residual(const double* m, std::size_t n_rows, std::size_t n, const double* x, const double* y,
                                std::size_t n_pairs, double* w) {
  for (std::size_t i = 0; i < n_rows; i += 2)
    for (std::size_t p = 0; p < n_pairs; ++p) {
      const std::size_t second = i + 1 < n_rows ? i + 1 : i;
      double ya[2], yb[2];
      KLANG_DOT2(m + i * n, m + second * n, n, x + 2 * p * n, ya, yb);
      for (int k = 0; k < 2; ++k) {
        ya[k] = y[2 * (i * n_pairs + p) + static_cast<std::size_t>(k)] - ya[k];
        yb[k] = second == i ? 0.0 : y[2 * (second * n_pairs + p) + static_cast<std::size_t>(k)] - yb[k];
      }
      KLANG_ADD2(m + i * n, m + second * n, n, ya, yb, w + 2 * p * n);
    }
}

KLANG_CLONES void rows_normal(const double* m, std::size_t n_rows, std::size_t n, const double* x, std::size_t n_pairs,
                              double* w) {
  for (std::size_t i = 0; i < n_rows; i += 2)
    for (std::size_t p = 0; p < n_pairs; ++p) {
      const std::size_t second = i + 1 < n_rows ? i + 1 : i;
      double ya[2], yb[2];
      KLANG_DOT2(m + i * n, m + second * n, n, x + 2 * p * n, ya, yb);
      if (second == i) yb[0] = yb[1] = 0.0;
      KLANG_ADD2(m + i * n, m + second * n, n, ya, yb, w + 2 * p * n);
    }
}

}  // namespace klang::la::detail
