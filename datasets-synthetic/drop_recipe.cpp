#include "datasets-synthetic/drop_recipe.hpp"

#include <toml++/toml.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <set>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/random.hpp"
#include "core/foundation/config/toml_depth.hpp"
#include "core/foundation/config/toml_table.hpp"
#include "core/physics/bubble/bubble_physics.hpp"

namespace klang::datasets {
namespace {

using bubble::kLargestRadiusM;
using bubble::kSmallestRadiusM;

constexpr double kInf = std::numeric_limits<double>::infinity();
constexpr std::size_t kMaxRecordings = 1000, kMaxDrops = 1000, kMaxDropsInAll = 20000;

const TomlField kSchema[] = {
    {"", "kind", TomlType::kText, "required", -kInf, kInf, "`drops`"},
    {"", "name", TomlType::kText, "the file's name", -kInf, kInf, "title"},
    {"", "sound", TomlType::kTable, "the defaults below", -kInf, kInf, "rate, length, level, formulas"},
    {"", "pitch", TomlType::kTable, "the defaults below", -kInf, kInf, "how the pitch rises near the surface"},
    {"", "noise", TomlType::kTable, "none", -kInf, kInf, "noise of the recording"},
    {"", "room", TomlType::kTable, "none", -kInf, kInf, "reverberation"},
    {"", "recording", TomlType::kTables, "none", -kInf, kInf, "one `[[recording]]` a sound file"},
    {"", "random", TomlType::kTables, "none", -kInf, kInf, "one `[[random]]` a seeded set of recordings"},

    {"sound", "sample_rate_hz", TomlType::kNumber, "48000", 8000, 768000, "sample rate"},
    {"sound", "duration_s", TomlType::kNumber, "2", 0.05, 120, "length of each recording"},
    {"sound", "peak", TomlType::kNumber, "0.5", 1e-6, 10, "largest value of the drops' sound, before room and noise"},
    {"sound", "theory", TomlType::kText, "`leighton`", -kInf, kInf,
     "`leighton`, `prosperetti` or `paper`: frequency and damping"},
    {"sound", "attack", TomlType::kText, "`none`", -kInf, kInf, "`none`, or `soft` (Zheng and James 2009, eq. 39)"},

    {"pitch", "model", TomlType::kText, "`harmonic_fluids`", -kInf, kInf,
     "`harmonic_fluids` (eq. 6), `harmonic_fluids_frozen`, `strasberg`, `two_sphere` or `constant`"},
    {"pitch", "k_delta_per_m", TomlType::kNumber, "72.95", 0, 1e4, "K_Δ of eq. (6)"},
    {"pitch", "eta", TomlType::kNumber, "1.24", 0.01, 100, "η of eq. (6)"},
    {"pitch", "phi0_m", TomlType::kNumber, "-0.008", -1, -1e-5, "φ0 of eq. (6), negative"},
    {"pitch", "largest_factor", TomlType::kNumber, "3", 1, 1000, "no model raises the pitch above this"},

    {"noise", "snr_db", TomlType::kNumber, "required", -60, 200, "mean square of the sound by that of the noise"},
    {"noise", "of", TomlType::kText, "`drop`", -kInf, kInf,
     "the sound meant: `drop`, the loudest drop from its onset until its amplitude is a tenth; or the whole "
     "`recording`"},
    {"noise", "colour", TomlType::kText, "`white`", -kInf, kInf, "`white` or `pink` (3 dB an octave, above 20 Hz)"},

    {"room", "rt60_s", TomlType::kNumber, "required", 0.01, 20, "time in which the tail falls by 60 dB"},
    {"room", "level_db", TomlType::kNumber, "-20", -120, 40, "energy of the tail's response against the direct sound"},

    {"recording", "name", TomlType::kText, "required", -kInf, kInf, "unique; the recording is NAME.wav"},
    {"recording", "drop", TomlType::kTables, "required", -kInf, kInf, "one `[[recording.drop]]` each"},

    {"recording.drop", "onset_s", TomlType::kNumber, "required", 0, 120, "when the bubble closes and begins to ring"},
    {"recording.drop", "radius_m", TomlType::kNumber, "required", kSmallestRadiusM, kLargestRadiusM, "of the bubble"},
    {"recording.drop", "depth_m", TomlType::kNumber, "0.01", 1e-5, 100, "of its centre at the onset"},
    {"recording.drop", "strength", TomlType::kNumber, "1", 1e-6, 1e6, "times the excitation by its surface tension"},
    {"recording.drop", "rise", TomlType::kText, "`constant`", -kInf, kInf,
     "`fixed`, `constant` speed or `terminal` (buoyancy, drag, added mass)"},
    {"recording.drop", "rise_speed_m_s", TomlType::kNumber, "0.2", -100, 100,
     "upwards: the constant speed, or that at the onset"},
    {"recording.drop", "stop_depth_radii", TomlType::kNumber, "1.05", 1, 100,
     "depth at which it comes to rest, in radii"},
    {"recording.drop", "phi0_m", TomlType::kNumber, "the recipe's", -1, -1e-5, "φ0 of eq. (6) for this drop"},

    {"random", "name", TomlType::kText, "required", -kInf, kInf, "recordings are NAME-1.wav, NAME-2.wav, ..."},
    {"random", "recordings", TomlType::kNumber, "1", 1, 1000, "their number"},
    {"random", "drops", TomlType::kNumber, "required", 1, 1000, "in each"},
    {"random", "smallest_radius_m", TomlType::kNumber, "0.0007", kSmallestRadiusM, kLargestRadiusM,
     "radii are uniform in their logarithm from here"},
    {"random", "largest_radius_m", TomlType::kNumber, "0.003", kSmallestRadiusM, kLargestRadiusM, "to here"},
    {"random", "shortest_gap_s", TomlType::kNumber, "0.05", 0, 60,
     "onsets are uniform, but never closer than this; 0: drops overlap as they fall"},
    {"random", "smallest_depth_m", TomlType::kNumber, "0.006", 1e-5, 100, "depths are uniform from here"},
    {"random", "largest_depth_m", TomlType::kNumber, "0.015", 1e-5, 100, "to here"},
    {"random", "rise", TomlType::kText, "`constant`", -kInf, kInf, "as in `recording.drop`"},
    {"random", "smallest_rise_speed_m_s", TomlType::kNumber, "0.1", -100, 100, "rise speeds are uniform from here"},
    {"random", "largest_rise_speed_m_s", TomlType::kNumber, "0.3", -100, 100, "to here"},
    {"random", "strength_std_db", TomlType::kNumber, "3", 0, 40, "scatter of the strength (normal in dB)"},
};

std::string checked_name(const TomlTable& table) {
  const std::string name = table.text("name");
  const bool fits = !name.empty() && name.size() <= 64 && std::all_of(name.begin(), name.end(), [](unsigned char c) {
    return std::isalnum(c) || c == '_' || c == '-' || c == '+' || c == '#';
  });
  if (!fits)
    throw InputError(table.place("name"), "cannot be a file name", name, "1 to 64 letters, digits and _ - + #");
  return name;
}

bubble::RiseKind read_rise_kind(const TomlTable& table) {
  const std::string kind = table.choice("rise", {"constant", "fixed", "terminal"});
  return kind == "fixed"      ? bubble::RiseKind::kFixed
         : kind == "terminal" ? bubble::RiseKind::kTerminal
                              : bubble::RiseKind::kConstantSpeed;
}

bubble::PitchModel read_pitch(const TomlTable& table) {
  bubble::PitchModel pitch;
  const std::string model =
      table.choice("model", {"harmonic_fluids", "harmonic_fluids_frozen", "strasberg", "two_sphere", "constant"});
  pitch.kind = model == "harmonic_fluids"          ? bubble::PitchKind::kHarmonicFluids
               : model == "harmonic_fluids_frozen" ? bubble::PitchKind::kHarmonicFluidsFrozen
               : model == "strasberg"              ? bubble::PitchKind::kStrasberg
               : model == "two_sphere"             ? bubble::PitchKind::kTwoSphere
                                                   : bubble::PitchKind::kConstant;
  pitch.k_delta_per_m = table.number("k_delta_per_m", pitch.k_delta_per_m);
  pitch.eta = table.number("eta", pitch.eta);
  pitch.phi0_m = table.number("phi0_m", pitch.phi0_m);
  pitch.largest_factor = table.number("largest_factor", pitch.largest_factor);
  return pitch;
}

Drop read_drop(const TomlTable& table, const bubble::PitchModel& pitch, double duration_s) {
  Drop drop;
  drop.onset_s = table.number("onset_s");
  if (!(drop.onset_s < duration_s))
    throw InputError(table.place("onset_s"), "lies after the recording's end", to_text(drop.onset_s),
                     "below " + to_text(duration_s));
  drop.radius_m = table.number("radius_m");
  drop.depth_m = table.number("depth_m", drop.depth_m);
  drop.strength = table.number("strength", 1.0);
  drop.rise.kind = read_rise_kind(table);
  drop.rise.speed_m_s = table.number("rise_speed_m_s", 0.2);
  drop.rise.stop_depth_radii = table.number("stop_depth_radii", drop.rise.stop_depth_radii);
  drop.pitch = pitch;
  drop.pitch.phi0_m = table.number("phi0_m", pitch.phi0_m);
  return drop;
}

struct Range {
  double low, high;
};

Range read_range(const TomlTable& table, std::string_view low_key, std::string_view high_key, double low, double high) {
  const Range range{table.number(low_key, low), table.number(high_key, high)};
  if (!(range.low <= range.high))
    throw InputError(table.place(high_key), "lies below " + std::string(low_key), to_text(range.high),
                     "from " + to_text(range.low));
  return range;
}

// Onsets over the recording's first nine tenths, sorted, no two closer than the gap: uniform ones, pushed apart.
std::vector<double> draw_onsets(std::size_t n, double gap_s, double from_s, double until_s, RandomStream& random) {
  const double slack = until_s - from_s - gap_s * static_cast<double>(n - 1);
  std::vector<double> onsets;
  for (std::size_t i = 0; i < n; ++i) onsets.push_back(random.uniform(0.0, slack));
  std::sort(onsets.begin(), onsets.end());
  for (std::size_t i = 0; i < n; ++i) onsets[i] += from_s + gap_s * static_cast<double>(i);
  return onsets;
}

void add_random(const TomlTable& table, const bubble::PitchModel& pitch, std::uint64_t seed, std::uint64_t set,
                DropRecipe& recipe) {
  const std::string name = checked_name(table);
  const auto n_recordings = static_cast<std::size_t>(std::llround(table.number("recordings", 1.0)));
  const auto n_drops = static_cast<std::size_t>(std::llround(table.number("drops")));
  const Range radius = read_range(table, "smallest_radius_m", "largest_radius_m", 7e-4, 3e-3);
  const Range depth = read_range(table, "smallest_depth_m", "largest_depth_m", 0.006, 0.015);
  const Range speed = read_range(table, "smallest_rise_speed_m_s", "largest_rise_speed_m_s", 0.1, 0.3);
  const double gap = table.number("shortest_gap_s", 0.05), std_db = table.number("strength_std_db", 3.0);
  const double from = std::min(0.05, 0.1 * recipe.duration_s), until = 0.9 * recipe.duration_s;
  if (gap * static_cast<double>(n_drops - 1) > until - from) {
    throw InputError(table.place("drops"), "do not fit into the recording with their shortest gap",
                     std::to_string(n_drops), "up to " + std::to_string(static_cast<int>((until - from) / gap) + 1));
  }
  std::size_t n_before = 0;
  for (const DropRecording& recording : recipe.recordings) n_before += recording.drops.size();
  if (recipe.recordings.size() + n_recordings > kMaxRecordings || n_before + n_recordings * n_drops > kMaxDropsInAll) {
    throw InputError(
        table.place("recordings"), "makes too many drops", std::to_string(n_recordings * n_drops),
        std::to_string(kMaxRecordings) + " recordings and " + std::to_string(kMaxDropsInAll) + " drops in all");
  }
  const bubble::RiseKind rise = read_rise_kind(table);
  for (std::size_t r = 0; r < n_recordings; ++r) {
    RandomStream random(seed, (std::uint64_t{0xd709} << 32) | (set << 16) | r);
    DropRecording recording{name + "-" + std::to_string(r + 1), {}};
    for (const double onset : draw_onsets(n_drops, gap, from, until, random)) {
      Drop drop;
      drop.onset_s = onset;
      drop.radius_m = radius.low * std::pow(radius.high / radius.low, random.uniform());
      drop.depth_m = random.uniform(depth.low, depth.high);
      drop.rise.kind = rise;
      drop.rise.speed_m_s = random.uniform(speed.low, speed.high);
      drop.strength = std::pow(10.0, std_db * random.normal() / 20.0);
      drop.pitch = pitch;
      recording.drops.push_back(drop);
    }
    recipe.recordings.push_back(std::move(recording));
  }
}

}  // namespace

bool is_drop_recipe(std::string_view text) {
  if (toml_keys_too_deep(text)) return false;  // its reader says so
  try {
    const toml::table root = toml::parse(text);
    return root["kind"].value_or(std::string_view()) == "drops";
  } catch (const toml::parse_error&) {
    return false;
  }
}

DropRecipe parse_drop_recipe(std::string_view text, const std::string& name, std::uint64_t seed) {
  const TomlTable root = TomlTable::parse(text, name, kSchema);
  root.choice("kind", {"drops"});
  DropRecipe recipe;
  recipe.name = root.text("name", name);
  const TomlTable sound = root.table("sound");
  recipe.sample_rate_hz = sound.number("sample_rate_hz", recipe.sample_rate_hz);
  recipe.duration_s = sound.number("duration_s", recipe.duration_s);
  recipe.peak = sound.number("peak", recipe.peak);
  const std::string theory = sound.choice("theory", {"leighton", "prosperetti", "paper"});
  recipe.theory = theory == "leighton" ? bubble::BubbleTheory::kLeighton
                  : theory == "paper"  ? bubble::BubbleTheory::kPaper
                                       : bubble::BubbleTheory::kProsperetti;
  recipe.soft_attack = sound.choice("attack", {"none", "soft"}) == "soft";
  const bubble::PitchModel pitch = read_pitch(root.table("pitch"));
  if (root.has("noise")) {
    const TomlTable noise = root.table("noise");
    recipe.snr_db = noise.number("snr_db");
    recipe.snr_of = noise.choice("of", {"drop", "recording"}) == "drop" ? DropSnr::kDrop : DropSnr::kRecording;
    recipe.pink = noise.choice("colour", {"white", "pink"}) == "pink";
  }
  if (root.has("room")) {
    const TomlTable room = root.table("room");
    recipe.room_rt60_s = room.number("rt60_s");
    recipe.room_level_db = room.number("level_db", recipe.room_level_db);
  }
  std::set<std::string> names;
  const auto check_unique = [&](const TomlTable& table) {
    if (!names.insert(table.text("name")).second)
      throw InputError(table.place("name"), "is used twice", table.text("name"));
  };
  for (const TomlTable& table : root.tables("recording", kMaxRecordings)) {
    DropRecording recording{checked_name(table), {}};
    check_unique(table);
    for (const TomlTable& drop : table.tables("drop", kMaxDrops)) {
      recording.drops.push_back(read_drop(drop, pitch, recipe.duration_s));
      try {
        bubble::bubble_oscillation(recording.drops.back().radius_m, recipe.medium, recipe.theory);
      } catch (const InputError& error) {
        throw InputError(drop.place("radius_m"), error.what());
      }
    }
    if (recording.drops.empty()) throw InputError(table.place("drop"), "is missing");
    std::stable_sort(recording.drops.begin(), recording.drops.end(),
                     [](const Drop& a, const Drop& b) { return a.onset_s < b.onset_s; });
    recipe.recordings.push_back(std::move(recording));
  }
  std::uint64_t set = 0;
  for (const TomlTable& table : root.tables("random", kMaxRecordings)) {
    check_unique(table);
    add_random(table, pitch, seed, ++set, recipe);
  }
  std::set<std::string> files;
  for (const DropRecording& recording : recipe.recordings) {
    if (!files.insert(recording.name).second)
      throw InputError(name, "two recordings get one file name", recording.name);
    for (std::size_t i = 1; i < recording.drops.size();
         ++i) {  // in order of onset, by which the rise file tells them apart
      if (!(recording.drops[i].onset_s > recording.drops[i - 1].onset_s))
        throw InputError(name + ", " + recording.name, "two drops have one onset_s",
                         to_text(recording.drops[i].onset_s));
    }
  }
  if (recipe.recordings.empty()) throw InputError(name, "has no recordings", "", "[[recording]] or [[random]]");
  return recipe;
}

std::string drop_recipe_schema_markdown() { return toml_schema_markdown(kSchema); }

}  // namespace klang::datasets
