#include "core/geometry/files/detail/vtk_data.hpp"

#include <vtkCommand.h>
#include <vtkLZ4DataCompressor.h>
#include <vtkLZMADataCompressor.h>
#include <vtkNew.h>
#include <vtkSmartPointer.h>
#include <vtkZLibDataCompressor.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>

#include "core/foundation/base/errors.hpp"
#include "core/geometry/files/byte_cursor.hpp"

namespace klang::mesh::detail {
namespace {

static_assert(std::endian::native == std::endian::little, "files are little-endian");

bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r'; }

/// Reads base64 or raw bytes one after the other. Streams that follow each other (a padded header, then data) are one.
class ByteStream {
 public:
  ByteStream(std::string_view bytes, bool base64, const std::string& place)
      : bytes_(bytes), base64_(base64), place_(place) {}

  /// At most this many bytes are left.
  std::size_t at_most() const { return base64_ ? (bytes_.size() - at_) / 4 * 3 + n_pending_ : bytes_.size() - at_; }

  void read(char* to, std::size_t n) {
    if (n > at_most()) fail();
    if (!base64_) {
      if (n > 0) std::memcpy(to, bytes_.data() + at_, n);
      at_ += n;
      return;
    }
    for (std::size_t i = 0; i < n; ++i) {
      if (n_pending_ == 0) decode_group();
      to[i] = pending_[0];
      std::copy(pending_.begin() + 1, pending_.end(), pending_.begin());
      --n_pending_;
    }
  }

  std::uint64_t count(const VtkEncoding& encoding) {
    std::array<char, 8> raw{};
    const auto n = static_cast<std::size_t>(encoding.header_bytes);
    read(raw.data(), n);
    if (encoding.swapped) std::reverse(raw.begin(), raw.begin() + encoding.header_bytes);
    std::uint64_t value = 0;
    std::memcpy(&value, raw.data(), 8);
    return value;
  }

  [[noreturn]] void fail() const { throw InputError(place_, "its data end too early"); }

 private:
  static int digit(char c) {
    if (c >= 'A' && c <= 'Z') return c - 'A';
    if (c >= 'a' && c <= 'z') return c - 'a' + 26;
    if (c >= '0' && c <= '9') return c - '0' + 52;
    return c == '+' ? 62 : c == '/' ? 63 : -1;
  }

  void decode_group() {
    std::uint32_t group = 0;
    int n_digits = 0, n_padding = 0;
    for (int k = 0; k < 4; ++k) {
      while (at_ < bytes_.size() && is_blank(bytes_[at_])) ++at_;
      if (at_ == bytes_.size()) fail();
      const char c = bytes_[at_++];
      const int value = digit(c);
      if (value < 0 && c != '=') throw InputError(place_, "its data are no base64");
      if (value < 0)
        ++n_padding;
      else if (n_padding > 0)
        throw InputError(place_, "its data are no base64");
      else
        ++n_digits;
      group = group << 6 | static_cast<std::uint32_t>(std::max(value, 0));
    }
    if (n_digits < 2) throw InputError(place_, "its data are no base64");
    n_pending_ = static_cast<std::size_t>(n_digits - 1);
    for (std::size_t k = 0; k < 3; ++k) pending_[k] = static_cast<char>(group >> (16 - 8 * k) & 255);
  }

