// Any bytes given as a liquid's boundary, a modal model, a transfer model or a soundbank are either read or refused with an InputError.
// The first byte picks the format (tools/lib/fuzz_seeds.py has the same numbers). A bank's data come in their container: random bytes
// never have the hash that its header asks for.
#include <zlib.h>

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/provenance.hpp"
#include "core/physics/modal/modal_model.hpp"
#include "core/sound/dual_domain/boundary_file.hpp"
#include "core/sound/soundbank/soundbank_file.hpp"
#include "core/sound/transfer/transfer_model_file.hpp"
#include "tests/fuzz/fuzz_file.hpp"

namespace {

using klang::test::FuzzFile;

std::string banked(const std::string& data) {
  uLongf size = compressBound(data.size());
  std::string packed(size, '\0');
  compress2(reinterpret_cast<Bytef*>(packed.data()), &size, reinterpret_cast<const Bytef*>(data.data()), data.size(),
            1);
  packed.resize(size);
  const std::string header = nlohmann::json({{"kind", "soundbank"}, {"data_sha256", klang::sha256(data)}}).dump();
  std::string bytes = "KLBANK\r\n";
  const std::uint32_t version = 1;
  bytes.append(reinterpret_cast<const char*>(&version), 4);
  for (const std::uint64_t n : {header.size(), packed.size(), data.size()})
    bytes.append(reinterpret_cast<const char*>(&n), 8);
  return bytes + header + packed;
}

void read_as(int format, std::string_view bytes) {
  static constexpr const char* kBoundaries[] = {".vtp", ".vtu", ".obj"};
  if (format < 3) {
    const FuzzFile file(bytes, kBoundaries[format]);
    klang::bubble::read_boundary(file.path());
  } else if (format == 3) {
    const FuzzFile file(bytes, ".pvd");
    klang::bubble::find_frames(file.path().string(), 1.0);
  } else if (format == 4) {
    klang::modal::read_modal_model_bytes(std::string(bytes), "fuzz");
  } else if (format == 5) {
    klang::acoustics::read_transfer_model_bytes(std::string(bytes), "fuzz");
  } else {
    const klang::soundbank::Soundbank bank =
        klang::soundbank::read_soundbank_bytes(format == 6 ? std::string(bytes) : banked(std::string(bytes)), "fuzz");
    for (const klang::soundbank::ShapePoint shape : {klang::soundbank::ShapePoint{-0.4, -0.2}, {0.0, 0.0}})
      lowest_frequency(bank, locate(bank, shape));
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  try {
    read_as(data[0] % 8, {reinterpret_cast<const char*>(data) + 1, size - 1});
  } catch (const klang::InputError&) {
  }
  return 0;
}
