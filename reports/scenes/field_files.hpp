#pragma once
#include <filesystem>
#include <optional>

#include "validate/studies/fields.hpp"

namespace klang::reports {

/// Level below the loudest direction at which a directivity balloon shrinks to a point.
inline constexpr double kBalloonRange_db = 30.0;

/// How a field of a study is shown.
enum class FieldKind { kSurface, kSlice, kBalloon };

/// Writes the fields of a study for ParaView, under the names that validate::FieldRecord has:
///   surfaces  NAME.vtp  triangles, point array named by the quantity
///   slices    NAME.vti  image in the plane of the slice (its direction matrix turns it), point array; NaN inside bodies
///   balloons  NAME.vtp  points at (1 + level / 30 dB) times the direction, arrays level_db (re loudest) and magnitude
/// @throws InputError when a file cannot be written
void write_fields(const validate::Fields& fields, const std::filesystem::path& folder);

/// A slice that write_fields wrote: geometry and values; empty where the file is none.
std::optional<validate::SliceField> read_slice(const std::filesystem::path& path);

}  // namespace klang::reports
