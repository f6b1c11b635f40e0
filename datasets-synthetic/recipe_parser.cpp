#include <algorithm>
#include <cctype>
#include <cmath>
#include <limits>
#include <set>

#include "core/foundation/base/conventions.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/config/toml_table.hpp"
#include "core/geometry/shapes/shape_reader.hpp"
#include "core/physics/modal/damping/damping_reader.hpp"
#include "core/physics/solid/material_reader.hpp"
#include "core/physics/solid/support_reader.hpp"
#include "datasets-synthetic/recipe_spec.hpp"

namespace klang::datasets {
namespace {

constexpr double kInf = std::numeric_limits<double>::infinity();
constexpr std::size_t kMaxBytes = 1 << 20, kMaxSpecimens = 100, kMaxStrikes = 1000, kMaxPickups = 64;

const TomlField kSchema[] = {
    {"", "name", TomlType::kText, "the file's name", -kInf, kInf, "title"},
    {"", "sound", TomlType::kTable, "the defaults below", -kInf, kInf, "rate, length, level"},
    {"", "material", TomlType::kTable, "required", -kInf, kInf, "the true material"},
    {"", "damping", TomlType::kTable, "required", -kInf, kInf, "the true damping"},
    {"", "noise", TomlType::kTable, "none", -kInf, kInf, "noise of the recording"},
    {"", "mains", TomlType::kTable, "none", -kInf, kInf, "hum"},
    {"", "room", TomlType::kTable, "none", -kInf, kInf, "reverberation"},
    {"", "split_pairs", TomlType::kTable, "none", -kInf, kInf, "imperfection that splits pairs of equal frequency"},
    {"", "fit", TomlType::kTable, "the defaults below", -kInf, kInf,
     "what the specimen.toml made with the sounds says"},
    {"", "specimen", TomlType::kTables, "required", -kInf, kInf, "one `[[specimen]]` a body and recording, 1 to 100"},

    {"sound", "sample_rate_hz", TomlType::kNumber, "48000", 4000, 768000, "sample rate"},
    {"sound", "duration_s", TomlType::kNumber, "5", 0.01, 120, "length of each recording"},
    {"sound", "peak", TomlType::kNumber, "0.5", 1e-6, 10,
     "largest value of the strikes' sound, before all disturbances"},
    {"sound", "dc_offset", TomlType::kNumber, "0", -1, 1, "added constant"},
    {"sound", "clip_level", TomlType::kNumber, "none", 1e-6, 10, "hard limit, last in the chain"},
    {"sound", "highest_hz", TomlType::kNumber, "20000", 20, 100000,
     "modes above are left out; those above 0.499 of the sample rate always are"},

    {"noise", "snr_db", TomlType::kNumber, "required", -60, 200,
     "mean square of the sound over the whole recording by that of the noise, each channel"},
    {"noise", "colour", TomlType::kText, "`white`", -kInf, kInf, "`white` or `pink` (3 dB an octave, above 20 Hz)"},

    {"mains", "frequency_hz", TomlType::kNumber, "50", 1, 1000, "fundamental"},
    {"mains", "amplitude", TomlType::kNumber, "required", 0, 1, "of the fundamental, full scale = 1"},
    {"mains", "harmonics", TomlType::kNumber, "3", 1, 40,
     "their number; the k-th has amplitude / k and a seeded phase"},

    {"room", "rt60_s", TomlType::kNumber, "required", 0.01, 20, "time in which the tail falls by 60 dB"},
    {"room", "level_db", TomlType::kNumber, "-20", -120, 40, "energy of the tail's response against the direct sound"},

    {"split_pairs", "relative_detuning", TomlType::kNumber, "required", 0, 0.1,
     "distance of the two frequencies, as a part of their mean"},
    {"split_pairs", "angle_rad", TomlType::kNumber, "0.6", -7, 7,
     "turn of the two shapes within the pair (0: a strike may leave one of them silent)"},

    {"fit", "parameters", TomlType::kTexts, "left to `klang fit`", -kInf, kInf, "parameters to fit"},
    {"fit", "youngs_modulus_factor", TomlType::kNumber, "1", 0.1, 10, "starting guess by the truth"},
    {"fit", "poissons_ratio", TomlType::kNumber, "the true one", -0.999, 0.4999, "starting guess"},

    {"specimen", "name", TomlType::kText, "required", -kInf, kInf, "unique; the recording is NAME.wav"},
    {"specimen", "shape", TomlType::kTable, "required", -kInf, kInf, "an analytic body"},
    {"specimen", "support", TomlType::kTable, "free", -kInf, kInf,
     "how the body is held: a table, or the text form (`\"clamped:x=0\"`)"},
    {"specimen", "strike", TomlType::kTables, "required", -kInf, kInf, "one or more blows"},
    {"specimen", "pickup", TomlType::kTables, "required", -kInf, kInf, "one for each channel"},
    {"specimen", "mount", TomlType::kTables, "none", -kInf, kInf,
     "viscous dampers: wire or foam that touches the body"},
    {"specimen", "predict", TomlType::kBoolean, "`false`", -kInf, kInf,
     "passed on to the specimen.toml made with the sounds"},

    {"specimen.strike", "time_s", TomlType::kNumber, "0.1", -10, 120, "centre of the force pulse"},
    {"specimen.strike", "at", TomlType::kVector, "required", -1, 1,
     "place, in half extents of the body from its centre"},
    {"specimen.strike", "impulse_n_s", TomlType::kVector, "required", -1e3, 1e3, "impulse vector"},
    {"specimen.strike", "contact_s", TomlType::kNumber, "0", 0, 0.1, "standard deviation of the Gaussian force pulse"},

    {"specimen.pickup", "at", TomlType::kVector, "required", -1, 1,
     "place, in half extents of the body from its centre"},
    {"specimen.pickup", "direction", TomlType::kVector, "required", -1e3, 1e3, "heard direction, any length"},

    {"specimen.mount", "at", TomlType::kVector, "required", -1, 1,
     "place, in half extents of the body from its centre"},
    {"specimen.mount", "direction", TomlType::kVector, "all directions", -1e3, 1e3, "damped direction, any length"},
    {"specimen.mount", "damping_n_s_per_m", TomlType::kNumber, "required", 0, 1e3, "coefficient of the damper"},
};

/// The table above with the keys of materials, damping laws, shapes and supports in their places.
const std::vector<TomlField>& recipe_schema() {
  static const std::vector<TomlField> schema = [] {
    std::vector<TomlField> fields(std::begin(kSchema), std::end(kSchema));
    const auto insert = [&](std::string_view before_table, const std::vector<TomlField>& more) {
      const auto place = std::find_if(fields.begin(), fields.end(),
                                      [&](const TomlField& field) { return field.table == before_table; });
      fields.insert(place, more.begin(), more.end());
    };
    insert("noise", solid::material_fields("material", "the preset's"));
    insert("noise", damping::damping_fields("damping"));
    insert("specimen.strike", mesh::shape_fields("specimen.shape"));
    insert("specimen.strike", solid::support_fields("specimen.support"));
    return fields;
  }();
  return schema;
}

solid::Material read_material(const TomlTable& table, const std::filesystem::path& folder) {
  const solid::MaterialInput input = solid::read_material(table, folder);
  if (!input.density_given) throw InputError(table.place("density_kg_m3"), "is missing", "", "a density, or a preset");
  return input.material;
}

/// A list of tables that must not be empty.
std::vector<TomlTable> some_tables(const TomlTable& table, std::string_view key, std::size_t most) {
  std::vector<TomlTable> list = table.tables(key, most);
  if (list.empty()) throw InputError(table.place(key), "is missing", "", "1 to " + std::to_string(most) + " of them");
  return list;
}

TomlTable required_table(const TomlTable& table, std::string_view key) {
  if (!table.has(key)) throw InputError(table.place(key), "is missing");
  return table.table(key);
}

void check_name(const std::string& name, const std::string& place) {
  const bool fits = !name.empty() && name.size() <= 64 && std::all_of(name.begin(), name.end(), [](unsigned char c) {
    return std::isalnum(c) || c == '_' || c == '-' || c == '+' || c == '#';
  });
  if (!fits) throw InputError(place, "cannot be a file name", name, "1 to 64 letters, digits and _ - + #");
}

RecipeSpecimen read_specimen(const TomlTable& table, const std::filesystem::path& base, const Recipe& recipe) {
  RecipeSpecimen specimen;
  specimen.name = table.text("name");
  check_name(specimen.name, table.place("name"));
  specimen.shape = mesh::read_shape(required_table(table, "shape"), base);
  specimen.support = solid::read_support(table);
  for (const TomlTable& strike : some_tables(table, "strike", kMaxStrikes)) {
    specimen.strikes.push_back({strike.number("time_s", 0.1), strike.vector("at"), strike.vector("impulse_n_s"),
                                strike.number("contact_s", 0.0)});
    if (!(specimen.strikes.back().time_s < recipe.duration_s)) {
      throw InputError(strike.place("time_s"), "is after the end of the recording",
                       to_text(specimen.strikes.back().time_s), "below " + to_text(recipe.duration_s));
    }
    if (specimen.strikes.back().impulse_n_s.isZero(0.0)) throw InputError(strike.place("impulse_n_s"), "is zero");
  }
  for (const TomlTable& pickup : some_tables(table, "pickup", kMaxPickups)) {
    specimen.pickups.push_back({pickup.vector("at"), pickup.vector("direction")});
    if (specimen.pickups.back().direction.isZero(0.0)) throw InputError(pickup.place("direction"), "is zero");
  }
  for (const TomlTable& mount : table.tables("mount", kMaxPickups)) {
    specimen.mounts.push_back({mount.vector("at"), std::nullopt, mount.number("damping_n_s_per_m")});
    if (!mount.has("direction")) continue;
    specimen.mounts.back().direction = mount.vector("direction");
    if (specimen.mounts.back().direction->isZero(0.0)) throw InputError(mount.place("direction"), "is zero");
  }
  specimen.predict = table.boolean("predict", false);
  std::stable_sort(specimen.strikes.begin(), specimen.strikes.end(),
                   [](const RecipeStrike& a, const RecipeStrike& b) { return a.time_s < b.time_s; });
  return specimen;
}

}  // namespace

double Recipe::decay_per_s(double omega) const { return damping->decay_per_s(omega, damping_parameters.data()); }

Recipe parse_recipe(std::string_view text, const std::string& name, const std::filesystem::path& base_folder) {
  if (text.size() > kMaxBytes) throw InputError(name, "is too long for a recipe", std::to_string(text.size()));
  const TomlTable root = TomlTable::parse(text, name, recipe_schema());
  Recipe recipe;
  recipe.name = root.text("name", name.c_str());
  recipe.material = read_material(required_table(root, "material"), base_folder);
  const damping::LawValue damping = damping::read_damping(required_table(root, "damping"));
  recipe.damping = damping.law;
  recipe.damping_parameters = damping.parameters;
  if (root.has("sound")) {
    const TomlTable sound = root.table("sound");
    recipe.sample_rate_hz = sound.number("sample_rate_hz", recipe.sample_rate_hz);
    recipe.duration_s = sound.number("duration_s", recipe.duration_s);
    recipe.peak = sound.number("peak", recipe.peak);
    recipe.dc_offset = sound.number("dc_offset", recipe.dc_offset);
    recipe.clip_level = sound.optional_number("clip_level");
    recipe.highest_hz = sound.number("highest_hz", recipe.highest_hz);
  }
  if (root.has("noise")) {
    const TomlTable noise = root.table("noise");
    recipe.snr_db = noise.number("snr_db");
    const std::string colour = noise.text("colour", "white");
    if (colour != "white" && colour != "pink") {
      throw InputError(noise.place("colour"), "unknown colour", colour, "white, pink");
    }
    recipe.pink = colour == "pink";
  }
  if (root.has("mains")) {
    const TomlTable mains = root.table("mains");
    recipe.mains_frequency_hz = mains.number("frequency_hz", 50.0);
    recipe.mains_amplitude = mains.number("amplitude");
    recipe.mains_harmonics = static_cast<int>(mains.number("harmonics", 3.0));
  }
  if (root.has("room")) {
    const TomlTable room = root.table("room");
    recipe.room_rt60_s = room.number("rt60_s");
    recipe.room_level_db = room.number("level_db", recipe.room_level_db);
  }
  if (root.has("split_pairs")) {
    const TomlTable split = root.table("split_pairs");
    recipe.split_detuning = split.number("relative_detuning");
    recipe.split_angle_rad = split.number("angle_rad", recipe.split_angle_rad);
  }
  if (root.has("fit")) {
    const TomlTable fit = root.table("fit");
    recipe.fit_parameters = fit.texts("parameters");
    for (const std::string& parameter : recipe.fit_parameters) {
      const bool plain = std::all_of(parameter.begin(), parameter.end(), [](unsigned char c) {
        return std::isalnum(c) || c == '_' || c == '.' || c == '-' || c == '+' || c == '#';
      });
      if (!plain || parameter.empty()) throw InputError(fit.place("parameters"), "is no parameter name", parameter);
    }
    recipe.start_youngs_factor = fit.number("youngs_modulus_factor", 1.0);
    recipe.start_poissons_ratio = fit.optional_number("poissons_ratio");
  }
  std::set<std::string> names;
  for (const TomlTable& table : some_tables(root, "specimen", kMaxSpecimens)) {
    recipe.specimens.push_back(read_specimen(table, base_folder, recipe));
    if (!names.insert(recipe.specimens.back().name).second) {
      throw InputError(name, "two specimens have one name", recipe.specimens.back().name);
    }
  }
  return recipe;
}

std::string recipe_schema_markdown() {
  std::string text =
      "# Recipes of synthetic recordings\n\n"
      "`klang dataset RECIPE` makes recordings with known truth. Generated from the table in\n"
      "`datasets-synthetic/recipe_parser.cpp`; a test keeps the two equal. Unknown keys are errors.\n";
  text += toml_schema_markdown(recipe_schema());
  text +=
      "\n## What is made, in this order\n"
      "1. True modes: boxes and tubes that are free by the Ritz method (`ritz_box.hpp`, `ritz_tube.hpp`: no "
      "finite\n"
      "   elements), other free bodies of revolution by the harmonics of their section, ellipsoids and boxes held at a "
      "face by\n"
      "   polynomials, as `klang modes` has them; the rest by quadratic elements one refinement finer than the default "
      "of `klang "
      "fit`.\n"
      "2. Pairs of equal frequency are split by `split_pairs` (bodies of revolution made of elements: equal "
      "within 1e-3).\n"
      "   Decays are those of the damping model and of the mounts' dampers (first order: c |u|^2 / 2 of a "
      "mode).\n"
      "3. Each mode rings by the exact oscillator bank; a channel hears its pickup's velocity. The loudest "
      "channel is\n"
      "   scaled to `peak`.\n"
      "4. Room (a seeded Gaussian tail for each channel), noise, hum, offset, clipping.\n\n"
      "The truth file gives, for each recording, every partial that sounds: damped frequency, decay, "
      "amplitude and phase\n"
      "at the first strike (of channel 1; `channels` has the rest). Same recipe and seed: same bits on any "
      "number of\n"
      "threads.\n";
  return text;
}

}  // namespace klang::datasets
