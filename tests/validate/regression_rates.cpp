// False alarms of `klang regress check` between sample rates, and shifts of four cents that it catches (docs/regression.md):
//   regression_rates [PAIRS] [TAKES: 1, or several that scatter by 1 cent and 10 % of decay] [SEED]
// Every second sound is made at its own rate, every other one resampled from the reference's rate.
#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <mutex>

#include "core/foundation/base/parallel.hpp"
#include "core/sound/audio/resample.hpp"
#include "tests/validate/synthetic_pairs.hpp"
#include "validate/regression/regression.hpp"

using namespace klang;

namespace {

constexpr std::array kRates = {44100.0, 48000.0, 32000.0, 96000.0, 22050.0, 192000.0};

tests::RingingObject scattered(tests::RingingObject object, bool scatters, RandomStream& random) {
  for (tests::RingingPartial& p : object) {
    if (!scatters) break;
    p.frequency_hz *= std::exp2(random.normal() / 1200.0);
    p.decay_per_s *= std::exp(0.1 * random.normal());
  }
  return object;
}

struct Pair {
  tests::RingingObject object;
  double first_hz = 0.0, other_hz = 0.0;
  bool resampled = false, scatters = false;
};

audio::Signal sound_of(const Pair& pair, double shift_cents, RandomStream& random) {
  tests::RingingObject object = scattered(pair.object, pair.scatters, random);
  for (tests::RingingPartial& p : object) p.frequency_hz *= std::exp2(shift_cents / 1200.0);
  tests::Take take = tests::random_take(random.uniform(25.0, 60.0), random);
  take.sample_rate_hz = pair.resampled ? pair.first_hz : pair.other_hz;
  const audio::Signal sound = tests::recorded(object, take, random);
  return pair.resampled ? audio::resample(sound, pair.other_hz) : sound;
}

struct Tally {
  int pairs = 0, alarms = 0, nothing_judged = 0, sharp_passed = 0;
  double level_db = 0.0;
  std::map<std::string, int> failing;
};

}  // namespace

int main(int argc, char** argv) {
  const auto n_pairs = static_cast<std::size_t>(argc > 1 ? std::atoi(argv[1]) : 200);
  const int n_takes = argc > 2 ? std::atoi(argv[2]) : 1;
  const auto seed = static_cast<std::uint64_t>(argc > 3 ? std::atoi(argv[3]) : 1);
  Tally sum;
  std::mutex mutex;
  for_each_job(n_pairs, [&](std::size_t k) {
    RandomStream random(seed, k);
    Pair pair{tests::random_object(random), kRates[k % 6], kRates[(k + 1 + k / 6) % 6], k % 2 == 1, n_takes > 1};
    std::vector<validate::SoundDescription> takes;
    for (int i = 0; i < n_takes; ++i) {
      tests::Take take = tests::random_take(random.uniform(25.0, 60.0), random);
      take.sample_rate_hz = pair.first_hz;
      takes.push_back(validate::describe(tests::recorded(scattered(pair.object, n_takes > 1, random), take, random)));
    }
    const auto reference = validate::make_reference(takes);
    const auto same = validate::compare(reference, validate::describe(sound_of(pair, 0.0, random)));
    const auto sharp = validate::compare(reference, validate::describe(sound_of(pair, 4.0, random)));

    const std::lock_guard lock(mutex);
    ++sum.pairs;
    sum.alarms += same.n_failed() > 0 && same.status == validate::RegressionStatus::kJudged;
    sum.nothing_judged += same.status != validate::RegressionStatus::kJudged;
    sum.sharp_passed += sharp.passed();
    for (const validate::ThirdComparison& third : same.thirds)
      if (third.difference_db) sum.level_db = std::max(sum.level_db, std::abs(*third.difference_db));
    for (const validate::Claim& claim : same.claims) {
      if (claim.passed || !claim.not_judged.empty()) continue;
      ++sum.failing[claim.name.substr(0, claim.name.find('-'))];
      if (sum.alarms <= 10)
        std::printf("pair %zu, %g to %g Hz: %s %.4g (tolerance %.4g)\n", k, pair.first_hz, pair.other_hz,
                    claim.name.c_str(), claim.measured, claim.tolerance);
    }
  });
  std::printf("%d pairs of %d take(s), seed %llu: false alarms %d, nothing judged %d, 4 cents sharp and passed %d\n",
              sum.pairs, n_takes, static_cast<unsigned long long>(seed), sum.alarms, sum.nothing_judged,
              sum.sharp_passed);
  std::printf("largest difference of a judged third octave: %.3f dB\n", sum.level_db);
  for (const auto& [name, count] : sum.failing) std::printf("  failed %s: %d\n", name.c_str(), count);
  return 0;
}
