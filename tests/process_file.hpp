#pragma once
#include <unistd.h>

#include <filesystem>
#include <list>
#include <string>
#include <system_error>
#include <utility>

namespace klang::test {

/// A temporary file's name that is this process' own, since ctest runs the tests of one program beside each other; the file goes when
/// the process ends.
inline std::filesystem::path process_file(const std::string& name) {
  struct File {
    explicit File(std::filesystem::path of) : path(std::move(of)) {}
    File(const File&) = delete;
    File& operator=(const File&) = delete;
    std::filesystem::path path;
    ~File() {
      std::error_code ignored;
      std::filesystem::remove(path, ignored);
    }
  };
  static std::list<File> files;
  const auto path = std::filesystem::temp_directory_path() / ("klang-" + std::to_string(::getpid()) + "-" + name);
  files.emplace_back(path);
  return path;
}

}  // namespace klang::test
