#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <memory>
#include <sstream>

#include "core/foundation/base/blas_kernels.hpp"
#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/json.hpp"
#include "core/foundation/base/output_file.hpp"
#include "core/foundation/base/parallel.hpp"
#include "core/foundation/base/provenance.hpp"
#include "core/foundation/base/random.hpp"
#include "core/foundation/base/sealed_file.hpp"
#include "core/foundation/config/csv.hpp"
#include "tests/process_file.hpp"

extern "C" {  // as parallel.cpp declares them
void openblas_set_num_threads(int n_threads);
int openblas_get_num_threads(void);
}

namespace fs = std::filesystem;

namespace {

fs::path fresh_folder(const std::string& name) {
  const fs::path folder = fs::temp_directory_path() / ("klang-base-" + name + std::to_string(::getpid()));
  fs::remove_all(folder);
  fs::create_directories(folder);
  return folder;
}

}  // namespace

TEST(BlasKernels, AreNotOfSse3WhereTheProcessorHasMore) {
  const bool chosen_by_hand = std::getenv("OPENBLAS_CORETYPE") != nullptr,
             has_more = !klang::best_blas_kernels().empty();
  EXPECT_TRUE(chosen_by_hand || !has_more || klang::blas_kernels() != "Prescott") << klang::blas_kernels();
}

TEST(InputError, MessageIsOneLineWithPlaceValueAndRange) {
  const klang::InputError error("a.toml", "wall_m is\nout of range", "-1", "above 0");
  EXPECT_STREQ(error.what(), "a.toml: wall_m is out of range (-1; allowed: above 0)");
}

TEST(InputError, OfAValueOfMegabytesTheBeginningIsShownUncutBetweenBytesOfACharacter) {
  std::string value(199, 'x');
  for (int i = 0; i < 100000; ++i) value += "\u00e9";
  const std::string text = klang::InputError("a.json.kind", "has no report", value, "analysis").what();
  EXPECT_LT(text.size(), 300u);
  EXPECT_EQ(text, "a.json.kind: has no report (" + std::string(199, 'x') + "... (200199 bytes); allowed: analysis)");
}

TEST(Checked, NotANumberAndInfinityAreRefused) {
  EXPECT_THROW(klang::checked("p", "x_m", std::nan(""), 0, 1), klang::InputError);
  EXPECT_THROW(klang::checked("p", "x_m", INFINITY, 0, INFINITY), klang::InputError);
  EXPECT_THROW(klang::checked_open("p", "x_m", 0.0, 0, 1), klang::InputError);
  EXPECT_EQ(klang::checked("p", "x_m", 0.0, 0, 1), 0.0);
}

TEST(Cents, AnOctaveIsTwelveHundred) { EXPECT_DOUBLE_EQ(klang::cents(880.0, 440.0), 1200.0); }

TEST(WriteFile, FullDiskLeavesTheEarlierFileAndNoTemporaries) {
  const fs::path folder = fresh_folder("full");
  const fs::path file = folder / "a.txt";
  klang::write_file(file, "before");
  EXPECT_THROW(klang::write_file_with(file,
                                      [](const fs::path& temporary) {
                                        std::ofstream(temporary) << "half";
                                        klang::write_file("/dev/full", "x");
                                      }),
               klang::InputError);
  EXPECT_EQ(klang::read_file(file), "before");
  EXPECT_EQ(std::distance(fs::directory_iterator(folder), fs::directory_iterator()), 1);
  fs::remove_all(folder);
}

TEST(SealedFile, AnyChangedMissingOrAddedByteBreaksTheSeal) {
  const auto file = klang::test::process_file("sealed");
  std::string content(3'000'000, 'x');
  content[1'500'000] = 'y';
  klang::write_file(file, content);
  EXPECT_FALSE(klang::is_sealed(file));
  klang::seal_file(file);
  EXPECT_TRUE(klang::is_sealed(file));
  const std::string sealed = klang::read_file(file);
  EXPECT_EQ(sealed.size(), content.size() + 40);
  for (const std::size_t at : {std::size_t{0}, std::size_t{1'500'000}, content.size(), sealed.size() - 1}) {
    std::string changed = sealed;
    changed[at] = static_cast<char>(changed[at] ^ 1);
    klang::write_file(file, changed);
    EXPECT_FALSE(klang::is_sealed(file)) << at;
  }
  klang::write_file(file, sealed.substr(1));
  EXPECT_FALSE(klang::is_sealed(file));
  klang::write_file(file, sealed + "x");
  EXPECT_FALSE(klang::is_sealed(file));
  std::filesystem::remove(file);
  EXPECT_FALSE(klang::is_sealed(file));
  EXPECT_THROW(klang::seal_file(file), klang::InputError);
}

TEST(SealedFile, ListsAskForNoMoreMemoryThanTheStreamHolds) {
  std::istringstream in(std::string(80, 'a'));
  in.seekg(16);
  EXPECT_EQ(klang::bytes_left(in), 64U);
  std::vector<double> values;
  EXPECT_THROW(klang::read_list(in, values, 9, "list"), klang::InputError);
  EXPECT_THROW(klang::read_list(in, values, std::uint64_t{1} << 61, "list"), klang::InputError);
  EXPECT_TRUE(values.empty());
  klang::read_list(in, values, 8, "list");
  EXPECT_EQ(values.size(), 8U);
  klang::read_list(in, values, 0, "list");
  EXPECT_TRUE(values.empty());
}

