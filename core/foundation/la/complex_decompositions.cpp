#include "core/foundation/la/complex_decompositions.hpp"

#include <algorithm>
#include <complex>
#include <vector>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/la/lapack.hpp"

namespace klang::la {
namespace {
using Complex = std::complex<double>;

int work_size(const Complex& asked) { return std::max(1, static_cast<int>(asked.real())); }
}  // namespace

Eigen::VectorXcd eigenvalues(Eigen::MatrixXcd a) {
  if (a.rows() != a.cols()) throw InputError("eigenvalues", "the matrix is not square");
  const int n = static_cast<int>(a.rows());
  Eigen::VectorXcd values(n);
  if (n == 0) return values;
  const int one = 1;
  int info = 0, n_work = -1;
  Complex asked, none;
  std::vector<double> real_work(2 * static_cast<std::size_t>(n));
  zgeev_("N", "N", &n, a.data(), &n, values.data(), &none, &one, &none, &one, &asked, &n_work, real_work.data(), &info);
  n_work = work_size(asked);
  std::vector<Complex> work(static_cast<std::size_t>(n_work));
  zgeev_("N", "N", &n, a.data(), &n, values.data(), &none, &one, &none, &one, work.data(), &n_work, real_work.data(),
         &info);
  if (info != 0) throw NumericalError("eigenvalues of a complex matrix did not converge");
  return values;
}

SingularValues singular_values(Eigen::MatrixXcd a) {
  const int m = static_cast<int>(a.rows()), n = static_cast<int>(a.cols()), r = std::min(m, n);
  SingularValues result{Eigen::MatrixXcd(m, r), Eigen::MatrixXcd(n, r), Eigen::VectorXd(r)};
  if (r == 0) return result;
  Eigen::MatrixXcd vt(r, n);
  const auto small = static_cast<std::size_t>(r), large = static_cast<std::size_t>(std::max(m, n));
  std::vector<double> real_work(small * std::max(5 * small + 7, 2 * large + 2 * small + 1));
  std::vector<int> integer_work(8 * small);
  int info = 0, n_work = -1;
  Complex asked;
  zgesdd_("S", &m, &n, a.data(), &m, result.s.data(), result.u.data(), &m, vt.data(), &r, &asked, &n_work,
          real_work.data(), integer_work.data(), &info);
  n_work = work_size(asked);
  std::vector<Complex> work(static_cast<std::size_t>(n_work));
  zgesdd_("S", &m, &n, a.data(), &m, result.s.data(), result.u.data(), &m, vt.data(), &r, work.data(), &n_work,
          real_work.data(), integer_work.data(), &info);
  if (info != 0) throw NumericalError("singular values of a complex matrix did not converge");
  result.v = vt.adjoint();
  return result;
}

}  // namespace klang::la
