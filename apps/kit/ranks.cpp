#include "apps/kit/ranks.hpp"

#include <dlfcn.h>
#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>

#include "apps/kit/rank_library.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/plugin.hpp"
#include "core/foundation/base/temporaries.hpp"

namespace klang::apps {

/// What klang_mpi.so exports.
struct RankLibrary {
  decltype(&klang_open_ranks) open = nullptr;
  decltype(&klang_close_ranks) close = nullptr;
  decltype(&klang_abort_ranks) abort = nullptr;
  decltype(&klang_mpi_version) version = nullptr;
};

namespace {

namespace fs = std::filesystem;
constexpr std::chrono::seconds kRankPatience{10};

/// What MPI's launchers say of how many processes there are; 1 where none has started this one.
int n_started() {
  for (const char* name : {"OMPI_COMM_WORLD_SIZE", "PMI_SIZE", "SLURM_STEP_NUM_TASKS"}) {
    const char* text = std::getenv(name);
    const bool by_pmi = std::getenv("PMIX_RANK") != nullptr || std::getenv("PMI_RANK") != nullptr;
    if (text != nullptr && (by_pmi || std::string_view(name).starts_with("OMPI"))) return std::atoi(text);
  }
  return 1;
}

std::optional<RankLibrary> rank_library() {
#ifdef KLANG_WITH_MPI
  // Deep: its MPI_Init is Open MPI's, not that of the sequential MUMPS, which was loaded before.
  if (void* const handle = load_plugin("klang_mpi.so", true)) {
    RankLibrary library;
    library.open = reinterpret_cast<decltype(library.open)>(dlsym(handle, "klang_open_ranks"));
    library.close = reinterpret_cast<decltype(library.close)>(dlsym(handle, "klang_close_ranks"));
    library.abort = reinterpret_cast<decltype(library.abort)>(dlsym(handle, "klang_abort_ranks"));
    library.version = reinterpret_cast<decltype(library.version)>(dlsym(handle, "klang_mpi_version"));
    if (library.open != nullptr && library.close != nullptr && library.abort != nullptr && library.version != nullptr)
      return library;
  }
#endif
  return std::nullopt;
}

/// Where path is, copied; a folder with all it has.
void copy_beside(const fs::path& from, const fs::path& to) {
  std::error_code problem;
  fs::copy(from, to, fs::copy_options::recursive, problem);
  if (problem) throw InputError(from.string(), "cannot be copied for another process", problem.message());
}

std::string moved_output(const std::string& given, const fs::path& folder) {
  if (given.empty() || given == "-") return given;
  fs::path path = fs::absolute(given).lexically_normal();
  if (!path.has_filename()) path = path.parent_path();
  fs::create_directories(folder);
  std::error_code ignored;
  const std::string name = path.filename().string();
  for (const auto& entry : fs::directory_iterator(path.parent_path(), ignored)) {
    const std::string other = entry.path().filename().string();
    if (other == name || other.starts_with(name + ".partial")) copy_beside(entry.path(), folder / other);
  }
  return (folder / name).string();
}

/// Options that name what is written. Where one of them is a flag in some command, the word after it is copied for nothing.
bool is_output(std::string_view word) {
  constexpr std::string_view kOutputs[] = {
      "-o", "--output", "--json", "--csv", "--vdb", "--tracked", "--impulses-csv", "--faust", "--sfz", "--scl", "--pd"};
  return std::find(std::begin(kOutputs), std::end(kOutputs), word) != std::end(kOutputs);
}

void fall_silent() {
  const int nowhere = ::open("/dev/null", O_WRONLY);
  if (nowhere < 0) return;
  ::dup2(nowhere, STDOUT_FILENO);
  ::dup2(nowhere, STDERR_FILENO);
  ::close(nowhere);
}

}  // namespace

void move_outputs(std::vector<std::string>& words, const std::string& scratch) {
  int n = 0;
  const auto folder = [&] { return fs::path(scratch) / std::to_string(n++); };
  for (std::size_t i = 0; i < words.size(); ++i) {
    std::string& word = words[i];
    if (is_output(word) && i + 1 < words.size() && !words[i + 1].starts_with("-")) {
      ++i;
      words[i] = moved_output(words[i], folder());
      continue;
    }
    const std::size_t equals = word.find('=');
    const std::string prefix = word.starts_with("--") ? word.substr(0, equals + 1) : word.substr(0, 2);
    const bool joined = word.starts_with("--") ? equals != std::string::npos && is_output(word.substr(0, equals))
                                               : prefix == "-o" && word.size() > 2;
    if (joined) word = prefix + moved_output(word.substr(prefix.size()), folder());
  }
}

struct Ranks::Impl {
  RankLibrary library;
  RankTransport* transport = nullptr;
  std::optional<JobRanks> jobs;
  std::unique_ptr<Temporary> scratch;
};

Ranks::Ranks(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Ranks::~Ranks() { share_jobs_over(nullptr); }

std::unique_ptr<Ranks> Ranks::join(std::vector<std::string>& words) {
  if (n_started() < 2) return nullptr;
  const std::optional<RankLibrary> library = rank_library();
  if (!library)
    throw InputError("MPI started " + std::to_string(n_started()) +
                     " processes, but this program cannot use it (klang doctor says why)");
  auto impl = std::make_unique<Impl>();
  impl->library = *library;
  impl->transport = library->open();
  if (impl->transport == nullptr) throw InputError("MPI does not start");
  impl->jobs.emplace(*impl->transport);
  const bool first = impl->jobs->rank() == 0;
  auto ranks = std::unique_ptr<Ranks>(new Ranks(std::move(impl)));
  Impl& own = *ranks->impl_;
  try {
    if (!first) {
      fall_silent();
      const fs::path folder = fs::temp_directory_path();
      own.scratch = std::make_unique<Temporary>(folder / "klang-rank", folder, false);
      move_outputs(words, own.scratch->path().string());
    }
    own.jobs->meet();
  } catch (const std::exception& error) {
    const End end = ranks->leave(2, error.what());
    throw InputError(end.complaint);
  }
  share_jobs_over(&*own.jobs);
  return ranks;
}

Ranks::End Ranks::leave(int code, const std::string& complaint) {
  const JobRanks::End end = impl_->jobs->finish(code, complaint, kRankPatience);
  impl_->scratch.reset();
  if (end.together)
    impl_->library.close(impl_->transport);
  else
    impl_->library.abort(impl_->transport, code);
  return {end.code, end.what};
}

std::optional<std::string> mpi_version() {
  const std::optional<RankLibrary> library = rank_library();
  if (!library) return std::nullopt;
  const std::string text = library->version();
  return text.substr(0, text.find(", package"));
}

}  // namespace klang::apps
