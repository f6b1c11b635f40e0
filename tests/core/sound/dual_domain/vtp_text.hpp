#pragma once
#include <sstream>
#include <string>

#include "core/sound/dual_domain/liquid_boundary.hpp"

namespace klang::test {

/// A .vtp with the cell array region, in plain text.
inline std::string vtp_text(const bubble::BoundaryMesh& mesh, const std::string& array_name = "region") {
  std::ostringstream out;
  out.precision(17);
  const auto n = mesh.surface.triangles.rows();
  out << "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"1.0\" "
         "byte_order=\"LittleEndian\">\n<PolyData>\n<Piece NumberOfPoints=\""
      << mesh.surface.vertices_m.rows()
      << "\" NumberOfVerts=\"0\" NumberOfLines=\"0\" NumberOfStrips=\"0\" NumberOfPolys=\"" << n
      << "\">\n<CellData><DataArray type=\"Int32\" Name=\"" << array_name << "\" format=\"ascii\">";
  for (const int r : mesh.region) out << r << ' ';
  out << "</DataArray></CellData>\n<Points><DataArray type=\"Float64\" NumberOfComponents=\"3\" format=\"ascii\">";
  for (Eigen::Index i = 0; i < mesh.surface.vertices_m.rows(); ++i)
    for (int a = 0; a < 3; ++a) out << mesh.surface.vertices_m(i, a) << ' ';
  out << "</DataArray></Points>\n<Polys><DataArray type=\"Int32\" Name=\"connectivity\" format=\"ascii\">";
  for (Eigen::Index t = 0; t < n; ++t)
    for (int c = 0; c < 3; ++c) out << mesh.surface.triangles(t, c) << ' ';
  out << "</DataArray><DataArray type=\"Int32\" Name=\"offsets\" format=\"ascii\">";
  for (Eigen::Index t = 1; t <= n; ++t) out << 3 * t << ' ';
  out << "</DataArray></Polys>\n</Piece>\n</PolyData>\n</VTKFile>\n";
  return out.str();
}

}  // namespace klang::test
