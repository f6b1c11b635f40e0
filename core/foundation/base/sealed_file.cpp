#include "core/foundation/base/sealed_file.hpp"

#include <openssl/evp.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <fstream>
#include <memory>
#include <optional>

namespace klang {
namespace {

constexpr std::size_t kDigest = 32, kChunk = std::size_t{1} << 20;
constexpr char kMark[9] = "KLNGSEAL";
struct Seal {
  char mark[8];
  std::array<unsigned char, kDigest> digest;
};
static_assert(sizeof(Seal) == 40);

/// None: the stream ended before.
std::optional<Seal> seal_of(std::istream& in, std::uint64_t n_bytes) {
  const std::unique_ptr<EVP_MD_CTX, decltype(&EVP_MD_CTX_free)> context(EVP_MD_CTX_new(), EVP_MD_CTX_free);
  EVP_DigestInit_ex(context.get(), EVP_sha256(), nullptr);
  std::vector<char> chunk(kChunk);
  while (n_bytes > 0) {
    const auto n = static_cast<std::size_t>(std::min<std::uint64_t>(n_bytes, kChunk));
    if (!in.read(chunk.data(), static_cast<std::streamsize>(n))) return std::nullopt;
    EVP_DigestUpdate(context.get(), chunk.data(), n);
    n_bytes -= n;
  }
  Seal seal;
  std::memcpy(seal.mark, kMark, sizeof seal.mark);
  EVP_DigestFinal_ex(context.get(), seal.digest.data(), nullptr);
  return seal;
}

}  // namespace

void seal_file(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  const std::optional<Seal> seal = in ? seal_of(in, bytes_left(in)) : std::nullopt;
  if (!seal) throw InputError(path.string(), "cannot be read");
  std::ofstream out(path, std::ios::binary | std::ios::app);
  out.write(reinterpret_cast<const char*>(&*seal), sizeof *seal);
  if (!out.flush()) throw InputError(path.string(), "cannot be written", "", "room on the disk");
}

bool is_sealed(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  if (!in) return false;
  const std::uint64_t n_bytes = bytes_left(in);
  if (n_bytes < sizeof(Seal)) return false;
  const std::optional<Seal> seal = seal_of(in, n_bytes - sizeof(Seal));
  Seal there;
  return seal && in.read(reinterpret_cast<char*>(&there), sizeof there) &&
         std::memcmp(&there, &*seal, sizeof there) == 0;
}

std::uint64_t bytes_left(std::istream& in) {
  const std::istream::pos_type here = in.tellg();
  if (here == std::istream::pos_type(-1)) return 0;
  in.seekg(0, std::ios::end);
  const std::istream::pos_type end = in.tellg();
  in.seekg(here);
  return end > here ? static_cast<std::uint64_t>(end - here) : 0;
}

}  // namespace klang
