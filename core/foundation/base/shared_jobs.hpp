#pragma once
#include <cstddef>
#include <functional>
#include <string>
#include <string_view>

#include "core/foundation/base/monitor.hpp"

namespace klang {

enum class JobThreads { kOneForEachJob, kAllForOneJob };

/// for_each_job (parallel.hpp) whose results may be found by other processes of the run (job_ranks.hpp): job(i) gives its result as
/// bytes (Packer), accept(i, result) takes each of them in, one at a time, in any order. All processes must come here with
/// the same jobs; afterwards all have accepted all. Within such a job, and where the process is alone, everything runs here.
void for_each_shared_job(std::size_t n, const std::function<std::string(std::size_t index)>& job,
                         const std::function<void(std::size_t index, std::string_view result)>& accept,
                         std::string_view stage = "jobs", Monitor& monitor = silent_monitor(),
                         JobThreads threads = JobThreads::kOneForEachJob);

}  // namespace klang
