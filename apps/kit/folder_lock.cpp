#include "apps/kit/folder_lock.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "core/foundation/base/errors.hpp"

namespace klang::apps {
namespace {

/// Whether the open file is still the one of that name: who held it before may have removed it meanwhile.
bool is_named(int descriptor, const std::filesystem::path& file) {
  struct stat open_one {
  }, named{};
  return fstat(descriptor, &open_one) == 0 && stat(file.c_str(), &named) == 0 && open_one.st_ino == named.st_ino &&
         open_one.st_dev == named.st_dev;
}

}  // namespace

FolderLock::FolderLock(const std::filesystem::path& folder) : folder_(folder), file_(folder / ".lock") {
  std::error_code error;
  for (std::filesystem::path path = std::filesystem::absolute(folder, error);
       !path.empty() && !std::filesystem::exists(path, error) && path != path.parent_path(); path = path.parent_path())
    made_ = path;
  std::filesystem::create_directories(folder_, error);
  if (error) throw InputError("--output", "cannot be made: " + error.message(), folder_.string());
  while (descriptor_ < 0) {
    descriptor_ = open(file_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
    if (descriptor_ < 0) throw InputError(file_.string(), std::string("cannot be made: ") + std::strerror(errno));
    if (flock(descriptor_, LOCK_EX | LOCK_NB) != 0) {
      const bool is_held = errno == EWOULDBLOCK;
      close(descriptor_);
      descriptor_ = -1;
      if (is_held)
        throw InputError(folder_.string(), "holds a run already, which is at work", "", "its end, or another folder");
      std::filesystem::remove(file_, error);
      return;  // a file system without locks
    }
    if (is_named(descriptor_, file_)) break;
    close(descriptor_);
    descriptor_ = -1;
  }
}

FolderLock::~FolderLock() {
  if (descriptor_ < 0) return;
  std::error_code ignored;
  std::filesystem::remove(file_, ignored);
  close(descriptor_);
  if (made_.empty()) return;
  for (std::filesystem::path path = std::filesystem::absolute(folder_, ignored);; path = path.parent_path())
    if (!std::filesystem::remove(path, ignored) || ignored || path == made_) break;  // not empty: stays
}

}  // namespace klang::apps
