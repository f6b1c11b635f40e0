#include "core/physics/liquid_vdb/vdb_codec.hpp"

#include <openvdb/openvdb.h>

#include <cmath>
#include <cstdint>
#include <cstring>
#include <new>
#include <string_view>
#include <utility>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/output_file.hpp"

namespace klang::liquid {
namespace {

constexpr double kLeastBand = 2.0;

std::string words(double a, double b, double c) { return to_text(a) + ", " + to_text(b) + ", " + to_text(c); }

/// Calls what may throw OpenVDB's or the library's exceptions.
template <class Function>
auto guarded(const std::string& file, Function&& function) {
  try {
    openvdb::initialize();
    return function();
  } catch (const InputError&) {
    throw;
  } catch (const std::bad_alloc&) {
    throw InputError(file, "is no usable .vdb: it asks for more memory than a file of its size can fill");
  } catch (const std::exception& error) {
    std::string what = std::string(error.what()).substr(0, 200);  // it may quote the file
    for (char& c : what)
      if (static_cast<unsigned char>(c) < ' ' || c == '\x7f') c = ' ';
    what.resize(what.find_last_not_of(' ') + 1);
    throw InputError(file, "is no usable .vdb: " + what);
  }
}

/// Edge of the voxels and centre of voxel 0; refuses what is not a grid of cubes along the axes.
void read_transform(const openvdb::math::Transform& transform, const std::string& file, VdbExtent& extent) {
  if (!transform.isLinear()) throw InputError(file, "has voxels that are no cubes (a frustum)");
  const openvdb::Mat4d m = transform.baseMap()->getAffineMap()->getMat4();
  const double edge = std::abs(m(0, 0));
  for (int a = 0; a < 3; ++a)
    for (int b = 0; b < 3; ++b)
      if (a != b && std::abs(m(a, b)) > 1e-6 * edge)
        throw InputError(file, "has voxels that are turned against the axes");
  for (int a = 0; a < 3; ++a)
    if (!(m(a, a) > 0.0) || std::abs(m(a, a) / edge - 1.0) > 1e-5)
      throw InputError(file, "has voxels that are no cubes", words(m(0, 0), m(1, 1), m(2, 2)), "three equal edges");
  extent.voxel = edge;
  extent.first = {m(3, 0), m(3, 1), m(3, 2)};
}

/// |grad phi| next to the surface, in the mean: 1 for distances in the file's unit. Some programs write them in voxels.
double slope_at_surface(const openvdb::FloatGrid& phi, double voxel) {
  const auto values = phi.getConstAccessor();
  double sum = 0.0;
  std::size_t count = 0;
  for (auto it = phi.cbeginValueOn(); it; ++it) {
    if (!it.isVoxelValue()) continue;
    const openvdb::Coord here = it.getCoord();
    double square = 0.0;
    bool mixed = false;
    for (int axis = 0; axis < 3; ++axis) {
      openvdb::Coord below = here, above = here;
      --below[axis];
      ++above[axis];
      if (!values.isValueOn(below) || !values.isValueOn(above)) {
        mixed = false;
        break;
      }
      const double low = values.getValue(below), high = values.getValue(above);
      square += 0.25 * (high - low) * (high - low);
      mixed = mixed || (low < 0.0) != (*it < 0.0F) || (high < 0.0) != (*it < 0.0F);
    }
    if (!mixed) continue;
    sum += std::sqrt(square);
    ++count;
  }
  return count > 0 ? sum / static_cast<double>(count) / voxel : 1.0;
}

/// How far values are distances: what is beyond has one value, the background's (0: everything is stored).
/// @param unit  of the values, in voxels
double band_voxels(const openvdb::FloatGrid& phi, double unit) {
  double inside = 0.0, outside = 0.0;
  for (auto it = phi.cbeginValueOn(); it; ++it) {
    const double value = *it;
    inside = std::max(inside, -value);
    outside = std::max(outside, value);
  }
  const double background = std::abs(static_cast<double>(phi.background()));
  // The outermost voxel's distance is less than the band by up to 1.
  const double reach = std::max(inside, outside) * unit + 0.5;
  return background > 0.0 ? std::min(reach, background * unit) : reach;
}

bool is_finite(float value) { return std::isfinite(value); }
bool is_finite(const openvdb::Vec3s& value) {
  return std::isfinite(value[0]) && std::isfinite(value[1]) && std::isfinite(value[2]);
}

/// All that can be asked for, active or not, and the background.
template <class Grid>
void require_numbers(const Grid& values, const std::string& file, const std::string& grid) {
  bool all = is_finite(values.background());
  for (auto it = values.cbeginValueAll(); all && it; ++it) all = is_finite(*it);
  if (!all) throw InputError(file, "the grid " + grid + " holds a value that is no number");
}

class OpenVdbGrids final : public VdbGrids {
 public:
  OpenVdbGrids(const std::string& name, const std::string& grid);
  const VdbExtent& extent() const override { return extent_; }
  bool has_velocity() const override { return velocity_ != nullptr; }
  double value(int i, int j, int k) const override { return scale_ * phi_->tree().getValue({i, j, k}); }
  double face_velocity(int axis, int i, int j, int k) const override;

