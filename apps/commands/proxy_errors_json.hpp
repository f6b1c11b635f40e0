#pragma once
#include <nlohmann/json_fwd.hpp>

namespace klang::fit {
struct ProxyErrors;
}

namespace klang::apps {

/// The measures by their names, units in these.
nlohmann::json proxy_errors_json(const fit::ProxyErrors& errors);

}  // namespace klang::apps
