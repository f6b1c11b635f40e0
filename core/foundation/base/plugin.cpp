#include "core/foundation/base/plugin.hpp"

#include <dlfcn.h>

#include <filesystem>

namespace klang {

void* load_plugin(const std::string& name, bool deep) {
  namespace fs = std::filesystem;
  std::error_code ignored;
  const fs::path folder = fs::read_symlink("/proc/self/exe", ignored).parent_path();
  for (const fs::path& path : {folder / name, folder / KLANG_PLUGIN_FOLDER / name}) {
    if (!fs::exists(path, ignored)) continue;
    if (void* const handle = dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL | (deep ? RTLD_DEEPBIND : 0))) return handle;
  }
  return nullptr;
}

}  // namespace klang
