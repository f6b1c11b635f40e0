#include "core/foundation/base/output_file.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <map>
#include <mutex>
#include <system_error>
#include <vector>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/temporaries.hpp"

namespace klang {
namespace fs = std::filesystem;
namespace {

[[noreturn]] void fail(const fs::path& path, int error) {
  throw InputError(path.string(), std::string("cannot write: ") + std::strerror(error));
}

/// Forces the file's bytes to the disk, so that a full disk shows before the rename.
void flush_to_disk(const fs::path& file, const fs::path& target) {
  const int fd = ::open(file.c_str(), O_RDONLY | O_CLOEXEC);
  if (fd < 0) fail(target, errno);
  const int status = ::fsync(fd);
  const int error = errno;
  ::close(fd);
  if (status != 0 && error != EINVAL && error != EROFS) fail(target, error);
}

void write_bytes(const fs::path& file, const fs::path& target, std::string_view bytes) {
  const int fd = ::open(file.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0644);
  if (fd < 0) fail(target, errno);
  while (!bytes.empty()) {
    const ssize_t n = ::write(fd, bytes.data(), bytes.size());
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) {
      const int error = errno;
      ::close(fd);
      fail(target, error);
    }
    bytes.remove_prefix(static_cast<std::size_t>(n));
  }
  if (::close(fd) != 0) fail(target, errno);
}

}  // namespace

void write_file(const fs::path& path, std::string_view bytes) {
  if (fs::is_character_file(path)) {  // /dev/stdout, /dev/full
    std::ofstream out(path, std::ios::binary);
    out.write(bytes.data(), static_cast<std::streamsize>(bytes.size())).flush();
    if (!out) fail(path, errno != 0 ? errno : EIO);
    return;
  }
  write_file_with(path, [&](const fs::path& temporary) { write_bytes(temporary, path, bytes); });
}

void write_file_with(const fs::path& path, const std::function<void(const fs::path&)>& writer) {
  if (path.empty() || fs::is_directory(path)) throw InputError(path.string(), "cannot write: not a file name");
  const Temporary temporary(path, path.parent_path(), true);
  try {
    writer(temporary.path());
    flush_to_disk(temporary.path(), path);
    std::error_code error;
    commit_whole([&] { fs::rename(temporary.path(), path, error); });
    if (error) fail(path, error.value());
  } catch (const std::exception&) {
    std::error_code ignored;
    fs::remove(temporary.path(), ignored);
    throw;
  }
}

OutputDirectory::OutputDirectory(fs::path target) : target_(std::move(target)) {
  if (!target_.has_filename()) target_ = target_.parent_path();
  if (target_.empty()) throw InputError("output folder", "its name is empty");
  if (fs::exists(target_) && !fs::is_directory(target_)) {
    throw InputError(target_.string(), "cannot write: it is a file, not a folder");
  }
  // Inside the target where it is there already: its parent may be another file system, or not ours to write.
  const fs::path parent = fs::is_directory(target_) ? fs::absolute(target_) : fs::absolute(target_).parent_path();
  std::error_code error;
  fs::create_directories(parent, error);
  if (error) fail(target_, error.value());
  staging_ = std::make_unique<Temporary>(target_, parent, false);
  fs::create_directory(staging(), error);
  if (error) fail(target_, error.value());
}

OutputDirectory::~OutputDirectory() {
  std::error_code ignored;
  fs::remove_all(staging(), ignored);
}

const fs::path& OutputDirectory::staging() const { return staging_->path(); }

fs::path OutputDirectory::sub_folder(std::string_view name) const {
  const fs::path folder = staging() / name;
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) fail(target_ / name, error.value());
  return folder;
}

void OutputDirectory::commit() {
  std::vector<fs::path> files;
  for (const auto& entry : fs::recursive_directory_iterator(staging())) {
    if (entry.is_regular_file()) files.push_back(fs::relative(entry.path(), staging()));
  }
  for (const fs::path& file : files) flush_to_disk(staging() / file, target_ / file);
  commit_whole([&] {
    std::error_code error;
    for (const fs::path& file : files) {
      fs::create_directories((target_ / file).parent_path(), error);
      if (!error) fs::rename(staging() / file, target_ / file, error);
      if (error) fail(target_ / file, error.value());
    }
  });
}

namespace {

constexpr std::size_t kMostOfStream = std::size_t{512} << 20;  // a device may never end

/// Of a pipe or device. It can be read once only: whoever asks again (for the hash of the input) gets the same bytes.
std::string stream_bytes(const fs::path& path, std::size_t max_bytes) {
  static std::mutex mutex;
  static std::map<fs::path, std::string> read_before;
  const std::lock_guard lock(mutex);
  if (const auto found = read_before.find(path); found != read_before.end()) return found->second;
  std::ifstream in(path, std::ios::binary);
  if (!in) throw InputError(path.string(), "cannot be read");
  std::string bytes, chunk(1 << 20, '\0');
  while (in) {
    in.read(chunk.data(), static_cast<std::streamsize>(chunk.size()));
    bytes.append(chunk.data(), static_cast<std::size_t>(in.gcount()));
    if (bytes.size() > max_bytes)
      throw InputError(path.string(), "gives too many bytes", "more than " + std::to_string(max_bytes), "a file");
  }
  return read_before.emplace(path, std::move(bytes)).first->second;
}

}  // namespace

std::string read_file(const fs::path& path, std::size_t max_bytes) {
  std::error_code error;
  if (path == "-" && !fs::exists(path, error)) return stream_bytes("/dev/stdin", std::min(max_bytes, kMostOfStream));
  const auto status = fs::status(path, error);
  if (!fs::exists(status)) throw InputError(path.string(), "no such file");
  if (fs::is_directory(status)) throw InputError(path.string(), "is a folder, not a file");
  std::string bytes;
  if (fs::is_regular_file(status)) {
    std::ifstream in(path, std::ios::binary);
    if (!in) throw InputError(path.string(), "cannot be read");
    const auto size = fs::file_size(path);
    if (size > max_bytes) {
      throw InputError(path.string(), "is too large", std::to_string(size) + " bytes",
                       "up to " + std::to_string(max_bytes));
    }
    bytes.resize(size);
    in.read(bytes.data(), static_cast<std::streamsize>(size));
    bytes.resize(static_cast<std::size_t>(in.gcount()));
  } else {
    return stream_bytes(path, std::min(max_bytes, kMostOfStream));
  }
  return bytes;
}

}  // namespace klang
