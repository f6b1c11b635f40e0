#include "core/sound/soundbank/soundbank_file.hpp"

#include <zlib.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

#include "core/foundation/base/check.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/json.hpp"
#include "core/foundation/base/output_file.hpp"
#include "core/foundation/base/parse_json.hpp"
#include "core/foundation/base/provenance.hpp"

namespace klang::soundbank {
namespace {

static_assert(std::endian::native == std::endian::little, "files are little-endian");

constexpr std::string_view kMagic = "KLBANK\r\n";
constexpr std::uint32_t kFileVersion = 1;
constexpr std::size_t kLargestData = std::size_t{8} << 30;
// Numbers of a bank pack by a factor of 1.2 to 3; what unpacks to more than this is made to fill the memory.
constexpr std::size_t kSmallData = std::size_t{16} << 20, kMostUnpackedPerByte = 20;

// Bytes that an item takes in the file at least.
template <typename T>
constexpr std::size_t kSmallest = 8;
template <>
constexpr std::size_t kSmallest<ShapePoint> = 16;
template <>
constexpr std::size_t kSmallest<ClassFrequencies> = 8 * kModeClasses;
template <>
constexpr std::size_t kSmallest<ShapeTriangle> = 32;
template <>
constexpr std::size_t kSmallest<Cell> = 24;
template <>
constexpr std::size_t kSmallest<CellMode> = 60;

/// Writes values one after the other.
class Writer {
 public:
  static constexpr bool kReads = false;
  std::string bytes;
  template <typename T>
  void raw(const T* values, std::size_t n) {
    bytes.append(reinterpret_cast<const char*>(values), n * sizeof(T));
  }
  std::size_t count(std::size_t n, std::size_t) {
    const auto value = static_cast<std::uint64_t>(n);
    raw(&value, 1);
    return n;
  }
};

/// Reads them back; nothing is allocated before the bytes are known to be there.
class Reader {
 public:
  static constexpr bool kReads = true;
  Reader(std::string_view bytes, std::string name) : bytes_(bytes), name_(std::move(name)) {}
  template <typename T>
  void raw(T* values, std::size_t n) {
    if (n > (bytes_.size() - at_) / sizeof(T)) fail("data end too early");
    if (n > 0) std::memcpy(values, bytes_.data() + at_, n * sizeof(T));  // no list: no place
    at_ += n * sizeof(T);
  }
  std::size_t count(std::size_t, std::size_t bytes_each) {
    std::uint64_t n = 0;
    raw(&n, 1);
    if (n > (bytes_.size() - at_) / bytes_each) fail("a count is larger than the file");
    return static_cast<std::size_t>(n);
  }
  bool at_end() const { return at_ == bytes_.size(); }
  [[noreturn]] void fail(const char* problem) const {
    throw InputError(name_, std::string("is no whole soundbank: ") + problem);
  }

