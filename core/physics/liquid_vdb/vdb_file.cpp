#include "core/physics/liquid_vdb/vdb_file.hpp"

#include <dlfcn.h>

#include <fstream>
#include <string_view>

#include "core/foundation/base/child.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/output_file.hpp"
#include "core/foundation/base/plugin.hpp"
#include "core/foundation/base/provenance.hpp"
#include "core/physics/liquid_vdb/vdb_codec.hpp"

#pragma weak klang_vdb_codec

namespace klang::liquid {
namespace {

/// A file's memory is at most that of its nodes, and every node has its masks of voxels unpacked in the file: a leaf of
/// vectors takes 6 KB for a mask of 64 bytes, and larger nodes less. The rest are tables and the packed blocks of one leaf.
constexpr std::size_t kMemoryPerByte = 128, kMemoryAlways = std::size_t{256} << 20;

/// That which is linked, or that of the library; null where there is none.
const VdbCodec* find_codec() {
  static const VdbCodec* const codec = []() -> const VdbCodec* {
    if (klang_vdb_codec != nullptr) return klang_vdb_codec();
    void* const library = load_plugin("klang_vdb.so");
    if (library == nullptr) return nullptr;
    const auto get = reinterpret_cast<decltype(&klang_vdb_codec)>(dlsym(library, "klang_vdb_codec"));
    return get != nullptr ? get() : nullptr;
  }();
  return codec;
}

const VdbCodec& codec(const std::filesystem::path& path) {
  if (const VdbCodec* const found = find_codec()) return *found;
  throw InputError(path.string(), "this program has no OpenVDB", "",
                   "a build where Debian's libopenvdb-dev is installed, with klang_vdb.so beside it");
}

/// OpenVDB gives each file a random number (UUID) behind the first 21 bytes; here it follows from the rest, so that the same liquid gives
/// the same bits.
void name_by_content(const std::filesystem::path& file) {
  constexpr std::size_t kAt = 21, kLength = 36;
  std::string bytes = read_file(file);
  if (bytes.size() < kAt + kLength || bytes[kAt + 8] != '-' || bytes[kAt + 23] != '-')
    throw InputError(file.string(), "is not laid out as OpenVDB 10 does it");
  bytes.replace(kAt, kLength, kLength, '0');
  std::string uuid = sha256(bytes).substr(0, 32);
  for (const std::size_t dash : {8, 13, 18, 23}) uuid.insert(dash, 1, '-');
  std::fstream out(file, std::ios::in | std::ios::out | std::ios::binary);
  out.seekp(static_cast<std::streamoff>(kAt));
  out.write(uuid.data(), static_cast<std::streamsize>(kLength));
  if (!out.flush()) throw InputError(file.string(), "cannot be written", "", "room on the disk");
}

}  // namespace

VdbFile::VdbFile(const std::filesystem::path& path, const std::string& grid, Monitor& monitor) {
  const VdbCodec& library = codec(path);
  const std::string name = path.string();
  const std::size_t size = library.check_head(path);
  // In a child first: the library takes memory as a file claims it, prints, and may crash.
  const ChildResult child = run_in_child(
      [&] {
        library.read(name, grid);
        return std::string();
      },
      monitor, kMemoryAlways + kMemoryPerByte * size);
  monitor.throw_if_stopped();
  if (!child.done && !child.bytes.empty()) throw InputError(child.bytes);
  if (!child.done) throw InputError(name, "is no usable .vdb: OpenVDB ends at it");
  grids_ = library.read(name, grid);
}
VdbFile::~VdbFile() = default;
VdbFile::VdbFile(VdbFile&&) noexcept = default;

bool has_vdb() { return find_codec() != nullptr; }
const VdbExtent& VdbFile::extent() const { return grids_->extent(); }
bool VdbFile::has_velocity() const { return grids_->has_velocity(); }
double VdbFile::value(int i, int j, int k) const { return grids_->value(i, j, k); }
double VdbFile::face_velocity(int axis, int i, int j, int k) const { return grids_->face_velocity(axis, i, j, k); }

void write_vdb(const std::filesystem::path& path, const GridShape& shape, const Field& phi_m,
               const std::optional<MacGrid>& u, double time_s) {
  const VdbCodec& library = codec(path);
  write_file_with(path, [&](const std::filesystem::path& temporary) {
    library.write(path.string(), temporary, shape, phi_m, u, time_s);
    name_by_content(temporary);
  });
}

}  // namespace klang::liquid
