#pragma once
#include <string>

#include "core/foundation/config/result_docs.hpp"

namespace klang {

/// A kind of result as JSON Schema (draft 2020-12): docs/schema/KIND.schema.json. `kind` (this one) and `schema_version` must be
/// there; what was not measured is null, so that null is allowed for all else; keys of later versions may stand beside.
std::string result_schema(const ResultKind& kind);

}  // namespace klang
