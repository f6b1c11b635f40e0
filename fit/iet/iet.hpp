#pragma once
#include <filesystem>
#include <vector>

#include "core/foundation/base/monitor.hpp"
#include "fit/iet/iet_document.hpp"

namespace klang::fit {

/// Whether the recordings that a specimens' file names have to be there: not where they are to be made.
enum class IetRecordings { kNeeded, kNotYet };

/// The specimens' file: a CSV with a head line; columns as IetSpecimen describes them.
/// @throws InputError naming file, line and column: unknown or missing columns, a dimension that the shape needs or does not have,
/// a value out of range, a recording that is not there, a name used twice
std::vector<IetSpecimen> read_iet_specimens(const std::filesystem::path& path,
                                            IetRecordings recordings = IetRecordings::kNeeded);

/// @throws InputError at this place: a dimension that the shape needs is missing, or one has no meaning for it
void check_dimensions(const IetSpecimen& specimen, const std::string& place);

/// Frequencies, moduli and damping of each, in parallel. Which partial is which: every pair of partials that can be the first
/// flexural and first torsional (of a disc: first and second natural) frequency gives a material; the one is taken under which most of what
/// rings is a mode of this body (reduced model of the full three-dimensional one). A second one that is another mode as well, of the same
/// first and some Poisson's ratio, is not taken: bars struck in the middle have no torsion, and a flexural overtone would be it.
/// @param folder  that recordings are relative to
std::vector<IetRow> measure_specimens(const std::vector<IetSpecimen>& specimens, const std::filesystem::path& folder,
                                      Monitor& monitor = silent_monitor());

/// Marks rows whose E or G (closed form) has a modified z-score 0.6745 |x - median| / MAD above 3.5 among five or more of a shape
/// (Iglewicz and Hoaglin, How to Detect and Handle Outliers, 1993).
void mark_outliers(std::vector<IetRow>& rows);

/// Mean and standard deviation (n - 1) by shape of what was measured, without outliers and what is implausible.
std::vector<IetSummary> summary_of(const std::vector<IetRow>& rows);

}  // namespace klang::fit
