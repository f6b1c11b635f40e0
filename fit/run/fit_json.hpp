#pragma once
#include <nlohmann/json_fwd.hpp>

#include "core/foundation/config/result_header.hpp"
#include "fit/run/fit.hpp"
#include "fit/tune/tune.hpp"

namespace klang::fit {

/// fit.json as docs/result-json.md describes it. The files it names lie beside it: recording-NAME.wav,
/// resynthesis-NAME.wav, modes-NAME.vtu (null where a specimen has none).
nlohmann::json fit_json(const FitProblem& problem, const FitResult& result, const Provenance& provenance);

/// tune.json: docs/result-json.md.
nlohmann::json tune_json(const TuneResult& result, const Provenance& provenance);

/// NAME as it appears in file names: everything but letters, digits, - and _ becomes _.
std::string file_stem(const std::string& specimen_name);

}  // namespace klang::fit
