#pragma once
#include <string>

namespace klang {

/// A library of ours that is loaded where it is wanted, because its own links would cost every start of the program (OpenVDB: 0.1 s)
/// or would reach others (MPI). It lies beside the program or where packages put it (../lib/.../klangprobe).
/// @param name of the file, "klang_vdb.so"
/// @param deep that its own links' symbols come before those of the program
/// @return for dlsym; null where there is none or it cannot be loaded. Never unloaded
void* load_plugin(const std::string& name, bool deep = false);

}  // namespace klang
