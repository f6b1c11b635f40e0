#include "reports/scenes/drawing_process.hpp"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>
#include <vtkObject.h>

#include <cerrno>
#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <cstring>

#include "reports/scenes/display.hpp"

namespace klang::reports::detail {
namespace {

constexpr double kSilenceLimitS = 90.0;  // a large mesh may take that long between two pictures, a hung driver longer
constexpr std::uint64_t kLargestPng = 64u << 20;

/// What the drawing process sends before each picture's bytes.
struct Header {
  std::uint32_t request = 0, width = 0, height = 0, flag = 0;
  double low = 0, high = 0;
  std::uint64_t n_bytes = 0;
};

bool write_whole(int fd, const void* data, std::size_t n) {
  const char* at = static_cast<const char*>(data);
  while (n > 0) {
    const ssize_t written = ::write(fd, at, n);
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return false;
    at += written;
    n -= static_cast<std::size_t>(written);
  }
  return true;
}

/// The drawing process. Never returns.
[[noreturn]] void draw_and_exit(const Drawer& drawer, const std::string& display, int fd, pid_t parent) {
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (::getppid() != parent) ::_exit(1);
  // What the caller did about signals is not for here; and when it aborts, no core file.
  for (const int number : {SIGINT, SIGTERM, SIGABRT, SIGSEGV, SIGPIPE}) ::signal(number, SIG_DFL);
  const rlimit none{0, 0};
  ::setrlimit(RLIMIT_CORE, &none);
  const int nothing = ::open("/dev/null", O_RDWR);
  ::dup2(nothing, 0);
  ::dup2(nothing, 1);
  ::dup2(nothing, 2);
  ::setenv("DISPLAY", display.c_str(), 1);
  ::setenv("VTK_SMP_BACKEND_IN_USE", "Sequential", 1);  // the caller's threads do not exist here
  vtkObject::GlobalWarningDisplayOff();
  try {
    drawer([&](std::size_t request, const std::optional<Drawing>& drawn) {
      Header header;
      header.request = static_cast<std::uint32_t>(request);
      std::string png;
      if (drawn) {
        png = png_bytes(drawn->image);
        header.width = static_cast<std::uint32_t>(drawn->image.width);
        header.height = static_cast<std::uint32_t>(drawn->image.height);
        header.flag = drawn->flag ? 1 : 0;
        header.low = drawn->low;
        header.high = drawn->high;
        header.n_bytes = png.size();
      }
      if (!write_whole(fd, &header, sizeof header) || !write_whole(fd, png.data(), png.size())) ::_exit(1);
    });
  } catch (const std::exception&) {
    ::_exit(1);
  }
  ::_exit(0);
}

enum class Reading { kDone, kEnded, kTimeout };

Reading read_whole(int fd, void* data, std::size_t n, Monitor& monitor) {
  using Clock = std::chrono::steady_clock;
  char* at = static_cast<char*>(data);
  auto last = Clock::now();
  while (n > 0) {
    pollfd waiting{fd, POLLIN, 0};
    const int ready = ::poll(&waiting, 1, 200);
    if (ready <= 0) {
      if (monitor.stop_requested() || std::chrono::duration<double>(Clock::now() - last).count() > kSilenceLimitS)
        return Reading::kTimeout;
      continue;
    }
    const ssize_t got = ::read(fd, at, n);
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return Reading::kEnded;
    at += got;
    n -= static_cast<std::size_t>(got);
    last = Clock::now();
  }
  return Reading::kDone;
}

}  // namespace

DrawnPictures draw_in_own_process(std::size_t n_requests, const Drawer& drawer, const std::string& what,
                                  const std::string& source, Monitor& monitor) {
  DrawnPictures result;
  result.pictures.resize(n_requests);
  if (n_requests == 0) return result;
  // An own server first: it draws the same everywhere, and a user's DISPLAY may be remote or dead.
  const VirtualDisplay server;
  std::string display = server.name();
  if (display.empty()) {
    const char* users = std::getenv("DISPLAY");
    if (!users || *users == '\0') {
      result.warning = server.problem() == "no Xvfb" ? "no display and no Xvfb: " + what + " left out"
                                                     : "no display and " + server.problem() + ": " + what + " left out";
      return result;
    }
    display = users;
  }
  int ends[2];
  if (::pipe2(ends, O_CLOEXEC) != 0) {
    result.warning = "no pipe to the drawing process: " + what + " left out";
    return result;
  }
  const pid_t parent = ::getpid();
  const pid_t child = ::fork();
  if (child == 0) {
    ::close(ends[0]);
    draw_and_exit(drawer, display, ends[1], parent);
  }
  ::close(ends[1]);
  if (child < 0) {
    ::close(ends[0]);
    result.warning = "no process to draw in: " + what + " left out";
    return result;
  }
  std::size_t n_answers = 0, n_missing = 0;
  Reading state = Reading::kDone;
  while (n_answers < n_requests) {
    Header header;
    state = read_whole(ends[0], &header, sizeof header, monitor);
    if (state != Reading::kDone || header.request >= n_requests || header.n_bytes > kLargestPng) break;
    DrawnPicture picture;
    picture.png.resize(header.n_bytes);
    picture.width = static_cast<int>(header.width);
    picture.height = static_cast<int>(header.height);
    picture.flag = header.flag != 0;
    picture.low = header.low;
    picture.high = header.high;
    state = read_whole(ends[0], picture.png.data(), picture.png.size(), monitor);
    if (state != Reading::kDone) break;
    if (picture.png.empty()) ++n_missing;
    result.pictures[header.request] = std::move(picture);
    ++n_answers;
    monitor.progress(what, static_cast<double>(n_answers) / static_cast<double>(n_requests));
  }
  ::close(ends[0]);
  if (n_answers < n_requests) ::kill(child, SIGKILL);
  int status = 0;
  while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  monitor.throw_if_stopped();
  const std::size_t left_out = n_requests - n_answers + n_missing;
  if (left_out > 0) {
    result.warning = state == Reading::kTimeout ? "drawing took too long: "
                     : n_answers < n_requests   ? "display " + display + " cannot draw: "
                                                : source + " missing or not readable: ";
    result.warning += (left_out == n_requests ? what : std::to_string(left_out) + " " + what) + " left out";
  }
  return result;
}

}  // namespace klang::reports::detail