  std::string_view bytes_;
  bool base64_;
  const std::string& place_;
  std::size_t at_ = 0, n_pending_ = 0;
  std::array<char, 4> pending_{};
};

/// Takes what a compressor has to say, which it would print otherwise.
class Silence : public vtkCommand {
 public:
  static Silence* New() { return new Silence; }  // NOLINT: VTK counts references
  void Execute(vtkObject*, unsigned long, void*) override {}
};

vtkSmartPointer<vtkDataCompressor> new_compressor(VtkCompressor kind) {
  vtkSmartPointer<vtkDataCompressor> compressor;
  if (kind == VtkCompressor::kZlib) compressor = vtkSmartPointer<vtkZLibDataCompressor>::New();
  if (kind == VtkCompressor::kLz4) compressor = vtkSmartPointer<vtkLZ4DataCompressor>::New();
  if (kind == VtkCompressor::kLzma) compressor = vtkSmartPointer<vtkLZMADataCompressor>::New();
  vtkNew<Silence> silence;
  compressor->AddObserver(vtkCommand::ErrorEvent, silence);
  compressor->AddObserver(vtkCommand::WarningEvent, silence);
  return compressor;
}

void check_length(std::uint64_t n_bytes, const VtkBlock& block, std::int64_t& budget, const std::string& place) {
  const std::int64_t wanted = block.n_bytes_wanted, each = block.memory_per_byte;
  if (wanted >= 0 && n_bytes != static_cast<std::uint64_t>(wanted))
    throw InputError(place, "its data have another length than the file says", std::to_string(n_bytes) + " bytes",
                     std::to_string(wanted));
  if (n_bytes > static_cast<std::uint64_t>(std::max<std::int64_t>(budget, 0) / each))
    throw InputError(place, "its data do not fit the length of the file", std::to_string(n_bytes) + " bytes");
  budget -= static_cast<std::int64_t>(n_bytes) * each;
}

std::string unpacked(ByteStream& stream, const VtkBlock& block, const VtkEncoding& encoding, std::int64_t& budget,
                     const std::string& place) {
  const std::uint64_t n_blocks = stream.count(encoding), block_bytes = stream.count(encoding),
                      last_bytes = stream.count(encoding);
  if (n_blocks > stream.at_most() / static_cast<std::size_t>(encoding.header_bytes)) stream.fail();
  constexpr std::uint64_t kMost = std::uint64_t{1} << 40;
  if (block_bytes > kMost || last_bytes > block_bytes || (n_blocks > 0 && block_bytes > kMost / n_blocks))
    throw InputError(place, "its compressed blocks have no possible length", std::to_string(block_bytes) + " bytes");
  const std::uint64_t n_bytes =
      n_blocks == 0 ? 0 : (n_blocks - 1) * block_bytes + (last_bytes > 0 ? last_bytes : block_bytes);
  check_length(n_bytes, block, budget, place);
  std::vector<std::uint64_t> packed_bytes(n_blocks);
  for (std::uint64_t& n : packed_bytes) n = stream.count(encoding);
  std::string bytes(n_bytes, '\0'), packed;
  const auto compressor = new_compressor(encoding.compressor);
  for (std::uint64_t b = 0; b < n_blocks; ++b) {
    if (packed_bytes[b] > stream.at_most()) stream.fail();
    packed.resize(packed_bytes[b]);
    stream.read(packed.data(), packed.size());
    const std::uint64_t at = b * block_bytes, n = std::min(block_bytes, n_bytes - at);
    if (n > 0 && compressor->Uncompress(reinterpret_cast<const unsigned char*>(packed.data()), packed.size(),
                                        reinterpret_cast<unsigned char*>(bytes.data() + at), n) != n)
      throw InputError(place, "its block " + std::to_string(b) + " cannot be unpacked");
  }
  return bytes;
}

template <class File, class Value>
void convert(std::string_view block, bool swapped, std::vector<Value>& values) {
  values.resize(block.size() / sizeof(File));
  for (std::size_t i = 0; i < values.size(); ++i) {
    std::array<char, sizeof(File)> raw;
    std::memcpy(raw.data(), block.data() + i * sizeof(File), sizeof(File));
    if (swapped) std::reverse(raw.begin(), raw.end());
    File value;
    std::memcpy(&value, raw.data(), sizeof(File));
    values[i] = static_cast<Value>(value);
  }
}

}  // namespace

int vtk_type_bytes(std::string_view type) {
  if (type == "Int8" || type == "UInt8") return 1;
  if (type == "Int16" || type == "UInt16") return 2;
  if (type == "Int32" || type == "UInt32" || type == "Float32") return 4;
  return type == "Int64" || type == "UInt64" || type == "Float64" ? 8 : 0;
}

std::string vtk_block(const VtkBlock& block, const VtkEncoding& encoding, std::int64_t& budget,
                      const std::string& place) {
  ByteStream stream(block.at, block.base64, place);
  if (encoding.compressor != VtkCompressor::kNone) return unpacked(stream, block, encoding, budget, place);
  const std::uint64_t n_bytes = stream.count(encoding);
  check_length(n_bytes, block, budget, place);
  if (n_bytes > stream.at_most()) stream.fail();
  std::string bytes(n_bytes, '\0');
  stream.read(bytes.data(), bytes.size());
  return bytes;
}

void vtk_ascii(std::string_view text, std::string_view type, std::int64_t n_wanted, const std::string& place,
               std::vector<double>& reals, std::vector<std::int64_t>& integers) {
  const bool real = vtk_type_is_real(type);
  std::size_t at = 0;
  const auto refuse = [&](std::string_view word) {
    std::string shown;
    for (const char c : word.substr(0, 32)) shown += c >= ' ' && c <= '~' ? c : '?';
    throw InputError(place, real ? "holds what is no number" : "holds what is no integer", shown);
  };
  while (true) {
    while (at < text.size() && is_blank(text[at])) ++at;
    if (at == text.size()) return;
    if (n_wanted >= 0 && static_cast<std::int64_t>(real ? reals.size() : integers.size()) > n_wanted) return;
    std::size_t end = at;
    while (end < text.size() && !is_blank(text[end])) ++end;
    const std::string_view word = text.substr(at, end - at);
    at = end;
    if (real) {
      if (!parse_number(word, reals.emplace_back())) refuse(word);
    } else {
      long long value = 0;
      if (!parse_integer(word, value)) refuse(word);
      integers.push_back(value);
    }
  }
}

void vtk_values(std::string_view block, std::string_view type, bool swapped, std::vector<double>& reals,
                std::vector<std::int64_t>& integers) {
  if (type == "Float64") convert<double>(block, swapped, reals);
  if (type == "Float32") convert<float>(block, swapped, reals);
  if (type == "Int64") convert<std::int64_t>(block, swapped, integers);
  if (type == "UInt64") convert<std::uint64_t>(block, swapped, integers);
  if (type == "Int32") convert<std::int32_t>(block, swapped, integers);
  if (type == "UInt32") convert<std::uint32_t>(block, swapped, integers);
  if (type == "Int16") convert<std::int16_t>(block, swapped, integers);
  if (type == "UInt16") convert<std::uint16_t>(block, swapped, integers);
  if (type == "Int8") convert<std::int8_t>(block, swapped, integers);
  if (type == "UInt8") convert<std::uint8_t>(block, swapped, integers);
}

}  // namespace klang::mesh::detail
