#include "apps/kit/signals.hpp"

#include <semaphore.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <string_view>
#include <thread>

#include "core/foundation/base/temporaries.hpp"

namespace klang::apps {
namespace {

constexpr auto kPatience = std::chrono::milliseconds(800);

std::atomic<int> first_signal = 0;
std::atomic<int> code_at_end = -1;
static_assert(std::atomic<int>::is_always_lock_free);
sem_t signal_came;

extern "C" void on_signal(int signal) {
  const int before = errno;
  int none = 0;
  if (first_signal.compare_exchange_strong(none, signal)) ::sem_post(&signal_came);
  errno = before;
}

void watch() {
  while (::sem_wait(&signal_came) != 0 && errno == EINTR) {
  }
  std::this_thread::sleep_for(kPatience);
  const int code = code_at_end;
  if (code < 0) {
    constexpr std::string_view kPlain = "klang: interrupted\n", kOverProgress = "\r\033[Kklang: interrupted\n";
    const std::string_view text = ::isatty(STDERR_FILENO) == 1 ? kOverProgress : kPlain;
    [[maybe_unused]] const auto n = ::write(STDERR_FILENO, text.data(), text.size());
    remove_temporaries();
  }
  ::_exit(code < 0 ? 128 + first_signal : code);
}

}  // namespace

void heed_signals() {
  static const bool once = [] {
    ::sem_init(&signal_came, 0, 0);
    // Not asked to do anything, the thread only waits; it needs no end.
    std::thread(watch).detach();
    struct sigaction action {};
    action.sa_handler = on_signal;
    action.sa_flags = SA_RESTART;
    for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
      struct sigaction before {};
      if (signal == SIGHUP && ::sigaction(signal, nullptr, &before) == 0 && before.sa_handler == SIG_IGN) continue;
      ::sigaction(signal, &action, nullptr);
    }
    return true;
  }();
  static_cast<void>(once);
}

int stop_signal() { return first_signal; }

void work_is_over(int exit_code) { code_at_end = exit_code; }

}  // namespace klang::apps
