#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkIntArray.h>
#include <vtkNew.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkXMLPolyDataWriter.h>
#include <zlib.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <list>
#include <mutex>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/output_file.hpp"
#include "core/physics/liquid/surface.hpp"
#include "core/sound/dual_domain/boundary_file.hpp"
#include "core/sound/liquid_scene/run_folder.hpp"

namespace klang::liquid_scene {
namespace {

constexpr double kLargestScale = 1e6;  // metres and metres per second
constexpr char kFieldMagic[8] = {'K', 'L', 'F', '2', '\r', '\n', 0, 0};

struct FieldHeader {
  char magic[8];
  std::int32_t nx, ny, nz, has_velocity;
  double cell_m;
  double scale[4];  ///< phi and the three components: value of one unit
};

/// @return whether all are numbers
bool append(const liquid::Field& field, double& scale, std::vector<std::int16_t>& words) {
  double most = 0.0;
  for (const double value : field.data()) {
    if (!std::isfinite(value)) return false;
    most = std::max(most, std::abs(value));
  }
  scale = most > 0.0 ? most / 32767.0 : 1.0;
  for (const double value : field.data()) words.push_back(static_cast<std::int16_t>(std::lround(value / scale)));
  return true;
}

/// Differences to the entry before: small numbers, which compress well.
void difference(std::vector<std::int16_t>& words) {
  std::uint16_t before = 0;
  for (std::int16_t& word : words) {
    const auto value = static_cast<std::uint16_t>(word);
    word = static_cast<std::int16_t>(static_cast<std::uint16_t>(value - before));
    before = value;
  }
}

void integrate(std::vector<std::int16_t>& words) {
  std::uint16_t value = 0;
  for (std::int16_t& word : words) {
    value = static_cast<std::uint16_t>(value + static_cast<std::uint16_t>(word));
    word = static_cast<std::int16_t>(value);
  }
}

}  // namespace

void write_surface(const std::filesystem::path& path, const liquid::LiquidSurface& surface) {
  vtkNew<vtkPolyData> data;
  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  const auto& v = surface.surface.vertices_m;
  points->SetNumberOfPoints(v.rows());
  for (Eigen::Index i = 0; i < v.rows(); ++i) points->SetPoint(i, v(i, 0), v(i, 1), v(i, 2));
  data->SetPoints(points);
  vtkNew<vtkCellArray> cells;
  vtkNew<vtkIntArray> region;
  region->SetName("region");
  for (Eigen::Index t = 0; t < surface.surface.triangles.rows(); ++t) {
    const vtkIdType ids[3] = {surface.surface.triangles(t, 0), surface.surface.triangles(t, 1),
                              surface.surface.triangles(t, 2)};
    cells->InsertNextCell(3, ids);
    region->InsertNextValue(surface.region[static_cast<std::size_t>(t)]);
  }
  data->SetPolys(cells);
  data->GetCellData()->AddArray(region);
  vtkNew<vtkXMLPolyDataWriter> writer;
  writer->SetInputData(data);
  writer->SetDataModeToAppended();
  writer->EncodeAppendedDataOff();
  writer->SetCompressorTypeToZLib();
  writer->SetCompressionLevel(1);
  writer->WriteToOutputStringOn();
  if (writer->Write() == 0) throw InputError(path.string(), "the surface could not be encoded");
  write_file(path, writer->GetOutputString());
}

void write_fields(const std::filesystem::path& path, const liquid::GridShape& shape, const liquid::Field& phi,
                  const std::optional<liquid::MacGrid>& u) {
  FieldHeader header{};
  std::memcpy(header.magic, kFieldMagic, sizeof kFieldMagic);
  header.nx = shape.nx;
  header.ny = shape.ny;
  header.nz = shape.nz;
  header.cell_m = shape.cell_m;
  std::vector<std::int16_t> words;
  bool numbers = append(phi, header.scale[0], words);
  header.has_velocity = u ? 1 : 0;
  for (int axis = 0; u && axis < 3 && numbers; ++axis) numbers = append((*u)[axis], header.scale[axis + 1], words);
  if (!numbers) throw NumericalError(path.string() + ": the frame's fields hold a value that is no number");
  difference(words);
  const auto n_bytes = static_cast<uLong>(words.size() * sizeof(std::int16_t));
  uLongf n_packed = compressBound(n_bytes);
  std::string bytes(sizeof header + n_packed, '\0');
  std::memcpy(bytes.data(), &header, sizeof header);
  if (compress2(reinterpret_cast<Bytef*>(bytes.data() + sizeof header), &n_packed,
                reinterpret_cast<const Bytef*>(words.data()), n_bytes, 1) != Z_OK)
    throw InputError(path.string(), "the fields could not be encoded");
  bytes.resize(sizeof header + n_packed);
  write_file(path, bytes);
}

FrameFields read_fields_file(const std::filesystem::path& path) {
  const std::string bytes = read_file(path);
  FieldHeader header;
  if (bytes.size() < sizeof header || std::memcmp(bytes.data(), kFieldMagic, sizeof kFieldMagic) != 0)
    throw InputError(path.string(), "is no file of fields");
  std::memcpy(&header, bytes.data(), sizeof header);
  const auto in_range = [](std::int32_t n) { return n >= 1 && n <= 20000; };
  const auto is_scale = [](double scale) { return scale >= 0.0 && scale <= kLargestScale; };
  if (!std::all_of(header.scale, header.scale + (header.has_velocity == 1 ? 4 : 1), is_scale) || !in_range(header.nx) ||
      !in_range(header.ny) || !in_range(header.nz) || static_cast<double>(header.nx) * header.ny * header.nz > 6.5e7 ||
      !(header.cell_m > 0.0))
    throw InputError(path.string(), "has a header that makes no sense");
  constexpr double kMostPacked = 1032.0;  // bytes of what zlib unpacks, per byte
  if (2.0 * header.nx * header.ny * header.nz > kMostPacked * static_cast<double>(bytes.size()))
    throw InputError(path.string(), "is damaged or cut off");
  FrameFields fields;
  fields.shape = {header.nx, header.ny, header.nz, header.cell_m};
  fields.phi_m = liquid::Field(header.nx, header.ny, header.nz);
  if (header.has_velocity == 1) fields.u = liquid::MacGrid(fields.shape);
  std::size_t n = fields.phi_m.size();
  for (int axis = 0; fields.u && axis < 3; ++axis) n += (*fields.u)[axis].size();
  std::vector<std::int16_t> words(n);
  uLongf n_bytes = n * sizeof(std::int16_t);
  if (uncompress(reinterpret_cast<Bytef*>(words.data()), &n_bytes,
                 reinterpret_cast<const Bytef*>(bytes.data() + sizeof header), bytes.size() - sizeof header) != Z_OK ||
      n_bytes != n * sizeof(std::int16_t))
    throw InputError(path.string(), "is damaged or cut off");
  integrate(words);
  std::size_t at = 0;
  for (double& value : fields.phi_m.data()) value = header.scale[0] * words[at++];
  for (int axis = 0; fields.u && axis < 3; ++axis)
    for (double& value : (*fields.u)[axis].data()) value = header.scale[axis + 1] * words[at++];
  return fields;
}

namespace {

double phi_of(const FrameFields& fields, const Eigen::Vector3d& x_m) {
  return liquid::at_centres(fields.phi_m, x_m, fields.shape.cell_m);
}

std::optional<Eigen::Vector3d> velocity_of(const FrameFields& fields, const Eigen::Vector3d& x_m) {
  if (!fields.u) return std::nullopt;
  return liquid::velocity_at(*fields.u, x_m, fields.shape.cell_m);
}

/// Some frames in memory; all else by those that they are of.
class FramesInMemory : public liquid::LiquidFrames {
 public:
  FramesInMemory(const liquid::LiquidFrames& all, std::size_t first,
                 std::vector<std::shared_ptr<const FrameFields>> fields)
      : all_(all), first_(first), fields_(std::move(fields)) {}
  std::span<const double> time_s() const override { return all_.time_s(); }
  liquid::LiquidSurface boundary(std::size_t frame) const override { return all_.boundary(frame); }
  double phi_m(std::size_t frame, const Eigen::Vector3d& x_m) const override {
    return has(frame) ? phi_of(*fields_[frame - first_], x_m) : all_.phi_m(frame, x_m);
  }
  std::optional<Eigen::Vector3d> velocity_m_s(std::size_t frame, const Eigen::Vector3d& x_m) const override {
    return has(frame) ? velocity_of(*fields_[frame - first_], x_m) : all_.velocity_m_s(frame, x_m);
  }
  double cell_m() const override { return all_.cell_m(); }
  bool in_outlet(const Eigen::Vector3d& x_m) const override { return all_.in_outlet(x_m); }
  const std::vector<liquid::SeedEvent>* seeds() const override { return all_.seeds(); }

