#include "core/foundation/base/temporaries.hpp"

#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <charconv>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <fstream>
#include <mutex>
#include <set>
#include <sstream>
#include <vector>

namespace klang {
namespace fs = std::filesystem;
namespace {

constexpr std::string_view kMark = ".tmp-";
constexpr int kMostEntries = 20000;  // of a folder; in a larger one nothing is looked for
constexpr auto kCommitPatience = std::chrono::milliseconds(500);

struct Registry {
  std::timed_mutex mutex;
  std::set<fs::path> paths, searched_folders;
};

Registry& registry() {
  static Registry* const instance = new Registry;  // outlives every thread
  return *instance;
}

/// When the process began, in clock ticks since the computer did (field 22 of /proc/PID/stat); 0: there is none.
std::uint64_t start_of(std::uint64_t pid) {
  std::ifstream file("/proc/" + std::to_string(pid) + "/stat");
  std::string line;
  std::getline(file, line);
  const std::size_t name_end = line.rfind(')');
  if (name_end == std::string::npos) return 0;
  std::istringstream fields(line.substr(name_end + 1));
  std::string skipped;
  for (int field = 3; field < 22; ++field) fields >> skipped;
  std::uint64_t start = 0;
  fields >> start;
  return start;
}

/// Of the computer and its space of process numbers (FNV-1a).
std::string host_mark() {
  std::array<char, 256> host{}, space{};
  ::gethostname(host.data(), host.size() - 1);
  if (::readlink("/proc/self/ns/pid", space.data(), space.size() - 1) < 0) space[0] = '\0';
  std::uint32_t hash = 2166136261U;
  for (const char c : std::string(host.data()) + space.data())
    hash = (hash ^ static_cast<unsigned char>(c)) * 16777619U;
  char text[16];
  std::snprintf(text, sizeof text, "%08x", hash);
  return text;
}

const std::string& own_mark() {
  static const std::string mark = std::string(kMark) + host_mark() + "-" + std::to_string(::getpid()) + "-" +
                                  std::to_string(start_of(static_cast<std::uint64_t>(::getpid()))) + "-";
  return mark;
}

/// Whether a name is that of a Temporary of this computer whose process is gone.
bool is_stale(const std::string& name) {
  const std::size_t at = name.rfind(kMark);
  if (name.empty() || name[0] != '.' || at == std::string::npos) return false;
  const std::string prefix = std::string(kMark) + host_mark() + "-";
  if (name.compare(at, prefix.size(), prefix) != 0) return false;
  std::array<std::uint64_t, 3> numbers{};  // process, start, counter
  const char *next = name.data() + at + prefix.size(), *const last = name.data() + name.size();
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    const auto parsed = std::from_chars(next, last, numbers[i]);
    if (parsed.ec != std::errc()) return false;
    next = parsed.ptr;
    if (i + 1 < numbers.size() && (next == last || *next++ != '-')) return false;
  }
  return (next == last || *next == '.') && start_of(numbers[0]) != numbers[1];
}

}  // namespace

Temporary::Temporary(const fs::path& target, const fs::path& folder, bool with_extension) {
  static std::atomic<unsigned> counter = 0;
  remove_stale_temporaries(folder);
  const std::string number = own_mark() + std::to_string(counter++);
  path_ = folder / ("." + (with_extension ? target.stem().string() + number + target.extension().string()
                                          : target.filename().string() + number));
  const std::lock_guard lock(registry().mutex);
  registry().paths.insert(path_);
}

Temporary::~Temporary() {
  const std::lock_guard lock(registry().mutex);
  registry().paths.erase(path_);
}

void commit_whole(const std::function<void()>& work) {
  const std::lock_guard lock(registry().mutex);
  work();
}

void remove_temporaries() {
  if (!registry().mutex.try_lock_for(kCommitPatience)) return;
  // The lock is kept: whoever wants to commit now waits for the end of the process.
  for (int pass = 0; pass < 3; ++pass)  // other threads may still be writing there
    for (const fs::path& path : registry().paths) {
      std::error_code ignored;
      fs::remove_all(path, ignored);
    }
}

void remove_stale_temporaries(const fs::path& folder) {
  {
    const std::lock_guard lock(registry().mutex);
    if (!registry().searched_folders.insert(folder).second) return;
  }
  std::error_code error;
  std::vector<fs::path> stale;
  int n = 0;
  for (fs::directory_iterator entry(folder.empty() ? fs::path(".") : folder, error), end; !error && entry != end;
       entry.increment(error)) {
    if (++n > kMostEntries) return;
    struct stat status {};
    if (is_stale(entry->path().filename().string()) && ::lstat(entry->path().c_str(), &status) == 0 &&
        status.st_uid == ::geteuid() && (S_ISREG(status.st_mode) || S_ISDIR(status.st_mode)))
      stale.push_back(entry->path());
  }
  for (const fs::path& path : stale) fs::remove_all(path, error);
}

}  // namespace klang
