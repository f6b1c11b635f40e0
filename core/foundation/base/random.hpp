#pragma once
#include <cstdint>

namespace klang {

/// A stream of random numbers that depends on (seed, stream) alone: give each job its own stream number and the
/// result does not depend on threads. PCG-XSH-RR 64/32 (O'Neill 2014), seeded through SplitMix64.
class RandomStream {
 public:
  RandomStream(std::uint64_t seed, std::uint64_t stream);
  std::uint32_t next_u32();
  /// Uniform on [0, 1), 53 bits.
  double uniform();
  double uniform(double low, double high) { return low + (high - low) * uniform(); }
  /// Standard normal (Box-Muller).
  double normal();
  /// Uniform integer in [0, n), n >= 1, without bias.
  std::uint32_t below(std::uint32_t n);

 private:
  std::uint64_t state_;
  std::uint64_t increment_;
  double spare_ = 0.0;
  bool has_spare_ = false;
};

}  // namespace klang
