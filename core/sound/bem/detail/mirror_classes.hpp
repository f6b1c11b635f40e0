#pragma once
#include <Eigen/Core>
#include <vector>

#include "core/foundation/la/dense_solve.hpp"
#include "core/sound/bem/radiating_surface.hpp"

namespace klang::acoustics::detail {

/// A surface that mirror planes carry into itself parts every solution into classes, each of one sign at each plane: a class's
/// values on the whole are those on the surface's own part times a sign, and no class hears of another. Class s has the sign
/// (-1)^(bits of s and g) on image g. Without planes there is one class, of the whole.
class MirrorClasses {
 public:
  explicit MirrorClasses(const RadiatingSurface& surface);

  int n_own_vertices() const { return n_own_vertices_; }
  int n_own_triangles() const { return n_own_triangles_; }

  /// A class of a column that is not zero.
  struct Part {
    int column, number;
  };
  struct Parts {
    std::vector<Part> list;      ///< by class, then column
    Eigen::MatrixXcd at_corner;  ///< on the whole: row 3 t + c, a column for each part; their sum is the column
  };
  /// Parts below 1e-12 of their column are round-off and left out.
  Parts split(const Eigen::MatrixXcd& at_corner) const;

  /// The vertices of the own part where a class does not vanish, in the order of their rows.
  std::vector<int> vertices_of(int number, const std::vector<int>& row_of_vertex) const;

  /// Matrix of a class from the rows of the own vertices: the columns of a vertex's images added up with their signs.
  la::RowMatrixXcd folded(int number, const std::vector<int>& vertices, const la::RowMatrixXcd& rows,
                          const std::vector<int>& row_of_vertex, const std::vector<int>& column_of_vertex) const;

  /// Adds a class's values at its vertices to those of the whole.
  void spread(int number, const std::vector<int>& vertices, const Eigen::VectorXcd& values,
              Eigen::Ref<Eigen::VectorXcd> whole) const;

 private:
  template <class Visit>
  void images(int number, int vertex, Visit&& visit) const;

  int n_images_ = 1, n_own_vertices_ = 0, n_own_triangles_ = 0;
  std::vector<std::vector<int>> vertex_image_;  ///< [g][own vertex]
  std::vector<int> planes_of_vertex_;           ///< bits, of own vertices
};

}  // namespace klang::acoustics::detail
