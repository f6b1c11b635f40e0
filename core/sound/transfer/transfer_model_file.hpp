#pragma once
#include <filesystem>
#include <string>

#include "core/physics/modal/modal_model.hpp"
#include "core/sound/transfer/transfer_model.hpp"

namespace klang::acoustics {

/// Writes and reads a .vtu that ParaView opens: one point a mode at the centre of its multipole, with frequency, order,
/// power, decay and elements as point data; coefficients (real and imaginary parts in turn, mode after mode), medium and
/// provenance as field data. Reading gives back every bit.
void write_transfer_model(const std::filesystem::path& path, const TransferModel& model,
                          const std::string& provenance_json = "{}");
/// @throws InputError when the file is no transfer model or its parts do not fit together
TransferModel read_transfer_model(const std::filesystem::path& path);
TransferModel read_transfer_model_bytes(std::string bytes, const std::string& name);
/// The provenance it was written with.
std::string read_transfer_provenance(const std::filesystem::path& path);

/// InputError unless every mode of transfer is one of model: index in range, frequencies equal to 1e-6 relative.
/// place: the file, for the message.
void check_belongs(const TransferModel& transfer, const modal::ModalModel& model, const std::string& place);

}  // namespace klang::acoustics
