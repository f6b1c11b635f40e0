#pragma once
#include <filesystem>

#include "core/physics/events/event_log.hpp"

namespace klang::events {

/// Writes a log as HDF5 (docs/event-log.md): a group per table, a dataset per field. Whole or not at all; the same log
/// gives the same bytes.
/// @throws InputError where the log is not valid or the file cannot be written
void write_event_log(const std::filesystem::path& path, const EventLog& log);

/// Reads it to the bit, or what another program wrote in that layout: tables and fields that are missing keep their
/// defaults unless docs/event-log.md requires them, what is not known is left alone, numbers of another width are
/// converted. Bodies that impulses and poses name are made up where there is no table of bodies.
/// @throws InputError in one line that names the file, and the dataset or row, for everything else
EventLog read_event_log(const std::filesystem::path& path);

}  // namespace klang::events
