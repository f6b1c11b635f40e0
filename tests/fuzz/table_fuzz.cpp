// Any bytes given as a result (JSON of every kind with a page), a reference spectrum, a partial table, a CSV, measured responses or
// tracked bubbles are either read or refused with an InputError. The first byte picks the format (tools/lib/fuzz_seeds.py has the same numbers).
#include <cstddef>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/parse_json.hpp"
#include "core/foundation/config/fields_json.hpp"
#include "core/physics/bubble/time_series.hpp"
#include "core/physics/entrainment/tracked_bubbles.hpp"
#include "core/physics/modal/modes_document.hpp"
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
    default:
      read_csv(format, bytes);
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  try {
    read_as(data[0] % 19, {reinterpret_cast<const char*>(data) + 1, size - 1});
  } catch (const klang::InputError&) {
  }
  return 0;
}
