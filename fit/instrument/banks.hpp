#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "core/foundation/base/monitor.hpp"
#include "core/sound/instrument/modal_bank.hpp"
#include "fit/ringdown/analysis_document.hpp"

namespace klang::fit {

/// analysis.json. @throws InputError
AnalysisDocument read_analysis_document(const std::filesystem::path& path);

/// The partials of a recording as a bank: those with a decay and an amplitude that ring (is_ring).
/// @param undamped  how many had no decay and are left out
instrument::ModalBank bank_of(const AnalysisDocument& analysis, int* undamped = nullptr);

/// A unit impulse across the body's thinnest direction at its far end, within 20 us: the strike where none is asked for.
events::Strike default_strike(const modal::ModalModel& model);

/// Banks of a result for other programs: of an analysis.json one with its amplitudes, of a fit.json one for each specimen (or
/// the named one) after the default strike, whose absolute level nobody measured: each peaks at instrument::kPeak.
/// @param frequencies_only  nothing but the frequencies will be used: a fit without damping will do
/// @throws InputError: another kind of result; a fit or a partial without damping
std::vector<instrument::ModalBank> read_banks(const std::filesystem::path& path, const std::string& specimen,
                                              double rate_hz, bool frequencies_only = false,
                                              Monitor& monitor = silent_monitor());

}  // namespace klang::fit
