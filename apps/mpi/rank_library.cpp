#include "apps/kit/rank_library.hpp"

#include <mpi.h>

#include <deque>
#include <limits>
#include <stdexcept>

namespace {

constexpr int kTag = 1;

/// Messages between ranks; what is sent is kept until MPI has taken it.
class MpiTransport final : public klang::RankTransport {
 public:
  MpiTransport() {
    MPI_Comm_dup(MPI_COMM_WORLD, &world_);
    MPI_Comm_rank(world_, &rank_);
    MPI_Comm_size(world_, &size_);
  }
  int rank() const override { return rank_; }
  int size() const override { return size_; }

  void send(int to, std::string_view bytes) override {
    if (bytes.size() > static_cast<std::size_t>(std::numeric_limits<int>::max()))
      throw std::runtime_error("a message between processes of more than 2 GiB");
    drop_taken();
    Sent& sent = on_their_way_.emplace_back();
    sent.bytes = bytes;
    MPI_Isend(sent.bytes.data(), static_cast<int>(sent.bytes.size()), MPI_BYTE, to, kTag, world_, &sent.request);
  }

  std::optional<klang::RankMessage> receive() override {
    drop_taken();
    int is_there = 0;
    MPI_Status status;
    MPI_Iprobe(MPI_ANY_SOURCE, kTag, world_, &is_there, &status);
    if (is_there == 0) return std::nullopt;
    int n = 0;
    MPI_Get_count(&status, MPI_BYTE, &n);
    klang::RankMessage message{status.MPI_SOURCE, std::string(static_cast<std::size_t>(n), '\0')};
    MPI_Recv(message.bytes.data(), n, MPI_BYTE, status.MPI_SOURCE, kTag, world_, MPI_STATUS_IGNORE);
    return message;
  }

  void wait_until_sent() {
    for (Sent& sent : on_their_way_) MPI_Wait(&sent.request, MPI_STATUS_IGNORE);
    on_their_way_.clear();
  }

 private:
  struct Sent {
    std::string bytes;
    MPI_Request request = MPI_REQUEST_NULL;
  };
  void drop_taken() {
    while (!on_their_way_.empty()) {
      int is_taken = 0;
      MPI_Test(&on_their_way_.front().request, &is_taken, MPI_STATUS_IGNORE);
      if (is_taken == 0) return;
      on_their_way_.pop_front();
    }
  }
  MPI_Comm world_ = MPI_COMM_NULL;
  int rank_ = 0, size_ = 1;
  std::deque<Sent> on_their_way_;
};

}  // namespace

klang::RankTransport* klang_open_ranks() {
  int provided = 0;
  if (MPI_Init_thread(nullptr, nullptr, MPI_THREAD_FUNNELED, &provided) != MPI_SUCCESS) return nullptr;
  return new MpiTransport;
}

void klang_close_ranks(klang::RankTransport* ranks) {
  auto* mpi = static_cast<MpiTransport*>(ranks);
  mpi->wait_until_sent();
  delete mpi;
  MPI_Finalize();
}

void klang_abort_ranks(klang::RankTransport*, int code) { MPI_Abort(MPI_COMM_WORLD, code); }

const char* klang_mpi_version() {
  static char text[MPI_MAX_LIBRARY_VERSION_STRING];
  int n = 0;
  return MPI_Get_library_version(text, &n) == MPI_SUCCESS ? text : "";
}
