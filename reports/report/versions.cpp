#include "reports/report/versions.hpp"

#include <librsvg/rsvg.h>

namespace klang::reports {

std::map<std::string, std::string> library_versions() {
  return {{"VTK", KLANG_VTK_VERSION},
          {"librsvg", std::to_string(LIBRSVG_MAJOR_VERSION) + "." + std::to_string(LIBRSVG_MINOR_VERSION) + "." +
                          std::to_string(LIBRSVG_MICRO_VERSION)}};
}

}  // namespace klang::reports
