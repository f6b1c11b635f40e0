#pragma once
#include <filesystem>

namespace klang::liquid_scene {

/// Looks through the files of an OpenFOAM case that a reader will parse (system/controlDict, polyMesh, folders of times; packed ones too):
/// brackets nest to 100 at most, and those of a text file close and hold text. VTK's parser descends once per bracket and has no end to it.
/// @throws InputError naming the file
void check_foam_case(const std::filesystem::path& folder);

/// The same of one file.
void check_foam_file(const std::filesystem::path& file);

}  // namespace klang::liquid_scene
