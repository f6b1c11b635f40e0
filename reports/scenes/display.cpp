#include "reports/scenes/display.hpp"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <string_view>
#include <thread>

namespace klang::reports {
namespace {

using Clock = std::chrono::steady_clock;

/// Full path of a program, found along PATH; empty when there is none.
std::string program_path(std::string_view name) {
  const char* path = std::getenv("PATH");
  std::string_view rest = path ? path : "";
  while (!rest.empty()) {
    const std::size_t colon = rest.find(':');
    const std::string_view folder = rest.substr(0, colon);
    rest = colon == std::string_view::npos ? std::string_view() : rest.substr(colon + 1);
    if (folder.empty()) continue;
    std::string candidate = std::string(folder) + "/" + std::string(name);
    if (::access(candidate.c_str(), X_OK) == 0) return candidate;
  }
  return {};
}

/// A line from fd without its end, or empty when the time is over or the other end closed.
std::string line_from(int fd, Clock::time_point until) {
  std::string line;
  while (true) {
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(until - Clock::now()).count();
    if (left <= 0) return {};
    pollfd waiting{fd, POLLIN, 0};
    const int ready = ::poll(&waiting, 1, static_cast<int>(left));
    if (ready < 0 && errno == EINTR) continue;
    if (ready <= 0) return {};
    char c = 0;
    const ssize_t n = ::read(fd, &c, 1);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return {};
    if (c == '\n') return line;
    if (line.size() < 32) line += c;
  }
}

}  // namespace

VirtualDisplay::VirtualDisplay(double timeout_s) {
  const std::string server = program_path("Xvfb");
  if (server.empty()) {
    problem_ = "no Xvfb";
    return;
  }
  int ends[2];
  if (::pipe2(ends, O_CLOEXEC) != 0) {
    problem_ = "no pipe";
    return;
  }
  const char* const arguments[] = {server.c_str(), "-displayfd", "3",   "-screen",  "0",
                                   "1280x1024x24", "-nolisten",  "tcp", "-noreset", nullptr};
  const pid_t parent = ::getpid();
  process_ = ::fork();
  if (process_ == 0) {  // only async-signal-safe calls from here to execv
    ::setpgid(0, 0);    // an interrupt from the terminal must not reach the server before its user is done
    ::prctl(PR_SET_PDEATHSIG, SIGTERM);
    if (::getppid() != parent) ::_exit(127);
    const int nothing = ::open("/dev/null", O_RDWR);
    ::dup2(nothing, 0);
    ::dup2(nothing, 1);
    ::dup2(nothing, 2);
    if (ends[1] == 3) {
      ::fcntl(3, F_SETFD, 0);
    } else {
      ::dup2(ends[1], 3);
    }
    ::close_range(4, ~0U, 0);
    ::execv(server.c_str(), const_cast<char* const*>(arguments));
    ::_exit(127);
  }
  ::close(ends[1]);
  if (process_ < 0) {
    ::close(ends[0]);
    problem_ = "no process for Xvfb";
    return;
  }
  const auto until =
      Clock::now() + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(timeout_s));
  const std::string number = line_from(ends[0], until);
  ::close(ends[0]);
  if (number.empty() || number.find_first_not_of("0123456789") != std::string::npos) {
    problem_ = "Xvfb does not start";
    stop();
    return;
  }
  name_ = ":" + number;
}

VirtualDisplay::~VirtualDisplay() { stop(); }

void VirtualDisplay::stop() {
  if (process_ <= 0) return;
  ::kill(process_, SIGTERM);
  for (int i = 0; i < 300; ++i) {
    if (::waitpid(process_, nullptr, WNOHANG) != 0) {
      process_ = -1;
      return;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  ::kill(process_, SIGKILL);
  while (::waitpid(process_, nullptr, 0) < 0 && errno == EINTR) {
  }
  process_ = -1;
}

}  // namespace klang::reports
