#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "core/sound/transfer/transfer_model.hpp"

namespace klang::acoustics {

/// The modes that a stopped run of radiate() had finished, in a file of their own: good for the same model and options only,
/// which a key names.
class RadiateProgress {
 public:
  /// Takes what the file holds, if it is there and was written under the same key. A file that cannot be read (another
  /// program's, or a damaged one) counts as none.
  RadiateProgress(std::filesystem::path file, std::string key, const Medium& medium);

  bool unreadable() const { return unreadable_; }  ///< there was a file, and no sense in it
  const std::vector<ModeTransfer>& modes() const { return model_.modes; }
  void add(const ModeTransfer& mode);  ///< writes the file anew, modes by index. @throws InputError when that fails
  void remove() const;                 ///< the file, once it is no longer needed

 private:
  std::filesystem::path file_;
  std::string key_;
  TransferModel model_;
  bool unreadable_ = false;
};

}  // namespace klang::acoustics
