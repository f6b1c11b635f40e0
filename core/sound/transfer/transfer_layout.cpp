#include "core/sound/transfer/transfer_layout.hpp"

#include <algorithm>
#include <complex>
#include <numeric>
#include <tuple>

#include "core/foundation/base/check.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/sound/waves/spherical_harmonics.hpp"

namespace klang::acoustics {
namespace {

using Complex = std::complex<double>;

// A lane is carried to its group's order with zero coefficients; h_n must stay finite there.
bool of_like_order(int order, int group_order) { return 4 * order + 16 >= 3 * group_order; }

}  // namespace

TransferLayout::TransferLayout(const TransferModel& model) : n_modes(static_cast<int>(model.modes.size())) {
  std::vector<int> sorted(model.modes.size());
  std::iota(sorted.begin(), sorted.end(), 0);
  const auto multipole = [&](int i) -> const Multipole& { return model.modes[static_cast<std::size_t>(i)].multipole; };
  const auto place = [&](int i) {
    const Eigen::Vector3d& c = multipole(i).centre_m;
    return std::tuple(c.x(), c.y(), c.z(), multipole(i).order, multipole(i).wavenumber_per_m);
  };
  std::stable_sort(sorted.begin(), sorted.end(), [&](int a, int b) { return place(a) > place(b); });
  for (const int i : sorted) {
    const Multipole& m = multipole(i);
    KLANG_CHECK(m.coefficients_pa.size() == basis_size(m.order) && m.wavenumber_per_m > 0.0, "a multipole is whole");
    if (centres.empty() || centres.back().position_m != m.centre_m) centres.push_back({m.centre_m, m.order, {}});
    Centre& centre = centres.back();
    int lane = kModeLanes;
    if (!centre.groups.empty() && of_like_order(m.order, centre.groups.back().order)) {
      lane =
          static_cast<int>(std::find(std::begin(centre.groups.back().modes), std::end(centre.groups.back().modes), -1) -
                           std::begin(centre.groups.back().modes));
    }
    if (lane == kModeLanes) {  // orders fall, so the first of a group has its highest
      Group group;
      group.order = m.order;
      group.first_coefficient = coefficients.size();
      std::fill(std::begin(group.modes), std::end(group.modes), -1);
      std::fill(std::begin(group.wavenumbers_per_m), std::end(group.wavenumbers_per_m), m.wavenumber_per_m);
      centre.groups.push_back(group);
      coefficients.resize(coefficients.size() + 2 * static_cast<std::size_t>(basis_size(m.order)), ModeLanes{});
      lane = 0;
    }
    Group& group = centre.groups.back();
    group.modes[lane] = i;
    group.wavenumbers_per_m[lane] = m.wavenumber_per_m;
    const auto put = [&](int n, int place_m, Complex c) {
      ModeLanes* const at =
          &coefficients[group.first_coefficient + 2 * static_cast<std::size_t>(basis_index(n, place_m))];
      at[0].values[lane] = c.real();
      at[1].values[lane] = c.imag();
    };
    for (int n = 0; n <= m.order; ++n) {
      put(n, 0, m.coefficients_pa[basis_index(n, 0)]);
      for (int k = 1; k <= n; ++k) {
        // M^m Y^m + M^-m Y^-m with Y^-m = (-1)^m conj(Y^m)
        const Complex up = m.coefficients_pa[basis_index(n, k)];
        const Complex down = (k % 2 == 0 ? 1.0 : -1.0) * m.coefficients_pa[basis_index(n, -k)];
        put(n, k, up + down);
        put(n, -k, Complex(0.0, 1.0) * (up - down));
      }
    }
    highest_order = std::max(highest_order, m.order);
  }
}

void check_listeners(const TransferLayout& layout, const Eigen::Ref<const Eigen::Matrix3Xd>& listeners_m) {
  for (Eigen::Index i = 0; i < listeners_m.cols(); ++i) {
    bool good = listeners_m.col(i).allFinite();
    for (const TransferLayout::Centre& centre : layout.centres) {
      good = good && (listeners_m.col(i) - centre.position_m).norm() > 0.0;
    }
    if (!good) {
      throw InputError(
          "listener " + std::to_string(i), "must be finite and away from the centre of every mode",
          to_text(listeners_m(0, i)) + ", " + to_text(listeners_m(1, i)) + ", " + to_text(listeners_m(2, i)));
    }
  }
}

}  // namespace klang::acoustics
