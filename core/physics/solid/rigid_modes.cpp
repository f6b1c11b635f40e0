#include "core/physics/solid/rigid_modes.hpp"

#include <Eigen/SVD>
#include <algorithm>
#include <map>
#include <numeric>

#include "core/foundation/base/errors.hpp"
#include "core/geometry/mesh/face_parts.hpp"

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

/// The parts at each node: nearly always one.
struct NodeParts {
  std::vector<int> first;                   ///< -1: a node of no element
  std::map<int, std::vector<int>> further;  ///< by node
};

NodeParts parts_at_nodes(const mesh::TetMesh& mesh, const std::vector<int>& part_of_element) {
  NodeParts parts{std::vector<int>(mesh.n_nodes(), -1), {}};
  for (int e = 0; e < mesh.n_elements(); ++e) {
    for (int k = 0; k < mesh.elements.cols(); ++k) {
      const int node = mesh.elements(e, k), part = part_of_element[e];
      if (parts.first[node] < 0) {
        parts.first[node] = part;
      } else if (parts.first[node] != part) {
        auto& more = parts.further[node];
        if (std::find(more.begin(), more.end(), part) == more.end()) more.push_back(part);
      }
    }
  }
  return parts;
}

std::vector<PartFrame> part_frames(const mesh::TetMesh& mesh, const std::vector<int>& part_of_element,
                                   const NodeParts& parts, int n_parts) {
  std::vector<PartFrame> frame(n_parts);
  std::vector<int> n_part_nodes(n_parts, 0);
  for (int i = 0; i < mesh.n_nodes(); ++i) {
    if (parts.first[i] < 0) continue;
    frame[parts.first[i]].centre_m += mesh.nodes_m.row(i).transpose();
    ++n_part_nodes[parts.first[i]];
  }
  for (int p = 0; p < n_parts; ++p) frame[p].centre_m /= std::max(n_part_nodes[p], 1);
  for (int e = 0; e < mesh.n_elements(); ++e) {
    PartFrame& f = frame[part_of_element[e]];
    for (int k = 0; k < 4; ++k) {
      f.radius_m = std::max(f.radius_m, (mesh.nodes_m.row(mesh.elements(e, k)).transpose() - f.centre_m).norm());
    }
  }
  return frame;
}

/// What holds parts that hang together by nodes: rows of constraints on (translation, rotation * radius) of each.
class Constraints {
 public:
  /// @param column  first column of each part, -1: not of this group
  Constraints(const std::vector<PartFrame>& frame, std::vector<int> column, int n_columns)
      : frame_(frame),
        column_(std::move(column)),
        rows_(Eigen::MatrixXd::Zero(n_columns, n_columns)),
        pending_(0, n_columns) {}

  bool has(int part) const { return column_[part] >= 0; }

  /// The displacement at x of part plus is that of part minus, or 0 where minus < 0.
  void add(const Eigen::Vector3d& x, int plus, int minus) {
    if (pending_.rows() == 0) pending_.resize(3 * 256, rows_.cols());
    if (n_pending_ + 3 > pending_.rows()) flush();
    pending_.middleRows(n_pending_, 3).setZero();
    pending_.block(n_pending_, column_[plus], 3, 6) = frame_[plus].rows(x);
    if (minus >= 0) pending_.block(n_pending_, column_[minus], 3, 6) = -frame_[minus].rows(x);
    n_pending_ += 3;
  }

