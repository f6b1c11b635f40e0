#pragma once
#include <sys/mman.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <string>
#include <string_view>

namespace klang::test {

/// Bytes as a file of this process, in memory: for readers that take a path. The name ends as the format's files do.
class FuzzFile {
 public:
  FuzzFile(std::string_view bytes, const std::string& extension) : descriptor_(::memfd_create("fuzz", 0)) {
    if (descriptor_ < 0 || ::write(descriptor_, bytes.data(), bytes.size()) != static_cast<ssize_t>(bytes.size()))
      std::abort();
    path_ = std::filesystem::temp_directory_path() / ("klang-fuzz-" + std::to_string(::getpid()) + extension);
    std::error_code error;
    std::filesystem::remove(path_, error);
    std::filesystem::create_symlink("/proc/self/fd/" + std::to_string(descriptor_), path_);
  }
  ~FuzzFile() {
    std::error_code error;
    std::filesystem::remove(path_, error);
    ::close(descriptor_);
  }
  FuzzFile(const FuzzFile&) = delete;
  FuzzFile& operator=(const FuzzFile&) = delete;
  const std::filesystem::path& path() const { return path_; }

 private:
  int descriptor_;
  std::filesystem::path path_;
};

}  // namespace klang::test
