#pragma once
#include <vector>

#include "validate/papers/papers.hpp"

/// The numbers of validate/papers, paper by paper; verdicts are given by the caller.
namespace klang::validate::detail {

std::vector<PaperNumber> rigid_body_sound_numbers(Monitor& monitor);  ///< S02
std::vector<PaperNumber> harmonic_fluid_numbers(Monitor& monitor);    ///< HF
std::vector<PaperNumber> soundbank_numbers(Monitor& monitor);         ///< SB
std::vector<PaperNumber> fracture_numbers(Monitor& monitor);          ///< SB (Tables 2, 3), B99, D02, H03
std::vector<PaperScene> paper_scenes(const std::filesystem::path& runs);
std::vector<PaperGap> paper_gaps();

/// One row of the chimes of S02, Table 2.
struct Chime {
  const char* printed_note;
  const char* note;  ///< that sounds
  int semitones;     ///< above A4 = 440 Hz
  double ideal_hz, length_m, measured_hz, computed_hz, adjusted_length_m, adjusted_hz;
};
const std::vector<Chime>& chimes();

}  // namespace klang::validate::detail
