#include "core/sound/transfer/radiate_progress.hpp"

#include <algorithm>

#include "core/foundation/base/errors.hpp"
#include "core/sound/transfer/transfer_model_file.hpp"

namespace klang::acoustics {

RadiateProgress::RadiateProgress(std::filesystem::path file, std::string key, const Medium& medium)
    : file_(std::move(file)), key_(std::move(key)), model_{medium, {}} {
  if (!std::filesystem::exists(file_)) return;
  try {
    if (read_transfer_provenance(file_) == key_) model_ = read_transfer_model(file_);
  } catch (const InputError&) {
    unreadable_ = true;
  }
}

void RadiateProgress::add(const ModeTransfer& mode) {
  model_.modes.push_back(mode);
  std::sort(model_.modes.begin(), model_.modes.end(), [](const auto& a, const auto& b) { return a.mode < b.mode; });
  write_transfer_model(file_, model_, key_);
}

void RadiateProgress::remove() const {
  std::error_code ignored;
  std::filesystem::remove(file_, ignored);
}

}  // namespace klang::acoustics
