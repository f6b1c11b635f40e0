#include "core/geometry/mesh/tetgen_mesher.hpp"

#define TETLIBRARY
#include <tetgen.h>

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <memory>
#include <new>
#include <optional>

#include "core/foundation/base/child.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/geometry/mesh/detail/edge_splitting.hpp"
#include "core/geometry/mesh/detail/narrow_facets.hpp"
#include "core/geometry/mesh/detail/tetgen_library.hpp"
#include "core/geometry/mesh/import_check.hpp"

namespace klang::mesh {
namespace detail {

std::mutex& tetgen_mutex() {
  static std::mutex mutex;
  return mutex;
}

int orientation_sign(const double* a, const double* b, const double* c, const double* d) {
  double u[3], v[3], w[3];
  for (int i = 0; i < 3; ++i) {
    u[i] = a[i] - d[i];
    v[i] = b[i] - d[i];
    w[i] = c[i] - d[i];
  }
  const double t0 = v[0] * w[1], t1 = w[0] * v[1], t2 = w[0] * u[1], t3 = u[0] * w[1], t4 = u[0] * v[1],
               t5 = v[0] * u[1];
  const double det = u[2] * (t0 - t1) + v[2] * (t2 - t3) + w[2] * (t4 - t5);
  const double scale = (std::abs(t0) + std::abs(t1)) * std::abs(u[2]) + (std::abs(t2) + std::abs(t3)) * std::abs(v[2]) +
                       (std::abs(t4) + std::abs(t5)) * std::abs(w[2]);
  if (std::abs(det) > 1e-15 * scale) return det > 0.0 ? 1 : -1;  // Shewchuk's bound is 7.8e-16
  if (scale == 0.0) return 0;
  const std::lock_guard lock(tetgen_mutex());
  exactinit(0, 0, 1, 1.0, 1.0, 1.0);  // each time: a mesh in between sets filters for its own size
  const auto writable = [](const double* p) { return const_cast<double*>(p); };  // read only, but not declared so
  const double exact = orient3d(writable(a), writable(b), writable(c), writable(d));
  return exact > 0.0 ? 1 : exact < 0.0 ? -1 : 0;
}

}  // namespace detail

namespace {

/// While it lives, C's stdout goes nowhere: TetGen prints its errors even when told to be quiet.
class QuietStdout {
 public:
  QuietStdout() : before_(stdout), nowhere_(std::fopen("/dev/null", "w")) {
    if (nowhere_ != nullptr) stdout = nowhere_;
  }
  ~QuietStdout() {
    stdout = before_;
    if (nowhere_ != nullptr) std::fclose(nowhere_);
  }
  QuietStdout(const QuietStdout&) = delete;
  QuietStdout& operator=(const QuietStdout&) = delete;

