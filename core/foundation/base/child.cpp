#include "core/foundation/base/child.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <exception>
#include <fstream>
#include <string_view>

#include "core/foundation/base/errors.hpp"

namespace klang {
namespace {

constexpr int kPollMs = 100;
constexpr int kThrew = 1;

void write_all(int fd, std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t n = ::write(fd, bytes.data(), bytes.size());
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return;
    bytes.remove_prefix(static_cast<std::size_t>(n));
  }
}

/// Address space of this process beside what it has now.
void limit_memory(std::size_t more_bytes) {
  std::size_t pages = 0;
  rlimit limit{};
  if (!(std::ifstream("/proc/self/statm") >> pages) || ::getrlimit(RLIMIT_AS, &limit) != 0) return;
  const rlim_t wanted = pages * static_cast<std::size_t>(::sysconf(_SC_PAGESIZE)) + more_bytes;
  if (limit.rlim_cur != RLIM_INFINITY && limit.rlim_cur < wanted) return;
  limit.rlim_cur = wanted;
  ::setrlimit(RLIMIT_AS, &limit);
}

[[noreturn]] void be_the_child(const std::function<std::string()>& work, int fd, pid_t parent, std::size_t more_bytes) {
  // What the terminal sends to the whole group is the parent's to answer.
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) std::signal(signal, SIG_IGN);
  for (const int signal : {SIGSEGV, SIGBUS, SIGFPE, SIGABRT}) std::signal(signal, SIG_DFL);
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  ::prctl(PR_SET_DUMPABLE, 0);  // a crash is an answer here: no core file
  if (::getppid() != parent) ::_exit(kThrew);
  const int nowhere = ::open("/dev/null", O_RDWR);
  ::dup2(nowhere, STDIN_FILENO);
  ::dup2(nowhere, STDOUT_FILENO);
  ::dup2(nowhere, STDERR_FILENO);
  if (more_bytes > 0) limit_memory(more_bytes);
  int code = 0;
  std::string bytes;
  try {
    bytes = work();
  } catch (const std::exception& error) {
    bytes = error.what();
    code = kThrew;
  }
  write_all(fd, bytes);
  ::_exit(code);
}

ChildResult run_here(const std::function<std::string()>& work) {
  ChildResult result;
  try {
    result.bytes = work();
    result.done = true;
  } catch (const std::exception& error) {
    result.bytes = error.what();
  }
  return result;
}

}  // namespace

ChildResult run_in_child(const std::function<std::string()>& work, Monitor& monitor, std::size_t more_bytes) {
  std::array<int, 2> ends{};
  if (::pipe2(ends.data(), O_CLOEXEC) != 0) return run_here(work);
  const pid_t parent = ::getpid(), child = ::fork();
  if (child < 0) {
    ::close(ends[0]);
    ::close(ends[1]);
    return run_here(work);
  }
  if (child == 0) be_the_child(work, ends[1], parent, more_bytes);
  ::close(ends[1]);
  ChildResult result;
  std::string buffer(1 << 16, '\0');
  bool stopped = false;
  for (;;) {
    if ((stopped = monitor.stop_requested())) break;
    pollfd wait{ends[0], POLLIN, 0};
    if (::poll(&wait, 1, kPollMs) <= 0) continue;
    const ssize_t n = ::read(ends[0], buffer.data(), buffer.size());
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) break;
    result.bytes.append(buffer.data(), static_cast<std::size_t>(n));
  }
  ::close(ends[0]);
  if (stopped) ::kill(child, SIGKILL);
  int status = 0;
  while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  if (stopped) throw Interrupted();
  result.done = WIFEXITED(status) && WEXITSTATUS(status) == 0;
  if (WIFSIGNALED(status)) result.signal = WTERMSIG(status);
  return result;
}

}  // namespace klang
