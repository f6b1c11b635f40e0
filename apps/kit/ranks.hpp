#pragma once
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace klang::apps {

/// Several processes of one run, as mpirun starts them (docs/scale.md): for_each_shared_job shares its jobs among them. Process 0
/// writes and speaks; the others work into a hidden folder that goes with them and say nothing.
class Ranks {
 public:
  /// Joins the others where MPI has started several processes; null where this one is alone. Of a process other than 0 the
  /// paths behind -o and --json among the words are changed. @throws InputError where this program cannot speak MPI
  static std::unique_ptr<Ranks> join(std::vector<std::string>& words);
  ~Ranks();
  Ranks(const Ranks&) = delete;
  Ranks& operator=(const Ranks&) = delete;

  struct End {
    int code = 0;
    std::string complaint;  ///< of another process, where this one has none
  };
  /// Every process comes here last; ends all of them where some do not come.
  End leave(int code, const std::string& complaint);

 private:
  struct Impl;
  explicit Ranks(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

/// Version of the MPI that Ranks would use; nothing where the program was built without or MPI is not installed.
std::optional<std::string> mpi_version();

/// Changes the values of -o, --json and other options that name what is written to paths below scratch and copies there what these have (and what a stopped
/// run left beside them), so that a process sees the same files as process 0 and changes none of them.
void move_outputs(std::vector<std::string>& words, const std::string& scratch);

}  // namespace klang::apps
