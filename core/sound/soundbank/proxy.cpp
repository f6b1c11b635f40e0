#include "core/sound/soundbank/proxy.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <nanoflann.hpp>

#include "core/foundation/base/check.hpp"
#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/sound/waves/multipole_transforms.hpp"

namespace klang::soundbank {
namespace {

std::string text_of(const Eigen::Vector3d& v) { return to_text(v[0]) + ", " + to_text(v[1]) + ", " + to_text(v[2]); }

struct Points {
  std::vector<Eigen::Vector3d> list;
  std::size_t kdtree_get_point_count() const { return list.size(); }
  double kdtree_get_pt(std::size_t i, std::size_t axis) const { return list[i][static_cast<Eigen::Index>(axis)]; }
  template <class Box>
  bool kdtree_get_bbox(Box&) const {
    return false;
  }
};
using KdTree = nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<double, Points>, Points, 3>;

}  // namespace

Eigen::Vector3d axes_of_moments(const Eigen::Vector3d& moments) {
  Eigen::Vector3d i = moments;
  if (!i.allFinite() || !(i.minCoeff() > 0.0))
    throw InputError("inertia", "moments must be positive and finite", text_of(moments));
  if (i[0] < i[1]) std::swap(i[0], i[1]);
  if (i[1] < i[2]) std::swap(i[1], i[2]);
  if (i[0] < i[1]) std::swap(i[0], i[1]);
  const double sum = i.sum();
  // Flat bodies lie on the border; a body whose moments come from a mesh may miss it by rounding.
  const double thin = i[1] + i[2] - i[0];
  if (!(thin >= -1e-9 * sum))
    throw InputError("inertia", "no body has these moments", text_of(moments),
                     "the largest at most the sum of the others");
  return Eigen::Vector3d(std::sqrt(std::max(thin, 0.0)), std::sqrt(i[0] - i[1] + i[2]), std::sqrt(i[0] + i[1] - i[2])) /
         std::sqrt(sum);
}

PrincipalFrame principal_frame(const Eigen::Matrix3d& inertia) {
  if (!inertia.allFinite() || !((inertia - inertia.transpose()).norm() <= 1e-9 * inertia.norm()))
    throw InputError("inertia", "the matrix must be symmetric and finite");
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(inertia);
  PrincipalFrame frame;
  frame.moments = solver.eigenvalues().reverse();
  if (!(frame.moments[2] > 0.0)) throw InputError("inertia", "moments must be positive", text_of(frame.moments));
  for (int d = 0; d < 3; ++d) frame.rotation.row(d) = solver.eigenvectors().col(2 - d).transpose();
  if (frame.rotation.determinant() < 0.0) frame.rotation.row(2) *= -1.0;
  return frame;
}

Eigen::Vector3d point_of_normal(const Eigen::Vector3d& axes, const Eigen::Vector3d& normal) {
  const Eigen::Vector3d stretched = axes.cwiseProduct(normal);
  return axes.cwiseProduct(stretched) / stretched.norm();
}

Eigen::Vector3d point_of_place(const Eigen::Vector3d& axes, const Eigen::Vector3d& r_m, const Eigen::Vector3d& moments,
                               double volume_m3) {
  // int x^2 dV = a^2 V / 5 for an ellipsoid, and half the sum of the other two moments less the own one for any body.
  const Eigen::Vector3d semi = axes_of_moments(moments) * std::sqrt(2.5 * moments.sum() / volume_m3);
  const Eigen::Vector3d xi = r_m.cwiseQuotient(semi.cwiseMax(1e-9 * semi.maxCoeff()));
  const double length = xi.norm();
  if (!(length > 0.0)) {
    Eigen::Index longest = 0;
    const double end = axes.maxCoeff(&longest);
    return end * Eigen::Vector3d::Unit(longest);
  }
  return axes.cwiseProduct(xi) / length;
}

struct ProxyFinder::Tree {
  Points points;
  std::unique_ptr<KdTree> index;
};

ProxyFinder::ProxyFinder(const Soundbank& bank) : bank_(bank) {
  KLANG_CHECK(!bank.cells.empty(), "a bank with cells");
  auto tree = std::make_unique<Tree>();
  for (const Cell& cell : bank.cells) tree->points.list.push_back(unit_axes(cell.shape));
  tree->index = std::make_unique<KdTree>(3, tree->points, nanoflann::KDTreeSingleIndexAdaptorParams(8));
  tree->index->buildIndex();
  tree_ = std::move(tree);
}

ProxyFinder::~ProxyFinder() = default;

int ProxyFinder::nearest_cell(const Eigen::Vector3d& axes, double& distance) const {
  std::size_t index = 0;
  double square = 0.0;
  nanoflann::KNNResultSet<double> result(1);
  result.init(&index, &square);
  tree_->index->findNeighbors(result, axes.data(), nanoflann::SearchParams());
  distance = std::sqrt(square);
  return static_cast<int>(index);
}

Proxy ProxyFinder::of_axes(const Eigen::Vector3d& axes, double lowest_frequency_hz, double shear_speed_m_s) const {
  checked_open("proxy", "lowest_frequency_hz", lowest_frequency_hz, 0.0, 1e9);
  const double speed = shear_speed_m_s > 0.0 ? shear_speed_m_s : bank_.material.shear_speed_m_s();
  const double depth = -std::log(bank_.thinnest);
  ShapePoint shape{-depth, -depth};
  const double longest = axes.maxCoeff();
  Eigen::Vector3d sorted = axes;
  std::sort(sorted.begin(), sorted.end());
  Proxy proxy;
  shape.u = sorted[0] > 0.0 ? std::log(sorted[0] / longest) : -HUGE_VAL;
  shape.v = sorted[1] > 0.0 ? std::log(sorted[1] / longest) : -HUGE_VAL;
  proxy.place = locate(bank_, shape);
  proxy.clamped = proxy.place.clamped;
  if (proxy.clamped) {
    shape.u = -depth;
    shape.v = std::clamp(shape.v, -depth, 0.0);
  }
  proxy.axes = unit_axes(shape);
  proxy.scale = lowest_frequency(bank_, proxy.place) * speed / (2.0 * kPi * lowest_frequency_hz);
  proxy.cell = nearest_cell(proxy.axes, proxy.cell_distance);
  return proxy;
}

Proxy ProxyFinder::find(const Eigen::Vector3d& moments, double lowest_frequency_hz, double shear_speed_m_s) const {
  return of_axes(axes_of_moments(moments), lowest_frequency_hz, shear_speed_m_s);
}

Eigen::VectorXd proxy_frequencies_hz(const Soundbank& bank, const Proxy& proxy, int count, double shear_speed_m_s) {
  const ClassFrequencies frequencies = interpolated_frequencies(bank, proxy.place);
  const double speed = shear_speed_m_s > 0.0 ? shear_speed_m_s : bank.material.shear_speed_m_s();
  const std::vector<ModeId> ids = lowest_modes(frequencies, count);
  Eigen::VectorXd hz(static_cast<Eigen::Index>(ids.size()));
  for (std::size_t i = 0; i < ids.size(); ++i)
    hz[static_cast<Eigen::Index>(i)] = frequencies[ids[i].mode_class][ids[i].index] * speed / (2.0 * kPi * proxy.scale);
  return hz;
}

EllipsoidModes cell_modes(const Soundbank& bank, int cell, double scale) {
  const Cell& from = bank.cells.at(static_cast<std::size_t>(cell));
  std::array<Eigen::VectorXd, kModeClasses> omega;
  std::array<Eigen::MatrixXd, kModeClasses> coefficients;
  for (const CellMode& mode : from.modes) {  // ascending: a class's modes come in order
    Eigen::VectorXd& w = omega[mode.id.mode_class];
    Eigen::MatrixXd& c = coefficients[mode.id.mode_class];
    w.conservativeResize(w.size() + 1);
    w[w.size() - 1] = mode.angular_frequency_rad_s / scale;
    c.conservativeResize(mode.coefficients.size(), w.size());
    c.col(w.size() - 1) = mode.coefficients.cast<double>() * std::pow(scale, -1.5);
  }
  return EllipsoidModes(scale * unit_axes(from.shape), bank.degree, std::move(omega), std::move(coefficients));
}

acoustics::TransferModel cell_transfer(const Soundbank& bank, int cell, double scale) {
  const Cell& from = bank.cells.at(static_cast<std::size_t>(cell));
  acoustics::TransferModel model{bank.medium, {}};
  for (std::size_t i = 0; i < from.modes.size(); ++i) {
    const CellMode& mode = from.modes[i];
    if (mode.packed_pa.empty()) continue;
    acoustics::ModeTransfer transfer;
    transfer.mode = static_cast<int>(i);
    transfer.frequency_hz = mode.angular_frequency_rad_s / (2.0 * kPi);
    transfer.multipole.wavenumber_per_m = mode.angular_frequency_rad_s / bank.medium.sound_speed_m_s;
    transfer.multipole.order = mode.order;
    transfer.multipole.coefficients_pa = unpacked_multipole(mode.packed_pa, mode.order, mode.id.mode_class);
    transfer.radiated_power_w = transfer.decay_radiation_per_s = mode.radiated_power_w;
    transfer.kept_power_fraction = mode.kept_power_fraction;
    transfer.residual = mode.boundary_error;
    model.modes.push_back(std::move(transfer));
  }
  return acoustics::with_size_factor(model, scale);
}

}  // namespace klang::soundbank