TEST(OutputDirectory, NothingAppearsWithoutCommitAndOtherFilesStay) {
  const fs::path folder = fresh_folder("out");
  klang::write_file(folder / "mine.txt", "keep");
  {
    klang::OutputDirectory out(folder);
    klang::write_file(out.staging() / "new.txt", "new");
  }
  EXPECT_FALSE(fs::exists(folder / "new.txt"));
  {
    klang::OutputDirectory out(folder);
    klang::write_file(out.sub_folder("figures") / "a.png", "png");
    out.commit();
  }
  EXPECT_EQ(klang::read_file(folder / "mine.txt"), "keep");
  EXPECT_EQ(klang::read_file(folder / "figures/a.png"), "png");
  fs::remove_all(folder);
}

TEST(RandomStream, DependsOnSeedAndStreamAlone) {
  klang::RandomStream a(1, 2), b(1, 2), c(1, 3), d(2, 2);
  const double first = a.uniform();
  EXPECT_EQ(first, b.uniform());
  EXPECT_NE(first, c.uniform());
  EXPECT_NE(first, d.uniform());
}

TEST(RandomStream, NormalHasUnitVarianceAndKurtosisThree) {
  klang::RandomStream random(7, 0);
  const int n = 200000;
  double sum = 0, sum_sq = 0, sum_4 = 0;
  for (int i = 0; i < n; ++i) {
    const double x = random.normal();
    sum += x;
    sum_sq += x * x;
    sum_4 += x * x * x * x;
  }
  EXPECT_LE(std::abs(sum / n), 4.5 / std::sqrt(n));
  EXPECT_LE(std::abs(sum_sq / n - 1), 4.5 * std::sqrt(2.0 / n));
  EXPECT_LE(std::abs(sum_4 / n - 3), 4.5 * std::sqrt(96.0 / n));
}

TEST(ParallelFor, CoversEachIndexOnceAtAnyGrain) {
  for (const std::size_t grain : {1UL, 7UL, 1000UL}) {
    std::vector<std::atomic<int>> hits(1001);
    klang::parallel_for(hits.size(), grain, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) ++hits[i];
    });
    for (const auto& hit : hits) EXPECT_EQ(hit, 1);
  }
}

TEST(ForEachJob, ThrowsTheFailureOfTheLowestIndexThatRan) {
  EXPECT_THROW(klang::for_each_job(64,
                                   [](std::size_t i) {
                                     if (i == 0) throw klang::InputError("job 0");
                                   }),
               klang::InputError);
}

TEST(BlasThreads, OfSeveralThatLiveAtOnceTheSmallestHoldsAndTheLastToEndBringsBackWhatWas) {
  openblas_set_num_threads(2);
  auto first = std::make_unique<klang::BlasThreads>(1);
  auto second = std::make_unique<klang::BlasThreads>(1);
  first.reset();  // as another thread's, which began before
  EXPECT_EQ(openblas_get_num_threads(), 1);
  {
    const klang::BlasThreads more(2);
    EXPECT_EQ(openblas_get_num_threads(), 1);
  }
  second.reset();
  EXPECT_EQ(openblas_get_num_threads(), 2);
}

TEST(Sha256, MatchesThePublishedDigestOfAbc) {
  EXPECT_EQ(klang::sha256("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
}

TEST(JsonNumber, NotANumberBecomesNull) {
  EXPECT_TRUE(klang::json_number(std::nan("")).is_null());
  EXPECT_TRUE(klang::json_number(std::optional<double>{}).is_null());
  EXPECT_EQ(klang::json_number(1.5), 1.5);
}

TEST(CsvFile, SkipsRemarksAndBlankLinesAndKeepsTheFilesLineNumbers) {
  const fs::path path = fresh_folder("csv") / "a.csv";
  std::ofstream(path, std::ios::binary) << "\xEF\xBB\xBFtime_s, phi_m\r\n\n# remark\n  1 ,\t+2.5e-3\r\n3,";
  klang::CsvFile file(path);
  ASSERT_TRUE(file.next());
  EXPECT_EQ(file.cells(), (std::vector<std::string_view>{"time_s", "phi_m"}));
  ASSERT_TRUE(file.next());
  EXPECT_EQ(file.line_number(), 4U);
  EXPECT_EQ(klang::csv_number(file.cells()[1], file.place()), 2.5e-3);
  ASSERT_TRUE(file.next());
  EXPECT_EQ(file.cells(), (std::vector<std::string_view>{"3", ""}));
  EXPECT_FALSE(file.next());
}

TEST(CsvFile, OnlyFiniteNumbersAreNumbers) {
  for (const char* bad : {"", "x", "1e", "1 2", "nan", "inf", "1e999", "0x10"})
    EXPECT_THROW(klang::csv_number(bad, "a.csv, line 1"), klang::InputError) << bad;
}
