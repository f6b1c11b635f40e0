#pragma once
#include "core/foundation/base/job_ranks.hpp"

/// What the library klang_mpi.so exports. It is loaded when MPI has started the program, with its own symbols first: the
/// sequential MUMPS that solves our linear systems brings an MPI_Init of its own, so that nothing else may link MPI.
extern "C" {
/// Initialises MPI for a program in which one thread communicates; null where that fails. close or abort ends it.
klang::RankTransport* klang_open_ranks();
void klang_close_ranks(klang::RankTransport* ranks);
/// Ends all processes of the run at once.
void klang_abort_ranks(klang::RankTransport* ranks, int code);
/// "Open MPI v4.1.4, ..."; may be asked before klang_open_ranks.
const char* klang_mpi_version();
}
