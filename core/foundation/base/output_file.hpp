#pragma once
#include <filesystem>
#include <fstream>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

namespace klang {

class Temporary;

/// Writes a file whole or not at all: the bytes go to a temporary name beside the target, which is flushed, checked
/// and renamed. When anything fails (no folder, no permission, full disk) the temporary file is removed, an earlier
/// target stays as it was, and an InputError names the path and the system's reason.
void write_file(const std::filesystem::path& path, std::string_view bytes);

/// As write_file for a library that insists on writing to a name: writer gets a temporary path with the target's
/// extension and must throw or leave a complete file there.
void write_file_with(const std::filesystem::path& path,
                     const std::function<void(const std::filesystem::path& temporary)>& writer);

/// A result of several files, kept in a hidden folder beside (or, where it exists, in) the target until commit() moves each of them into the
/// target (files of other names that are there already stay). Without commit the destructor removes everything it made.
/// The constructor fails at once with an InputError where the target cannot be written.
class OutputDirectory {
 public:
  explicit OutputDirectory(std::filesystem::path target);
  ~OutputDirectory();
  OutputDirectory(const OutputDirectory&) = delete;
  OutputDirectory& operator=(const OutputDirectory&) = delete;
  /// Where to write in the meantime: staging() / "figures/a.png". Sub-folders are made by sub_folder().
  const std::filesystem::path& staging() const;
  std::filesystem::path sub_folder(std::string_view name) const;
  void commit();

 private:
  std::filesystem::path target_;
  std::unique_ptr<Temporary> staging_;
};

/// The file's bytes; InputError when it is missing, a folder, unreadable, or larger than max_bytes. "-" is standard input;
/// of pipes and devices 512 MiB at most are taken.
std::string read_file(const std::filesystem::path& path, std::size_t max_bytes = std::size_t{4} << 30);

}  // namespace klang
