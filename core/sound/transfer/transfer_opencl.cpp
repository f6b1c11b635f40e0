#include "core/sound/transfer/transfer_opencl.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <map>
#include <mutex>

#include "core/foundation/base/check.hpp"
#include "core/foundation/base/errors.hpp"
#include "transfer_kernels_cl.hpp"

namespace klang::acoustics {
namespace {

using opencl::Buffer;
using opencl::two_parts;
using Complex = std::complex<double>;

constexpr long double kTwoPi = 6.283185307179586476925286766559005768L;

}  // namespace

struct OpenClTransfer::State {
  State(const std::string& choice, Precision precision, const TransferModel& model)
      : session(kTransferKernelsSource, choice, precision), layout(model) {}

  opencl::Session session;
  const TransferLayout layout;  // for check_listeners
  std::mutex mutex;
  // Of the model, on the device.
  Buffer order, centre_of_mode, first_degree, first_coefficient, degree, order_of_centre, first_harmonic, turns,
      coefficients, diagonal, by_z, by_previous;
  // Of the listeners, for n_slots_held of them.
  Buffer distance, direction, h, sectoral, y, p;
  int n_listeners_held = 0, listeners_a_time = 1;
  int n_modes = 0, n_centres = 0, n_degrees = 0, n_harmonics = 0, largest_order = 0;
  std::vector<Eigen::Vector3d> centres;

