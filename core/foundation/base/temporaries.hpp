#pragma once
#include <filesystem>
#include <functional>
#include <string>

namespace klang {

/// A hidden file or folder that a result is written to before it gets its name. While this object lives the path is known to
/// remove_temporaries(). Its name ends in ".tmp-HOST-PID-START-NUMBER" (before the extension): whoever comes later can tell
/// whether the process that made it is gone.
class Temporary {
 public:
  /// Beside target, with its extension where with_extension. Leftovers of dead processes in that folder are removed.
  Temporary(const std::filesystem::path& target, const std::filesystem::path& folder, bool with_extension);
  ~Temporary();
  Temporary(const Temporary&) = delete;
  Temporary& operator=(const Temporary&) = delete;
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

/// Runs work (the renames that make a result visible) whole: remove_temporaries() waits for it.
void commit_whole(const std::function<void()>& work);

/// For a process about to end at once: removes every living Temporary's path, and lets no commit begin any more. Waits up to
/// half a second for one under way. Any thread may call it, once.
void remove_temporaries();

/// Removes what dead processes of this computer (and this space of process numbers) left in a folder; a folder is looked
/// through once per process.
void remove_stale_temporaries(const std::filesystem::path& folder);

}  // namespace klang
