#include "core/geometry/files/surface_file.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/output_file.hpp"
#include "core/geometry/files/byte_cursor.hpp"

namespace klang::mesh {
namespace {

using Vertex = std::array<double, 3>;
using Triangle = std::array<int, 3>;

/// Collects what the readers find, in the file's numbering.
class SurfaceBuilder {
 public:
  explicit SurfaceBuilder(const ByteCursor& cursor) : cursor_(cursor) {}

  void add_vertex(const Vertex& v) {
    for (const double x : v)
      if (!std::isfinite(x)) cursor_.fail("vertex " + std::to_string(vertices_.size()) + " is not finite");
    vertices_.push_back(v);
  }

  /// Of an STL: the number of this vertex, old or new.
  int welded_vertex(Vertex v) {
    for (double& x : v) {
      if (!std::isfinite(x)) cursor_.fail("vertex of face " + std::to_string(triangles_.size()) + " is not finite");
      x += 0.0;  // -0.0 becomes 0.0
    }
    const auto [it, added] = welded_.try_emplace(v, static_cast<int>(vertices_.size()));
    if (added) vertices_.push_back(v);
    return it->second;
  }

  void add_triangle(const Triangle& t) { triangles_.push_back(t); }

  /// A polygon of the file as a fan; indices are checked against the vertices known at finish().
  void add_polygon(const std::vector<long long>& corners) {
    if (corners.size() < 3)
      cursor_.fail("face " + std::to_string(n_faces_) + " has too few corners", std::to_string(corners.size()),
                   "3 or more");
    for (const long long corner : corners)
      if (corner < 0 || corner > 2147483646)
        cursor_.fail("face " + std::to_string(n_faces_) + ": vertex out of range", std::to_string(corner));
    for (std::size_t i = 1; i + 1 < corners.size(); ++i) {
      triangles_.push_back(
          {static_cast<int>(corners[0]), static_cast<int>(corners[i]), static_cast<int>(corners[i + 1])});
      face_of_triangle_.push_back(n_faces_);
    }
    ++n_faces_;
  }

  long long n_vertices() const { return static_cast<long long>(vertices_.size()); }
  long long n_faces() const { return n_faces_; }

  SurfaceMesh finish() const {
    if (triangles_.empty()) throw InputError(cursor_.name(), "no faces");
    SurfaceMesh surface;
    surface.vertices_m.resize(static_cast<Eigen::Index>(vertices_.size()), 3);
    for (std::size_t i = 0; i < vertices_.size(); ++i)
      for (int a = 0; a < 3; ++a) surface.vertices_m(static_cast<Eigen::Index>(i), a) = vertices_[i][a];
    surface.triangles.resize(static_cast<Eigen::Index>(triangles_.size()), 3);
    for (std::size_t t = 0; t < triangles_.size(); ++t)
      for (int c = 0; c < 3; ++c) {
        if (triangles_[t][c] >= n_vertices())
          throw InputError(cursor_.name(), "face " + std::to_string(face_of_triangle_[t]) + ": vertex out of range",
                           std::to_string(triangles_[t][c]), "0 to " + std::to_string(n_vertices() - 1) + " (0-based)");
        surface.triangles(static_cast<Eigen::Index>(t), c) = triangles_[t][c];
      }
    return surface;
  }