  template <typename Real>
  void upload_model(const TransferModel& model);
  template <typename Real>
  void hold(int n_listeners);
  template <typename Real>
  void run(const Eigen::Ref<const Eigen::Matrix3Xd>& listeners, Eigen::Index first, int count,
           Eigen::MatrixXcd& pressures);
};

template <typename Real>
void OpenClTransfer::State::upload_model(const TransferModel& model) {
  n_modes = static_cast<int>(model.modes.size());
  std::vector<int> orders, centre_index, degrees_at, coefficients_at, centre_orders, harmonics_at;
  std::vector<std::array<Real, 2>> turns_per_m, c;
  for (const ModeTransfer& mode : model.modes) {
    const Multipole& m = mode.multipole;
    auto found = std::find(centres.begin(), centres.end(), m.centre_m);
    if (found == centres.end()) {
      centres.push_back(m.centre_m);
      centre_orders.push_back(0);
      found = centres.end() - 1;
    }
    const auto centre = static_cast<int>(found - centres.begin());
    int& centre_order = centre_orders[static_cast<std::size_t>(centre)];
    centre_order = std::max(centre_order, m.order);
    orders.push_back(m.order);
    centre_index.push_back(centre);
    degrees_at.push_back(n_degrees);
    n_degrees += m.order + 1;
    largest_order = std::max(largest_order, m.order);
    turns_per_m.push_back(two_parts<Real>(m.wavenumber_per_m / kTwoPi));
    coefficients_at.push_back(static_cast<int>(c.size()));
    c.resize(c.size() + static_cast<std::size_t>(basis_size(m.order)));
    const auto put = [&](int n, int place, Complex value) {
      c[static_cast<std::size_t>(coefficients_at.back() + basis_index(n, place))] = {static_cast<Real>(value.real()),
                                                                                     static_cast<Real>(value.imag())};
    };
    for (int n = 0; n <= m.order; ++n) {
      put(n, 0, m.coefficients_pa[basis_index(n, 0)]);
      for (int k = 1; k <= n; ++k) {  // as in TransferLayout
        const Complex up = m.coefficients_pa[basis_index(n, k)];
        const Complex down = (k % 2 == 0 ? 1.0 : -1.0) * m.coefficients_pa[basis_index(n, -k)];
        put(n, k, up + down);
        put(n, -k, Complex(0.0, 1.0) * (up - down));
      }
    }
  }
  n_centres = static_cast<int>(centres.size());
  for (const int n : centre_orders) {
    harmonics_at.push_back(n_harmonics);
    n_harmonics += static_cast<int>(basis_size(n));
  }
  std::vector<int> degree_of;
  for (int n = 0; n <= largest_order; ++n) degree_of.insert(degree_of.end(), static_cast<std::size_t>(2 * n + 1), n);
  const SphericalHarmonics tables(largest_order);
  const auto to_real = [](const std::vector<double>& values) {
    return std::vector<Real>(values.begin(), values.end());
  };
  order = session.upload(orders);
  centre_of_mode = session.upload(centre_index);
  first_degree = session.upload(degrees_at);
  first_coefficient = session.upload(coefficients_at);
  degree = session.upload(degree_of);
  order_of_centre = session.upload(centre_orders);
  first_harmonic = session.upload(harmonics_at);
  turns = session.upload(turns_per_m);
  coefficients = session.upload(c);
  diagonal = session.upload(to_real(tables.diagonal()));
  const auto to_parts = [](const std::vector<double>& values) {
    std::vector<std::array<Real, 2>> parts;
    for (const double value : values) parts.push_back(two_parts<Real>(value));
    return parts;
  };
  by_z = session.upload(to_parts(tables.by_z()));
  by_previous = session.upload(to_parts(tables.by_previous()));
  // At most 128 MB of what the passes hand on, and at most 4096 listeners at a time.
  const double bytes_each = sizeof(Real) * (2.0 * n_degrees + n_harmonics + 2.0 * n_centres * (largest_order + 1.0) +
                                            8.0 * n_centres + 2.0 * n_modes);
  listeners_a_time = static_cast<int>(std::clamp(128e6 / bytes_each, 1.0, 4096.0));
}

template <typename Real>
void OpenClTransfer::State::hold(int n_listeners) {
  if (n_listeners <= n_listeners_held) return;
  const auto n = static_cast<std::size_t>(n_listeners) * sizeof(Real);
  const auto count = [](int value) { return static_cast<std::size_t>(std::max(1, value)); };
  distance = session.buffer(2 * n * count(n_centres));
  direction = session.buffer(6 * n * count(n_centres));
  h = session.buffer(2 * n * count(n_degrees));
  sectoral = session.buffer(2 * n * count(n_centres) * count(largest_order + 1));
  y = session.buffer(n * count(n_harmonics));
  p = session.buffer(2 * n * count(n_modes));
  n_listeners_held = n_listeners;
}

template <typename Real>
void OpenClTransfer::State::run(const Eigen::Ref<const Eigen::Matrix3Xd>& listeners, Eigen::Index first, int count,
                                Eigen::MatrixXcd& pressures) {
  hold<Real>(count);
  std::vector<std::array<Real, 2>> distances;
  std::vector<std::array<Real, 2>> directions;
  for (Eigen::Index l = first; l < first + count; ++l) {
    for (const Eigen::Vector3d& centre : centres) {
      const Eigen::Vector3d r = listeners.col(l) - centre;
      const double length = r.norm();
      distances.push_back(two_parts<Real>(length));
      for (int axis = 0; axis < 3; ++axis) directions.push_back(two_parts<Real>(r[axis] / length));
    }
  }
  session.write(distance, distances.data(), distances.size() * sizeof distances[0]);
  session.write(direction, directions.data(), directions.size() * sizeof directions[0]);
  const std::array<Real, 2> two_pi = two_parts<Real>(kTwoPi);
  const auto n_l = static_cast<std::size_t>(count), n_m = static_cast<std::size_t>(n_modes),
             n_c = static_cast<std::size_t>(n_centres);
  session.run("hankel", {n_m, n_l}, nullptr, order, centre_of_mode, first_degree, n_degrees, n_centres, two_pi[0],
              two_pi[1], turns, distance, h);
  session.run("sectoral_harmonics", {n_c, n_l}, nullptr, order_of_centre, n_centres, largest_order, diagonal, direction,
              sectoral);
  session.run("harmonics", {static_cast<std::size_t>(largest_order) + 1, n_c, n_l}, nullptr, order_of_centre,
              first_harmonic, n_harmonics, n_centres, largest_order, by_z, by_previous, direction, sectoral, y);
  const std::size_t group[2] = {session.group(), 1};
  session.run("reduction", {n_m * group[0], n_l}, group, order, centre_of_mode, first_degree, first_harmonic,
              first_coefficient, degree, n_degrees, n_harmonics, n_modes, coefficients, h, y, p);
  std::vector<std::complex<Real>> result(n_m * n_l);
  session.read(p, result.data(), result.size() * sizeof result[0]);
  pressures.middleCols(first, count) =
      Eigen::Map<const Eigen::Matrix<std::complex<Real>, Eigen::Dynamic, Eigen::Dynamic>>(result.data(), n_modes, count)
          .template cast<Complex>();
}

OpenClTransfer::OpenClTransfer(const TransferModel& model, const std::string& choice, Precision precision)
    : state_(new State(choice, precision, model)) {
  precision == Precision::kDouble ? state_->upload_model<double>(model) : state_->upload_model<float>(model);
}

OpenClTransfer::~OpenClTransfer() = default;
const opencl::Device& OpenClTransfer::device() const { return state_->session.device(); }

void OpenClTransfer::evaluate(const Eigen::Ref<const Eigen::Matrix3Xd>& listeners_m, Eigen::MatrixXcd& pressures_pa) {
  check_listeners(state_->layout, listeners_m);
  pressures_pa.resize(state_->n_modes, listeners_m.cols());
  if (pressures_pa.size() == 0) return;
  const std::lock_guard lock(state_->mutex);  // kernel arguments and buffers are the object's
  for (Eigen::Index first = 0; first < listeners_m.cols(); first += state_->listeners_a_time) {
    const int count = static_cast<int>(std::min<Eigen::Index>(state_->listeners_a_time, listeners_m.cols() - first));
    if (state_->session.precision() == Precision::kDouble) {
      state_->run<double>(listeners_m, first, count, pressures_pa);
    } else {
      state_->run<float>(listeners_m, first, count, pressures_pa);
    }
  }
}

AnyTransferEvaluator::AnyTransferEvaluator(const TransferModel& model, const opencl::DeviceChoice& where) {
  if (where.used) {
    try {
      device_ = std::make_unique<OpenClTransfer>(model, where.device, where.precision);
      device_name_ = device_->device().name;
      return;
    } catch (const opencl::Error& error) {
      message_ = std::string(error.what()) + "; transfer is evaluated on the processor";
    }
  }
  processor_ = std::make_unique<TransferEvaluator>(model);
}

void AnyTransferEvaluator::evaluate(const Eigen::Ref<const Eigen::Matrix3Xd>& listeners_m,
                                    Eigen::MatrixXcd& pressures_pa) {
  if (device_ != nullptr) {
    device_->evaluate(listeners_m, pressures_pa);
  } else {
    processor_->evaluate(listeners_m, pressures_pa);
  }
}

}  // namespace klang::acoustics
