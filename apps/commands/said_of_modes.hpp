#pragma once
#include <optional>
#include <string>
#include <vector>

#include "apps/commands/scene_folder.hpp"

namespace klang::apps {

/// What was said when a body's modes were made (modes/STEM.json), which a run that finds them in its folder says again.
class SaidOfModes {
 public:
  /// @param folder  of the run; null: nothing is kept
  SaidOfModes(const SceneFolder* folder, const std::string& stem, const scene::SceneNotes& notes);
  SaidOfModes(const SaidOfModes&) = delete;
  SaidOfModes& operator=(const SaidOfModes&) = delete;

  /// Passes on what is said, and remembers it.
  const scene::SceneNotes& notes() const { return listening_; }
  /// Before the modes' own files are written, so that where they are it is.
  void keep(std::optional<double> mesh_error) const;
  /// @return the mesh's error as it was
  std::optional<double> say_again() const;

 private:
  const SceneFolder* folder_;
  std::string file_;
  scene::SceneNotes notes_, listening_;
  std::vector<std::string> warnings_;
};

}  // namespace klang::apps
