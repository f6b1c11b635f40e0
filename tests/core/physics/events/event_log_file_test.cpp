#include "core/physics/events/event_log_file.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/output_file.hpp"
#include "core/physics/events/detail/hdf5_file.hpp"
#include "tests/core/physics/events/sample_log.hpp"

namespace klang::events {
namespace {

class EventLogFile : public testing::Test {
 protected:
  void SetUp() override {
    path_ = std::filesystem::path(testing::TempDir()) /
            (std::string("klang-log-") + testing::UnitTest::GetInstance()->current_test_info()->name() + ".h5");
  }
  void TearDown() override { std::filesystem::remove(path_); }

  // One line that names the file and holds the words, and nothing on stderr.
  void expect_refused(const std::string& words) const {
    testing::internal::CaptureStderr();
    std::string message;
    try {
      read_event_log(path_);
      ADD_FAILURE() << "accepted: " << words;
    } catch (const InputError& error) {
      message = error.what();
    }
    EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
    EXPECT_EQ(message.find(path_.string()), 0u) << message;
    EXPECT_NE(message.find(words), std::string::npos) << message;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
  }
  void write_foreign(const std::function<void(detail::Hdf5Output&)>& write) const {
    detail::Hdf5Output file(path_);
    file.attribute("schema_version", 1);
    write(file);
    write_file(path_, file.bytes());
  }
  std::filesystem::path path_;
};

TEST_F(EventLogFile, ComesBackToTheBitAndTheSameLogIsTheSameBytes) {
  const EventLog log = sample_log();
  write_event_log(path_, log);
  const EventLog back = read_event_log(path_);
  EventLog::describe_tables(log, [&](std::string_view table, std::string_view, const auto& rows) {
    using Row = typename std::decay_t<decltype(rows)>::value_type;
    EventLog::describe_tables(back, [&](std::string_view other, std::string_view, const auto& read) {
      if constexpr (std::is_same_v<std::decay_t<decltype(read)>, std::vector<Row>>) {
        ASSERT_EQ(read.size(), rows.size()) << other;
        for (std::size_t i = 0; i < rows.size(); ++i) {
          std::vector<std::string> bytes[2];
          const auto bytes_of = [](std::vector<std::string>& list) {
            return [&list]<class T>(const Field&, const T& value) {
              if constexpr (std::is_same_v<T, std::string>)
                list.push_back(value);
              else
                list.emplace_back(reinterpret_cast<const char*>(&value), sizeof value);
            };
          };
          Row::describe(rows[i], bytes_of(bytes[0]));
          Row::describe(read[i], bytes_of(bytes[1]));
          EXPECT_EQ(bytes[0], bytes[1]) << table << i;
        }
      }
    });
  });
  const std::string first = read_file(path_);
  write_event_log(path_, log);
  EXPECT_EQ(read_file(path_), first);
}

TEST_F(EventLogFile, EmptyLogIsALog) {
  write_event_log(path_, {});
  EXPECT_TRUE(read_event_log(path_).impulses.empty());
}

TEST_F(EventLogFile, TakesTheImpulsesOfAnotherEngineWithoutMore) {
  write_foreign([](detail::Hdf5Output& file) {
    file.group("impulses", "");
    file.integers("impulses/time_s", "", std::vector<int>{1, 2});  // whole seconds
    file.integers("impulses/body", "", std::vector<int>{1, 0});
    file.numbers("impulses/point_m", "", std::vector<double>{1, 2, 3, 4, 5, 6}, 3);
    file.numbers("impulses/impulse_n_s", "", std::vector<double>{0, 0, 1, 0, 2, 0}, 3);
    file.numbers("impulses/temperature_k", "", std::vector<double>{300, 301}, 1);
  });
  const EventLog log = read_event_log(path_);
  ASSERT_EQ(log.impulses.size(), 2u);
  EXPECT_EQ(log.impulses[1].time_s, 2.0);
  EXPECT_EQ(log.impulses[1].point_m, Eigen::Vector3d(4, 5, 6));
  EXPECT_EQ(log.impulses[1].shape, PulseShape::kHertz);
  ASSERT_EQ(log.bodies.size(), 2u);
  EXPECT_EQ(log.bodies[1].name, "body 1");
}

TEST_F(EventLogFile, WrongFilesAreRefusedInOneLine) {
  expect_refused("cannot be read");
  write_file(path_, "time_s,body\n0,1\n");
  expect_refused("is no HDF5 file");
  write_event_log(path_, sample_log());
  const std::string whole = read_file(path_);
  for (const std::size_t n : {std::size_t{0}, std::size_t{100}, whole.size() / 2, whole.size() - 1}) {
    write_file(path_, std::string_view(whole).substr(0, n));
    expect_refused("");
  }
  {
    detail::Hdf5Output file(path_);
    write_file(path_, file.bytes());
  }
  expect_refused("schema_version");
  write_foreign([](detail::Hdf5Output& file) { file.group("images", ""); });
  expect_refused("none of its tables");
  write_foreign([](detail::Hdf5Output& file) {
    file.group("fractures", "");
    file.numbers("fractures/time_s", "", std::vector<double>{1}, 1);
  });
  expect_refused("fractures/body");
  write_foreign([](detail::Hdf5Output& file) {
    file.group("fractures", "");
    file.numbers("fractures/time_s", "", std::vector<double>{1}, 1);
    file.integers("fractures/body", "", std::vector<int>{0, 0});
  });
  expect_refused("number of rows");
  write_foreign([](detail::Hdf5Output& file) {
    file.group("fractures", "");
    file.numbers("fractures/time_s", "", std::vector<double>{1, 2}, 2);
    file.integers("fractures/body", "", std::vector<int>{0});
  });
  expect_refused("wrong shape");
  write_foreign([](detail::Hdf5Output& file) {
    file.group("fractures", "");
    file.texts("fractures/time_s", "", std::vector<std::string>{"noon"});
    file.integers("fractures/body", "", std::vector<int>{0});
  });
  expect_refused("does not hold numbers");
  write_foreign([](detail::Hdf5Output& file) {
    file.group("bodies", "");
    file.integers("bodies/parent", "", std::vector<int>{4});
  });
  expect_refused("bodies[0]");
}

TEST_F(EventLogFile, UnknownWordNamesItsRowAndWhatIsKnown) {
  write_foreign([](detail::Hdf5Output& file) {
    file.group("impulses", "");
    file.numbers("impulses/time_s", "", std::vector<double>{1}, 1);
    file.integers("impulses/body", "", std::vector<int>{0});
    file.numbers("impulses/point_m", "", std::vector<double>{1, 2, 3}, 3);
    file.numbers("impulses/impulse_n_s", "", std::vector<double>{0, 0, 1}, 3);
    file.texts("impulses/shape", "", std::vector<std::string>{"square"});
  });
  expect_refused("impulses/shape[0]: is unknown (square; allowed: one of gaussian, hertz, held)");
}

TEST_F(EventLogFile, LogThatIsNotValidIsNotWritten) {
  EventLog log = sample_log();
  log.impulses[0].body = 17;
  EXPECT_THROW(write_event_log(path_, log), InputError);
  EXPECT_FALSE(std::filesystem::exists(path_));
}

TEST_F(EventLogFile, FolderThatIsNotThereIsAnErrorOfOneLine) {
  try {
    write_event_log(path_ / "deeper" / "log.h5", sample_log());
    ADD_FAILURE();
  } catch (const InputError& error) {
    EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
  }
}

}  // namespace
}  // namespace klang::events
