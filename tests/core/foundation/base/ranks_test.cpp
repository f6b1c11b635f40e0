// Ranks as threads of one process that talk through queues: the protocol of core/foundation/base/job_ranks.hpp without MPI.
#include <gtest/gtest.h>

#include <deque>
#include <mutex>
#include <numeric>
#include <thread>
#include <vector>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/job_ranks.hpp"
#include "core/foundation/base/packed.hpp"
#include "core/foundation/base/shared_jobs.hpp"

namespace klang {
namespace {

struct Post {
  explicit Post(int n) : boxes(static_cast<std::size_t>(n)) {}
  std::mutex mutex;
  std::vector<std::deque<RankMessage>> boxes;
};

class QueueTransport final : public RankTransport {
 public:
  QueueTransport(Post& post, int rank) : post_(post), rank_(rank) {}
  int rank() const override { return rank_; }
  int size() const override { return static_cast<int>(post_.boxes.size()); }
  void send(int to, std::string_view bytes) override {
    const std::lock_guard lock(post_.mutex);
    post_.boxes[static_cast<std::size_t>(to)].push_back({rank_, std::string(bytes)});
  }
  std::optional<RankMessage> receive() override {
    const std::lock_guard lock(post_.mutex);
    auto& box = post_.boxes[static_cast<std::size_t>(rank_)];
    if (box.empty()) return std::nullopt;
    RankMessage message = box.front();
    box.pop_front();
    return message;
  }

