#include "core/sound/scene/detail/deform_reader.hpp"

#include <cmath>
#include <limits>

#include "core/foundation/base/nearest_word.hpp"
#include "core/physics/solid/support.hpp"
#include "core/sound/scene/detail/link_reader.hpp"

namespace klang::scene::detail {
namespace {

constexpr double kInf = std::numeric_limits<double>::infinity();
constexpr std::size_t kMostHolds = 1000;

}  // namespace

std::vector<TomlField> crack_fields(const char* table) {
  using enum TomlType;
  return {
      {table, "strength_pa", kNumber, "the material's tensile_strength_pa", 0, 1e15,
       "normalised separation, or principal stress, at which a node parts", true},
      {table, "toughness_n", kNumber, "none", 0, 1e15,
       "instead: B99's tau, an eigenvalue in newtons; what it means depends on the mesh", true},
      {table, "criterion", kText, "`separation`", -kInf, kInf, "`separation` (B99's tensor) or `rankine`"},
      {table, "yield_stress_pa", kNumber, "none: it does not flow", 0, 1e13, "von Mises' yield stress"},
      {table, "plastic_strain_limit", kNumber, "0.243 with a yield stress", 0, 10,
       "largest norm of Green's plastic strain, below 0.6123"},
      {table, "gamma1", kNumber, "none", 0, 10, "instead of yield_stress_pa: D02's threshold"},
      {table, "gamma2", kNumber, "0.486 with gamma1", 0, 10,
       "instead of plastic_strain_limit: D02's limit, below 1.2247"},
      {table, "viscosity_lambda_pa_s", kNumber, "0", -1e9, 1e9, "B99's phi"},
      {table, "viscosity_mu_pa_s", kNumber, "0", 0, 1e9, "B99's psi"},
      {table, "snap", kNumber, "0.25", 0, 0.5,
       "cuts nearer to an edge's end than this share of the shortest edge go through it"},
      {table, "smallest_height", kNumber, "0.15", 0.01, 0.5,
       "share of the mean edge: cuts that would leave flatter elements go through nodes"},
      {table, "self_contact", kBoolean, "false", -kInf, kInf,
       "true: its pieces push one another, and it itself where it folds; else they pass through"},
      {table, "integrator", kText, "`leapfrog`", -kInf, kInf,
       "`leapfrog`, or B99's `euler` and `taylor`, which need viscosity"},
      {table, "literature", kText, "`mended`", -kInf, kInf,
       "`mended`, or `paper`: total stress decides, cracks run at any speed and start anywhere at once"},
  };
}

std::vector<TomlField> hold_fields() {
  using enum TomlType;
  return {
      {"hold", "body", kText, "required", -kInf, kInf, "a cracking or modal body"},
      {"hold", "where", kText, "this or at_m", -kInf, kInf,
       "nodes in the body's frame, as of supports: `x=min`, `z<0.01`, `box:...`"},
      {"hold", "at_m", kVector, "this or where", -1e4, 1e4, "the nearest node, in the body's frame"},
      {"hold", "kind", kText, "`position`", -kInf, kInf, "`position` (displacement), `velocity` or `acceleration`"},
      {"hold", "csv", kText, "required", -kInf, kInf,
       "columns time_s, x, y, z in the world's axes, linear between rows; relative to the scene"},
  };
}

std::vector<TomlField> joint_fields() {
  using enum TomlType;
  return {
      {"joint", "body", kText, "required", -kInf, kInf, "a modal body"},
      {"joint", "other", kText, "`world`", -kInf, kInf, "another modal body, or `world`"},
      {"joint", "at_m", kVector, "required", -1e4, 1e4,
       "in the first body's frame: its nearest corner, at most a tenth of its size away, and what is there of the "
       "other stay together"},
  };
}

CrackSettings read_crack(const TomlTable& scene, const TomlTable& own, const SceneMaterial& material,
                         const std::string& place) {
  const auto number = [&](const char* key) {
    return own.has(key) ? own.optional_number(key) : scene.optional_number(key);
  };
  const auto table_of = [&](const char* key) -> const TomlTable& { return own.has(key) ? own : scene; };
  CrackSettings settings;
  fracture::CrackOptions& crack = settings.crack;
  // A body's own strength or toughness goes before either of the scene's; so do its thresholds of flow.
  const TomlTable& limits = own.has("strength_pa") || own.has("toughness_n") ? own : scene;
  crack.strength_pa = limits.optional_number("strength_pa");
  crack.toughness_n = limits.optional_number("toughness_n");
  if (!crack.strength_pa && !crack.toughness_n) crack.strength_pa = material.tensile_strength_pa;
  crack.criterion =
      *enum_from_text<fracture::CrackCriterion>(table_of("criterion").choice("criterion", {"separation", "rankine"}));
  const bool own_flow =
      own.has("gamma1") || own.has("gamma2") || own.has("yield_stress_pa") || own.has("plastic_strain_limit");
  const TomlTable& flow = own_flow ? own : scene;
  settings.plasticity = {flow.optional_number("gamma1"), flow.optional_number("gamma2"),
                         flow.optional_number("yield_stress_pa"), flow.optional_number("plastic_strain_limit")};
  settings.viscosity_lambda_pa_s = number("viscosity_lambda_pa_s").value_or(0.0);
  settings.viscosity_mu_pa_s = number("viscosity_mu_pa_s").value_or(0.0);
  settings.self_contact = table_of("self_contact").boolean("self_contact", settings.self_contact);
  crack.snap = number("snap").value_or(crack.snap);
  crack.smallest_height = number("smallest_height").value_or(crack.smallest_height);
  settings.integrator = *enum_from_text<fracture::Integrator>(
      table_of("integrator").choice("integrator", {"leapfrog", "euler", "taylor"}));
  const double phi = settings.viscosity_lambda_pa_s, psi = settings.viscosity_mu_pa_s;
  if (!(3.0 * phi + 2.0 * psi >= 0.0))
    throw InputError(table_of("viscosity_lambda_pa_s").place("viscosity_lambda_pa_s"), "gives energy back",
                     to_text(phi), "-2/3 of viscosity_mu_pa_s, " + to_text(-2.0 / 3.0 * psi) + ", or more");
  if (settings.integrator != fracture::Integrator::kLeapfrog && !(psi > 0.0))
    throw InputError(table_of("integrator").place("integrator"), "grows at any step without viscosity (erratum 63)",
                     to_text(settings.integrator), "leapfrog, or a viscosity_mu_pa_s above 0");
  if (table_of("literature").choice("literature", {"mended", "paper"}) == "paper") {
    crack.total_stress = true;
    crack.speed_limit = 0.0;
    crack.new_crack_factor = 1.0;
    crack.follows_plane = false;
  }
  located(place, [&] {
    crack.validate();
    fracture::read_plasticity(settings.plasticity, material.elastic,
                              {"gamma1", "gamma2", "yield_stress_pa", "plastic_strain_limit"});
    return 0;
  });
  return settings;
}

std::vector<TomlField> modal_fields(const char* table) {
  using enum TomlType;
  return {
      {table, "n_modes", kNumber, "20", 0, 1000, "elastic modes from the lowest"},
      {table, "residual_flexibility", kBoolean, "false", -kInf, kInf,
       "discarded modes are springs of their static compliance between body and floor, instead of stiff; no "
       "restitution then"},
      {table, "contact", kText, "`lcp`", -kInf, kInf,
       "`lcp`, or `lp`: H03's linear program, without friction (erratum 71)"},
  };
}

ModalSettings read_modal(const TomlTable& scene, const TomlTable& own) {
  const auto table_of = [&](const char* key) -> const TomlTable& { return own.has(key) ? own : scene; };
  ModalSettings settings;
  const TomlTable& modes = table_of("n_modes");
  const double n = modes.number("n_modes", settings.n_modes);
  if (n != std::floor(n)) throw InputError(modes.place("n_modes"), "is no whole number", to_text(n));
  settings.n_modes = static_cast<int>(n);
  settings.residual_flexibility =
      table_of("residual_flexibility").boolean("residual_flexibility", settings.residual_flexibility);
  settings.linear_program = table_of("contact").choice("contact", {"lcp", "lp"}) == "lp";
  return settings;
}

std::vector<SceneHold> read_holds(const TomlTable& root, const Scene& scene, const std::filesystem::path& folder) {
  std::vector<SceneHold> holds;
  for (const TomlTable& table : root.tables("hold", kMostHolds)) {
    SceneHold hold;
    hold.place = table.place();
    const std::string name = table.text("body");
    hold.body = -1;
    for (std::size_t i = 0; i < scene.bodies.size(); ++i)
      if (scene.bodies[i].name == name) hold.body = static_cast<int>(i);
    if (hold.body < 0) throw unknown_word(table.place("body"), "unknown body", name, name, body_names(scene));
    const BodyModel model = scene.bodies[static_cast<std::size_t>(hold.body)].model;
    if (model != BodyModel::kCracking && model != BodyModel::kModal)
      throw InputError(table.place("body"), "is no body that can be held", name, "model = \"cracking\" or \"modal\"");
    if (table.has("where") == table.has("at_m"))
      throw InputError(table.place(), table.has("where") ? "has where and at_m" : "says not where", name,
                       "where, or at_m");
    if (table.has("where")) {
      hold.where = table.text("where");
      located(table.place("where"), [&] {
        solid::parse_support("clamped:" + hold.where);
        return 0;
      });
    } else {
      hold.at_m = table.vector("at_m");
    }
    const auto kind =
        *enum_from_text<fracture::HoldKind>(table.choice("kind", {"position", "velocity", "acceleration"}));
    hold.csv = existing_file(table.text("csv"), table.place("csv"), folder);
    hold.path = fracture::HoldPath(kind, fracture::read_hold_rows(hold.csv), table.place("csv"));
    if (kind == fracture::HoldKind::kPosition && hold.path.displacement_m(0.0).norm() > 1e-9)
      throw InputError(table.place("csv"), "jumps at the start",
                       to_text(hold.path.displacement_m(0.0).norm()) + " m at 0 s", "a displacement of 0 at 0 s");
    holds.push_back(std::move(hold));
  }
  return holds;
}

std::vector<SceneJoint> read_joints(const TomlTable& root, const Scene& scene) {
  std::vector<SceneJoint> joints;
  const auto modal_body = [&](const TomlTable& table, const char* key, const std::string& name) {
    for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
      if (scene.bodies[i].name != name) continue;
      if (scene.bodies[i].model != BodyModel::kModal)
        throw InputError(table.place(key), "is no body that can be joined", name, "model = \"modal\"");
      return static_cast<int>(i);
    }
    throw unknown_word(table.place(key), "unknown body", name, name, body_names(scene));
  };
  for (const TomlTable& table : root.tables("joint", kMostHolds)) {
    SceneJoint joint;
    joint.place = table.place();
    joint.body = modal_body(table, "body", table.text("body"));
    if (table.has("other") && table.text("other") != "world")
      joint.other = modal_body(table, "other", table.text("other"));
    if (joint.other == joint.body) throw InputError(table.place("other"), "is joined to itself", table.text("body"));
    joint.at_m = table.vector("at_m");
    joints.push_back(std::move(joint));
  }
  return joints;
}

}  // namespace klang::scene::detail
