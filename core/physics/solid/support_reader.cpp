#include "core/physics/solid/support_reader.hpp"

#include <limits>

#include "core/foundation/base/errors.hpp"

namespace klang::solid {

std::vector<TomlField> support_fields(std::string_view table) {
  constexpr double kInf = std::numeric_limits<double>::infinity();
  return {
      {table, "kind", TomlType::kText, "required", -kInf, kInf, "free, clamped or pinned"},
      {table, "where", TomlType::kText, "required unless free", -kInf, kInf,
       "`x=min`, `x=max`, `x=0.05`, `z>0.1`, `box:x0,y0,z0:x1,y1,z1` or `set:NAME`"},
  };
}

Support read_support(const TomlTable& body) {
  if (!body.has("support")) return {};
  if (body.is_text("support"))
    return located(body.place("support"), [&] { return parse_support(body.text("support")); });
  const TomlTable table = body.table("support");
  const auto kind = table.optional_text("kind"), where = table.optional_text("where");
  constexpr std::string_view kKinds = "free, clamped, pinned";
  if (!kind) throw InputError(table.place("kind"), "is missing", "", kKinds);
  if (*kind != "free" && *kind != "clamped" && *kind != "pinned")
    throw InputError(table.place("kind"), "unknown kind of support", *kind, kKinds);
  if (*kind == "free") {
    if (where) throw InputError(table.place("where"), "has no meaning for a free body", *where);
    return {};
  }
  if (!where) throw InputError(table.place("where"), "is missing");
  return located(table.place("where"), [&] { return parse_support(*kind + ":" + *where); });
}

}  // namespace klang::solid
