#include "reports/pages/shape_view.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <nlohmann/json.hpp>

#include "core/foundation/base/errors.hpp"
#include "core/geometry/mesh/surface_decimation.hpp"
#include "reports/kit/raster.hpp"
#include "reports/kit/text.hpp"
#include "reports/pages/page_parts.hpp"

namespace klang::reports::detail {
namespace {

using nlohmann::json;

constexpr double kLongBody = 3.0, kTwinRatio = 1.0003;
constexpr std::size_t kMostModes = 12;
constexpr int kMostTriangles = 15000, kFewestTriangles = 2000;

std::string ordinal(int n) {
  const int last = n % 10, tens = n / 10 % 10;
  return std::to_string(n) + (tens == 1 ? "th" : last == 1 ? "st" : last == 2 ? "nd" : last == 3 ? "rd" : "th");
}

/// A mode as the motion of cross-sections: shares of its mean squared motion, and sign changes along the body.
struct SectionMotion {
  double bending[2] = {0, 0}, torsion = 0, along = 0;
  int bending_nodes[2] = {0, 0}, torsion_nodes = 0, along_nodes = 0;
};

int sign_changes(const Eigen::Ref<const Eigen::VectorXd>& values) {
  const double least = 0.03 * values.cwiseAbs().maxCoeff();
  int sign = 0, changes = 0;
  for (const double value : values) {
    if (std::abs(value) <= least) continue;
    const int now = value > 0 ? 1 : -1;
    changes += sign != 0 && now != sign;
    sign = now;
  }
  return changes;
}

/// @param axes  columns: along, then two across
SectionMotion section_motion(const Eigen::MatrixXd& places, const Eigen::Ref<const Eigen::VectorXd>& shape,
                             const Eigen::Matrix3d& axes) {
  constexpr int kSlices = 40;
  const Eigen::VectorXd s = places.col(0);
  const double low = s.minCoeff(), span = s.maxCoeff() - low;
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(kSlices, 4);  // along, across, across, moment
  Eigen::VectorXd count = Eigen::VectorXd::Zero(kSlices), inertia = Eigen::VectorXd::Zero(kSlices);
  double total = 0;
  for (Eigen::Index i = 0; i < places.rows(); ++i) {
    const auto k = std::min<Eigen::Index>(kSlices - 1, static_cast<Eigen::Index>((s[i] - low) / span * kSlices));
    const Eigen::Vector3d u = axes.transpose() * shape.segment<3>(3 * i);
    sum.row(k).head<3>() += u.transpose();
    sum(k, 3) += places(i, 1) * u[2] - places(i, 2) * u[1];
    inertia[k] += places(i, 1) * places(i, 1) + places(i, 2) * places(i, 2);
    count[k] += 1;
    total += u.squaredNorm();
  }
  const Eigen::VectorXd n = count.cwiseMax(1.0);
  SectionMotion motion;
  const auto energy = [&](int column) { return sum.col(column).cwiseAbs2().cwiseQuotient(n).sum() / total; };
  const auto nodes = [&](int column) { return sign_changes(sum.col(column).cwiseQuotient(n)); };
  motion.along = energy(0);
  motion.along_nodes = nodes(0);
  for (int d = 0; d < 2; ++d) motion.bending[d] = energy(1 + d), motion.bending_nodes[d] = nodes(1 + d);
  motion.torsion = sum.col(3).cwiseAbs2().cwiseQuotient(inertia.cwiseMax(1e-300)).sum() / total;
  motion.torsion_nodes = nodes(3);
  return motion;
}

/// What goes into the page: vertices, triangles, and of each vertex the mesh node whose motion it has.
struct Skin {
  mesh::Points points;
  std::vector<std::array<int, 3>> triangles;
  std::vector<Eigen::Index> node;
};

Skin skin_of(const mesh::TetMesh& body, int most_triangles) {
  mesh::SurfaceMesh surface = mesh::boundary_surface(body);
  const bool fine = surface.triangles.cols() == 6 && 4 * surface.triangles.rows() <= most_triangles;
  Skin skin;
  std::vector<int> place(static_cast<std::size_t>(surface.vertices_m.rows()), -1);
  if (!fine && surface.triangles.rows() > most_triangles) {
    if (surface.triangles.cols() == 6) surface.triangles = mesh::IndexRows(surface.triangles.leftCols(3));
    const mesh::Points all = surface.vertices_m;
    std::vector<Eigen::Index> used;
    std::vector<bool> seen(place.size(), false);
    for (const int v : surface.triangles.reshaped<Eigen::RowMajor>())
      if (!seen[static_cast<std::size_t>(v)]) seen[static_cast<std::size_t>(v)] = true, used.push_back(v);
    surface = mesh::drawn_surface(surface, most_triangles);
    for (Eigen::Index i = 0; i < surface.vertices_m.rows(); ++i) {
      const auto nearest = std::min_element(used.begin(), used.end(), [&](Eigen::Index a, Eigen::Index b) {
        return (all.row(a) - surface.vertices_m.row(i)).squaredNorm() <
               (all.row(b) - surface.vertices_m.row(i)).squaredNorm();
      });
      skin.node.push_back(*nearest);
    }
    skin.points = surface.vertices_m;
    for (Eigen::Index t = 0; t < surface.triangles.rows(); ++t)
      skin.triangles.push_back({surface.triangles(t, 0), surface.triangles(t, 1), surface.triangles(t, 2)});
    return skin;
  }
  const auto vertex = [&](int node) {
    int& at = place[static_cast<std::size_t>(node)];
    if (at < 0) at = static_cast<int>(skin.node.size()), skin.node.push_back(node);
    return at;
  };
  for (Eigen::Index t = 0; t < surface.triangles.rows(); ++t) {
    const auto row = surface.triangles.row(t);
    const auto add = [&](int a, int b, int c) {
      skin.triangles.push_back({vertex(row[a]), vertex(row[b]), vertex(row[c])});
    };
    if (!fine) {
      add(0, 1, 2);
      continue;
    }
    add(0, 3, 5), add(3, 1, 4), add(5, 4, 2), add(3, 4, 5);
  }
  skin.points.resize(static_cast<Eigen::Index>(skin.node.size()), 3);
  for (std::size_t i = 0; i < skin.node.size(); ++i)
    skin.points.row(static_cast<Eigen::Index>(i)) = surface.vertices_m.row(skin.node[i]);
  return skin;
}

template <class Integer>
std::string packed(const std::vector<Integer>& values) {
  return base64({reinterpret_cast<const char*>(values.data()), sizeof(Integer) * values.size()});
}

json body_data(const Skin& skin) {
  const Eigen::RowVector3d low = skin.points.colwise().minCoeff(), high = skin.points.colwise().maxCoeff();
  const Eigen::RowVector3d centre = 0.5 * (low + high);
  const double half = 0.5 * (high - low).maxCoeff();
  std::vector<std::int16_t> points;
  for (Eigen::Index i = 0; i < skin.points.rows(); ++i)
    for (int axis = 0; axis < 3; ++axis)
      points.push_back(static_cast<std::int16_t>(std::lround(32767 * (skin.points(i, axis) - centre[axis]) / half)));
  std::vector<std::uint32_t> triangles;
  for (const auto& triangle : skin.triangles)
    for (const int v : triangle) triangles.push_back(static_cast<std::uint32_t>(v));
  const bool few = skin.points.rows() < 65536;
  return {
      {"points", packed(points)},
      {"wide", !few},
      {"triangles", few ? packed(std::vector<std::uint16_t>(triangles.begin(), triangles.end())) : packed(triangles)}};
}

std::string shape_data(const Skin& skin, const Eigen::Ref<const Eigen::VectorXd>& shape) {
  double largest = 0;
  for (const Eigen::Index node : skin.node)
    largest = std::max(largest, shape.segment<3>(3 * node).cwiseAbs().maxCoeff());
  std::vector<std::int8_t> motion;
  for (const Eigen::Index node : skin.node)
    for (int axis = 0; axis < 3; ++axis)
      motion.push_back(static_cast<std::int8_t>(largest > 0 ? std::lround(127 * shape[3 * node + axis] / largest) : 0));
  return packed(motion);
}

}  // namespace

std::vector<std::string> mode_names(const modal::ModalModel& model) {
  std::vector<std::string> names(static_cast<std::size_t>(model.n_modes()));
  const Eigen::RowVector3d middle = model.mesh.nodes_m.colwise().mean();
  const Eigen::MatrixXd away = model.mesh.nodes_m.rowwise() - middle;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> spread(Eigen::Matrix3d(away.transpose() * away));
  Eigen::Matrix3d axes;  // along, across with the larger extent, across with the smaller one
  axes << spread.eigenvectors().col(2), spread.eigenvectors().col(1), spread.eigenvectors().col(0);
  const Eigen::MatrixXd places = away * axes;
  const Eigen::RowVector3d size = places.colwise().maxCoeff() - places.colwise().minCoeff();
  if (!(size[0] > kLongBody * size[1])) return names;
  const bool round = size[2] > 0.98 * size[1];
  for (Eigen::Index k = 0; k < model.n_modes(); ++k) {
    const SectionMotion motion = section_motion(places, model.shapes.col(k), axes);
    std::string& name = names[static_cast<std::size_t>(k)];
    const int d = motion.bending[0] > motion.bending[1] ? 0 : 1;
    if (motion.bending[0] + motion.bending[1] > 0.5 && motion.bending_nodes[d] >= 2)
      name = ordinal(motion.bending_nodes[d] - 1) + " bending" + (!round && d == 0 ? " edgewise" : "");
    else if (motion.torsion > 0.5 && motion.torsion_nodes >= 1)
      name = ordinal(motion.torsion_nodes) + " torsion";
    else if (motion.along > 0.5 && motion.along_nodes >= 1)
      name = ordinal(motion.along_nodes) + " longitudinal";
  }
  return names;
}

std::string shape_view_html(const BodyModes& body, std::size_t n_bodies, ReportFolder& folder) {
  if (body.modes_file.empty() || body.candidates.empty() || !folder.has(body.modes_file)) return {};
  json data;
  std::string options;
  try {
    const modal::ModalModel model = modal::read_modal_model(folder.path() / body.modes_file);
    const Skin skin = skin_of(model.mesh, std::max(kFewestTriangles, kMostTriangles / static_cast<int>(n_bodies)));
    const std::vector<std::string> names = mode_names(model);
    data = body_data(skin);
    data["modes"] = json::array();
    for (const ModePicture& mode : body.candidates) {
      if (mode.mode_index < 0 || mode.mode_index >= model.n_modes() || data["modes"].size() >= kMostModes) continue;
      const std::string& name = names[static_cast<std::size_t>(mode.mode_index)];
      const std::string words =
          (name.empty() ? "mode " + std::to_string(mode.mode_index) : name) + ", " + hertz(mode.frequency_hz);
      options += tag("option", escaped(words), data["modes"].empty() ? "selected" : "");
      data["modes"].push_back({{"words", words}, {"shape", shape_data(skin, model.shapes.col(mode.mode_index))}});
    }
  } catch (const InputError&) {
    return {};  // what is wrong with the file the pictures say
  }
  if (options.empty()) return {};
  return "<figure data-figure=\"shape\"><script type=\"application/json\" data-body>" + data.dump() +
         "</script><div class=\"stage\"><canvas tabindex=\"0\" role=\"img\" aria-label=\"The body moving in the mode "
         "chosen below; drag to turn it\"></canvas></div><p class=\"tools\"><label>Mode <select data-modes>" +
         options +
         "</select></label><button type=\"button\" data-action=\"animate\" aria-pressed=\"true\">Move</button> <output "
         "data-name></output></p>" +
         tag("figcaption",
             "The body in one of its modes, greatly enlarged; drag to turn, wheel or two fingers to come nearer. Red "
             "moves outwards, blue inwards; dark lines are the nodes.") +
         "</figure>\n";
}

}  // namespace klang::reports::detail
