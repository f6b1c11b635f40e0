#pragma once
#include <cstddef>
#include <filesystem>

namespace klang::liquid_scene {

/// Looks through the files of an OpenFOAM case that a reader will parse (system/controlDict, polyMesh, folders of times; packed ones too):
/// brackets nest to 100 at most, and those of a text file close and hold text. VTK's parser descends once per bracket and has no end to it.
/// @return their bytes, unpacked. @throws InputError naming the file
std::size_t check_foam_case(const std::filesystem::path& folder);

/// The same of one file.
std::size_t check_foam_file(const std::filesystem::path& file);

}  // namespace klang::liquid_scene
