#include "core/physics/solid/rigid_modes.hpp"

#include <Eigen/SVD>
#include <algorithm>
#include <array>
#include <map>
#include <numeric>

#include "core/foundation/base/errors.hpp"

namespace klang::solid {
namespace {

constexpr int kMaxParts = 100;
// A part is free to turn about a line of held nodes only if they lie on it to this share of the part's
// radius.
constexpr double kRankTolerance = 1e-7;

class Groups {
 public:
  explicit Groups(int n) : parent_(n) { std::iota(parent_.begin(), parent_.end(), 0); }
  int root(int i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void join(int i, int j) {
    i = root(i);
    j = root(j);
    parent_[std::max(i, j)] = std::min(i, j);
  }

 private:
  std::vector<int> parent_;
};

// Number of the part of each element: elements that share a face are one part.
std::vector<int> face_parts(const mesh::TetMesh& mesh, int& n_parts) {
  struct Face {
    std::array<int, 3> corners;
    int element;
    bool operator<(const Face& other) const { return corners < other.corners; }
  };
  std::vector<Face> faces;
  faces.reserve(4 * static_cast<std::size_t>(mesh.n_elements()));
  constexpr int corners[4][3] = {{1, 2, 3}, {0, 2, 3}, {0, 1, 3}, {0, 1, 2}};
  for (int e = 0; e < mesh.n_elements(); ++e) {
    for (const auto& face : corners) {
      std::array<int, 3> nodes{mesh.elements(e, face[0]), mesh.elements(e, face[1]), mesh.elements(e, face[2])};
      std::sort(nodes.begin(), nodes.end());
      faces.push_back({nodes, e});
    }
  }
  std::sort(faces.begin(), faces.end());
  Groups groups(mesh.n_elements());
  for (std::size_t k = 1; k < faces.size(); ++k) {
    if (faces[k].corners == faces[k - 1].corners) groups.join(faces[k].element, faces[k - 1].element);
  }
  std::vector<int> part(mesh.n_elements(), -1);
  n_parts = 0;
  for (int e = 0; e < mesh.n_elements(); ++e) {
    const int root = groups.root(e);
    part[e] = root == e ? n_parts++ : part[root];  // a root is the lowest number of its group
  }
  return part;
}

// The displacement at x of part p is rows(x, p) times (translation, rotation * radius) of p.
struct PartFrame {
  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();
  double radius_m = 0;
  Eigen::Matrix<double, 3, 6> rows(const Eigen::Vector3d& x) const {
    const Eigen::Vector3d r = (x - centre_m) / radius_m;
    Eigen::Matrix<double, 3, 6> result;
    result.leftCols<3>().setIdentity();
    result.rightCols<3>() << 0, r[2], -r[1], -r[2], 0, r[0], r[1], -r[0], 0;
    return result;
  }
};

}  // namespace

Eigen::MatrixXd rigid_modes(const mesh::TetMesh& mesh, const AssembledSolid& assembled) {
  int n_parts = 0;
  const std::vector<int> part_of_element = face_parts(mesh, n_parts);
  if (n_parts > kMaxParts) {
    throw InputError("mesh", "falls apart into too many pieces that share no face", std::to_string(n_parts),
                     "at most " + std::to_string(kMaxParts));
  }
  // The parts at each node: nearly always one.
  std::vector<int> first_part(mesh.n_nodes(), -1);
  std::map<int, std::vector<int>> further_parts;
  for (int e = 0; e < mesh.n_elements(); ++e) {
    for (int k = 0; k < mesh.elements.cols(); ++k) {
      const int node = mesh.elements(e, k), part = part_of_element[e];
      if (first_part[node] < 0) {
        first_part[node] = part;
      } else if (first_part[node] != part) {
        auto& more = further_parts[node];
        if (std::find(more.begin(), more.end(), part) == more.end()) more.push_back(part);
      }
    }
  }
  std::vector<PartFrame> frame(n_parts);
  std::vector<int> n_part_nodes(n_parts, 0);
  for (int i = 0; i < mesh.n_nodes(); ++i) {
    if (first_part[i] < 0) continue;
    frame[first_part[i]].centre_m += mesh.nodes_m.row(i).transpose();
    ++n_part_nodes[first_part[i]];
  }
  for (int p = 0; p < n_parts; ++p) frame[p].centre_m /= std::max(n_part_nodes[p], 1);
  for (int e = 0; e < mesh.n_elements(); ++e) {
    PartFrame& f = frame[part_of_element[e]];
    for (int k = 0; k < 4; ++k) {
      f.radius_m = std::max(f.radius_m, (mesh.nodes_m.row(mesh.elements(e, k)).transpose() - f.centre_m).norm());
    }
  }

  std::vector<char> is_free(mesh.n_nodes(), 0);
  for (const int node : assembled.free_nodes) is_free[node] = 1;
  Groups groups(n_parts);
  for (const auto& [node, parts] : further_parts) {
    for (const int part : parts) groups.join(first_part[node], part);
  }

  std::vector<Eigen::VectorXd> motions;  // each of size 6 n_parts
  for (int root = 0; root < n_parts; ++root) {
    if (groups.root(root) != root) continue;
    std::vector<int> column(n_parts, -1);
    int n_columns = 0;
    for (int p = root; p < n_parts; ++p) {
      if (groups.root(p) == root) {
        column[p] = n_columns;
        n_columns += 6;
      }
    }
    // Normal equations of the constraints, one 3-row block at a time, would square the tolerance; a QR on the
    // way keeps it.
    Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(n_columns, n_columns);
    Eigen::MatrixXd pending(0, n_columns);
    Eigen::Index n_pending = 0;
    const auto flush = [&] {
      Eigen::MatrixXd stacked(n_columns + n_pending, n_columns);
      stacked << rows, pending.topRows(n_pending);
      rows =
          Eigen::HouseholderQR<Eigen::MatrixXd>(stacked).matrixQR().topRows(n_columns).triangularView<Eigen::Upper>();
      n_pending = 0;
    };
    const auto constrain = [&](const Eigen::Vector3d& x, int plus, int minus) {
      if (pending.rows() == 0) pending.resize(3 * 256, n_columns);
      if (n_pending + 3 > pending.rows()) flush();
      pending.middleRows(n_pending, 3).setZero();
      pending.block(n_pending, column[plus], 3, 6) = frame[plus].rows(x);
      if (minus >= 0) pending.block(n_pending, column[minus], 3, 6) = -frame[minus].rows(x);
      n_pending += 3;
    };
    for (int i = 0; i < mesh.n_nodes(); ++i) {
      if (first_part[i] < 0 || column[first_part[i]] < 0) continue;
      const Eigen::Vector3d x = mesh.nodes_m.row(i).transpose();
      if (!is_free[i]) constrain(x, first_part[i], -1);
      if (const auto more = further_parts.find(i); more != further_parts.end()) {
        for (const int part : more->second) constrain(x, first_part[i], part);
      }
    }
    if (n_pending > 0) flush();
    const Eigen::JacobiSVD<Eigen::MatrixXd> svd(rows, Eigen::ComputeFullV);
    const double cut = kRankTolerance * std::max(1.0, svd.singularValues()(0));
    for (int k = 0; k < n_columns; ++k) {
      if (svd.singularValues()(k) > cut) continue;
      Eigen::VectorXd motion = Eigen::VectorXd::Zero(6 * n_parts);
      for (int p = 0; p < n_parts; ++p) {
        if (column[p] >= 0) motion.segment<6>(6 * p) = svd.matrixV().col(k).segment<6>(column[p]);
      }
      motions.push_back(std::move(motion));
    }
  }

  Eigen::MatrixXd basis(assembled.n_dofs(), static_cast<Eigen::Index>(motions.size()));
  for (std::size_t i = 0; i < assembled.free_nodes.size(); ++i) {
    const int node = assembled.free_nodes[i], part = first_part[node];
    const Eigen::Matrix<double, 3, 6> rows = frame[part].rows(mesh.nodes_m.row(node).transpose());
    for (std::size_t k = 0; k < motions.size(); ++k) {
      basis.block<3, 1>(3 * static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(k)) =
          rows * motions[k].segment<6>(6 * part);
    }
  }
  return basis;
}

}  // namespace klang::solid
