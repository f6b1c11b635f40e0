#include "core/sound/bem/detail/mirror_classes.hpp"

#include <algorithm>
#include <complex>
#include <numeric>

namespace klang::acoustics::detail {
namespace {

constexpr double kRoundOff = 1e-12;

double sign_of(int number, int image) { return mesh::turns_over(number & image) ? -1.0 : 1.0; }

}  // namespace

MirrorClasses::MirrorClasses(const RadiatingSurface& surface) {
  const SurfaceMirrors& mirrors = surface.mirrors;
  n_images_ = mirrors.planes.n_images();
  n_own_triangles_ = surface.n_triangles() / n_images_;
  n_own_vertices_ = n_images_ == 1 ? surface.n_vertices() : mirrors.n_own_vertices;
  if (n_images_ == 1) {
    vertex_image_.emplace_back(static_cast<std::size_t>(n_own_vertices_));
    std::iota(vertex_image_[0].begin(), vertex_image_[0].end(), 0);
  } else {
    vertex_image_ = mirrors.vertex_image;
  }
  planes_of_vertex_.assign(static_cast<std::size_t>(n_own_vertices_), 0);
  for (int v = 0; v < n_own_vertices_; ++v)
    for (int bit = 1; bit < n_images_; bit *= 2)
      if (vertex_image_[bit][v] == v) planes_of_vertex_[v] |= bit;
}

MirrorClasses::Parts MirrorClasses::split(const Eigen::MatrixXcd& at_corner) const {
  Parts parts;
  std::vector<Eigen::VectorXcd> columns;
  for (int number = 0; number < n_images_; ++number)
    for (Eigen::Index c = 0; c < at_corner.cols(); ++c) {
      Eigen::VectorXcd whole = Eigen::VectorXcd::Zero(at_corner.rows());
      for (int t = 0; t < n_own_triangles_; ++t)
        for (int corner = 0; corner < 3; ++corner) {
          const auto row = [&](int g) {
            return 3 * (g * n_own_triangles_ + t) + (mesh::turns_over(g) ? (3 - corner) % 3 : corner);
          };
          std::complex<double> mean = 0.0;
          for (int g = 0; g < n_images_; ++g) mean += sign_of(number, g) * at_corner(row(g), c);
          mean /= n_images_;
          for (int g = 0; g < n_images_; ++g) whole[row(g)] = sign_of(number, g) * mean;
        }
      if (!(whole.norm() > kRoundOff * at_corner.col(c).norm())) continue;
      parts.list.push_back({static_cast<int>(c), number});
      columns.push_back(std::move(whole));
    }
  parts.at_corner.resize(at_corner.rows(), static_cast<Eigen::Index>(columns.size()));
  for (std::size_t i = 0; i < columns.size(); ++i) parts.at_corner.col(static_cast<Eigen::Index>(i)) = columns[i];
  return parts;
}

std::vector<int> MirrorClasses::vertices_of(int number, const std::vector<int>& row_of_vertex) const {
  std::vector<int> vertices;
  for (int v = 0; v < n_own_vertices_; ++v)
    if ((planes_of_vertex_[v] & number) == 0) vertices.push_back(v);
  std::sort(vertices.begin(), vertices.end(), [&](int a, int b) { return row_of_vertex[a] < row_of_vertex[b]; });
  return vertices;
}

/// visit(vertex of the whole, sign) for each image of a vertex once.
template <class Visit>
void MirrorClasses::images(int number, int vertex, Visit&& visit) const {
  for (int g = 0; g < n_images_; ++g)
    if ((g & planes_of_vertex_[vertex]) == 0) visit(vertex_image_[g][vertex], sign_of(number, g));
}

la::RowMatrixXcd MirrorClasses::folded(int number, const std::vector<int>& vertices, const la::RowMatrixXcd& rows,
                                       const std::vector<int>& row_of_vertex,
                                       const std::vector<int>& column_of_vertex) const {
  struct Term {
    int from, to;
    double sign;
  };
  std::vector<Term> terms;
  for (std::size_t i = 0; i < vertices.size(); ++i)
    images(number, vertices[i], [&](int vertex, double sign) {
      terms.push_back({column_of_vertex[vertex], static_cast<int>(i), sign});
    });
  const auto n = static_cast<Eigen::Index>(vertices.size());
  la::RowMatrixXcd matrix = la::RowMatrixXcd::Zero(n, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const std::complex<double>* const from = rows.row(row_of_vertex[vertices[i]]).data();
    std::complex<double>* const to = matrix.row(i).data();
    for (const Term& term : terms) to[term.to] += term.sign * from[term.from];
  }
  return matrix;
}

void MirrorClasses::spread(int number, const std::vector<int>& vertices, const Eigen::VectorXcd& values,
                           Eigen::Ref<Eigen::VectorXcd> whole) const {
  for (std::size_t i = 0; i < vertices.size(); ++i)
    images(number, vertices[i],
           [&](int vertex, double sign) { whole[vertex] += sign * values[static_cast<Eigen::Index>(i)]; });
}

}  // namespace klang::acoustics::detail
