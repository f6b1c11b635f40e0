#include "core/sound/dual_domain/boundary_file.hpp"

#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkCellType.h>
#include <vtkDoubleArray.h>
#include <vtkIntArray.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkXMLPolyDataWriter.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <sstream>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/output_file.hpp"
#include "core/foundation/base/parallel.hpp"
#include "core/geometry/files/byte_cursor.hpp"
#include "core/geometry/files/surface_file.hpp"
#include "core/geometry/files/vtk_xml.hpp"

namespace klang::bubble {
namespace {

using Eigen::Index;
using Eigen::Vector3d;

/// Normals that the file carries must point the way its faces do.
void check_normals(const mesh::VtkXmlFile& file, const BoundaryMesh& mesh, const std::vector<std::size_t>& cell_of) {
  const auto normals_of = [&](mesh::VtkPlace place) {
    std::optional<mesh::VtkArray> array = file.find(place, "Normals");
    if (array && array->n_components != 3) array.reset();
    return array;
  };
  const std::optional<mesh::VtkArray> of_cells = normals_of(mesh::VtkPlace::kCellData),
                                      of_points = normals_of(mesh::VtkPlace::kPointData);
  const auto normal = [](const mesh::VtkArray& a, std::size_t i) {
    return Vector3d(a.number(3 * i), a.number(3 * i + 1), a.number(3 * i + 2));
  };
  for (Index t = 0; t < mesh.surface.triangles.rows(); ++t) {
    Vector3d p[3];
    bool all_against = of_points.has_value();
    for (int c = 0; c < 3; ++c) p[c] = mesh.surface.vertices_m.row(mesh.surface.triangles(t, c)).transpose();
    const Vector3d face = (p[1] - p[0]).cross(p[2] - p[0]);
    for (int c = 0; c < 3 && all_against; ++c)
      all_against = normal(*of_points, static_cast<std::size_t>(mesh.surface.triangles(t, c))).dot(face) < 0.0;
    const std::size_t cell = cell_of[static_cast<std::size_t>(t)];
    if (all_against || (of_cells && normal(*of_cells, cell).dot(face) < 0.0))
      throw InputError(file.name(), "inconsistent normals: the array Normals at face " + std::to_string(cell) +
                                        " points against the order of its corners");
  }
}

BoundaryMesh read_vtk(const std::filesystem::path& path, bool polygons, bool needs_regions) {
  const std::string name = path.string();
  const mesh::VtkXmlFile file(read_file(path), name, polygons ? "PolyData" : "UnstructuredGrid");
  BoundaryMesh mesh;
  mesh.name = name;
  mesh.surface.vertices_m = file.points();
  const std::optional<mesh::VtkArray> region = file.find(mesh::VtkPlace::kCellData, "region");
  if (!region && needs_regions)
    throw InputError(name, "the cell array \"region\" is missing", {}, "per face: 0 free surface, 1 rigid wall");
  const mesh::VtkCells cells = file.cells();
  std::vector<Eigen::Vector3i> triangles;
  std::vector<std::size_t> cell_of;
  for (std::size_t cell = 0; cell < cells.types.size(); ++cell) {
    const int type = cells.types[cell];
    if (type == VTK_VERTEX || type == VTK_POLY_VERTEX || type == VTK_LINE || type == VTK_POLY_LINE ||
        type == VTK_EMPTY_CELL)
      continue;
    if (type != VTK_TRIANGLE && type != VTK_QUAD && type != VTK_POLYGON)
      throw InputError(name, "face " + std::to_string(cell) + " is no triangle, quad or polygon",
                       "VTK cell type " + std::to_string(type), "5, 7, 9");
    const double value = region ? region->number(cell * static_cast<std::size_t>(region->n_components)) : 0.0;
    if (!(std::floor(value) == value && value >= 0.0 && value <= 3.0))
      throw InputError(name, "face " + std::to_string(cell) + " has an unknown region", to_text(value),
                       "0 free surface, 1 rigid wall, 2 solid in the liquid, 3 its dry part");
    const auto corner = [&](std::int64_t i) {
      return static_cast<int>(cells.connectivity[static_cast<std::size_t>(cells.begin(cell) + i)]);
    };
    const std::int64_t n_corners = cells.offsets[cell] - cells.begin(cell);
    if (n_corners < 3)
      throw InputError(name, "face " + std::to_string(cell) + " has too few corners", std::to_string(n_corners),
                       "3 or more");
    for (std::int64_t c = 1; c + 1 < n_corners; ++c) {
      triangles.emplace_back(corner(0), corner(c), corner(c + 1));
      if (region) mesh.region.push_back(static_cast<int>(value));
      cell_of.push_back(cell);
    }
  }
  mesh.surface.triangles.resize(static_cast<Index>(triangles.size()), 3);
  for (std::size_t t = 0; t < triangles.size(); ++t)
    mesh.surface.triangles.row(static_cast<Index>(t)) = triangles[t].transpose();
  check_normals(file, mesh, cell_of);
  return mesh;
}

BoundaryMesh read_obj(const std::filesystem::path& path) {
  BoundaryMesh mesh;
  mesh.name = path.string();
  const std::string bytes = read_file(path);
  mesh.surface = mesh::read_surface_bytes(bytes, ".obj", mesh.name);
  // A second reading for what the surface reader leaves out: the groups.
  std::istringstream lines(mesh::without_continued_lines(bytes));
  int region = 0;
  for (std::string line; std::getline(lines, line);) {
    const std::string before_comment = line.substr(0, line.find('#'));
    const std::vector<std::string_view> words = mesh::split_words(before_comment);
    if (words.empty()) continue;
    if (words[0] == "f") {
      mesh.region.insert(mesh.region.end(), words.size() - 3, region);
    } else if ((words[0] == "g" || words[0] == "o" || words[0] == "usemtl") && words.size() > 1) {
      const std::string_view last = words.back();
      const std::size_t digits = last.find_last_not_of("0123456789") + 1;  // npos + 1 = 0: all digits
      long long number = 0;
      if (digits < last.size() && mesh::parse_integer(last.substr(digits), number))
        region = static_cast<int>(std::min<long long>(number, 99));  // unknown ones are refused by face
    }
  }
  if (mesh.region.size() != static_cast<std::size_t>(mesh.surface.triangles.rows()))
    throw InputError(mesh.name, "groups of faces cannot be read");
  return mesh;
}

std::string lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

BoundaryFrames read_pvd(const std::filesystem::path& path) {
  const std::string bytes = read_file(path);
  BoundaryFrames frames;
  const auto attribute = [](const std::string& element, const std::string& key) -> std::string {
    const std::size_t at = element.find(key + "=\"");
    if (at == std::string::npos) return {};
    const std::size_t begin = at + key.size() + 2;
    return element.substr(begin, element.find('"', begin) - begin);
  };
  for (std::size_t at = bytes.find("<DataSet"); at != std::string::npos; at = bytes.find("<DataSet", at + 1)) {
    const std::string element = bytes.substr(at, bytes.find('>', at) - at);
    double time = 0.0;
    const std::string text = attribute(element, "timestep"), file = attribute(element, "file");
    if (!mesh::parse_number(text, time) || !std::isfinite(time) || file.empty())
      throw InputError(path.string(), "frame " + std::to_string(frames.files.size()) + " has no timestep or file",
                       text);
    frames.time_s.push_back(time);
    frames.files.push_back(path.parent_path() / file);
  }
  return frames;
}

BoundaryFrames numbered(const std::string& pattern, double frame_step_s) {
  const std::filesystem::path path(pattern);
  const std::string name = path.filename().string();
  const std::size_t first = name.find('#'), last = name.find_last_of('#');
  if (first == std::string::npos || name.find_first_not_of('#', first) <= last)
    throw OptionsError("", {{"boundary", "needs one run of # for the number", pattern, "drop_####.vtp"}});
  const std::string head = name.substr(0, first), tail = name.substr(last + 1);
  const std::size_t width = last - first + 1;
  const std::filesystem::path folder = path.has_parent_path() ? path.parent_path() : std::filesystem::path(".");
  std::map<long long, std::filesystem::path> found;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(folder, error)) {
    const std::string file = entry.path().filename().string();
    if (file.size() < head.size() + width + tail.size() || !file.starts_with(head) || !file.ends_with(tail)) continue;
    const std::string digits = file.substr(head.size(), file.size() - head.size() - tail.size());
    long long number = 0;
    if (digits.find_first_not_of("0123456789") != std::string::npos || (digits.size() > width && digits[0] == '0') ||
        !mesh::parse_integer(digits, number))
      continue;
    found[number] = folder / file;
  }
  if (found.empty()) throw OptionsError("", {{"boundary", "has no frames of this name", pattern}});
  BoundaryFrames frames;
  long long expected = found.begin()->first;
  for (const auto& [number, file] : found) {
    if (number != expected) {
      std::string missing = std::to_string(expected);
      missing.insert(0, missing.size() < width ? width - missing.size() : 0, '0');
      const std::string all =
          "every number from " + std::to_string(found.begin()->first) + " to " + std::to_string(found.rbegin()->first);
      throw OptionsError("", {{"boundary", "has a frame missing", (folder / (head + missing + tail)).string(), all}});
    }
    frames.time_s.push_back(static_cast<double>(number - found.begin()->first) * frame_step_s);
    frames.files.push_back(file);
    ++expected;
  }
  return frames;
}

BoundaryMesh read_any(const std::filesystem::path& path, double unit_m, bool needs_regions) {
  checked_open("boundary", "unit_m", unit_m, 0.0, 1e6);
  const std::string extension = lower(path.extension().string());
  BoundaryMesh mesh;
  if (extension == ".vtp" || extension == ".vtu") {
    mesh = read_vtk(path, extension == ".vtp", needs_regions);
  } else if (extension == ".obj") {
    mesh = read_obj(path);
  } else {
    throw InputError(path.string(), "unknown format of a boundary", extension, ".vtp, .vtu, .obj");
  }
  mesh.surface.vertices_m *= unit_m;
  return mesh;
}

}  // namespace

