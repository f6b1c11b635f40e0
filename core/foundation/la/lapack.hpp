#pragma once
#include <complex>

// LAPACK and BLAS of OpenBLAS; its header has names that clash with Eigen's.
extern "C" {
void dgemm_(const char* trans_a, const char* trans_b, const int* m, const int* n, const int* k, const double* alpha,
            const double* a, const int* lda, const double* b, const int* ldb, const double* beta, double* c,
            const int* ldc);
void zgemm_(const char* trans_a, const char* trans_b, const int* m, const int* n, const int* k,
            const std::complex<double>* alpha, const std::complex<double>* a, const int* lda,
            const std::complex<double>* b, const int* ldb, const std::complex<double>* beta, std::complex<double>* c,
            const int* ldc);
void dpotrf_(const char* uplo, const int* n, double* a, const int* lda, int* info);
void zpotrf_(const char* uplo, const int* n, std::complex<double>* a, const int* lda, int* info);
void dtrsm_(const char* side, const char* uplo, const char* trans, const char* diag, const int* m, const int* n,
            const double* alpha, const double* a, const int* lda, double* b, const int* ldb);
void ztrsm_(const char* side, const char* uplo, const char* trans, const char* diag, const int* m, const int* n,
            const std::complex<double>* alpha, const std::complex<double>* a, const int* lda, std::complex<double>* b,
            const int* ldb);
void dgels_(const char* trans, const int* m, const int* n, const int* n_rhs, double* a, const int* lda, double* b,
            const int* ldb, double* work, const int* n_work, int* info);
void zgels_(const char* trans, const int* m, const int* n, const int* n_rhs, std::complex<double>* a, const int* lda,
            std::complex<double>* b, const int* ldb, std::complex<double>* work, const int* n_work, int* info);
void cgetrf_(const int* m, const int* n, std::complex<float>* a, const int* lda, int* pivots, int* info);
void cgetrs_(const char* trans, const int* n, const int* n_rhs, const std::complex<float>* a, const int* lda,
             const int* pivots, std::complex<float>* b, const int* ldb, int* info);
void zgetrf_(const int* m, const int* n, std::complex<double>* a, const int* lda, int* pivots, int* info);
void zgetrs_(const char* trans, const int* n, const int* n_rhs, const std::complex<double>* a, const int* lda,
             const int* pivots, std::complex<double>* b, const int* ldb, int* info);
void dsyevr_(const char* jobz, const char* range, const char* uplo, const int* n, double* a, const int* lda,
             const double* vl, const double* vu, const int* il, const int* iu, const double* abstol, int* m, double* w,
             double* z, const int* ldz, int* isuppz, double* work, const int* lwork, int* iwork, const int* liwork,
             int* info);
void dsytrf_(const char* uplo, const int* n, double* a, const int* lda, int* pivots, double* work, const int* n_work,
             int* info);
void dsygvx_(const int* itype, const char* jobz, const char* range, const char* uplo, const int* n, double* a,
             const int* lda, double* b, const int* ldb, const double* vl, const double* vu, const int* il,
             const int* iu, const double* abstol, int* m, double* w, double* z, const int* ldz, double* work,
             const int* lwork, int* iwork, int* ifail, int* info);
}

/// One name for both number types.
namespace klang::la {

inline void gemm(char ta, char tb, int m, int n, int k, double alpha, const double* a, int lda, const double* b,
                 int ldb, double beta, double* c, int ldc) {
  dgemm_(&ta, &tb, &m, &n, &k, &alpha, a, &lda, b, &ldb, &beta, c, &ldc);
}
inline void gemm(char ta, char tb, int m, int n, int k, std::complex<double> alpha, const std::complex<double>* a,
                 int lda, const std::complex<double>* b, int ldb, std::complex<double> beta, std::complex<double>* c,
                 int ldc) {
  zgemm_(&ta, &tb, &m, &n, &k, &alpha, a, &lda, b, &ldb, &beta, c, &ldc);
}
inline int potrf(int n, double* a) {
  int info = 0;
  dpotrf_("L", &n, a, &n, &info);
  return info;
}
inline int potrf(int n, std::complex<double>* a) {
  int info = 0;
  zpotrf_("L", &n, a, &n, &info);
  return info;
}
/// B := L^{-1} B (trans 'N') or L^{-H} B (trans 'C').
inline void solve_lower(char trans, int n, int n_columns, const double* l, double* b) {
  const double one = 1.0;
  dtrsm_("L", "L", &trans, "N", &n, &n_columns, &one, l, &n, b, &n);
}
inline void solve_lower(char trans, int n, int n_columns, const std::complex<double>* l, std::complex<double>* b) {
  const std::complex<double> one = 1.0;
  ztrsm_("L", "L", &trans, "N", &n, &n_columns, &one, l, &n, b, &n);
}
inline int gels(int m, int n, int n_rhs, double* a, double* b, double* work, int n_work) {
  int info = 0;
  dgels_("N", &m, &n, &n_rhs, a, &m, b, &m, work, &n_work, &info);
  return info;
}
inline int gels(int m, int n, int n_rhs, std::complex<double>* a, std::complex<double>* b, std::complex<double>* work,
                int n_work) {
  int info = 0;
  zgels_("N", &m, &n, &n_rhs, a, &m, b, &m, work, &n_work, &info);
  return info;
}

}  // namespace klang::la