 private:
  Post& post_;
  int rank_;
};

void on_ranks(int n, const std::function<void(JobRanks&)>& program) {
  Post post(n);
  std::vector<std::thread> threads;
  for (int r = 0; r < n; ++r)
    threads.emplace_back([&post, &program, r] {
      QueueTransport transport(post, r);
      JobRanks ranks(transport);
      program(ranks);
    });
  for (std::thread& thread : threads) thread.join();
}

std::string square(std::size_t i) { return Packer().add(static_cast<double>(i) * static_cast<double>(i)).take(); }

TEST(Ranks, EveryRankEndsUpWithTheResultOfEachJobOnceAndEachJobRunsOnce) {
  for (const int n : {1, 2, 3, 5}) {
    constexpr std::size_t kJobs = 100;
    std::vector<std::atomic<int>> runs(kJobs);
    std::vector<std::vector<double>> found(static_cast<std::size_t>(n), std::vector<double>(kJobs, -1.0));
    on_ranks(n, [&](JobRanks& ranks) {
      ranks.meet();
      auto& mine = found[static_cast<std::size_t>(ranks.rank())];
      for (int call = 0; call < 3; ++call) {
        ranks.run(
            {kJobs, 2, "squares"}, [&](std::size_t i) { return ++runs[i], square(i); },
            [&](std::size_t i, std::string_view result) { mine[i] = Unpacker(result).take<double>(); },
            silent_monitor());
      }
      EXPECT_TRUE(ranks.finish(0, {}, std::chrono::seconds(5)).together);
    });
    for (std::size_t i = 0; i < kJobs; ++i) {
      EXPECT_EQ(runs[i], 3) << i;
      for (const auto& of_rank : found) EXPECT_EQ(of_rank[i], static_cast<double>(i * i));
    }
  }
}

TEST(Ranks, TheFailureOfTheLowestJobThatFailedIsThrownOnAllWithItsKind) {
  on_ranks(3, [](JobRanks& ranks) {
    const auto job = [](std::size_t i) -> std::string {
      if (i >= 5) throw InputError("job " + std::to_string(i));
      return {};
    };
    try {
      ranks.run(
          {9, 1, "failing"}, job, [](std::size_t, std::string_view) {}, silent_monitor());
      ADD_FAILURE() << "no failure on rank " << ranks.rank();
    } catch (const InputError& error) {
      EXPECT_TRUE(std::string(error.what()).starts_with("job ")) << error.what();
    }
    // They go on together afterwards.
    int n = 0;
    ranks.run(
        {4, 1, "again"}, square, [&](std::size_t, std::string_view) { ++n; }, silent_monitor());
    EXPECT_EQ(n, 4);
    ranks.finish(0, {}, std::chrono::seconds(5));
  });
}

TEST(Ranks, ARankThatEndsAloneEndsTheOthersInsteadOfKeepingThemWaiting) {
  on_ranks(3, [](JobRanks& ranks) {
    if (ranks.rank() == 2) {
      ranks.finish(3, "out of memory", std::chrono::seconds(5));
      return;
    }
    try {
      ranks.run(
          {50, 1, "jobs"}, square, [](std::size_t, std::string_view) {}, silent_monitor());
      ADD_FAILURE() << "rank " << ranks.rank() << " did not hear of it";
    } catch (const NumericalError& error) {
      EXPECT_NE(std::string(error.what()).find("process 2 ended: out of memory"), std::string::npos) << error.what();
    }
    EXPECT_TRUE(ranks.finish(3, "failed", std::chrono::seconds(5)).together);
  });
}

TEST(Ranks, RanksThatDisagreeAboutTheWorkAreToldSo) {
  on_ranks(2, [](JobRanks& ranks) {
    const std::size_t n = ranks.rank() == 0 ? 5 : 6;
    EXPECT_THROW(ranks.run(
                     {n, 1, "jobs"}, square, [](std::size_t, std::string_view) {}, silent_monitor()),
                 NumericalError);
    ranks.finish(3, {}, std::chrono::seconds(5));
  });
}

TEST(Ranks, AStopOfAnyRankStopsAll) {
  struct Stop : Monitor {
    bool stop_requested() const override { return true; }
  } stop;
  on_ranks(3, [&](JobRanks& ranks) {
    const auto slow = [](std::size_t) {
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
      return std::string();
    };
    EXPECT_THROW(ranks.run(
                     {100000, 1, "jobs"}, slow, [](std::size_t, std::string_view) {},
                     ranks.rank() == 1 ? static_cast<Monitor&>(stop) : silent_monitor()),
                 Interrupted);
    ranks.finish(130, {}, std::chrono::seconds(5));
  });
}

TEST(Ranks, TheExitOfARankThatFailedAtTheEndIsKnownToRankZero) {
  on_ranks(2, [](JobRanks& ranks) {
    const bool first = ranks.rank() == 0;
    const JobRanks::End end = ranks.finish(first ? 0 : 2, first ? "" : "disk full", std::chrono::seconds(5));
    EXPECT_TRUE(end.together);
    EXPECT_EQ(end.code, 2);
    if (first) {
      EXPECT_EQ(end.what, "process 1: disk full");
    }
  });
}

TEST(Ranks, AMessageThatIsCutOffIsRefused) {
  const std::string bytes = Packer().add(1.5).add_list(std::vector<int>{1, 2, 3}).take();
  Unpacker whole(bytes);
  EXPECT_EQ(whole.take<double>(), 1.5);
  EXPECT_EQ(whole.take_list<std::vector<int>>(), (std::vector<int>{1, 2, 3}));
  EXPECT_TRUE(whole.done());
  Unpacker cut(std::string_view(bytes).substr(0, bytes.size() - 1));
  cut.take<double>();
  EXPECT_THROW(cut.take_list<std::vector<int>>(), std::runtime_error);
}

TEST(SharedJobs, OfAProcessThatIsAloneAllAreAcceptedOnce) {
  for (const JobThreads threads : {JobThreads::kOneForEachJob, JobThreads::kAllForOneJob}) {
    std::vector<double> found(50, -1.0);
    for_each_shared_job(
        found.size(), square,
        [&](std::size_t i, std::string_view result) { found[i] = Unpacker(result).take<double>(); }, "squares",
        silent_monitor(), threads);
    for (std::size_t i = 0; i < found.size(); ++i) EXPECT_EQ(found[i], static_cast<double>(i * i));
  }
}

}  // namespace
}  // namespace klang