BoundaryMesh read_boundary(const std::filesystem::path& path, double unit_m) { return read_any(path, unit_m, true); }
BoundaryMesh read_boundary_without_regions(const std::filesystem::path& path, double unit_m) {
  return read_any(path, unit_m, false);
}

bool is_series(const std::string& name) {
  return std::filesystem::path(name).filename().string().find('#') != std::string::npos ||
         lower(std::filesystem::path(name).extension().string()) == ".pvd";
}

BoundaryFrames find_frames(const std::string& pattern, double frame_step_s) {
  const bool collection = lower(std::filesystem::path(pattern).extension().string()) == ".pvd";
  if (!collection) checked_open("boundary series", "frame_step_s", frame_step_s, 0.0, 1e3);
  const BoundaryFrames frames = collection ? read_pvd(pattern) : numbered(pattern, frame_step_s);
  if (frames.files.empty()) throw InputError(pattern, "the series has no frames");
  for (std::size_t i = 0; i < frames.files.size(); ++i) {
    std::error_code error;
    if (!std::filesystem::is_regular_file(frames.files[i], error))
      throw InputError(pattern, "a frame of the series is missing", frames.files[i].string());
    if (i > 0 && !(frames.time_s[i] > frames.time_s[i - 1]))
      throw InputError(pattern, "times of the series do not rise at frame " + std::to_string(i),
                       to_text(frames.time_s[i]));
  }
  return frames;
}