 private:
  VdbExtent extent_;
  openvdb::FloatGrid::Ptr phi_;
  openvdb::Vec3SGrid::Ptr velocity_;
  bool staggered_ = false;
  double scale_ = 1.0;  ///< of phi, to the file's unit
};

OpenVdbGrids::OpenVdbGrids(const std::string& name, const std::string& grid) {
  openvdb::io::File file(name);
  file.open(false);
  std::string others;
  for (auto it = file.beginName(); it != file.endName(); ++it) others += (others.empty() ? "" : ", ") + it.gridName();
  if (!file.hasGrid(grid)) throw InputError(name, "has no grid " + grid, others, "a level set of this name");
  phi_ = openvdb::gridPtrCast<openvdb::FloatGrid>(file.readGrid(grid));
  if (!phi_) throw InputError(name, "the grid " + grid + " holds no numbers (float)");
  read_transform(phi_->transform(), name, extent_);
  const openvdb::CoordBBox box = phi_->evalActiveVoxelBoundingBox();
  if (box.empty()) throw InputError(name, "the grid " + grid + " is empty");
  for (int a = 0; a < 3; ++a) {
    extent_.low[static_cast<std::size_t>(a)] = box.min()[a];
    extent_.high[static_cast<std::size_t>(a)] = box.max()[a];
  }
  require_numbers(*phi_, name, grid);
  const double slope = slope_at_surface(*phi_, extent_.voxel);
  if (!(slope > 1e-9)) throw InputError(name, "the grid " + grid + " holds no distances: it is flat at its surface");
  const bool in_voxels = std::abs(slope * extent_.voxel - 1.0) < 0.05;
  if (!(slope > 0.7 && slope < 1.4)) scale_ = in_voxels ? extent_.voxel : 1.0 / slope;
  extent_.band_voxels = band_voxels(*phi_, scale_ / extent_.voxel);
  if (!(extent_.band_voxels >= kLeastBand * (1.0 - 1e-5)))
    throw InputError(name, "the band of distances is too thin", to_text(extent_.band_voxels) + " voxels",
                     "2 voxels or more on each side of the surface");
  for (const char* const word : {"velocity", "vel"}) {
    if (velocity_ || !file.hasGrid(word)) continue;
    velocity_ = openvdb::gridPtrCast<openvdb::Vec3SGrid>(file.readGrid(word));
    if (velocity_ && velocity_->transform() != phi_->transform()) velocity_.reset();
    if (velocity_) require_numbers(*velocity_, name, word);
  }
  staggered_ = velocity_ && velocity_->getGridClass() == openvdb::GRID_STAGGERED;
}

double OpenVdbGrids::face_velocity(int axis, int i, int j, int k) const {
  const openvdb::Coord here(i, j, k);
  const double value = velocity_->tree().getValue(here)[axis];
  if (staggered_) return value;
  openvdb::Coord below = here;
  below[axis] -= 1;
  return 0.5 * (value + velocity_->tree().getValue(below)[axis]);
}

/// The head of a file, value after value.
class Head {
 public:
  Head(std::string_view bytes, std::string name) : bytes_(bytes), name_(std::move(name)) {}
  template <class T>
  T take() {
    T value{};
    std::memcpy(&value, skip(sizeof value), sizeof value);
    return value;
  }
  const char* skip(std::size_t n) {
    if (n > bytes_.size() - at_) cut_off();
    at_ += n;
    return bytes_.data() + at_ - n;
  }
  void skip_text() { skip(take<std::uint32_t>()); }
  void go_to(std::int64_t at) {
    if (at < static_cast<std::int64_t>(at_) || static_cast<std::size_t>(at) > bytes_.size()) cut_off();
    at_ = static_cast<std::size_t>(at);
  }

