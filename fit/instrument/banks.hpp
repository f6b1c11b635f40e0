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

/// Banks, and what was assumed to make them.
struct ReadBanks {
  std::vector<instrument::ModalBank> banks;
  std::vector<std::string> warnings = {};
};

/// The partials of a recording as one bank: those with an amplitude that ring (is_ring); without a decay by the assumed loss factor.
ReadBanks bank_of(const AnalysisDocument& analysis);

/// A unit impulse across the body's thinnest direction at its far end, within 20 us: the strike where none is asked for.
events::Strike default_strike(const modal::ModalModel& model);

/// Banks of a result for other programs: of an analysis.json one with its amplitudes, of a fit.json one for each specimen (or
/// the named one) after the default strike, whose absolute level nobody measured: each peaks at instrument::kPeak.
/// Where no damping was measured it is assumed, and said.
/// @throws InputError: another kind of result; nothing that rings
ReadBanks read_banks(const std::filesystem::path& path, const std::string& specimen, double rate_hz,
                     Monitor& monitor = silent_monitor());

}  // namespace klang::fit
