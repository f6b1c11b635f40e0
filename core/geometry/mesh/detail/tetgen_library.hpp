#pragma once
#include <mutex>

namespace klang::mesh::detail {

/// TetGen keeps global state (constants of its exact arithmetic) and prints; everything that enters its
/// library holds this lock.
std::mutex& tetgen_mutex();

/// Sign of the volume of (a, b, c, d), each three coordinates: exact for the doubles given. A rounding bound
/// decides nearly always; TetGen's (Shewchuk's) exact arithmetic the rest.
int orientation_sign(const double* a, const double* b, const double* c, const double* d);

}  // namespace klang::mesh::detail
