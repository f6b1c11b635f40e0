#pragma once
#include <vector>

#include "validate/papers/papers.hpp"

/// The numbers of validate/papers, paper by paper; verdicts are given by the caller.
namespace klang::validate::detail {

std::vector<PaperNumber> rigid_body_sound_numbers(Monitor& monitor);  ///< S02
std::vector<PaperNumber> harmonic_fluid_numbers(Monitor& monitor);    ///< HF
std::vector<PaperNumber> soundbank_numbers(Monitor& monitor);         ///< SB
std::vector<PaperNumber> fracture_numbers(Monitor& monitor);          ///< SB (Tables 2, 3), B99, D02, H03
/// @param root  folder that has datasets-synthetic: runs of other scene files than there are not judged
std::vector<PaperScene> paper_scenes(const std::filesystem::path& runs, const std::filesystem::path& root = {});
std::vector<PaperGap> paper_gaps();

/// The number is arithmetic on the paper's own.
inline PaperNumber itself(PaperNumber number) {
  number.source = NumberSource::kPaper;
  return number;
}
/// The number is known from elsewhere.
inline PaperNumber elsewhere(PaperNumber number) {
  number.source = NumberSource::kElsewhere;
  return number;
}
/// Ours must be this, within a relative tolerance.
inline PaperNumber held(PaperNumber number, double reference, std::string source, double tolerance = 1e-6) {
  number.reference = reference;
  number.reference_source = std::move(source);
  number.reference_tolerance = tolerance;
  return number;
}

/// What a scene of a row must be: tests hold it against the file.
struct SceneFile {
  const char *scene, *name;
  double duration_s;
};
const std::vector<SceneFile>& scene_files();

/// One row of the chimes of S02, Table 2.
struct Chime {
  const char* printed_note;
  const char* note;  ///< that sounds
  int semitones;     ///< above A4 = 440 Hz
  double ideal_hz, length_m, measured_hz, computed_hz, adjusted_length_m, adjusted_hz;
};
const std::vector<Chime>& chimes();

}  // namespace klang::validate::detail
