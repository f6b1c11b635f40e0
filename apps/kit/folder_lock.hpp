#pragma once
#include <filesystem>

namespace klang::apps {

/// Holds a folder for one process while it lives. The system gives the lock back when a process ends, however it ends, so that none is ever
/// left over; its file (.lock) is removed by whoever holds it, and the folder with it where it was made for it and is empty.
class FolderLock {
 public:
  /// Makes the folder where it is missing. @throws InputError: another process holds it, or it cannot be made
  explicit FolderLock(const std::filesystem::path& folder);
  ~FolderLock();
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

 private:
  std::filesystem::path folder_, file_;
  std::filesystem::path made_;  ///< the topmost folder that was made; empty: none
  int descriptor_ = -1;
};

}  // namespace klang::apps
