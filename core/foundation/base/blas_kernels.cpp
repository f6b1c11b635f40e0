#include "core/foundation/base/blas_kernels.hpp"

#include <dlfcn.h>

#include <cstdlib>

extern "C" char* openblas_get_corename(void);

namespace klang {

std::string blas_kernels() { return openblas_get_corename(); }

std::string best_blas_kernels() {
#if defined(__x86_64__)
  __builtin_cpu_init();
  const bool avx2 = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
  const bool avx512 = avx2 && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
                      __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512vl");
  if (avx512 && __builtin_cpu_supports("avx512bf16")) return "Cooperlake";
  if (avx512) return "SkylakeX";
  if (avx2) return "Haswell";
#endif
  return {};
}

bool choose_blas_kernels() {
  const std::string best = best_blas_kernels();
  if (std::getenv("OPENBLAS_CORETYPE") != nullptr || best.empty() || blas_kernels() != "Prescott") return false;
  using Function = void (*)();
  const auto forget = reinterpret_cast<Function>(dlsym(RTLD_DEFAULT, "gotoblas_dynamic_quit"));
  const auto choose = reinterpret_cast<Function>(dlsym(RTLD_DEFAULT, "gotoblas_dynamic_init"));
  if (forget == nullptr || choose == nullptr) return false;  // another BLAS
  setenv("OPENBLAS_CORETYPE", best.c_str(), 1);
  forget();
  choose();
  unsetenv("OPENBLAS_CORETYPE");
  return true;
}

}  // namespace klang