 private:
  FILE* before_;
  FILE* nowhere_;
};

double g_longest_edge_sq = 0.0;  // of TetGen's callback, which has no context; guarded by tetgen_mutex()

bool too_long(REAL* a, REAL* b, REAL* c, REAL* d, REAL*, REAL) {
  const REAL* p[4] = {a, b, c, d};
  for (const auto& edge : kTetEdges) {
    double length_sq = 0.0;
    for (int i = 0; i < 3; ++i) length_sq += (p[edge[0]][i] - p[edge[1]][i]) * (p[edge[0]][i] - p[edge[1]][i]);
    if (length_sq > g_longest_edge_sq) return true;
  }
  return false;
}

void fill_input(tetgenio& in, const SurfaceMesh& surface, const SurfaceParts& parts) {
  in.firstnumber = 0;
  in.numberofpoints = static_cast<int>(surface.vertices_m.rows());
  in.pointlist = new REAL[3 * static_cast<std::size_t>(in.numberofpoints)];
  std::copy(surface.vertices_m.data(), surface.vertices_m.data() + surface.vertices_m.size(), in.pointlist);
  in.numberoffacets = static_cast<int>(surface.triangles.rows());
  in.facetlist = new tetgenio::facet[in.numberoffacets];
  for (int t = 0; t < in.numberoffacets; ++t) {
    tetgenio::facet& facet = in.facetlist[t];
    tetgenio::init(&facet);
    facet.numberofpolygons = 1;
    facet.polygonlist = new tetgenio::polygon[1];
    tetgenio::init(&facet.polygonlist[0]);
    facet.polygonlist[0].numberofvertices = 3;
    facet.polygonlist[0].vertexlist = new int[3];
    for (int c = 0; c < 3; ++c) facet.polygonlist[0].vertexlist[c] = surface.triangles(t, c);
  }
  in.numberofholes = static_cast<int>(parts.point_in_hollow.size());
  if (in.numberofholes > 0) in.holelist = new REAL[3 * static_cast<std::size_t>(in.numberofholes)];
  for (int h = 0; h < in.numberofholes; ++h)
    for (int i = 0; i < 3; ++i) in.holelist[3 * h + i] = parts.point_in_hollow[h][i];
}

constexpr int kCrashed = -1;

std::string reason(int code) {
  switch (code) {
    case 1:
      return "out of memory";
    case 3:
      return "a self-intersection";
    case 4:
      return "a very small feature";
    case 5:
      return "two facets that nearly touch";
    case 10:
      return "an input error";
    case kCrashed:
      return "it crashed";
    default:
      return "an internal error";
  }
}

/// TetGen's answer, or the number it threw.
std::optional<int> run_tetgen(const SurfaceMesh& surface, const SurfaceParts& parts, const std::string& switches,
                              double max_edge_m, TetMesh& mesh) {
  tetgenio in, out;
  fill_input(in, surface, parts);
  if (max_edge_m > 0.0) {
    g_longest_edge_sq = max_edge_m * max_edge_m;
    in.tetunsuitable = too_long;
  }
  std::string text = switches;
  try {
    const QuietStdout quiet;
    tetrahedralize(text.data(), &in, &out);
  } catch (const int code) {
    return code;
  }
  if (out.numberoftetrahedra <= 0) return 2;
  mesh.nodes_m.resize(out.numberofpoints, 3);
  std::copy(out.pointlist, out.pointlist + 3 * static_cast<std::size_t>(out.numberofpoints), mesh.nodes_m.data());
  mesh.elements.resize(out.numberoftetrahedra, 4);
  for (int e = 0; e < out.numberoftetrahedra; ++e)
    for (int c = 0; c < 4; ++c)
      mesh.elements(e, c) = out.tetrahedronlist[static_cast<std::size_t>(e) * out.numberofcorners + c];
  return std::nullopt;
}

/// The answer of run_tetgen() as bytes: the code, then counts, nodes and elements of a mesh.
std::string packed(std::optional<int> failure, const TetMesh& mesh) {
  std::string bytes;
  const auto put = [&bytes](const auto* values, Eigen::Index n) {
    bytes.append(reinterpret_cast<const char*>(values), static_cast<std::size_t>(n) * sizeof *values);
  };
  const std::array<int, 3> head{failure.value_or(0), mesh.n_nodes(), mesh.n_elements()};
  put(head.data(), 3);
  put(mesh.nodes_m.data(), mesh.nodes_m.size());
  put(mesh.elements.data(), mesh.elements.size());
  return bytes;
}

std::optional<int> unpacked(const std::string& bytes, TetMesh& mesh) {
  std::array<int, 3> head{};
  if (bytes.size() < sizeof head) return kCrashed;
  std::memcpy(head.data(), bytes.data(), sizeof head);
  if (head[0] != 0) return head[0];
  mesh.nodes_m.resize(head[1], 3);
  mesh.elements.resize(head[2], 4);
  const std::size_t n_nodes = sizeof(double) * static_cast<std::size_t>(mesh.nodes_m.size());
  const std::size_t n_elements = sizeof(int) * static_cast<std::size_t>(mesh.elements.size());
  if (bytes.size() != sizeof head + n_nodes + n_elements) return kCrashed;
  std::memcpy(mesh.nodes_m.data(), bytes.data() + sizeof head, n_nodes);
  std::memcpy(mesh.elements.data(), bytes.data() + sizeof head + n_nodes, n_elements);
  return std::nullopt;
}

std::optional<int> run_in_own_process(const SurfaceMesh& surface, const SurfaceParts& parts,
                                      const std::string& switches, double max_edge_m, TetMesh& mesh, Monitor& monitor) {
  const ChildResult result = run_in_child(
      [&] {
        TetMesh made;
        const auto failure = run_tetgen(surface, parts, switches, max_edge_m, made);
        return packed(failure, made);
      },
      monitor);
  return result.done ? unpacked(result.bytes, mesh) : std::optional(kCrashed);
}

}  // namespace

void TetgenOptions::validate() const { validate_fields("TetGen options", *this); }

double expected_elements(const SurfaceMesh& surface, double volume_m3, const TetgenOptions& options) {
  const auto at = [&surface](Eigen::Index t, int c) -> Eigen::Vector3d {
    return surface.vertices_m.row(surface.triangles(t, c)).transpose();
  };
  const Eigen::Index n_triangles = surface.triangles.rows();
  std::vector<double> shortest(static_cast<std::size_t>(surface.vertices_m.rows()), HUGE_VAL);
  for (Eigen::Index t = 0; t < n_triangles; ++t)
    for (int c = 0; c < 3; ++c)
      for (const int v : {surface.triangles(t, c), surface.triangles(t, (c + 1) % 3)})
        shortest[v] = std::min(shortest[v], (at(t, c) - at(t, (c + 1) % 3)).norm());
  double n = 0.0;
  for (Eigen::Index t = 0; t < n_triangles; ++t) {
    double size = HUGE_VAL;
    for (int c = 0; c < 3; ++c) size = std::min(size, shortest[surface.triangles(t, c)]);
    n += 4.0 * (at(t, 1) - at(t, 0)).cross(at(t, 2) - at(t, 0)).norm() / (size * size);
  }
  // Regular tetrahedra of that edge; real ones are about half as large.
  if (options.max_edge_m > 0.0) n += 2.0 * volume_m3 * 6.0 * std::sqrt(2.0) / std::pow(options.max_edge_m, 3);
  return n;
}

TetMesh mesh_surface(const SurfaceMesh& surface, const TetgenOptions& options, const std::string& name,
                     Monitor& monitor) {
  options.validate();
  const SurfaceParts parts = check_closed_surface(surface, name);
  if (const double n = detail::elements_along_narrow_facets(surface); !(n <= 0.5 * options.max_elements))
    throw InputError(name, "its narrow parts need too many elements",
                     "about " + to_text(std::round(n)) + " along their edges",
                     "up to " + to_text(0.5 * options.max_elements) + ": a body that is less thin");
  if (options.max_edge_m > 0.0) {
    // Regular tetrahedra of that edge; real ones are about half as large.
    const double n_expected = 2.0 * parts.volume_m3 * 6.0 * std::sqrt(2.0) / std::pow(options.max_edge_m, 3);
    if (!(n_expected <= options.max_elements))
      throw InputError(
          name, "too many elements for this edge length",
          "max_edge_m = " + to_text(options.max_edge_m) + ", about " + to_text(std::round(n_expected)) + " elements",
          "up to " + to_text(options.max_elements));
  }
  const std::string quality = "q" + to_text(options.radius_edge_ratio) + "/" + to_text(options.min_dihedral_deg);
  TetMesh mesh;
  std::optional<int> failure;
  {
    const std::lock_guard lock(detail::tetgen_mutex());
    // Refining inside an untouched surface (Y) succeeds on some surfaces where cutting its facets does not.
    const std::string limit = "S" + std::to_string(static_cast<long>(options.max_elements / 3.0)) + "Q";
    for (const std::string& switches : {"pz" + quality + limit, "pzY" + quality + limit}) {
      failure = options.in_child ? run_in_own_process(surface, parts, switches, options.max_edge_m, mesh, monitor)
                                 : run_tetgen(surface, parts, switches, options.max_edge_m, mesh);
      if (!failure || *failure == 1 || *failure == 3) break;
    }
  }
  if (failure)
    throw InputError(name, "TetGen could not fill the surface: " + reason(*failure),
                     *failure == kCrashed ? std::string() : "code " + std::to_string(*failure));
  mesh = checked_import(std::move(mesh), name);
  // TetGen leaves long edges where facets meet at sharp angles.
  if (options.max_edge_m > 0.0) detail::split_long_edges(mesh, options.max_edge_m);
  const SurfaceMesh boundary = boundary_surface(mesh);
  std::vector<char> on_surface(mesh.n_nodes(), 0);
  for (Eigen::Index t = 0; t < boundary.triangles.rows(); ++t)
    for (int c = 0; c < 3; ++c) on_surface[boundary.triangles(t, c)] = 1;
  for (int i = 0; i < mesh.n_nodes(); ++i)
    if (on_surface[i]) mesh.node_sets["surface"].push_back(i);
  return options.order == 2 ? to_quadratic(mesh) : mesh;
}

}  // namespace klang::mesh