 private:
  std::string_view bytes_;
  std::string name_;
  std::size_t at_ = 0;
};

// One description of each part for both directions.
template <typename Archive>
void value(Archive& a, double& x) {
  a.raw(&x, 1);
}
template <typename Archive>
void value(Archive& a, int& x) {
  auto wide = static_cast<std::int32_t>(x);
  a.raw(&wide, 1);
  x = wide;
}
template <typename Archive>
void value(Archive& a, ShapePoint& p) {
  value(a, p.u), value(a, p.v);
}
template <typename Archive, typename Scalar>
void value(Archive& a, Eigen::Matrix<Scalar, Eigen::Dynamic, 1>& x) {
  const std::size_t n = a.count(static_cast<std::size_t>(x.size()), sizeof(Scalar));
  if constexpr (Archive::kReads) x.resize(static_cast<Eigen::Index>(n));
  a.raw(x.data(), n);
}
template <typename Archive>
void value(Archive& a, ClassFrequencies& f) {
  for (Eigen::VectorXd& of_class : f) value(a, of_class);
}
template <typename Archive>
void value(Archive& a, CellMode& m) {
  value(a, m.id.mode_class), value(a, m.id.index), value(a, m.angular_frequency_rad_s), value(a, m.coefficients),
      value(a, m.order);
  const std::size_t n = a.count(m.packed_pa.size(), sizeof(m.packed_pa[0]));
  if constexpr (Archive::kReads) m.packed_pa.resize(n);
  a.raw(m.packed_pa.data(), n);
  value(a, m.radiated_power_w), value(a, m.kept_power_fraction), value(a, m.boundary_error);
}
template <typename Archive, typename T>
void list(Archive& a, std::vector<T>& items) {
  const std::size_t n = a.count(items.size(), kSmallest<T>);
  if constexpr (Archive::kReads) items.resize(n);
  for (T& item : items) value(a, item);
}
template <typename Archive>
void value(Archive& a, Cell& c) {
  value(a, c.shape), list(a, c.modes);
}
template <typename Archive>
void value(Archive& a, ShapeTriangle& t) {
  for (int& node : t.nodes) value(a, node);
  for (int& child : t.children) value(a, child);
}
template <typename Archive>
void value(Archive& a, Soundbank& b) {
  value(a, b.poissons_ratio);
  value(a, b.material.lame_lambda_pa), value(a, b.material.lame_mu_pa), value(a, b.material.density_kg_m3);
  value(a, b.medium.density_kg_m3), value(a, b.medium.sound_speed_m_s);
  value(a, b.thinnest), value(a, b.tolerance), value(a, b.n_checked_modes), value(a, b.max_interpolation_error);
  value(a, b.max_interpolation_error_all), value(a, b.n_check_shapes), value(a, b.modes_per_cell), value(a, b.degree);
  list(a, b.nodes), list(a, b.node_frequencies), list(a, b.triangles), list(a, b.cells);
}
template <typename Archive, typename T>
void map(Archive& a, std::map<ShapePoint, T>& items) {
  std::size_t n = a.count(items.size(), 16 + kSmallest<T>);
  if constexpr (Archive::kReads) {
    for (; n > 0; --n) {
      ShapePoint key;
      value(a, key);
      value(a, items[key]);
    }
  } else {
    for (auto& [key, item] : items) {
      ShapePoint copy = key;
      value(a, copy), value(a, item);
    }
  }
}
template <typename Archive>
void value(Archive& a, BuildProgress& p) {
  map(a, p.frequencies), map(a, p.cells);
}

void write(const std::filesystem::path& path, nlohmann::json header, const std::string& data) {
  uLongf size = compressBound(data.size());
  std::string packed(size, '\0');
  KLANG_CHECK(compress2(reinterpret_cast<Bytef*>(packed.data()), &size, reinterpret_cast<const Bytef*>(data.data()),
                        data.size(), 6) == Z_OK,
              "zlib compresses what is in memory");
  packed.resize(size);
  header["data_sha256"] = sha256(data);
  const std::string text = header.dump();
  Writer out;
  out.bytes = kMagic;
  out.raw(&kFileVersion, 1);
  for (const std::size_t n : {text.size(), packed.size(), data.size()}) out.count(n, 1);
  write_file(path, out.bytes + text + packed);
}

struct Contents {
  nlohmann::json header;
  std::string data;
};

Contents read(const std::string& bytes, const std::string& name, const std::string& kind) {
  const auto refuse = [&](const std::string& problem) { throw InputError(name, "is no whole soundbank: " + problem); };
  if (bytes.size() < kMagic.size() + 28 || bytes.compare(0, kMagic.size(), kMagic) != 0)
    throw InputError(name, "is no soundbank", {}, "a file written by klang proxy build");
  std::uint32_t version = 0;
  std::array<std::uint64_t, 3> sizes{};
  std::memcpy(&version, bytes.data() + kMagic.size(), 4);
  std::memcpy(sizes.data(), bytes.data() + kMagic.size() + 4, 24);
  if (version > kFileVersion)
    throw InputError(name, "was written by a newer version of the program", "schema version " + std::to_string(version),
                     "1");
  const std::size_t start = kMagic.size() + 28;
  if (sizes[0] > bytes.size() || sizes[1] > bytes.size() || start + sizes[0] + sizes[1] != bytes.size())
    refuse("it is truncated or has bytes too many");
  if (sizes[2] > kLargestData || sizes[2] > std::max(kSmallData, kMostUnpackedPerByte * sizes[1]))
    refuse("the size of its data is not possible");
  Contents contents;
  contents.header = parse_json(std::string_view(bytes).substr(start, sizes[0]), name + ": its header");
  if (text_under(contents.header, "kind") != kind) refuse("its header is damaged or of another kind");
  contents.data.resize(sizes[2]);
  uLongf size = sizes[2];
  const int status = uncompress(reinterpret_cast<Bytef*>(contents.data.data()), &size,
                                reinterpret_cast<const Bytef*>(bytes.data() + start + sizes[0]), sizes[1]);
  if (status != Z_OK || size != sizes[2]) refuse("its data cannot be unpacked");
  if (text_under(contents.header, "data_sha256") != sha256(contents.data))
    refuse("its data do not have the hash of its header");
  return contents;
}

bool is_shape(const ShapePoint& p) {
  return p.u >= -20.0 && p.u <= 1e-9 && p.v >= -20.0 && p.v <= 1e-9;  // round-off at the sphere
}

void check_mode(const Soundbank& bank, const CellMode& mode, const Reader& reader) {
  if (mode.id.mode_class < 0 || mode.id.mode_class >= kModeClasses || mode.id.index < 0 ||
      mode.id.index >= bank.node_frequencies[0][mode.id.mode_class].size())
    reader.fail("a mode is none of its class");
  if (mode.order < 0 || mode.order > 200 ||
      (!mode.packed_pa.empty() && mode.packed_pa.size() != packed_size(mode.order, mode.id.mode_class)))
    reader.fail("the multipole of a mode is damaged");
  if (mode.coefficients.size() != mode_shape_size(bank.degree, mode.id.mode_class) || !mode.coefficients.allFinite())
    reader.fail("the shape of a mode is damaged");
  if (!(mode.angular_frequency_rad_s > 0.0 && mode.angular_frequency_rad_s <= 1e12))
    reader.fail("the frequency of a mode is not within 0 to 1e12 rad/s");
  for (const double number : {mode.radiated_power_w, mode.kept_power_fraction, mode.boundary_error})
    if (!std::isfinite(number)) reader.fail("a number of a mode is not finite");
  for (const std::complex<float>& c : mode.packed_pa)
    if (!std::isfinite(c.real()) || !std::isfinite(c.imag())) reader.fail("a coefficient of a mode is not finite");
}

/// What the tree and the cells must satisfy for lookups to be safe.
void check_consistent(const Soundbank& bank, const Reader& reader) {
  const auto n_nodes = static_cast<int>(bank.nodes.size()), n_triangles = static_cast<int>(bank.triangles.size());
  if (n_triangles == 0 || bank.cells.empty() || bank.node_frequencies.size() != bank.nodes.size())
    reader.fail("parts are missing");
  if (!(bank.thinnest > 0.0 && bank.thinnest < 1.0)) reader.fail("the thinnest shape is not within 0 to 1");
  if (bank.degree < 3 || bank.degree > 24) reader.fail("the degree is not within 3 to 24");
  if (bank.n_checked_modes < 0 || bank.n_check_shapes < 0 || bank.modes_per_cell < 0)
    reader.fail("a count is negative");
  solid::validate(bank.material);
  bank.medium.validate();
  if (!(std::abs(bank.poissons_ratio - bank.material.poissons_ratio()) <= 1e-6))
    reader.fail("Poisson's ratio is not that of its material");
  for (const double number : {bank.tolerance, bank.max_interpolation_error, bank.max_interpolation_error_all})
    if (!(number >= 0.0 && number <= 1e6)) reader.fail("an error is not within 0 to 1e6");
  for (const ShapePoint& node : bank.nodes)
    if (!is_shape(node)) reader.fail("a node is no shape");
  for (int t = 0; t < n_triangles; ++t) {
    const ShapeTriangle& triangle = bank.triangles[t];
    for (const int node : triangle.nodes)
      if (node < 0 || node >= n_nodes) reader.fail("a node is missing");
    const auto [first, second] = triangle.children;
    const bool leaf = first < 0 && second < 0;
    if (!leaf && (first <= t || second <= t || first >= n_triangles || second >= n_triangles))
      reader.fail("the tree is damaged");
  }
  for (const ClassFrequencies& f : bank.node_frequencies)
    for (int c = 0; c < kModeClasses; ++c)
      if (f[c].size() == 0 || f[c].size() != bank.node_frequencies[0][c].size() || !(f[c].minCoeff() > 0.0) ||
          !(f[c].maxCoeff() <= 1e6))
        reader.fail("a frequency is missing, or not within 0 to 1e6");
  for (const Cell& cell : bank.cells) {
    if (!is_shape(cell.shape)) reader.fail("a cell is no shape");
    for (const CellMode& mode : cell.modes) check_mode(bank, mode, reader);
  }
}

}  // namespace

void write_soundbank(const std::filesystem::path& path, const Soundbank& bank) {
  Writer data;
  Soundbank copy = bank;
  value(data, copy);
  write(path,
        {{"kind", "soundbank"},
         {"schema_version", kFileVersion},
         {"provenance", nlohmann::json::parse(bank.provenance_json)},
         {"poissons_ratio", bank.poissons_ratio},
         {"n_cells", bank.cells.size()}},
        data.bytes);
}

Soundbank read_soundbank(const std::filesystem::path& path) {
  return read_soundbank_bytes(read_file(path), path.string());
}

Soundbank read_soundbank_bytes(const std::string& bytes, const std::string& name) {
  const Contents contents = read(bytes, name, "soundbank");
  Reader reader(contents.data, name);
  Soundbank bank;
  value(reader, bank);
  if (!reader.at_end()) reader.fail("there are data too many");
  check_consistent(bank, reader);
  bank.provenance_json = contents.header.value("provenance", nlohmann::json::object()).dump();
  return bank;
}

void write_build_progress(const std::filesystem::path& path, const BuildProgress& progress, const std::string& key) {
  Writer data;
  BuildProgress copy = progress;
  value(data, copy);
  write(path, {{"kind", "soundbank_progress"}, {"schema_version", kFileVersion}, {"key", key}}, data.bytes);
}

std::optional<BuildProgress> read_build_progress(const std::filesystem::path& path, const std::string& key) {
  const Contents contents = read(read_file(path), path.string(), "soundbank_progress");
  if (text_under(contents.header, "key") != key) return std::nullopt;
  Reader reader(contents.data, path.string());
  BuildProgress progress;
  value(reader, progress);
  return progress;
}

void check_poissons_ratio(const Soundbank& bank, double poissons_ratio, const std::string& place) {
  if (!(std::abs(poissons_ratio - bank.poissons_ratio) <= 0.005 + 1e-12))  // one bank between 0.19 and 0.2 serves both
    throw InputError(place, "the bank is of another Poisson's ratio", to_text(poissons_ratio),
                     to_text(bank.poissons_ratio) + " within 0.005");
}

}  // namespace klang::soundbank