 private:
  bool has(std::size_t frame) const { return frame >= first_ && frame - first_ < fields_.size(); }
  const liquid::LiquidFrames& all_;
  const std::size_t first_;
  const std::vector<std::shared_ptr<const FrameFields>> fields_;
};

class FolderFrames : public liquid::LiquidFrames {
 public:
  FolderFrames(const LiquidScene& scene, const RunFolder& folder, std::size_t n_frames)
      : folder_(folder), outlets_(scene.setup.outlets), cell_m_(scene.setup.shape.cell_m) {
    for (std::size_t frame = 0; frame < n_frames; ++frame) times_.push_back(scene.frame_s(frame));
  }
  std::span<const double> time_s() const override { return times_; }
  liquid::LiquidSurface boundary(std::size_t frame) const override {
    bubble::BoundaryMesh mesh = bubble::read_boundary(folder_.frame_file(frame));
    return {std::move(mesh.surface), std::move(mesh.region)};
  }
  double phi_m(std::size_t frame, const Eigen::Vector3d& x_m) const override { return phi_of(*fields(frame), x_m); }
  std::optional<Eigen::Vector3d> velocity_m_s(std::size_t frame, const Eigen::Vector3d& x_m) const override {
    return velocity_of(*fields(frame), x_m);
  }
  std::shared_ptr<const LiquidFrames> held(std::size_t first, std::size_t last) const override {
    std::vector<std::shared_ptr<const FrameFields>> those;
    for (std::size_t frame = first; frame <= last; ++frame) those.push_back(fields(frame));
    return std::make_shared<FramesInMemory>(*this, first, std::move(those));
  }
  double cell_m() const override { return cell_m_; }
  bool in_outlet(const Eigen::Vector3d& x_m) const override {
    for (const liquid::Outlet& outlet : outlets_)
      if ((x_m.array() > outlet.low_m.array()).all() && (x_m.array() < outlet.high_m.array()).all()) return true;
    return false;
  }

 private:
  static constexpr std::size_t kKept = 6;
  std::shared_ptr<const FrameFields> fields(std::size_t frame) const {
    const std::lock_guard lock(mutex_);
    for (auto it = kept_.begin(); it != kept_.end(); ++it)
      if (it->first == frame) {
        kept_.splice(kept_.begin(), kept_, it);
        return kept_.front().second;
      }
    kept_.emplace_front(frame, std::make_shared<const FrameFields>(read_fields_file(folder_.field_file(frame))));
    if (kept_.size() > kKept) kept_.pop_back();
    return kept_.front().second;
  }

  RunFolder folder_;
  std::vector<liquid::Outlet> outlets_;
  double cell_m_;
  std::vector<double> times_;
  mutable std::mutex mutex_;
  mutable std::list<std::pair<std::size_t, std::shared_ptr<const FrameFields>>> kept_;
};

}  // namespace

std::unique_ptr<liquid::LiquidFrames> folder_frames(const LiquidScene& scene, const RunFolder& folder,
                                                    std::size_t n_frames) {
  return std::make_unique<FolderFrames>(scene, folder, n_frames);
}

}  // namespace klang::liquid_scene
