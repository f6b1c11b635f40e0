#include "validate/papers/papers.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <sstream>

#include "core/foundation/base/output_file.hpp"
#include "validate/papers/detail/paper_groups.hpp"

namespace klang::validate {
namespace {

PaperNumber number(double printed, double ours, double tolerance, bool off = false) {
  PaperNumber n;
  n.printed = printed;
  n.ours = ours;
  n.tolerance = tolerance;
  n.paper_off = off;
  return n;
}

}  // namespace

TEST(PaperVerdict, AgreementMisprintsAndOpenDifferencesAreTold) {
  EXPECT_EQ(verdict_of(number(100, 100.5, 0.01)), PaperVerdict::kAgrees);
  EXPECT_EQ(verdict_of(number(100, 102, 0.01)), PaperVerdict::kDiffers);
  EXPECT_EQ(verdict_of(number(100, 200, 0.01, true)), PaperVerdict::kPaperOff);
  EXPECT_EQ(verdict_of(number(100, 100.5, 0.01, true)), PaperVerdict::kDiffers) << "called wrong, and yet it agrees";
  EXPECT_EQ(verdict_of(number(100, std::nan(""), 0.01, true)), PaperVerdict::kDiffers);
  PaperNumber wrong = number(100, 100.5, 0.01);
  wrong.reference = 100.0;
  EXPECT_EQ(verdict_of(wrong), PaperVerdict::kDiffers) << "agrees with the paper, not with the reference";
}

TEST(Papers, EveryNumberAgreesOrIsKnownToBeOff) {
  const PaperTables tables = run_papers();
  EXPECT_GE(tables.numbers.size(), 80u);
  std::set<std::string> ids;
  for (const PaperNumber& n : tables.numbers) {
    EXPECT_TRUE(ids.insert(n.id).second) << n.id << " twice";
    EXPECT_NE(n.verdict, PaperVerdict::kDiffers) << n.id << ": printed " << n.printed << ", ours " << n.ours;
    EXPECT_EQ(n.verdict == PaperVerdict::kPaperOff, n.paper_off) << n.id;
    EXPECT_FALSE(n.paper_off && n.note.empty()) << n.id << ": wrong, but why";
  }
  EXPECT_TRUE(tables.passed());
  for (const Claim& claim : claims_of(tables)) EXPECT_TRUE(claim.passed) << claim.name;
  // The page in docs is what the command writes today.
  EXPECT_EQ(read_file(KLANG_SOURCE_DIR "/docs/papers.md"), markdown(tables))
      << "run klang validate papers --markdown docs/papers.md";
}

TEST(Papers, ChimesAreThoseOfTheDataTable) {
  std::istringstream lines(read_file(KLANG_SOURCE_DIR "/datasets-synthetic/tables/s02_table2_chimes.csv"));
  std::string line;
  std::getline(lines, line);
  for (const detail::Chime& chime : detail::chimes()) {
    ASSERT_TRUE(std::getline(lines, line));
    std::istringstream cells(line);
    std::vector<std::string> cell;
    for (std::string text; std::getline(cells, text, ',');) cell.push_back(text);
    ASSERT_EQ(cell.size(), 8u);
    EXPECT_EQ(cell[0], chime.printed_note);
    EXPECT_EQ(cell[1], chime.note);
    const double values[] = {chime.ideal_hz,    chime.length_m,          chime.measured_hz,
                             chime.computed_hz, chime.adjusted_length_m, chime.adjusted_hz};
    for (std::size_t i = 0; i < 6; ++i) EXPECT_EQ(std::stod(cell[i + 2]), values[i]) << line;
  }
}

}  // namespace klang::validate