 private:
  const ByteCursor& cursor_;
  std::vector<Vertex> vertices_;
  std::vector<Triangle> triangles_;
  std::vector<long long> face_of_triangle_;
  std::map<Vertex, int> welded_;
  long long n_faces_ = 0;
};

Vertex read_vertex(ByteCursor& cursor) {
  Vertex v;
  for (double& x : v) x = cursor.number("a coordinate");
  return v;
}

SurfaceMesh read_stl_binary(ByteCursor& cursor) {
  cursor.set_binary(true);
  cursor.skip(80, "the header");
  const std::size_t n = cursor.checked_count(cursor.raw<std::uint32_t>("the face count"), "the face count", 50);
  SurfaceBuilder builder(cursor);
  for (std::size_t t = 0; t < n; ++t) {
    const std::string what = "face " + std::to_string(t);
    cursor.need(50, what);
    cursor.skip(12, what);
    Triangle triangle;
    for (int& corner : triangle) {
      Vertex v;
      for (double& x : v) x = cursor.raw<float>(what);
      corner = builder.welded_vertex(v);
    }
    cursor.skip(2, what);
    builder.add_triangle(triangle);
  }
  return builder.finish();
}

/// Whether an STL is binary. Binary files may begin with "solid" too, and may have bytes behind the last facet: then there
/// are bytes that no text has, and the facets that the header promises fit into the file.
bool is_binary_stl(ByteCursor& cursor, std::string_view bytes) {
  if (lower_case(cursor.peek_word().substr(0, 5)) != "solid") return true;
  if (bytes.size() < 84) return false;
  std::uint32_t n = 0;
  std::memcpy(&n, bytes.data() + 80, 4);
  const std::uint64_t promised = 84 + std::uint64_t{50} * n;
  if (promised == bytes.size()) return true;
  const std::string_view body = bytes.substr(80, 2000);
  const bool no_text = std::any_of(body.begin(), body.end(), [](char c) { return c >= '\0' && c < '\t'; });
  return n > 0 && promised <= bytes.size() && no_text;
}

SurfaceMesh read_stl(ByteCursor& cursor, std::string_view bytes, SurfaceRepairs& repairs) {
  if (is_binary_stl(cursor, bytes)) {
    cursor.seek(0);
    SurfaceMesh surface = read_stl_binary(cursor);
    repairs.n_extra_bytes = static_cast<std::int64_t>(cursor.remaining());
    return surface;
  }
  cursor.line();
  SurfaceBuilder builder(cursor);
  const auto expect = [&](std::string_view wanted) {
    const std::string_view word = cursor.word(wanted);
    if (lower_case(word) != wanted) cursor.fail("unexpected word", word.substr(0, 32), wanted);
  };
  for (std::size_t face = 0; cursor.skip_blanks(); ++face) {
    const std::string keyword = lower_case(cursor.peek_word());
    if (keyword == "endsolid" || keyword == "solid") {
      cursor.line();
      continue;
    }
    expect("facet");
    expect("normal");
    for (int i = 0; i < 3; ++i) cursor.word("a normal");  // not used, and often "nan"
    expect("outer");
    expect("loop");
    Triangle triangle;
    for (int& corner : triangle) {
      expect("vertex");
      corner = builder.welded_vertex(read_vertex(cursor));
    }
    expect("endloop");
    expect("endfacet");
    builder.add_triangle(triangle);
  }
  return builder.finish();
}

/// A vertex or face of an OBJ whose line ends in a backslash. Remarks and names of files may end so by themselves.
bool goes_on(std::string_view line) {
  if (line.empty() || line.back() != '\\') return false;
  const std::vector<std::string_view> words = split_words(line);
  return words[0] == "v" || words[0] == "f";
}

SurfaceMesh read_obj(ByteCursor& cursor) {
  SurfaceBuilder builder(cursor);
  std::string joined;
  std::vector<long long> corners;
  while (cursor.skip_blanks()) {
    const std::size_t begin = cursor.position();
    std::string_view line = cursor.line();
    if (goes_on(line)) {
      joined = line;
      while (goes_on(joined) && cursor.remaining() > 0) {
        joined.back() = ' ';
        joined += cursor.line();
      }
      line = joined;
    }
    const auto fail = [&](const std::string& problem, std::string_view value) {
      cursor.seek(begin);
      cursor.fail(problem, value.substr(0, 32));
    };
    line = line.substr(0, line.find('#'));
    const std::vector<std::string_view> words = split_words(line);
    if (words.empty()) continue;
    if (words[0] == "v") {
      Vertex v{};
      if (words.size() < 4) fail("vertex without three coordinates", line);
      for (int a = 0; a < 3; ++a)
        if (!parse_number(words[a + 1], v[a])) fail("a coordinate is not a number", words[a + 1]);
      for (const double x : v)
        if (!std::isfinite(x)) fail("vertex " + std::to_string(builder.n_vertices()) + " is not finite", line);
      builder.add_vertex(v);
    } else if (words[0] == "f") {
      corners.clear();
      for (std::size_t i = 1; i < words.size(); ++i) {
        long long index = 0;  // from 1, or from the end when negative; v, v/vt, v//vn, v/vt/vn
        if (!parse_integer(words[i].substr(0, words[i].find('/')), index) || index == 0 ||
            index < -builder.n_vertices() || index > 2147483646)
          fail("face " + std::to_string(builder.n_faces()) + ": vertex out of range", words[i]);
        corners.push_back(index > 0 ? index - 1 : builder.n_vertices() + index);
      }
      if (corners.size() < 3) fail("face " + std::to_string(builder.n_faces()) + " has too few corners", line);
      builder.add_polygon(corners);
    }  // everything else (normals, groups, materials, curves) does not matter here
  }
  return builder.finish();
}

SurfaceMesh read_off(ByteCursor& cursor) {
  cursor.set_comment('#');
  std::string keyword(cursor.peek_word());
  int n_extra = 0;  // numbers after the coordinates
  if (keyword == "OFF" || keyword == "COFF" || keyword == "NOFF" || keyword == "CNOFF" || keyword == "NCOFF") {
    cursor.word("OFF");
    if (keyword.find("N") != std::string::npos) n_extra += 3;
    if (keyword.find("C") != std::string::npos) n_extra += -1;  // colours: the rest of the line
    if (cursor.peek_word() == "BINARY") cursor.fail("binary OFF is not supported", "", "ASCII");
  } else {
    long long unused = 0;
    if (!parse_integer(keyword, unused)) cursor.fail("not an OFF file", keyword.substr(0, 32), "OFF");
  }
  const std::size_t n_vertices = cursor.count("the vertex count", 6);
  const std::size_t n_faces = cursor.count("the face count", 8);
  cursor.integer("the edge count");
  SurfaceBuilder builder(cursor);
  for (std::size_t i = 0; i < n_vertices; ++i) {
    builder.add_vertex(read_vertex(cursor));
    if (n_extra != 0) cursor.line();
  }
  std::vector<long long> corners;
  for (std::size_t f = 0; f < n_faces; ++f) {
    const std::size_t n = cursor.count("the corner count of face " + std::to_string(f), 2);
    corners.clear();
    for (std::size_t i = 0; i < n; ++i) corners.push_back(cursor.integer("a corner of face " + std::to_string(f)));
    builder.add_polygon(corners);
    cursor.line();  // colours
  }
  return builder.finish();
}

struct PlyProperty {
  std::string name, type, count_type;  ///< count_type set for lists
};
struct PlyElement {
  std::string name;
  std::size_t count = 0;
  std::vector<PlyProperty> properties;
};

std::size_t ply_size(ByteCursor& cursor, std::string_view type) {
  static const std::map<std::string, std::size_t, std::less<>> kSizes{
      {"char", 1},  {"uchar", 1},   {"int8", 1},   {"uint8", 1},  {"short", 2}, {"ushort", 2},
      {"int16", 2}, {"uint16", 2},  {"int", 4},    {"uint", 4},   {"int32", 4}, {"uint32", 4},
      {"float", 4}, {"float32", 4}, {"double", 8}, {"float64", 8}};
  const auto it = kSizes.find(type);
  if (it == kSizes.end()) cursor.fail("unknown property type", type.substr(0, 32), "char to double");
  return it->second;
}

double ply_value(ByteCursor& cursor, const std::string& type, bool ascii, bool swapped, std::string_view what) {
  if (ascii) return cursor.number(what);
  if (type == "char" || type == "int8") return cursor.raw<std::int8_t>(what);
  if (type == "uchar" || type == "uint8") return cursor.raw<std::uint8_t>(what);
  if (type == "short" || type == "int16") return cursor.raw<std::int16_t>(what, swapped);
  if (type == "ushort" || type == "uint16") return cursor.raw<std::uint16_t>(what, swapped);
  if (type == "int" || type == "int32") return cursor.raw<std::int32_t>(what, swapped);
  if (type == "uint" || type == "uint32") return cursor.raw<std::uint32_t>(what, swapped);
  if (type == "float" || type == "float32") return cursor.raw<float>(what, swapped);
  return cursor.raw<double>(what, swapped);
}

SurfaceMesh read_ply(ByteCursor& cursor) {
  if (cursor.line() != "ply") cursor.fail("not a PLY file", "", "first line ply");
  bool ascii = true, swapped = false, have_format = false;
  std::vector<PlyElement> elements;
  while (true) {
    if (cursor.remaining() == 0) cursor.fail("the header does not end", "", "end_header");
    const std::vector<std::string_view> words = split_words(cursor.line());
    if (words.empty() || words[0] == "comment" || words[0] == "obj_info") continue;
    if (words[0] == "end_header") break;
    if (words[0] == "format" && words.size() >= 2) {
      ascii = words[1] == "ascii";
      swapped = words[1] == "binary_big_endian";
      if (!ascii && !swapped && words[1] != "binary_little_endian")
        cursor.fail("unknown format", words[1].substr(0, 32));
      have_format = true;
    } else if (words[0] == "element" && words.size() == 3) {
      long long n = 0;
      if (!parse_integer(words[2], n)) cursor.fail("element count is not an integer", words[2].substr(0, 32));
      elements.push_back(
          {std::string(words[1]),
           cursor.checked_count(static_cast<double>(n), "the count of " + std::string(words[1].substr(0, 32)), 1),
           {}});
    } else if (words[0] == "property" && words.size() == 3 && !elements.empty()) {
      ply_size(cursor, words[1]);
      elements.back().properties.push_back({std::string(words[2]), std::string(words[1]), ""});
    } else if (words[0] == "property" && words.size() == 5 && words[1] == "list" && !elements.empty()) {
      ply_size(cursor, words[2]);
      ply_size(cursor, words[3]);
      elements.back().properties.push_back({std::string(words[4]), std::string(words[3]), std::string(words[2])});
    } else {
      cursor.fail("unknown header line", words[0].substr(0, 32));
    }
  }
  if (!have_format) cursor.fail("the header has no format line");

  cursor.set_binary(!ascii);
  SurfaceBuilder builder(cursor);
  std::vector<long long> corners;
  for (const PlyElement& element : elements) {
    const bool is_vertex = element.name == "vertex", is_face = element.name == "face";
    if (element.properties.empty() && element.count > 0)
      cursor.fail("element without properties", element.name.substr(0, 32));
    for (std::size_t i = 0; i < element.count; ++i) {
      Vertex v{HUGE_VAL, HUGE_VAL, HUGE_VAL};
      bool have_corners = false;
      for (const PlyProperty& property : element.properties) {
        if (property.count_type.empty()) {
          const double value = ply_value(cursor, property.type, ascii, swapped, "a value");
          if (is_vertex && property.name.size() == 1 && property.name[0] >= 'x' && property.name[0] <= 'z')
            v[property.name[0] - 'x'] = value;
          continue;
        }
        const std::size_t n =
            cursor.checked_count(ply_value(cursor, property.count_type, ascii, swapped, "a list count"), "a list count",
                                 ascii ? 2 : ply_size(cursor, property.type));
        const bool is_corners = is_face && (property.name == "vertex_indices" || property.name == "vertex_index");
        if (is_corners) corners.clear();
        for (std::size_t k = 0; k < n; ++k) {
          const double value = ply_value(cursor, property.type, ascii, swapped, "a list value");
          if (!is_corners) continue;
          if (!(value >= 0.0 && value <= 2147483646.0 && value == std::floor(value)))
            cursor.fail("face " + std::to_string(i) + ": vertex out of range", to_text(value));
          corners.push_back(static_cast<long long>(value));
        }
        have_corners |= is_corners;
      }
      if (is_vertex) builder.add_vertex(v);
      if (is_face) {
        if (!have_corners) cursor.fail("faces without vertex_indices");
        builder.add_polygon(corners);
      }
    }
  }
  return builder.finish();
}

}  // namespace

bool is_surface_file(const std::filesystem::path& path) {
  const std::string extension = lower_case(path.extension().string());
  return extension == ".stl" || extension == ".obj" || extension == ".ply" || extension == ".off";
}

SurfaceMesh read_surface_bytes(std::string_view bytes, std::string_view extension, const std::string& name,
                               SurfaceRepairs* repairs) {
  if (bytes.empty()) throw InputError(name, "the file is empty");
  ByteCursor cursor(bytes, name);
  const std::string kind = lower_case(extension);
  SurfaceRepairs unheard;
  if (kind == ".stl") return read_stl(cursor, bytes, repairs != nullptr ? *repairs : unheard);
  if (kind == ".obj") return read_obj(cursor);
  if (kind == ".ply") return read_ply(cursor);
  if (kind == ".off") return read_off(cursor);
  throw InputError(name, "unknown surface format", kind, ".stl, .obj, .ply, .off");
}

SurfaceMesh read_surface(const std::filesystem::path& path) {
  return read_surface_bytes(read_file(path), path.extension().string(), path.string());
}

SurfaceMesh read_mended_surface(const std::filesystem::path& path, SurfaceRepairs& repairs) {
  SurfaceRepairs of_file;
  const SurfaceMesh read = read_surface_bytes(read_file(path), path.extension().string(), path.string(), &of_file);
  SurfaceMesh surface = repaired_surface(read, path.string(), repairs);
  repairs.n_extra_bytes = of_file.n_extra_bytes;
  return surface;
}

std::string without_continued_lines(std::string_view obj) {
  std::string text;
  ByteCursor cursor(obj, {});
  while (cursor.remaining() > 0) {
    std::string line(cursor.line());
    while (goes_on(line) && cursor.remaining() > 0) {
      line.back() = ' ';
      line += cursor.line();
    }
    text += line + "\n";
  }
  return text;
}

void write_stl(const std::filesystem::path& path, const SurfaceMesh& surface) {
  std::string bytes(80, ' ');
  const auto put = [&bytes](const auto& value) { bytes.append(reinterpret_cast<const char*>(&value), sizeof value); };
  put(static_cast<std::uint32_t>(surface.triangles.rows()));
  for (Eigen::Index t = 0; t < surface.triangles.rows(); ++t) {
    std::array<Eigen::Vector3d, 3> p;
    for (int c = 0; c < 3; ++c) p[c] = surface.vertices_m.row(surface.triangles(t, c));
    const Eigen::Vector3d normal = (p[1] - p[0]).cross(p[2] - p[0]).normalized();
    for (int a = 0; a < 3; ++a) put(static_cast<float>(normal[a]));
    for (const Eigen::Vector3d& point : p)
      for (int a = 0; a < 3; ++a) put(static_cast<float>(point[a]));
    put(std::uint16_t{0});
  }
  write_file(path, bytes);
}

}  // namespace klang::mesh
