// False alarms and catches of `klang regress check` on synthetic pairs (docs/regression.md):
//   regression_pairs [PAIRS] [SNR_DB of the reference] [SNR_DB of the sound] [SEED] [0: no least tolerances]
#include <array>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <mutex>

#include "core/foundation/base/parallel.hpp"
#include "tests/validate/synthetic_pairs.hpp"
#include "validate/regression/regression.hpp"

using namespace klang;

namespace {

struct Tally {
  int pairs = 0, alarms = 0, nothing_judged = 0;
  int claims = 0, not_judged = 0, failed = 0;
  std::array<int, 2> changed{}, caught{}, unheard{};  // shift, decay: of partials with the power to show it
  std::map<std::string, int> failing;
};

/// The claim of the reference's partial nearest to a frequency; null where it is none.
const validate::Claim* claim_of(const validate::ReferenceSpectrum& reference, const validate::RegressionResult& result,
                                double frequency_hz, const char* which) {
  for (std::size_t i = 0; i < reference.partials.size(); ++i) {
    if (std::abs(cents(reference.partials[i].partial.frequency_hz, frequency_hz)) > 20.0) continue;
    for (const validate::Claim& claim : result.claims) {
      if (claim.name == "partial-" + std::to_string(i + 1) + which) return &claim;
    }
  }
  return nullptr;
}

bool failed(const validate::Claim* claim) { return claim && !claim->passed && claim->not_judged.empty(); }

}  // namespace

int main(int argc, char** argv) {
  const int n_pairs = argc > 1 ? std::atoi(argv[1]) : 1000;
  const double snr_db = argc > 2 ? std::atof(argv[2]) : 40.0;
  const double sound_snr_db = argc > 3 ? std::atof(argv[3]) : snr_db;
  const auto seed = static_cast<std::uint64_t>(argc > 4 ? std::atoi(argv[4]) : 1);
  validate::RegressionOptions options;
  if (argc > 5 && std::atoi(argv[5]) == 0) options.floor_cents = options.floor_decay = 0.0;
  Tally sum;
  std::mutex mutex;
  for_each_job(static_cast<std::size_t>(n_pairs), [&](std::size_t pair) {
    RandomStream random(seed, pair);
    const tests::RingingObject object = tests::random_object(random);
    const auto reference = validate::make_reference(
        {validate::describe(tests::recorded(object, tests::random_take(snr_db, random), random))});
    const auto same = validate::compare(
        reference, validate::describe(tests::recorded(object, tests::random_take(sound_snr_db, random), random)),
        options);

    const auto victim = random.below(static_cast<std::uint32_t>(object.size()));
    tests::RingingObject shifted = object, damped = object;
    shifted[victim].frequency_hz *= std::pow(2.0, (random.uniform() < 0.5 ? 3.0 : -3.0) / 1200.0);
    damped[victim].decay_per_s *= random.uniform() < 0.5 ? 1.1 : 0.9;
    const auto after_shift = validate::compare(
        reference, validate::describe(tests::recorded(shifted, tests::random_take(sound_snr_db, random), random)),
        options);
    const auto after_damping = validate::compare(
        reference, validate::describe(tests::recorded(damped, tests::random_take(sound_snr_db, random), random)),
        options);

    const std::lock_guard lock(mutex);
    ++sum.pairs;
    sum.alarms += same.n_failed() > 0;
    sum.nothing_judged += same.status != validate::RegressionStatus::kJudged;
    sum.claims += static_cast<int>(same.claims.size());
    sum.not_judged += same.n_not_judged();
    sum.failed += same.n_failed();
    for (const validate::Claim& claim : same.claims) {
      if (failed(&claim)) {
        ++sum.failing[claim.name.substr(0, claim.name.find('-')) +
                      claim.name.substr(claim.name.find('.') == std::string::npos ? claim.name.size()
                                                                                  : claim.name.find('.'))];
        if (sum.alarms <= 10)
          std::printf("pair %zu: %s %.4g (tolerance %.4g)\n", pair, claim.name.c_str(), claim.measured,
                      claim.tolerance);
      }
    }
    // Power is decided on the unchanged pair, so that the outcome does not choose who counts.
    const std::array<const char*, 2> which = {".frequency", ".decay"};
    const std::array<const validate::RegressionResult*, 2> changed = {&after_shift, &after_damping};
    for (std::size_t k = 0; k < 2; ++k) {
      const validate::Claim* before = claim_of(reference, same, object[victim].frequency_hz, which[k]);
      if (!before || !before->not_judged.empty()) {
        ++sum.unheard[k];
        continue;
      }
      ++sum.changed[k];
      sum.caught[k] += changed[k]->n_failed() > 0;
    }
  });
  std::printf("%d pairs, reference at %g dB, sound at %g dB, seed %llu\n", sum.pairs, snr_db, sound_snr_db,
              static_cast<unsigned long long>(seed));
  std::printf("false alarms: %d (%.2f %%), claims %d, not judged %d, failed %d; nothing judged in %d\n", sum.alarms,
              100.0 * sum.alarms / sum.pairs, sum.claims, sum.not_judged, sum.failed, sum.nothing_judged);
  for (const auto& [name, count] : sum.failing) std::printf("  failed %s: %d\n", name.c_str(), count);
  const char* names[] = {"shift of 3 cents", "decay changed by 10 %"};
  for (std::size_t k = 0; k < 2; ++k) {
    std::printf("%s: caught %d of %d (%.2f %%); %d more could not be judged\n", names[k], sum.caught[k], sum.changed[k],
                100.0 * sum.caught[k] / std::max(sum.changed[k], 1), sum.unheard[k]);
  }
  return 0;
}
