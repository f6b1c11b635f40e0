#pragma once
#include <string>

namespace klang {

/// Kernels that OpenBLAS computes with, by its names.
std::string blas_kernels();

/// What this processor should have of OpenBLAS' names, empty where SSE3 is all there is.
std::string best_blas_kernels();

/// OpenBLAS 0.3.21 knows no processor after 2021 (Emerald Rapids, for one) and gives those it does not know kernels of SSE3, a
/// quarter of the speed. Where it did so and the processor has more, its choice is made again; OPENBLAS_CORETYPE in the
/// environment wins over both. parallel.cpp does so before main(), while nothing computes.
bool choose_blas_kernels();

}  // namespace klang
