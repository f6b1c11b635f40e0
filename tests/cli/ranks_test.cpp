// mpirun -n N klang ...: the same results as one process gives, whatever N.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>

#include "tests/cli/expect_refused.hpp"
#include "tests/cli/json_file.hpp"
#include "tests/cli/klang_process.hpp"

namespace klang::test {
namespace {

using nlohmann::json;

RunResult run_on(int n, const std::string& arguments, const Scratch& scratch) {
  return run_klang(arguments, scratch.path(),
                   "OMPI_MCA_rmaps_base_oversubscribe=1 OMPI_MCA_plm_rsh_agent=true mpirun --allow-run-as-root -n " +
                       std::to_string(n));
}

json without_run(json result) {
  result.erase("provenance");
  result.erase("wall_time_s");
  result.erase("bytes");
  return result;
}

constexpr const char* kBuild =
    "proxy build --thinnest 0.6 --tolerance 0.2 --modes 5 --checked-modes 3 --degree 6 --check-shapes 5 "
    "--boundary-tolerance 0.1 -o ";

std::string bytes_of(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

TEST(Ranks, BuildTheSameSoundbankOnOneTwoAndThreeProcesses) {
  const Scratch scratch;
  ASSERT_EQ(run_klang(std::string(kBuild) + "a.bank --json a.json", scratch.path()).exit_code, 0);
  const std::string one = bytes_of(scratch.path() / "a.bank");
  for (const int n : {2, 3}) {
    std::filesystem::rename(scratch.path() / "a.bank", scratch.path() / "one.bank");
    const RunResult run = run_on(n, std::string(kBuild) + "a.bank --json b.json", scratch);
    ASSERT_EQ(run.exit_code, 0) << run.err;
    EXPECT_EQ(std::count(run.out.begin(), run.out.end(), '\n'), 1) << run.out;  // one of them speaks
    EXPECT_EQ(without_run(read_json(scratch.path() / "a.json")), without_run(read_json(scratch.path() / "b.json")));
    // Alike but for the file's record of the command and the time.
    const std::string many = bytes_of(scratch.path() / "a.bank");
    EXPECT_EQ(one.size(), many.size());
    const std::size_t n_tail = one.size() / 2;
    EXPECT_EQ(one.substr(one.size() - n_tail), many.substr(many.size() - n_tail));
  }
  EXPECT_EQ(scratch.files(), (std::vector<std::string>{"a.bank", "a.json", "b.json", "one.bank"}));
}

TEST(Ranks, GoOnWithWhatAnotherNumberOfProcessesLeft) {
  const Scratch scratch;
  ASSERT_EQ(run_klang(std::string(kBuild) + "whole.bank --json a.json", scratch.path()).exit_code, 0);
  // A run that is killed at once leaves a partial file or none; both must end in the same bank.
  run_klang(std::string(kBuild) + "b.bank", scratch.path(), "timeout -s INT 0.3");
  const RunResult run = run_on(2, std::string(kBuild) + "b.bank --json b.json", scratch);
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(without_run(read_json(scratch.path() / "a.json")), without_run(read_json(scratch.path() / "b.json")));
}

TEST(Ranks, RadiateEachModeOnceAndTheSame) {
  const Scratch scratch;
  ASSERT_EQ(run_klang("modes --shape box --dims length_m=0.05,width_m=0.03,height_m=0.02 --count 4 -o box.vtu -q",
                      scratch.path())
                .exit_code,
            0);
  const std::string transfer = "transfer box.vtu --kept-power 0.99 --max-elements 300 --allow-coarse -o t.vtu --json ";
  ASSERT_EQ(run_klang(transfer + "a.json", scratch.path()).exit_code, 0);
  const RunResult run = run_on(2, transfer + "b.json", scratch);
  ASSERT_EQ(run.exit_code, 0) << run.err;
  json one = without_run(read_json(scratch.path() / "a.json")), two = without_run(read_json(scratch.path() / "b.json"));
  EXPECT_EQ(one["modes"].size(), 4U);
  EXPECT_EQ(one, two);
}

TEST(Ranks, RefuseBadInputOnceAndWriteNothing) {
  const Scratch scratch;
  const RunResult run = run_on(2, "proxy build --thinnest 4 -o a.bank", scratch);
  EXPECT_EQ(run.exit_code, 2);
  const std::string line = "klang: soundbank: --thinnest";
  const std::size_t at = run.err.find(line);
  ASSERT_NE(at, std::string::npos) << run.err;
  EXPECT_EQ(run.err.find(line, at + 1), std::string::npos) << run.err;
  EXPECT_TRUE(scratch.files().empty());
}

TEST(Ranks, DoctorNamesTheMpiThatIsBuiltIn) {
  const Scratch scratch;
  ASSERT_EQ(run_klang("doctor -q --json d.json", scratch.path()).exit_code, 0);
  const json mpi = read_json(scratch.path() / "d.json")["mpi"];
  EXPECT_EQ(mpi["built_in"], true);
  EXPECT_NE(mpi["version"].get<std::string>().find("MPI"), std::string::npos) << mpi;
}

}  // namespace
}  // namespace klang::test
