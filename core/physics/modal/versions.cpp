#include "core/physics/modal/versions.hpp"

#include <Spectra/Util/Version.h>
#include <cholmod.h>
#include <dmumps_c.h>

extern "C" char* openblas_get_config(void);

namespace klang::modal {
namespace {

std::string dotted(int a, int b, int c) {
  return std::to_string(a) + "." + std::to_string(b) + "." + std::to_string(c);
}

}  // namespace

std::map<std::string, std::string> library_versions() {
  return {{"CHOLMOD", dotted(CHOLMOD_MAIN_VERSION, CHOLMOD_SUB_VERSION, CHOLMOD_SUBSUB_VERSION)},
          {"MUMPS", MUMPS_VERSION},
          {"OpenBLAS", openblas_get_config()},
          {"Spectra", dotted(SPECTRA_MAJOR_VERSION, SPECTRA_MINOR_VERSION, SPECTRA_PATCH_VERSION)}};
}

}  // namespace klang::modal
