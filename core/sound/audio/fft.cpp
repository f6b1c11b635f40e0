#include "core/sound/audio/fft.hpp"

#include <fftw3.h>

#include <map>
#include <mutex>
#include <utility>

#include "core/foundation/base/check.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/output_file.hpp"

namespace klang::audio {
namespace {

enum class Kind { kRealForward, kRealInverse, kComplexInverse };

fftw_complex* as_fftw(std::complex<double>* p) { return reinterpret_cast<fftw_complex*>(p); }

/// All plans of the process. FFTW executes a plan from any thread; only planning is serialised.
class Plans {
 public:
  fftw_plan get(Kind kind, int n) {
    const std::lock_guard lock(mutex_);
    fftw_plan& plan = plans_[{kind, n}];
    if (plan == nullptr) plan = make(kind, n);
    KLANG_CHECK(plan != nullptr, "FFTW could not plan");
    return plan;
  }

  void use_wisdom(const std::filesystem::path& file) {
    const std::lock_guard lock(mutex_);
    if (std::filesystem::exists(file) && fftw_import_wisdom_from_string(read_file(file, 1 << 24).c_str()) == 0) {
      throw InputError(file.string(), "is not FFTW wisdom");
    }
    wisdom_file_ = file;
  }

  void save_wisdom() {
    const std::lock_guard lock(mutex_);
    if (wisdom_file_.empty()) return;
    char* text = fftw_export_wisdom_to_string();
    const std::string bytes = text;
    fftw_free(text);
    std::error_code ignored;
    std::filesystem::create_directories(wisdom_file_.parent_path(), ignored);
    write_file(wisdom_file_, bytes);
  }

 private:
  fftw_plan make(Kind kind, int n) const {
    const unsigned flags = (wisdom_file_.empty() ? FFTW_ESTIMATE : FFTW_MEASURE) | FFTW_UNALIGNED;
    Eigen::VectorXd real(n);
    Eigen::VectorXcd a(n), b(n);
    switch (kind) {
      case Kind::kRealForward:
        return fftw_plan_dft_r2c_1d(n, real.data(), as_fftw(a.data()), flags | FFTW_PRESERVE_INPUT);
      case Kind::kRealInverse:
        return fftw_plan_dft_c2r_1d(n, as_fftw(a.data()), real.data(), flags);
      case Kind::kComplexInverse:
        return fftw_plan_dft_1d(n, as_fftw(a.data()), as_fftw(b.data()), FFTW_BACKWARD, flags | FFTW_PRESERVE_INPUT);
    }
    return nullptr;
  }

  std::mutex mutex_;
  std::map<std::pair<Kind, int>, fftw_plan> plans_;
  std::filesystem::path wisdom_file_;
};

Plans& plans() {
  static Plans instance;
  return instance;
}

bool is_good(Eigen::Index n) {
  for (const Eigen::Index prime : {2, 3, 5}) {
    while (n % prime == 0) n /= prime;
  }
  return n == 1;
}

}  // namespace

Eigen::Index good_fft_size(Eigen::Index n) {
  KLANG_CHECK(n >= 1 && n <= (Eigen::Index{1} << 30), "size out of range");
  while (!is_good(n)) ++n;
  return n;
}

Eigen::Index good_fft_size_below(Eigen::Index n) {
  KLANG_CHECK(n >= 1, "size out of range");
  while (!is_good(n)) --n;
  return n;
}

Eigen::VectorXcd real_spectrum(const Eigen::Ref<const Eigen::VectorXd>& x, Eigen::Index n_fft) {
  const fftw_plan plan = plans().get(Kind::kRealForward, static_cast<int>(n_fft));
  Eigen::VectorXcd spectrum(n_fft / 2 + 1);
  if (x.size() >= n_fft) {
    fftw_execute_dft_r2c(plan, const_cast<double*>(x.data()),
                         as_fftw(spectrum.data()));  // input is preserved
  } else {
    Eigen::VectorXd padded = Eigen::VectorXd::Zero(n_fft);
    padded.head(x.size()) = x;
    fftw_execute_dft_r2c(plan, padded.data(), as_fftw(spectrum.data()));
  }
  return spectrum;
}

Eigen::VectorXd real_from_spectrum(const Eigen::VectorXcd& spectrum, Eigen::Index n_fft) {
  KLANG_CHECK(spectrum.size() == n_fft / 2 + 1, "spectrum has the wrong size");
  const fftw_plan plan = plans().get(Kind::kRealInverse, static_cast<int>(n_fft));
  Eigen::VectorXcd scratch = spectrum / static_cast<double>(n_fft);  // c2r overwrites its input
  Eigen::VectorXd x(n_fft);
  fftw_execute_dft_c2r(plan, as_fftw(scratch.data()), x.data());
  return x;
}

Eigen::VectorXcd complex_from_spectrum(const Eigen::VectorXcd& spectrum) {
  const fftw_plan plan = plans().get(Kind::kComplexInverse, static_cast<int>(spectrum.size()));
  Eigen::VectorXcd x(spectrum.size());
  fftw_execute_dft(plan, const_cast<fftw_complex*>(reinterpret_cast<const fftw_complex*>(spectrum.data())),
                   as_fftw(x.data()));
  return x / static_cast<double>(spectrum.size());
}

void use_fft_wisdom(const std::filesystem::path& file) { plans().use_wisdom(file); }
void save_fft_wisdom() { plans().save_wisdom(); }

}  // namespace klang::audio
