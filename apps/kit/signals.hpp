#pragma once

namespace klang::apps {

/// From now on SIGINT, SIGTERM and SIGHUP (unless it is ignored, as under nohup) are heeded: monitors say stop, and where the
/// work has not ended 0.8 s later (a library that cannot be asked, a read that waits) a watching thread removes what
/// the run has not finished writing and ends the process with 128 + the signal's number.
void heed_signals();

/// The first of these signals that came; 0: none.
int stop_signal();

/// The work is over; should the watching thread still have to end the process, then with this code and without a word.
void work_is_over(int exit_code);

}  // namespace klang::apps
