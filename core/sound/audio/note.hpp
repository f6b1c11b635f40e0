#pragma once
#include <array>
#include <filesystem>
#include <string>
#include <string_view>

namespace klang::audio {

inline constexpr double kConcertPitchHz = 440.0;                    ///< A4 of ISO 16
inline constexpr double kLowestA4Hz = 300.0, kHighestA4Hz = 600.0;  ///< what is taken for an A4

/// A frequency by the nearest note of equal temperament.
struct NearestNote {
  std::string name;    ///< "F#4": sharps; C4 is the middle C
  double cents = 0.0;  ///< of the frequency above the note, -50 to 50
};
/// @param frequency_hz  > 0, finite
NearestNote nearest_note(double frequency_hz, double a4_hz = kConcertPitchHz);

/// Number of a key: 12 (octave + 1) + semitones above C, so that C4 = 60 and A4 = 69.
/// @param name  a letter, # or b (several), an octave from -1 to 11: "D5", "Bb3", "F##4"
/// @throws InputError with the name
int key_of_note(std::string_view name);

/// "F#4" of 66.
std::string note_of_key(int key);

/// Twelve degrees from C, by their ratios to it; A4 keeps its frequency.
class Temperament {
 public:
  static Temperament equal();  ///< 2^(i/12)
  /// Five-limit just intonation from C: 1, 16/15, 9/8, 6/5, 5/4, 4/3, 45/32, 3/2, 8/5, 5/3, 9/5, 15/8.
  static Temperament just();
  /// A Scala file (.scl, huygens-fokker.org/scala/scl_format.html) of twelve degrees, the last of which is the octave.
  /// @throws InputError with file and line: no such file, another number of degrees, degrees that do not rise from above 1/1
  static Temperament read_scala(const std::filesystem::path& path);
  /// "equal", "just" or the path of a .scl file. @throws InputError
  static Temperament parse(const std::string& text);

  double frequency_hz(int key, double a4_hz) const;
  const std::string& name() const { return name_; }

 private:
  std::string name_;
  std::array<double, 12> ratio_{};  ///< to C
  double octave_ = 2.0;
};

}  // namespace klang::audio
