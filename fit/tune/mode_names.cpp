#include "fit/tune/mode_names.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <complex>
#include <map>
#include <optional>

#include "core/foundation/base/checked_index.hpp"
#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/geometry/shapes/section.hpp"
#include "core/geometry/shapes/shape_registry.hpp"
#include "fit/tune/tune.hpp"

namespace klang::fit {
namespace {

constexpr const char* kModePlace = "tune: mode";

/// Share of a mode's motion that is cross-sections moving sideways as a whole, and the number of sign changes along the
/// body of the stronger direction. Slices are bins along the axis.
struct Flexure {
  double share = 0.0;
  int n_nodes = 0;
  int direction = 0;
};

Flexure flexure(const mesh::TetMesh& mesh, const Eigen::Ref<const Eigen::VectorXd>& shape, int axis) {
  constexpr int kSlices = 40;
  const auto coordinate = mesh.nodes_m.col(axis);
  const double low = coordinate.minCoeff(), span = coordinate.maxCoeff() - low;
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(kSlices, 3);
  Eigen::VectorXd count = Eigen::VectorXd::Zero(kSlices);
  double total = 0.0;
  for (Eigen::Index node = 0; node < mesh.nodes_m.rows(); ++node) {
    const auto slice =
        std::min<Eigen::Index>(kSlices - 1, static_cast<Eigen::Index>((coordinate[node] - low) / span * kSlices));
    const Eigen::Vector3d u = shape.segment<3>(3 * node);
    sum.row(slice) += u.transpose();
    count[slice] += 1.0;
    total += u.squaredNorm();
  }
  Flexure result;
  double best = -1.0, sideways = 0.0;
  for (int direction = 0; direction < 3; ++direction) {
    if (direction == axis) continue;
    double energy = 0.0;
    int sign = 0, changes = 0;
    const double largest = sum.col(direction).cwiseAbs().cwiseQuotient(count.cwiseMax(1.0)).maxCoeff();
    for (int slice = 0; slice < kSlices; ++slice) {
      if (count[slice] == 0.0) continue;
      const double mean = sum(slice, direction) / count[slice];
      energy += count[slice] * mean * mean;
      if (std::abs(mean) < 0.02 * largest) continue;
      const int now = mean > 0.0 ? 1 : -1;
      changes += sign != 0 && now != sign;
      sign = now;
    }
    sideways += energy;
    if (energy > best) best = energy, result.n_nodes = changes, result.direction = direction;
  }
  result.share = total > 0.0 ? sideways / total : 0.0;
  return result;
}

/// The points of the widest circle of a body of revolution by their angle: number of the node and angle [rad].
std::vector<std::pair<Eigen::Index, double>> widest_circle(const mesh::TetMesh& mesh) {
  const Eigen::VectorXd radius = mesh.nodes_m.leftCols<2>().rowwise().norm();
  Eigen::Index first = 0;
  const double widest = radius.maxCoeff(&first), tolerance = 1e-7 * widest;
  std::vector<std::pair<Eigen::Index, double>> circle;
  for (Eigen::Index node = 0; node < radius.size(); ++node)
    if (radius[node] > widest - tolerance && std::abs(mesh.nodes_m(node, 2) - mesh.nodes_m(first, 2)) < tolerance)
      circle.emplace_back(node, std::atan2(mesh.nodes_m(node, 1), mesh.nodes_m(node, 0)));
  return circle;
}

/// How often the motion goes round the circle: the harmonic of the largest power.
int harmonic_of(const std::vector<std::pair<Eigen::Index, double>>& circle,
                const Eigen::Ref<const Eigen::VectorXd>& shape) {
  int best = 0;
  double largest = -1.0;
  for (int m = 0; 2 * m < static_cast<int>(circle.size()); ++m) {
    std::array<std::complex<double>, 3> sum{};
    for (const auto& [node, angle] : circle) {
      const Eigen::Vector3d u = shape.segment<3>(3 * node);
      const double c = std::cos(angle), s = std::sin(angle);
      const std::complex<double> turn = std::polar(1.0, -m * angle);
      sum[0] += turn * (c * u.x() + s * u.y());
      sum[1] += turn * (c * u.y() - s * u.x());
      sum[2] += turn * u.z();
    }
    // A cosine of m > 0 has half its power at -m.
    const double power = (m == 0 ? 1.0 : 2.0) * (std::norm(sum[0]) + std::norm(sum[1]) + std::norm(sum[2]));
    if (power > largest) largest = power, best = m;
  }
  return best;
}

struct RingName {
  int meridians = 0, number = 1;
};

/// What bell makers call them (Perrin, Charnley and dePont 1983): (2,0), (2,1#), (3,1), (3,1#), (4,1).
std::optional<RingName> ring_name(const std::string& mode) {
  static const std::map<std::string, RingName> bell = {
      {"hum", {2, 1}}, {"prime", {2, 2}}, {"tierce", {3, 1}}, {"quint", {3, 2}}, {"nominal", {4, 1}}};
  if (const auto found = bell.find(mode); found != bell.end()) return found->second;
  if (mode.rfind("ring ", 0) != 0) return std::nullopt;
  RingName name;
  const char* end = mode.data() + mode.size();
  auto at = std::from_chars(mode.data() + 5, end, name.meridians);
  if (at.ec == std::errc{} && at.ptr != end && *at.ptr == ',') at = std::from_chars(at.ptr + 1, end, name.number);
  if (at.ec != std::errc{} || at.ptr != end || name.meridians < 0 || name.number < 1)
    throw InputError(kModePlace, "unknown mode", mode, "\"ring M\" or \"ring M,K\": the K-th with M nodal diameters");
  return name;
}

int ring_mode(const std::string& mode, const RingName& name, const mesh::ShapeSpec& shape,
              const modal::ModalModel& model) {
  if (!mesh::is_axisymmetric(shape))
    throw InputError(kModePlace, "a mode that only bodies of revolution have", mode, "an index, or bending N");
  const auto circle = widest_circle(model.mesh);
  int found = 0;
  for (Eigen::Index k = 0; k < model.n_modes(); ++k) {
    if (harmonic_of(circle, model.shapes.col(k)) != name.meridians) continue;
    // Two of each, but for m = 0.
    const int number = name.meridians == 0 ? found + 1 : found / 2 + 1;
    ++found;
    if (number == name.number) return static_cast<int>(k);
  }
  throw InputError(kModePlace, "no such mode among the computed ones", mode,
                   "up to " + to_text(model.frequency_hz().maxCoeff()) + " Hz");
}

}  // namespace

std::vector<std::vector<int>> bending_modes(const mesh::ShapeSpec& shape, const modal::ModalModel& model) {
  const auto axis = mesh::find_shape(shape.kind).long_axis(shape);
  std::vector<std::vector<int>> families;
  if (!axis) return families;
  // A flat bar has two families of its own: n counts within the direction of the lowest flexural mode; a tube's pair
  // turns freely in the plane, so that both members count.
  int direction = -1;
  for (Eigen::Index k = 0; k < model.n_modes(); ++k) {
    const Flexure f = flexure(model.mesh, model.shapes.col(k), axis->axis);
    if (f.share < 0.5 || f.n_nodes < 2) continue;
    if (direction < 0) direction = f.direction;
    if (!axis->round && f.direction != direction) continue;
    const auto n = static_cast<std::size_t>(f.n_nodes - 1);
    if (n > families.size() + 1) continue;
    if (families.size() < n) families.resize(n);
    auto& family = families[n - 1];
    const bool partner =
        family.empty() || cents(model.angular_frequency_rad_s[k], model.angular_frequency_rad_s[family.front()]) < 5.0;
    if (partner) family.push_back(static_cast<int>(k));
  }
  return families;
}

int named_mode(const std::string& mode, const mesh::ShapeSpec& shape, const modal::ModalModel& model) {
  if (mode.rfind("bending ", 0) == 0) {
    int n = 0;
    std::from_chars(mode.data() + 8, mode.data() + mode.size(), n);
    const auto families = bending_modes(shape, model);
    if (n >= 1 && n <= static_cast<int>(families.size()) && !item(families, n - 1).empty()) {
      return item(families, n - 1).front();
    }
    throw InputError(kModePlace, "no such bending mode among the computed ones", mode,
                     "bending 1 to bending " + std::to_string(families.size()));
  }
  if (const auto ring = ring_name(mode)) return ring_mode(mode, *ring, shape, model);
  int index = -1;
  const auto end = std::from_chars(mode.data(), mode.data() + mode.size(), index);
  if (end.ec != std::errc{} || end.ptr != mode.data() + mode.size() || index < 0 || index >= model.n_modes()) {
    throw InputError(
        kModePlace, "unknown mode", mode,
        "0 to " + std::to_string(model.n_modes() - 1) + ", bending N, ring M,K, hum, prime, tierce, quint, nominal");
  }
  return index;
}

}  // namespace klang::fit