 private:
  [[noreturn]] void cut_off() const {
    throw InputError(name_, "is no usable .vdb: it is cut off or its head is broken");
  }
  std::string_view bytes_;
  std::string name_;
  std::size_t at_ = 0;
};

/// Every grid ends within the file: the library takes what is missing as it finds it in memory.
void check_ends(Head head) {
  constexpr std::size_t kIdBytes = 36;
  head.skip(sizeof(std::int64_t));
  // Older heads have other parts.
  if (head.take<std::uint32_t>() < openvdb::OPENVDB_FILE_VERSION_NODE_MASK_COMPRESSION) return;
  head.skip(2 * sizeof(std::uint32_t));  // the library's version
  const bool has_places = head.take<char>() != 0;
  head.skip(kIdBytes);
  if (!has_places) return;  // the library refuses it
  for (auto n = head.take<std::int32_t>(); n > 0; --n)
    for (int part = 0; part < 3; ++part) head.skip_text();  // name, type and value of what is said about the file
  for (auto n = head.take<std::int32_t>(); n > 0; --n) {
    for (int part = 0; part < 3; ++part) head.skip_text();  // name, type, and whose voxels it shares
    head.skip(2 * sizeof(std::int64_t));
    head.go_to(head.take<std::int64_t>());
  }
}

/// @return the file's bytes. @throws InputError: it cannot be read, is none, or of a later version
std::size_t check_head(const std::filesystem::path& path) {
  const std::string bytes = read_file(path, std::size_t{1} << 34);  // says what is wrong with a file that is none
  std::int64_t magic = 0;
  std::uint32_t version = 0;
  if (bytes.size() >= sizeof magic) std::memcpy(&magic, bytes.data(), sizeof magic);
  if (magic != openvdb::OPENVDB_MAGIC || bytes.size() < sizeof magic + sizeof version)
    throw InputError(path.string(), "is no usable .vdb: it does not start as one");
  std::memcpy(&version, bytes.data() + sizeof magic, sizeof version);
  if (version > openvdb::OPENVDB_FILE_VERSION)
    throw InputError(path.string(), "is no usable .vdb: its version is unknown", std::to_string(version),
                     "up to " + std::to_string(static_cast<std::uint32_t>(openvdb::OPENVDB_FILE_VERSION)));
  check_ends(Head(bytes, path.string()));
  return bytes.size();
}

std::unique_ptr<VdbGrids> read(const std::string& name, const std::string& grid) {
  return guarded(name, [&] { return std::make_unique<OpenVdbGrids>(name, grid); });
}

void write(const std::string& name, const std::filesystem::path& path, const GridShape& shape, const Field& phi_m,
           const std::optional<MacGrid>& u, double time_s) {
  guarded(name, [&] {
    double most = 3.0 * shape.cell_m;
    for (const double value : phi_m.data()) most = std::max(most, std::abs(value));
    const auto transform = openvdb::math::Transform::createLinearTransform(shape.cell_m);
    transform->postTranslate(openvdb::Vec3d(0.5 * shape.cell_m));
    const auto phi = openvdb::FloatGrid::create(static_cast<float>(most));
    phi->setName("phi");
    phi->setGridClass(openvdb::GRID_LEVEL_SET);
    phi->setTransform(transform);
    phi->insertMeta("time_s", openvdb::DoubleMetadata(time_s));
    auto values = phi->getAccessor();
    for (int k = 0; k < shape.nz; ++k)
      for (int j = 0; j < shape.ny; ++j)
        for (int i = 0; i < shape.nx; ++i) values.setValue({i, j, k}, static_cast<float>(phi_m(i, j, k)));
    openvdb::GridPtrVec grids{phi};
    if (u) {
      const auto velocity = openvdb::Vec3SGrid::create(openvdb::Vec3s(0.0F));
      velocity->setName("velocity");
      velocity->setGridClass(openvdb::GRID_STAGGERED);
      velocity->setTransform(transform);
      auto faces = velocity->getAccessor();
      const auto at = [&](int axis, int i, int j, int k) {
        return (*u)[axis].contains(i, j, k) ? static_cast<float>((*u)[axis](i, j, k)) : 0.0F;
      };
      for (int k = 0; k <= shape.nz; ++k)
        for (int j = 0; j <= shape.ny; ++j)
          for (int i = 0; i <= shape.nx; ++i) {
            const openvdb::Vec3s value(at(0, i, j, k), at(1, i, j, k), at(2, i, j, k));
            if (value != openvdb::Vec3s(0.0F)) faces.setValue({i, j, k}, value);
          }
      grids.push_back(velocity);
    }
    openvdb::io::File file(path.string());
    file.write(grids);
    file.close();
  });
  // The library does not ask whether its bytes got to the disk.
  try {
    check_head(path);
  } catch (const InputError&) {
    throw InputError(name, "cannot be written: the disk took part of it", "", "room on the disk");
  }
}

}  // namespace
}  // namespace klang::liquid

extern "C" const klang::liquid::VdbCodec* klang_vdb_codec() {
  using namespace klang::liquid;
  static constexpr VdbCodec kCodec{.check_head = check_head, .read = read, .write = write};
  return &kCodec;
}
