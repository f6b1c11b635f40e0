#include "core/sound/transfer/transfer_evaluation.hpp"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/parallel.hpp"
#include "core/sound/transfer/detail/transfer_kernel.hpp"

namespace klang::acoustics {
namespace {

using detail::kListeners;

// Scratch of one thread, grown once.
double* scratch(std::size_t n) {
  thread_local std::vector<double> buffer;
  if (buffer.size() < n) buffer.resize(n);
  return buffer.data();
}

struct Slice {
  const TransferLayout::Centre* centre;
  std::size_t begin, end;  // groups
};

}  // namespace

TransferEvaluator::TransferEvaluator(const TransferModel& model) : layout_(model), harmonics_(layout_.highest_order) {}

void TransferEvaluator::evaluate(const Eigen::Ref<const Eigen::Matrix3Xd>& listeners_m,
                                 Eigen::MatrixXcd& pressures_pa) const {
  check_listeners(layout_, listeners_m);
  const Eigen::Index n_listeners = listeners_m.cols();
  pressures_pa.resize(layout_.n_modes, n_listeners);
  if (n_listeners == 0 || layout_.n_modes == 0) return;
  const auto n_blocks = static_cast<std::size_t>((n_listeners + kListeners - 1) / kListeners);

  const auto run = [&](std::size_t block, const Slice& slice) {
    const TransferLayout::Centre& centre = *slice.centre;
    const auto n_basis = static_cast<std::size_t>(basis_size(centre.order));
    const Eigen::Index first = static_cast<Eigen::Index>(block) * kListeners;
    const int count = static_cast<int>(std::min<Eigen::Index>(kListeners, n_listeners - first));
    const int width = count == 1 ? 1 : kListeners;  // missing ones repeat the last
    double* const harmonics =
        scratch(static_cast<std::size_t>(width) * (n_basis + 4 * static_cast<std::size_t>(centre.order + 1)));
    double directions[3 * kListeners], distances[kListeners];
    for (int l = 0; l < width; ++l) {
      const Eigen::Vector3d r = listeners_m.col(first + std::min(l, count - 1)) - centre.position_m;
      distances[l] = r.norm();
      for (int axis = 0; axis < 3; ++axis) directions[axis * width + l] = r[axis] / distances[l];
    }
    detail::real_harmonics(centre.order, width, harmonics_.diagonal().data(), harmonics_.by_z().data(),
                           harmonics_.by_previous().data(), directions,
                           harmonics + static_cast<std::size_t>(width) * n_basis, harmonics);
    for (std::size_t g = slice.begin; g < slice.end; ++g) {
      const TransferLayout::Group& group = centre.groups[g];
      double start[3 * kModeLanes * kListeners], out[2 * kModeLanes * kListeners];
      for (int l = 0; l < count; ++l) {
        double* const s = start + 3 * kModeLanes * l;
        for (int lane = 0; lane < kModeLanes; ++lane) {
          // h_0 = i e^{-ix} / x; what the product x loses is a phase error of 1e-12 at kr = 10^4.
          const double k = group.wavenumbers_per_m[lane], x = k * distances[l], rest = std::fma(k, distances[l], -x);
          const double sine = std::sin(x), cosine = std::cos(x);
          s[lane] = 1.0 / x;
          s[kModeLanes + lane] = (sine + rest * cosine) / x;
          s[2 * kModeLanes + lane] = (cosine - rest * sine) / x;
        }
      }
      detail::group_pressures(group.order, count, layout_.coefficients.data() + group.first_coefficient, harmonics,
                              start, out);
      for (int l = 0; l < count; ++l) {
        for (int lane = 0; lane < kModeLanes && group.modes[lane] >= 0; ++lane) {
          pressures_pa(group.modes[lane], first + l) = {out[2 * kModeLanes * l + lane],
                                                        out[2 * kModeLanes * l + kModeLanes + lane]};
        }
      }
    }
  };

  // Little work is done before threads would have started. One listener of many modes is shared out by groups; each share
  // makes the harmonics anew, which costs less than handing them over.
  constexpr double kSerialOperations = 4e5;
  const bool serial =
      thread_count() == 1 || operations_per_listener() * static_cast<double>(n_listeners) < kSerialOperations;
  if (serial) {
    for (std::size_t block = 0; block < n_blocks; ++block) {
      for (const TransferLayout::Centre& centre : layout_.centres) run(block, {&centre, 0, centre.groups.size()});
    }
    return;
  }
  const auto n_shares = static_cast<std::size_t>(thread_count());
  const bool split = n_blocks * layout_.centres.size() < 4 * n_shares;
  std::vector<Slice> slices;
  for (const TransferLayout::Centre& centre : layout_.centres) {
    const std::size_t n_groups = centre.groups.size(), shares = split ? std::min(n_groups, n_shares) : 1;
    std::vector<double> work(n_groups + 1, 0.0);
    for (std::size_t g = 0; g < n_groups; ++g)
      work[g + 1] = work[g] + static_cast<double>(basis_size(centre.groups[g].order));
    std::size_t begin = 0;
    for (std::size_t s = 1; s <= shares; ++s) {
      std::size_t end = begin;
      while (end < n_groups && work[end] < work[n_groups] * static_cast<double>(s) / static_cast<double>(shares)) ++end;
      if (end > begin) slices.push_back({&centre, begin, end});
      begin = end;
    }
  }
  parallel_for(n_blocks * slices.size(), split ? 1 : 4, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) run(i / slices.size(), slices[i % slices.size()]);
  });
}

double TransferEvaluator::operations_per_listener() const {
  double operations = 0.0;
  for (const TransferLayout::Centre& centre : layout_.centres) {
    operations += 3.0 * static_cast<double>(basis_size(centre.order));  // recurrence and two products for each m >= 0
    for (const TransferLayout::Group& group : centre.groups) {
      const auto n_used = std::count_if(std::begin(group.modes), std::end(group.modes), [](int m) { return m >= 0; });
      // 2 multiplications and 2 additions a coefficient; 13 for each degree (sum over degrees, recurrence)
      operations +=
          static_cast<double>(n_used) * (4.0 * static_cast<double>(basis_size(group.order)) + 13.0 * (group.order + 1));
    }
  }
  return operations;
}

}  // namespace klang::acoustics
