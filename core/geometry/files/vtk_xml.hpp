#pragma once
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/geometry/mesh/tet_mesh.hpp"

namespace klang::mesh {

/// Where an array of a VTK file belongs.
enum class VtkPlace { kPointData, kCellData, kFieldData };

/// An array, values interleaved. One of the two lists is filled: reals for Float32 and Float64, integers for the others.
struct VtkArray {
  std::string type;  ///< as the file says: "Float64", "Int32", ...
  std::int64_t n_components = 1;
  std::vector<double> reals;
  std::vector<std::int64_t> integers;
  std::size_t size() const { return reals.empty() ? integers.size() : reals.size(); }
  double number(std::size_t i) const { return reals.empty() ? static_cast<double>(integers[i]) : reals[i]; }
};

/// Corners of cell c: connectivity[offsets[c - 1]] (0 for c = 0) up to offsets[c]. Every index is one of a point.
struct VtkCells {
  std::vector<std::int64_t> connectivity, offsets;
  std::vector<int> types;  ///< VTK's numbers: 10 tetrahedron, 5 triangle, ...
  std::int64_t begin(std::size_t cell) const { return cell == 0 ? 0 : offsets[cell - 1]; }
};

/// A VTK XML file of an unstructured grid (.vtu) or of polygons (.vtp), read without VTK: its own reader trusts the counts and indices
/// of a file and ends the program where they lie. Here every length is held against the bytes that are there before memory is
/// taken, what is unpacked in all is at most 200 times the file (or 256 MB), and indices are checked. ASCII, base64 and appended
/// (raw, base64) data, either byte order, UInt32 and UInt64 headers, zlib, LZ4 and LZMA; several pieces become one.
/// Every function throws InputError with the file's name, the element or array, and what is wrong.
class VtkXmlFile {
 public:
  /// type: "UnstructuredGrid" or "PolyData".
  VtkXmlFile(std::string bytes, std::string name, std::string_view type);
  ~VtkXmlFile();
  VtkXmlFile(VtkXmlFile&&) noexcept;
  VtkXmlFile& operator=(VtkXmlFile&&) noexcept;

  const std::string& name() const;
  std::int64_t n_points() const;
  std::int64_t n_cells() const;
  Points points() const;
  /// Verts, lines, polys and strips in this order for PolyData, with the types that VTK gives them.
  VtkCells cells() const;
  std::vector<std::string> array_names(VtkPlace place) const;
  /// Nothing where there is none; an array of points or cells has n_components values for each of them.
  std::optional<VtkArray> find(VtkPlace place, std::string_view array) const;
  /// First text of an array of texts in the field data.
  std::optional<std::string> find_text(std::string_view array) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace klang::mesh
