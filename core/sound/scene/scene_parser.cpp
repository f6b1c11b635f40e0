#include <algorithm>
#include <cctype>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/output_file.hpp"
#include "core/foundation/base/parse_json.hpp"
#include "core/foundation/config/toml_table.hpp"
#include "core/geometry/shapes/shape_reader.hpp"
#include "core/physics/solid/fitted_material.hpp"
#include "core/physics/solid/material_reader.hpp"
#include "core/sound/scene/detail/deform_reader.hpp"
#include "core/sound/scene/detail/link_reader.hpp"
#include "core/sound/scene/detail/sound_reader.hpp"
#include "core/sound/scene/scene.hpp"

namespace klang::scene {
namespace {

using enum TomlType;
constexpr double kInf = std::numeric_limits<double>::infinity();
constexpr std::size_t kMostBodies = 10'000, kMostMaterials = 1000;

const TomlField kSchema[] = {
    {"", "name", kText, "the file's name", -kInf, kInf, "title"},
    {"", "duration_s", kNumber, "until all bodies rest", 0, 3600, "length of motion and sound", true},
    {"", "longest_s", kNumber, "60", 0, 3600, "without duration_s: a scene that moves longer is refused", true},
    {"", "solver", kTable, "the defaults below", -kInf, kInf, "steps of the motion"},
    {"", "world", kTable, "the defaults below", -kInf, kInf, "gravity and floor"},
    {"", "material", kTables, "required", -kInf, kInf, "one `[[material]]` each"},
    {"", "body", kTables, "required", -kInf, kInf, "one `[[body]]` each, up to 10000"},
    {"", "hold", kTables, "none", -kInf, kInf,
     "one `[[hold]]` each: places of cracking and modal bodies that are moved from outside"},
    {"", "joint", kTables, "none", -kInf, kInf, "one `[[joint]]` each: places that modal bodies share"},
    {"", "cord", kTables, "none", -kInf, kInf, "one `[[cord]]` each: two places that it holds together"},
    {"", "hinge", kTables, "none", -kInf, kInf, "one `[[hinge]]` each: a place that two bodies share"},
    {"", "crack", kTable, "the defaults below", -kInf, kInf, "how cracking bodies flow and crack"},
    {"", "modal", kTable, "the defaults below", -kInf, kInf, "how modal bodies move"},
    {"", "fracture", kTable, "the defaults below", -kInf, kInf, "how breakable bodies break"},
    {"", "sound", kTable, "the defaults below", -kInf, kInf, "what is heard, and where"},
    {"", "frames", kTable, "the defaults below", -kInf, kInf, "pictures of the motion"},

    {"solver", "rate_hz", kNumber, "10000", 100, 1e6, "steps per second"},
    {"solver", "iterations", kNumber, "200", 1, 1e5, "most sweeps over lasting contacts per step"},
    {"solver", "collisions", kText, "`pairwise`", -kInf, kInf,
     "`pairwise` (impacts of one step one after the other) or `simultaneous`"},
    {"solver", "pose_rate_hz", kNumber, "1000", 1, 1e6, "poses per second that are kept of each body"},

    {"world", "gravity_m_s2", kVector, "[0, 0, -9.81]", -1e4, 1e4, "gravity"},
    {"world", "floor", kTable, "no floor", -kInf, kInf, "the plane z = 0"},
    {"world.floor", "material", kText, "required", -kInf, kInf, "a material of the scene"},
    {"world.floor", "sound", kTable, "none: the floor is silent", -kInf, kInf, "a slab that rings where it is struck"},

    {"material", "name", kText, "required", -kInf, kInf, "by which bodies name it"},
    {"material", "restitution", kNumber, "0.5", 0, 1,
     "separation over approach speed of an impact; of two materials the smaller holds"},
    {"material", "roughness", kNumber, "0: smooth", 0, 1,
     "of a lasting contact that moves along the surface: rms change of its force over the force, as it is heard"},
    {"material", "roughness_length_m", kNumber, "5e-4", 1e-6, 0.1, "over which the surface is alike"},
    {"material", "friction", kNumber, "0.4", 0, 100, "Coulomb's coefficient; of two materials the smaller holds"},
    {"material", "tensile_strength_pa", kNumber, "none", 0, 1e12,
     "largest principal stress that it stands; does not follow from ringing", true},
    {"material", "fracture_energy_j_m2", kNumber, "none", 0, 1e9,
     "toughness: energy per area of crack; does not follow from ringing", true},
    {"material", "damping", kTable, "a loss factor of 1/1000, and the run says so", -kInf, kInf, "how modes decay"},

    {"body", "name", kText, "required", -kInf, kInf, "unique; not `floor`"},
    {"body", "shape", kTable, "this or mesh", -kInf, kInf, "a shape and its dimensions (docs/shapes.md)"},
    {"body", "mesh", kText, "this or shape", -kInf, kInf, "a mesh file, relative to the scene"},
    {"body", "unit_m", kNumber, "1", 1e-9, 1e9, "length of the mesh's unit"},
    {"body", "material", kText, "required", -kInf, kInf, "a material of the scene"},
    {"body", "model", kText, "`rigid`", -kInf, kInf,
     "`rigid`, `breakable`: an impact that strains it enough breaks it; its pieces do not break again; or `cracking`: "
     "it deforms, "
     "flows and cracks, step by step"},
    {"body", "stress_edge_m", kNumber, "the wall, twice the volume over the surface", 0, 1e4,
     "of a breakable body's mesh for stress; by default no more than some 60,000 elements", true},
    {"body", "score", kTable, "none", -kInf, kInf, "a plane along which a breakable body is scored"},
    {"body", "position_m", kVector, "[0, 0, 0]", -1e4, 1e4, "of the origin of the shape or file"},
    {"body", "rotation_deg", kVector, "[0, 0, 0]", -1e6, 1e6, "about the world's x, then y, then z"},
    {"body", "velocity_m_s", kVector, "[0, 0, 0]", -1e4, 1e4, "of the centre of mass"},
    {"body", "angular_velocity_rad_s", kVector, "[0, 0, 0]", -1e5, 1e5, "about the world's axes"},
    {"body", "fixed", kBoolean, "false", -kInf, kInf, "it does not move, whatever pushes it"},
    {"body", "modal", kTable, "the scene's", -kInf, kInf, "of a modal body: what stands here wins"},
    {"body", "crack", kTable, "the scene's", -kInf, kInf, "of a cracking body: what stands here wins"},
    {"body", "max_edge_m", kNumber, "as `klang modes`", 0, 1e4, "of the mesh for its modes, and of a cracking body's",
     true},
    {"body", "modes_to_hz", kNumber, "the sound's band_hz", 1, 1e5,
     "highest of its own modes that is computed, where that is below the end of the band, in which its pieces are "
     "heard"},
    {"body", "sound", kText, "`auto`", -kInf, kInf,
     "`modes`: its own modes and their radiation; `proxy`: an ellipsoid of the bank; `none`; `auto`: modes, or a proxy "
     "by "
     "proxy_above_hz, unless it is fixed"},

    {"body.score", "point_m", kVector, "required", -1e4, 1e4, "of the plane, in the body's frame"},
    {"body.score", "normal", kVector, "required", -1e6, 1e6, "of the plane, any length but 0"},
    {"body.score", "strength_factor", kNumber, "0.1", 0, 1, "of the strength where the score runs", true},
    {"body.score", "toughness_factor", kNumber, "0.1", 0, 1, "of the toughness of a crack in it", true},

    {"fracture", "pattern", kText, "`auto`", -kInf, kInf,
     "`power` (convex cells), `geodesic` (SB's regions) or `auto`: power for a body of one convex part"},
    {"fracture", "eta", kNumber, "0.8", 1e-6, 1, "share of the strain energy that cracks may cost"},
    {"fracture", "alpha", kNumber, "0.15", 0, 1, "how much smaller pieces are where more energy is"},
    {"fracture", "smallest_piece_m", kNumber, "0.006", 0, 10, "least distance of cells"},
    {"fracture", "most_pieces", kNumber, "400", 2, 2000, "cells of one breakage"},
    {"fracture", "generations", kNumber, "1", 1, 10, "how often things break: 1: pieces do not break again"},
    {"fracture", "force_model", kText, "`hertz`", -kInf, kInf,
     "`hertz`: peak of Hertz' pulse, with at most the energy of the compression; `impulse_over_step` or `authors_code` "
     "(impulse "
     "times 1800 per s): no such limit, what the model adds is booked in work_j (errata 49, 50)"},
    {"fracture", "impulses", kBoolean, "true", -kInf, kInf, "cracks that open push the pieces apart"},
    {"fracture", "literature", kText, "`mended`", -kInf, kInf, "`mended`, or `paper`: impulses as SB prints them"},

};

/// The table above with the keys of materials, damping and shapes in their places.
const std::vector<TomlField>& schema() {
  static const std::vector<TomlField> fields = [] {
    std::vector<TomlField> all(std::begin(kSchema), std::end(kSchema));
    const auto insert = [&](std::string_view before_table, const std::vector<TomlField>& more) {
      const auto place =
          std::find_if(all.begin(), all.end(), [&](const TomlField& field) { return field.table == before_table; });
      all.insert(place, more.begin(), more.end());
    };
    insert("body", solid::material_fields("material", "the preset's or the fit's"));
    insert("body", damping::damping_fields("material.damping"));
    insert("fracture", detail::hold_fields());
    insert("fracture", detail::joint_fields());
    insert("fracture", detail::link_fields());
    insert("fracture", detail::crack_fields("crack"));
    insert("fracture", detail::modal_fields("modal"));
    insert("fracture", detail::modal_fields("body.modal"));
    insert("fracture", detail::crack_fields("body.crack"));
    insert("body.score", mesh::shape_fields("body.shape"));
    insert("material", detail::floor_sound_fields());
    const std::vector<TomlField> heard = detail::sound_fields();
    all.insert(all.end(), heard.begin(), heard.end());
    return all;
  }();
  return fields;
}

/// The best law of a fit without what radiation and mounts added to it; none where no decay was measured.
void read_fitted_damping(const nlohmann::json& fit, SceneMaterial& material, FitSpread& spread) {
  const nlohmann::json candidates = fit.value("/damping/candidates"_json_pointer, nlohmann::json::array());
  if (!candidates.is_array() || candidates.empty()) return;
  const nlohmann::json& best = candidates.front();
  std::string model = text_under(best, "model");
  model = model.substr(0, model.find("_and_"));
  damping::LawValue value;
  value.law = damping::find_law(model, damping::LawUse::kOptions);
  if (!value.law || !best.contains("parameters") || !best["parameters"].is_array()) return;
  for (const damping::LawParameter& parameter : value.law->parameters()) {
    std::optional<double> number, std;
    for (const nlohmann::json& entry : best["parameters"]) {
      if (text_under(entry, "name") != parameter.name) continue;
      if (entry.contains("value") && entry["value"].is_number()) number = entry["value"].get<double>();
      if (entry.contains("std") && entry["std"].is_number()) std = entry["std"].get<double>();
    }
    if (!number) return;  // not that law's numbers
    value.parameters.push_back(*number);
    if (std) spread.damping_std.push_back(*std);
  }
  // Numbers without a deviation are not exact numbers: damping is drawn only where all are known.
  if (spread.damping_std.size() != value.parameters.size()) spread.damping_std.clear();
  material.damping = std::move(value);
}

/// Elastic constants that the data determine, with their covariance.
void read_fitted_spread(const nlohmann::json& fit, FitSpread& spread) {
  const nlohmann::json names = fit.value("/correlation/names"_json_pointer, nlohmann::json::array());
  const nlohmann::json matrix = fit.value("/correlation/matrix"_json_pointer, nlohmann::json::array());
  std::vector<double> stds;
  std::vector<std::size_t> rows;
  for (std::size_t i = 0; i < names.size(); ++i)
    for (const nlohmann::json& parameter : fit.value("parameters", nlohmann::json::array())) {
      const std::string name = text_under(parameter, "name");
      const bool elastic = name == "youngs_modulus_pa" || name == "poissons_ratio" || name == "shear_modulus_pa" ||
                           name == "lame_lambda_pa" || name == "lame_mu_pa";
      if (!elastic || names[i] != name || !parameter.contains("std") || !parameter["std"].is_number()) continue;
      spread.names.push_back(name);
      stds.push_back(parameter["std"].get<double>());
      rows.push_back(i);
    }
  const auto n = static_cast<Eigen::Index>(rows.size());
  spread.covariance = Eigen::MatrixXd::Zero(n, n);
  for (std::size_t i = 0; i < rows.size(); ++i)
    for (std::size_t k = 0; k < rows.size(); ++k) {
      const nlohmann::json& entry = matrix.at(rows[i]).at(rows[k]);
      spread.covariance(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(k)) =
          (entry.is_number() ? entry.get<double>() : (i == k ? 1.0 : 0.0)) * stds[i] * stds[k];
    }
}

SceneMaterial read_scene_material(const TomlTable& table, const std::filesystem::path& folder) {
  SceneMaterial material;
  material.name = table.text("name");
  if (material.name.empty()) throw InputError(table.place("name"), "is empty");
  const solid::MaterialInput input = solid::read_material(table, folder);
  if (!input.density_given)
    throw InputError(table.place("density_kg_m3"), "is missing", "", "a density, a preset or a fit");
  material.elastic = input.material;
  if (table.has("fit")) {
    material.elastic.name = material.name;
    FitSpread spread;
    for (const std::filesystem::path& file : input.files) {
      const nlohmann::json fit = solid::read_fit_json(file);
      if (!material.contradiction) material.contradiction = solid::contradiction_of(fit, file);
      located(file.string(), [&] {
        try {
          read_fitted_damping(fit, material, spread);
          read_fitted_spread(fit, spread);
        } catch (const nlohmann::json::exception&) {
          throw InputError("correlation", "is not that of a fit");
        }
        return 0;
      });
    }
    if (table.has("damping")) spread.damping_std.clear();
    if (!spread.names.empty() || !spread.damping_std.empty()) material.spread = std::move(spread);
  }
  material.inputs = input.files;
  material.restitution = table.number("restitution", material.restitution);
  material.friction = table.number("friction", material.friction);
  material.roughness = table.number("roughness", 0.0);
  material.roughness_length_m = table.number("roughness_length_m", material.roughness_length_m);
  material.tensile_strength_pa = table.optional_number("tensile_strength_pa");
  material.fracture_energy_j_m2 = table.optional_number("fracture_energy_j_m2");
  if (table.has("damping")) material.damping = damping::read_damping(table.table("damping"));
  return material;
}

int material_named(const Scene& scene, const std::string& name, const std::string& place) {
  std::string known;
  for (std::size_t i = 0; i < scene.materials.size(); ++i) {
    if (scene.materials[i].name == name) return static_cast<int>(i);
    known += (known.empty() ? "" : ", ") + scene.materials[i].name;
  }
  throw InputError(place, "unknown material", name, known);
}

void read_breaking(const TomlTable& table, const Scene& scene, SceneBody& body) {
  if (body.model != BodyModel::kBreakable) {
    for (const char* key : {"stress_edge_m", "score"})
      if (table.has(key))
        throw InputError(table.place(key), "belongs to a breakable body", body.name, "model = \"breakable\"");
    return;
  }
  const SceneMaterial& material = scene.material_of(body);
  if (!material.tensile_strength_pa || !material.fracture_energy_j_m2)
    throw InputError(table.place("model"), "needs a strength and a toughness of the material", material.name,
                     "tensile_strength_pa and fracture_energy_j_m2");
  if (body.fixed) throw InputError(table.place("model"), "a fixed body does not break", body.name, "a body that moves");
  body.stress_edge_m = table.number("stress_edge_m", 0.0);
  if (!table.has("score")) return;
  const TomlTable score = table.table("score");
  fracture::ScoredPlane plane;
  const Eigen::Vector3d normal = score.vector("normal");
  if (!(normal.norm() > 0.0)) throw InputError(score.place("normal"), "has no direction", "0, 0, 0");
  plane.plane.normal = normal.normalized();
  plane.plane.offset_m = plane.plane.normal.dot(score.vector("point_m"));
  plane.strength_factor = score.number("strength_factor", plane.strength_factor);
  plane.toughness_factor = score.number("toughness_factor", plane.toughness_factor);
  body.score = plane;
}

void read_fracture(const TomlTable& table, fracture::FractureOptions& options) {
  options.pattern = *enum_from_text<fracture::PatternKind>(table.choice("pattern", {"auto", "power", "geodesic"}));
  options.eta = table.number("eta", options.eta);
  options.alpha = table.number("alpha", options.alpha);
  options.smallest_piece_m = table.number("smallest_piece_m", options.smallest_piece_m);
  const double most = table.number("most_pieces", options.most_pieces);
  if (most != std::floor(most)) throw InputError(table.place("most_pieces"), "is no whole number", to_text(most));
  options.most_pieces = static_cast<int>(most);
  const double generations = table.number("generations", options.generations);
  if (generations != std::floor(generations))
    throw InputError(table.place("generations"), "is no whole number", to_text(generations));
  options.generations = static_cast<int>(generations);
  options.impulses = table.boolean("impulses", options.impulses);
  options.literature = *enum_from_text<fracture::Literature>(table.choice("literature", {"mended", "paper"}));
  located(table.place(), [&] {
    options.validate();
    return 0;
  });
}

/// Pieces are called PARENT/NUMBER, and their pieces PARENT/NUMBER/NUMBER.
bool is_name_of_piece(const std::string& name, const std::string& parent) {
  return name.size() > parent.size() + 1 && name.starts_with(parent) && name[parent.size()] == '/' &&
         name.find_first_not_of("0123456789/", parent.size()) == std::string::npos;
}

SceneBody read_body(const TomlTable& table, const std::filesystem::path& folder, const Scene& scene) {
  SceneBody body;
  body.place = table.place();
  body.name = table.text("name");
  if (body.name.empty() || body.name == "floor")
    throw InputError(table.place("name"), "is no name of a body", body.name, "a text other than floor");
  if (std::any_of(body.name.begin(), body.name.end(),
                  [](unsigned char c) { return std::iscntrl(c) != 0; }))  // tables have a row for it
    throw InputError(table.place("name"), "holds a line break or another control character", "", "one line of text");
  for (const SceneBody& other : scene.bodies) {
    if (other.name == body.name)
      throw InputError(table.place("name"), "is given twice", body.name, "a name of its own");
    const std::string &one = body.name, &two = other.name;
    if (is_name_of_piece(one, two) || is_name_of_piece(two, one))
      throw InputError(table.place("name"), "is what a piece may be called, or the body it comes from",
                       one + ", " + two, "no body's name with / and a number behind it");
  }
  if (table.has("shape") == table.has("mesh"))
    throw InputError(table.place(), table.has("mesh") ? "has a shape and a mesh" : "has no shape", body.name,
                     "shape = { kind = ... } or mesh = FILE");
  if (table.has("shape")) {
    body.shape = mesh::read_shape(table.table("shape"), folder);
    if (table.has("unit_m")) throw InputError(table.place("unit_m"), "belongs to a mesh; shapes are in metres");
  } else {
    body.mesh = existing_file(table.text("mesh"), table.place("mesh"), folder);
    body.unit_m = table.number("unit_m", 1.0);
  }
  body.material = material_named(scene, table.text("material"), table.place("material"));
  body.model = *enum_from_text<BodyModel>(table.choice("model", {"rigid", "breakable", "cracking", "modal"}));
  body.position_m = table.vector("position_m", body.position_m);
  body.rotation_deg = table.vector("rotation_deg", body.rotation_deg);
  body.velocity_m_s = table.vector("velocity_m_s", body.velocity_m_s);
  body.angular_velocity_rad_s = table.vector("angular_velocity_rad_s", body.angular_velocity_rad_s);
  body.fixed = table.boolean("fixed", false);
  body.max_edge_m = table.number("max_edge_m", 0.0);
  body.modes_to_hz = table.optional_number("modes_to_hz");
  read_breaking(table, scene, body);
  if (table.has("crack") && body.model != BodyModel::kCracking)
    throw InputError(table.place("crack"), "belongs to a cracking body", body.name, "model = \"cracking\"");
  if (table.has("modal") && body.model != BodyModel::kModal)
    throw InputError(table.place("modal"), "belongs to a modal body", body.name, "model = \"modal\"");
  if ((body.model == BodyModel::kCracking || body.model == BodyModel::kModal) && body.fixed)
    throw InputError(table.place("fixed"), "a cracking or modal body is held by holds", body.name,
                     "[[hold]] where = ..., kind = \"position\"");
  body.sound = *enum_from_text<BodySound>(table.choice("sound", {"auto", "modes", "proxy", "none"}));
  return body;
}

void read_solver(const TomlTable& root, Scene& scene) {
  const TomlTable solver = root.table("solver");
  rigid::RigidWorldOptions& options = scene.solver;
  options.rate_hz = solver.number("rate_hz", options.rate_hz);
  const double iterations = solver.number("iterations", options.iterations);
  if (iterations != std::floor(iterations))
    throw InputError(solver.place("iterations"), "is no whole number", to_text(iterations));
  options.iterations = static_cast<int>(iterations);
  options.collisions =
      *enum_from_text<rigid::CollisionOrder>(solver.choice("collisions", {"pairwise", "simultaneous"}));
  scene.pose_rate_hz = solver.number("pose_rate_hz", scene.pose_rate_hz);
  const TomlTable world = root.table("world");
  options.gravity_m_s2 = world.vector("gravity_m_s2", options.gravity_m_s2);
  if (world.has("floor")) {
    const TomlTable floor = world.table("floor");
    scene.floor_material = material_named(scene, floor.text("material"), floor.place("material"));
    options.floor = skin_of(scene.materials[static_cast<std::size_t>(*scene.floor_material)]);
    if (floor.has("sound")) scene.floor_sound = detail::read_floor_sound(floor.table("sound"));
  }
}

/// The floor is a half-space that nobody stands in.
void refuse_below_floor(const TomlTable& table, const SceneListener& listener) {
  double lowest_m = listener.position_m.z();
  for (const ListenerKey& key : listener.path) lowest_m = std::min(lowest_m, key.position_m.z());
  if (lowest_m < 0.0)
    throw InputError(table.place("position_m"), "the listener is below the floor", to_text(lowest_m) + " m",
                     "z of 0 and above, or no world.floor");
}

}  // namespace

Scene parse_scene(std::string_view toml, const std::filesystem::path& file) {
  const TomlTable root = TomlTable::parse(toml, file.filename().string(), schema());
  const std::filesystem::path folder = file.parent_path();
  Scene scene;
  scene.file = file;
  scene.name = root.text("name", file.stem().string());
  scene.duration_s = root.optional_number("duration_s");
  scene.longest_s = root.number("longest_s", scene.longest_s);
  for (const TomlTable& table : root.tables("material", 1, kMostMaterials)) {
    SceneMaterial material = read_scene_material(table, folder);
    for (const SceneMaterial& other : scene.materials)
      if (other.name == material.name)
        throw InputError(table.place("name"), "is given twice", material.name, "a name of its own");
    scene.materials.push_back(std::move(material));
  }
  read_solver(root, scene);
  for (const TomlTable& table : root.tables("body", 1, kMostBodies)) {
    scene.bodies.push_back(read_body(table, folder, scene));
    SceneBody& body = scene.bodies.back();
    if (body.model == BodyModel::kCracking)
      body.crack =
          detail::read_crack(root.table("crack"), table.table("crack"), scene.material_of(body), table.place());
    if (body.model == BodyModel::kModal) body.modal = detail::read_modal(root.table("modal"), table.table("modal"));
  }
  scene.holds = detail::read_holds(root, scene, folder);
  scene.joints = detail::read_joints(root, scene);
  scene.links = detail::read_links(root, scene);
  if (scene.has_deforming_bodies() && !scene.duration_s)
    throw InputError(root.place("duration_s"), "is missing", "",
                     "a scene with cracking or modal bodies says how long it lasts");
  detail::read_sound(root.table("sound"), folder, scene.sound);
  if (scene.floor_material) refuse_below_floor(root.table("sound").table("listener"), scene.sound.listener);
  if (scene.floor_sound && !scene.sound.listener.path.empty())
    throw InputError(root.table("sound").place("listener"), "walks: a floor with sound is heard from one place", "",
                     "position_m, or no world.floor.sound");
  for (const SceneBody& body : scene.bodies)
    if (body.sound == BodySound::kProxy && scene.sound.bank.empty())
      throw InputError(body.place, "sound = \"proxy\" needs a soundbank", body.name, "sound.bank = FILE");
  scene.frames = detail::read_frames(root.table("frames"));
  read_fracture(root.table("fracture"), scene.fracture);
  scene.force_model = *enum_from_text<ForceModel>(
      root.table("fracture").choice("force_model", {"hertz", "impulse_over_step", "authors_code"}));
  return scene;
}

Scene read_scene(const std::filesystem::path& toml) {
  return parse_scene(read_file(toml, std::size_t{64} << 20), toml);
}

std::string scene_schema_markdown() { return toml_schema_markdown(schema()); }

}  // namespace klang::scene