void write_boundary_solution(const std::filesystem::path& path, const BoundaryMesh& mesh,
                             const LiquidBoundary& boundary, const DualDomainResult& result,
                             double liquid_density_kg_m3) {
  const Index n_vertices = mesh.surface.vertices_m.rows(), n_triangles = mesh.surface.triangles.rows();
  const double per_slope =
      1.0 / (2.0 * kPi * result.frequency_hz * liquid_density_kg_m3);  // |v_n| = |dP/dn| / (omega rho)
  vtkNew<vtkPolyData> data;
  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  for (Index i = 0; i < n_vertices; ++i)
    points->InsertNextPoint(boundary.surface().vertices_m(boundary.welded_vertex(static_cast<int>(i)), 0),
                            boundary.surface().vertices_m(boundary.welded_vertex(static_cast<int>(i)), 1),
                            boundary.surface().vertices_m(boundary.welded_vertex(static_cast<int>(i)), 2));
  data->SetPoints(points);
  const auto new_array = [](const char* name, int components, Index n) {
    auto array = vtkSmartPointer<vtkDoubleArray>::New();
    array->SetName(name);
    array->SetNumberOfComponents(components);
    array->SetNumberOfTuples(n);
    array->Fill(0.0);
    return array;
  };
  const auto set = [&](vtkDoubleArray* slope, vtkDoubleArray* velocity, Index i, const std::complex<double>& value) {
    slope->SetComponent(i, 0, value.real());
    slope->SetComponent(i, 1, value.imag());
    velocity->SetComponent(i, 0, std::abs(value) * per_slope);
  };

  // A vertex as the file has it belongs to one region, or to several: free surface first, then the sample that faces its way.
  std::vector<std::vector<std::size_t>> samples_of(static_cast<std::size_t>(n_vertices));
  for (std::size_t s = 0; s < boundary.samples().size(); ++s)
    samples_of[static_cast<std::size_t>(boundary.samples()[s].vertex)].push_back(s);
  std::vector<Index> face_of(static_cast<std::size_t>(n_vertices), -1);
  for (Index t = 0; t < n_triangles; ++t)
    for (int c = 0; c < 3; ++c) {
      Index& face = face_of[static_cast<std::size_t>(mesh.surface.triangles(t, c))];
      if (face < 0 || mesh.region[static_cast<std::size_t>(t)] < mesh.region[static_cast<std::size_t>(face)]) face = t;
    }
  const auto normal_of = [&](Index t) {
    Vector3d p[3];
    for (int c = 0; c < 3; ++c)
      p[c] = boundary.surface().vertices_m.row(boundary.surface().triangles(t, c)).transpose();
    return Vector3d((p[1] - p[0]).cross(p[2] - p[0]).normalized());
  };
  auto point_slope = new_array("surface_normal_derivative", 2, n_vertices),
       point_velocity = new_array("surface_normal_velocity_m_s", 1, n_vertices);
  for (Index i = 0; i < n_vertices; ++i) {
    const Index face = face_of[static_cast<std::size_t>(i)];
    if (face < 0) continue;
    const Vector3d normal = normal_of(face);
    double best = -2.0;
    for (const std::size_t s : samples_of[static_cast<std::size_t>(boundary.welded_vertex(static_cast<int>(i)))]) {
      const BoundarySample& sample = boundary.samples()[s];
      if (static_cast<int>(sample.region) != mesh.region[static_cast<std::size_t>(face)] ||
          sample.normal.dot(normal) <= best)
        continue;
      best = sample.normal.dot(normal);
      set(point_slope, point_velocity, i, result.normal_derivative[static_cast<Index>(s)]);
    }
  }
  auto cell_slope = new_array("surface_normal_derivative", 2, n_triangles),
       cell_velocity = new_array("surface_normal_velocity_m_s", 1, n_triangles);
  std::vector<std::complex<double>> slopes(static_cast<std::size_t>(n_triangles));
  parallel_for(slopes.size(), 64, [&](std::size_t begin, std::size_t end) {
    for (std::size_t t = begin; t < end; ++t) {
      if (mesh.region[t] == static_cast<int>(BoundaryRegion::kDrySolid)) continue;
      Vector3d middle = Vector3d::Zero();
      for (int c = 0; c < 3; ++c)
        middle +=
            boundary.surface().vertices_m.row(boundary.surface().triangles(static_cast<Index>(t), c)).transpose() / 3.0;
      const Vector3d normal = normal_of(static_cast<Index>(t));
      if (normal.allFinite()) slopes[t] = liquid_pressure_slope(result, middle, normal);
    }
  });
  vtkNew<vtkCellArray> cells;
  vtkNew<vtkIntArray> region;
  region->SetName("region");
  for (Index t = 0; t < n_triangles; ++t) {
    const vtkIdType ids[3] = {mesh.surface.triangles(t, 0), mesh.surface.triangles(t, 1), mesh.surface.triangles(t, 2)};
    cells->InsertNextCell(3, ids);
    region->InsertNextValue(mesh.region[static_cast<std::size_t>(t)]);
    set(cell_slope, cell_velocity, t, slopes[static_cast<std::size_t>(t)]);
  }
  data->SetPolys(cells);
  data->GetPointData()->AddArray(point_slope);
  data->GetPointData()->AddArray(point_velocity);
  data->GetCellData()->AddArray(region);
  data->GetCellData()->AddArray(cell_slope);
  data->GetCellData()->AddArray(cell_velocity);
  vtkNew<vtkXMLPolyDataWriter> writer;
  writer->SetInputData(data);
  writer->SetDataModeToAppended();
  writer->EncodeAppendedDataOff();
  writer->SetCompressorTypeToNone();
  writer->WriteToOutputStringOn();
  if (writer->Write() == 0) throw InputError(path.string(), "the surface could not be encoded");
  write_file(path, writer->GetOutputString());
}

}  // namespace klang::bubble