  /// Motions that meet all of them, each of size 6 n_parts.
  void append_motions(std::vector<Eigen::VectorXd>& motions) {
    if (n_pending_ > 0) flush();
    const auto n_parts = static_cast<Eigen::Index>(column_.size());
    const Eigen::JacobiSVD<Eigen::MatrixXd> svd(rows_, Eigen::ComputeFullV);
    const double cut = kRankTolerance * std::max(1.0, svd.singularValues()(0));
    for (Eigen::Index k = 0; k < rows_.cols(); ++k) {
      if (svd.singularValues()(k) > cut) continue;
      Eigen::VectorXd motion = Eigen::VectorXd::Zero(6 * n_parts);
      for (Eigen::Index p = 0; p < n_parts; ++p) {
        const int column = column_[static_cast<std::size_t>(p)];
        if (column >= 0) motion.segment<6>(6 * p) = svd.matrixV().col(k).segment<6>(column);
      }
      motions.push_back(std::move(motion));
    }
  }

 private:
  /// Normal equations, one 3-row block at a time, would square the tolerance; a QR on the way keeps it.
  void flush() {
    const Eigen::Index n_columns = rows_.cols();
    Eigen::MatrixXd stacked(n_columns + n_pending_, n_columns);
    stacked << rows_, pending_.topRows(n_pending_);
    rows_ = Eigen::HouseholderQR<Eigen::MatrixXd>(stacked).matrixQR().topRows(n_columns).triangularView<Eigen::Upper>();
    n_pending_ = 0;
  }

  const std::vector<PartFrame>& frame_;
  std::vector<int> column_;
  Eigen::MatrixXd rows_, pending_;
  Eigen::Index n_pending_ = 0;
};

/// The motions that the support leaves free of every group of parts that share nodes, each of size 6 n_parts.
std::vector<Eigen::VectorXd> free_motions(const mesh::TetMesh& mesh, const std::vector<int>& free_nodes,
                                          const NodeParts& parts, const std::vector<PartFrame>& frame) {
  const auto n_parts = static_cast<int>(frame.size());
  std::vector<char> is_free(mesh.n_nodes(), 0);
  for (const int node : free_nodes) is_free[node] = 1;
  Groups groups(n_parts);
  for (const auto& [node, further] : parts.further) {
    for (const int part : further) groups.join(parts.first[node], part);
  }
  std::vector<Eigen::VectorXd> motions;
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
    Constraints constraints(frame, std::move(column), n_columns);
    for (int i = 0; i < mesh.n_nodes(); ++i) {
      if (parts.first[i] < 0 || !constraints.has(parts.first[i])) continue;
      const Eigen::Vector3d x = mesh.nodes_m.row(i).transpose();
      if (!is_free[i]) constraints.add(x, parts.first[i], -1);
      if (const auto more = parts.further.find(i); more != parts.further.end()) {
        for (const int part : more->second) constraints.add(x, parts.first[i], part);
      }
    }
    constraints.append_motions(motions);
  }
  return motions;
}

}  // namespace

Eigen::MatrixXd rigid_modes(const mesh::TetMesh& mesh, const AssembledSolid& assembled) {
  const auto [n_parts, part_of_element] = mesh::face_parts(mesh);
  if (n_parts > kMaxParts) {
    throw InputError("mesh", "falls apart into too many pieces that share no face", std::to_string(n_parts),
                     "at most " + std::to_string(kMaxParts));
  }
  const NodeParts parts = parts_at_nodes(mesh, part_of_element);
  const std::vector<PartFrame> frame = part_frames(mesh, part_of_element, parts, n_parts);
  const std::vector<Eigen::VectorXd> motions = free_motions(mesh, assembled.free_nodes, parts, frame);
  Eigen::MatrixXd basis(assembled.n_dofs(), static_cast<Eigen::Index>(motions.size()));
  for (std::size_t i = 0; i < assembled.free_nodes.size(); ++i) {
    const int node = assembled.free_nodes[i], part = parts.first[node];
    const Eigen::Matrix<double, 3, 6> rows = frame[part].rows(mesh.nodes_m.row(node).transpose());
    for (std::size_t k = 0; k < motions.size(); ++k) {
      basis.block<3, 1>(3 * static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(k)) =
          rows * motions[k].segment<6>(6 * part);
    }
  }
  return basis;
}

}  // namespace klang::solid
