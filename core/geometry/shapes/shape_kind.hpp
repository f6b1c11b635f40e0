#pragma once
#include <array>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/geometry/mesh/round_surface.hpp"
#include "core/geometry/shapes/shape.hpp"

namespace klang::mesh {

/// A length that a kind of shape is given by. Admissible: low_m < value < high_m, and what the kind's relations ask for.
struct ShapeDimension {
  std::string name;     ///< with unit, "outer_radius_m"
  std::string meaning;  ///< with its relation to the others, "thickness of the wall, below outer_radius_m"
  double low_m = 0.0;
  double high_m = 1e6;
};

/// What is the same for every body of a kind.
struct ShapeFacts {
  std::string name;     ///< the word in files and on the command line
  std::string meaning;  ///< in words, for the table of shapes
  std::string placement;
  std::vector<ShapeDimension> dimensions;
  bool has_profile = false;  ///< given by profile_csv, not by dimensions
  /// Modes come in pairs by symmetry that a mesh splits a little. Not for balls, whose multiplets are larger.
  bool modes_in_pairs = false;
};

/// The direction a slender body bends along.
struct LongAxis {
  int axis = 0;        ///< 0 x, 1 y, 2 z
  bool round = false;  ///< both directions across are alike: bending modes are pairs
};

/// Part of a half-plane section: the image (r, z) [m] of the unit square, divided n_u x n_v times.
struct SectionPatch {
  int n_u = 1, n_v = 1;
  std::function<Eigen::Vector2d(double u, double v)> map;
};

/// One kind of analytic body: everything that depends on the kind. The functions of shape.hpp and section.hpp check a
/// ShapeSpec and then ask its kind; here every spec is a checked one of this kind. To add a kind: a class in
/// detail/NAME_shape.{hpp,cpp}, a line in shape_registry.cpp, and the source in CMakeLists.txt.
class ShapeKind {
 public:
  explicit ShapeKind(ShapeFacts facts);
  virtual ~ShapeKind() = default;
  ShapeKind(const ShapeKind&) = delete;
  ShapeKind& operator=(const ShapeKind&) = delete;

  const ShapeFacts& facts() const { return facts_; }
  const std::vector<std::string>& dimension_names() const { return dimension_names_; }

  /// Relations between dimensions, each of which is within its own range. @throws InputError naming the dimension
  virtual void check_relations(const ShapeSpec& spec) const;

  virtual double volume_m3(const ShapeSpec& spec) const = 0;  ///< of the analytic body
  virtual double area_m2(const ShapeSpec& spec) const = 0;

  /// Divisions with edges no longer than edge_m [m]; edge_m = 0: those that resolve the lowest modes.
  virtual std::array<int, 3> counts(const ShapeSpec& spec, double edge_m) const = 0;
  /// Every edge halved level times. @throws InputError where the mesh becomes too big
  virtual ShapeDivisions refined(const std::array<int, 3>& counts, int level) const;
  virtual TetMesh mesh(const ShapeSpec& spec, const ShapeDivisions& divisions, int order) const = 0;

  /// convex_parts() of shape.hpp. Default: wedges of the section of a body of revolution.
  virtual std::vector<Eigen::Matrix3Xd> convex_parts(const ShapeSpec& spec) const;
  /// round_surfaces() of round_surfaces.hpp. Default: rings of the section of a body of revolution.
  virtual std::vector<RoundSurface> round_surfaces(const ShapeSpec& spec) const;

  /// resonance_divisions() and reference_divisions() of shape.hpp. Defaults: the default counts; twice as fine.
  virtual ShapeDivisions resonance_divisions(const ShapeSpec& spec, double bar_speed_m_s, double highest_hz) const;
  virtual ShapeDivisions reference_divisions(const ShapeSpec& spec) const;

  /// Empty for a body that is not slender by its kind.
  virtual std::optional<LongAxis> long_axis(const ShapeSpec& spec) const;

  /// A body of revolution about the z axis; then the section's functions below are defined.
  virtual bool is_axisymmetric(const ShapeSpec& spec) const;
  /// Which bodies of the kind are, in words: "bowl", "ellipsoid with a_m = b_m"; empty: none.
  virtual std::string axisymmetric_words() const;
  /// Smallest thickness that bends [m].
  virtual double section_thickness_m(const ShapeSpec& spec) const;
  virtual std::array<int, 3> section_counts(const ShapeSpec& spec, double edge_m) const;
  /// Patches whose common borders are divided alike; n as section_counts() gives them.
  virtual std::vector<SectionPatch> section_patches(const ShapeSpec& spec, const std::array<int, 3>& n) const;

 private:
  ShapeFacts facts_;
  std::vector<std::string> dimension_names_;
};

}  // namespace klang::mesh
