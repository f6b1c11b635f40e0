#pragma once
#include <filesystem>
#include <string>
#include <string_view>

#include "core/geometry/mesh/surface_repair.hpp"
#include "core/geometry/mesh/tet_mesh.hpp"

namespace klang::mesh {

/// True for .stl, .obj, .ply, .off (any case).
bool is_surface_file(const std::filesystem::path& path);

/// Triangles of an STL (ASCII, binary), OBJ, PLY (ASCII, binary of either byte order) or OFF file, in the
/// file's unit (the caller scales to metres). Polygons are cut into fans of triangles; texture, normals and
/// colours are left out; lines of an OBJ may go on behind a backslash. Vertices of an STL that agree to the last bit become one (0.0 and -0.0 too). The
/// result is numbered as in the file, but not checked: see check_closed_surface.
/// @throws InputError naming the line, byte or face (0-based): unreadable, truncated, no number, not finite,
/// index out of range, fewer than three corners, no faces
SurfaceMesh read_surface(const std::filesystem::path& path);

/// As read_surface on bytes in memory; extension with its dot (".stl"), name for messages.
/// repairs, where given: counts bytes behind the last facet of a binary STL.
SurfaceMesh read_surface_bytes(std::string_view bytes, std::string_view extension, const std::string& name,
                               SurfaceRepairs* repairs = nullptr);

/// read_surface() and repaired_surface(); repairs says what was mended.
SurfaceMesh read_mended_surface(const std::filesystem::path& path, SurfaceRepairs& repairs);

/// An OBJ's text with the vertices and faces whose line ends in a backslash joined with the next line.
std::string without_continued_lines(std::string_view obj);

/// Binary STL (32-bit coordinates) of the corner triangles.
void write_stl(const std::filesystem::path& path, const SurfaceMesh& surface);

}  // namespace klang::mesh
