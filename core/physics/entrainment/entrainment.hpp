#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "core/foundation/base/monitor.hpp"
#include "core/physics/bubble/pitch_formulas.hpp"
#include "core/physics/entrainment/bubble_path.hpp"
#include "core/physics/entrainment/radii.hpp"
#include "core/physics/entrainment/seeds.hpp"

namespace klang::entrainment {

enum class EntrainmentForm {
  kMended,  ///< coverage in a ball of max(r, 1.5 h): without a scale of its own
  kPaper    ///< in a ball of r alone, (0.22 h)^2 sum w against 2.43 coverage r^2 (eq. 41): small bubbles always pass
};
constexpr auto words_of(EntrainmentForm) {
  return std::array{Word{EntrainmentForm::kMended, "mended"}, Word{EntrainmentForm::kPaper, "paper"}};
}

/// A box in which every part of the free surface is a seed, renewed at its life's end. Nothing is rejected there.
struct Patch {
  Eigen::Vector3d low_m, high_m;
  double start_s = 0.0, end_s = 0.0;
};

/// How moving liquid makes bubbles (Zheng and James 2009, appendix B, mended).
struct EntrainmentOptions {
  double attempts_per_m2_s =
      0.0;  ///< per area of seeds at strength 1; a seed stands for h^2 / 16 of surface (erratum 78)
  SeedOptions seeds;
  double coverage = 0.6;  ///< share of a disc that seeds must fill, times their strength; 0: no rejection
  bool consume = false;   ///< a birth takes the seeds within 1.5 radii with it
  EntrainmentForm form = EntrainmentForm::kMended;
  RadiusDistribution radii;
  std::vector<Patch> patches;
  void validate() const;  ///< InputError
};

struct Births {
  std::vector<Birth> births;  ///< by time
  std::size_t n_seeds = 0, n_attempts = 0, n_rejected = 0;
};

/// Births over all frames. In each step between frames attempts_per_m2_s h^2/16 dt sum w attempts are made (a fraction by chance, so
/// that the mean is right for any step and cell), each at a seed drawn by its strength, uniform in the step, where the seed is
/// then; the radius is drawn after it. Patches: attempts_per_m2_s * area of the free surface within * dt / 2, at uniform places
/// of it and depths to 2 h. The same seed gives the same births on any number of threads.
/// @throws InputError: seeds are asked for and the frames have neither velocity nor seeds
Births find_births(const liquid::LiquidFrames& frames, const EntrainmentOptions& options, std::uint64_t seed,
                   Monitor& monitor = silent_monitor());

/// A row of bubbles.csv.
struct BubbleRow {
  std::int64_t id = 0;
  double birth_s = 0.0, end_s = 0.0;
  EndKind end_kind = EndKind::kEnd;
  double radius_m = 0.0, x_m = 0.0, y_m = 0.0, z_m = 0.0, depth_m = 0.0;
  double frequency_start_hz = 0.0, frequency_end_hz = 0.0;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"id", "from 1, by birth"}, self.id);
    visit({"birth_s", "its birth"}, self.birth_s);
    visit({"end_s", "when it reached what end_kind says"}, self.end_s);
    visit({"end_kind", "surface, outlet, end (of the frames), merge or split"}, self.end_kind);
    visit({"radius_m", "its radius"}, self.radius_m);
    visit({"x_m", "at birth"}, self.x_m);
    visit({"y_m", "at birth"}, self.y_m);
    visit({"z_m", "at birth"}, self.z_m);
    visit({"depth_m", "below the surface at birth"}, self.depth_m);
    visit({"frequency_start_hz", "of a free bubble (Minnaert); of tracked ones as given"}, self.frequency_start_hz);
    visit({"frequency_end_hz", "at its end, by the pitch law"}, self.frequency_end_hz);
  }
};

/// @param pitch  with the theory's undamped frequency of the free bubble as frequency at birth
std::vector<BubbleRow> bubble_rows(const std::vector<BubblePath>& paths, const bubble::BubbleMedium& medium,
                                   bubble::BubbleTheory theory, const bubble::PitchModel& pitch);
/// bubbles.csv.
std::string bubbles_csv(const std::vector<BubbleRow>& rows);

}  // namespace klang::entrainment
