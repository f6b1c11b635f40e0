// Any bytes given as a result (JSON of every kind with a page), a reference spectrum, a partial table, a CSV, measured responses,
// tracked bubbles or liquids (.vdb, an OpenFOAM case) are either read or refused with an InputError. The first byte picks the format (tools/lib/fuzz_seeds.py has the same numbers).
#include <unistd.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/parse_json.hpp"
#include "core/foundation/config/fields_json.hpp"
#include "core/physics/bubble/time_series.hpp"
#include "core/physics/entrainment/tracked_bubbles.hpp"
#include "core/physics/liquid_vdb/vdb_file.hpp"
#include "core/physics/modal/modes_document.hpp"
#include "core/sound/liquid_scene/foreign_frames.hpp"
#include "core/sound/stage/listener_file.hpp"
#include "fit/bubble/bubble_document.hpp"
#include "fit/frf/response_set.hpp"
#include "fit/proxy/proxy_fit_document.hpp"
#include "fit/ringdown/analysis_document.hpp"
#include "fit/ringdown/partial_table.hpp"
#include "fit/run/fit_document.hpp"
#include "fit/tune/tune_document.hpp"
#include "tests/fuzz/fuzz_file.hpp"
#include "validate/regression/reference_spectrum.hpp"
#include "validate/regression/regression_document.hpp"
#include "validate/studies/study_document.hpp"

namespace {

using klang::test::FuzzFile;

/// Read, and written again: what is read must be fit to be written.
template <class Document>
void read_document(std::string_view text) {
  klang::json_of(klang::read_fields<Document>(klang::parse_json(text, "fuzz"), "fuzz")).dump();
}

void read_csv(int format, std::string_view bytes) {
  if (format == 12) {
    const FuzzFile file(bytes, ".csv");
    constexpr std::string_view kNeeded[] = {"x_m"}, kOptional[] = {"phi_m"};
    klang::bubble::read_time_series(file.path(), kNeeded, kOptional, true);
  } else if (format == 13) {
    const FuzzFile file(bytes, ".json");
    klang::bubble::read_transfer_series(file.path());
  } else {
    const FuzzFile file(bytes, ".csv");
    klang::stage::read_listener(file.path(), {}, {0.0, 1.0, 0.0});
  }
}

/// An OpenFOAM case, its files one after the other with a byte 30 between them.
void read_case(std::string_view bytes) {
  const std::filesystem::path folder =
      std::filesystem::temp_directory_path() / ("klang-fuzz-case-" + std::to_string(::getpid()));
  std::filesystem::remove_all(folder);
  for (const char* const name :
       {"system/controlDict", "constant/polyMesh/points", "constant/polyMesh/faces", "constant/polyMesh/owner",
        "constant/polyMesh/neighbour", "constant/polyMesh/boundary", "0/alpha.water", "0.01/alpha.water"}) {
    const std::size_t end = bytes.find('\x1e');
    std::filesystem::create_directories((folder / name).parent_path());
    std::ofstream(folder / name, std::ios::binary) << bytes.substr(0, end);
    bytes = end == std::string_view::npos ? std::string_view() : bytes.substr(end + 1);
  }
  klang::liquid_scene::ForeignOptions options;
  options.frames = folder.string();
  const auto frames = klang::liquid_scene::openfoam_frames(options, klang::silent_monitor());
  for (std::size_t k = 0; k < frames->n_frames(); ++k) frames->read(k);
}

void read_as(int format, std::string_view bytes) {
  switch (format) {
    case 0:
      return read_document<klang::fit::FitDocument>(bytes);
    case 1:
      return read_document<klang::fit::AnalysisDocument>(bytes);
    case 2:
      return read_document<klang::modal::ModesDocument>(bytes);
    case 3:
      return read_document<klang::validate::StudyDocument>(bytes);
    case 4:
      return read_document<klang::validate::RegressionDocument>(bytes);
    case 5:
      return read_document<klang::fit::bubble::BubblesDocument>(bytes);
    case 6:
      return read_document<klang::fit::ProxyFitDocument>(bytes);
    case 7:
    case 8:
      return read_document<klang::fit::TuneDocument>(bytes);
    case 9:
      klang::validate::parse_reference(bytes, "fuzz");
      return;
    case 10:
      klang::fit::parse_partial_json(bytes, "fuzz");
      return;
    case 11:
      klang::fit::parse_partial_csv(bytes, "fuzz");
      return;
    case 15:
      klang::fit::read_universal_bytes(bytes, "fuzz");
      return;
    case 16: {
      const FuzzFile file(bytes, ".mat");
      klang::fit::read_responses(file.path());
      return;
    }
    case 17:  // read, and written again
      klang::entrainment::tracked_bubbles_text(
          klang::entrainment::parse_tracked_bubbles(std::string(bytes), "fuzz").paths);
      return;
    case 18: {
      const FuzzFile file(bytes, ".xz");
      klang::entrainment::read_tracked_bubbles(file.path());
      return;
    }
    case 19: {
      const FuzzFile file(bytes, ".vdb");
      const klang::liquid::VdbFile vdb(file.path());
      return;
    }
    case 20:
      return read_case(bytes);
    default:
      read_csv(format, bytes);
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  try {
    read_as(data[0] % 21, {reinterpret_cast<const char*>(data) + 1, size - 1});
  } catch (const klang::InputError&) {
  }
  return 0;
}
