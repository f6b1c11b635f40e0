#pragma once
#include <cstddef>
#include <cstring>
#include <string>
#include <string_view>
#include <vector>

namespace klang::mesh {

/// Reads words and raw numbers from a file's bytes and refuses, with the place, what is not there. Nothing is
/// allocated from a count before count() has seen that the file is long enough for it.
class ByteCursor {
 public:
  ByteCursor(std::string_view bytes, std::string name) : bytes_(bytes), name_(std::move(name)) {}

  std::size_t position() const { return at_; }
  std::size_t remaining() const { return bytes_.size() - at_; }
  void seek(std::size_t position) { at_ = position; }
  /// Characters that start a comment up to the end of the line, for skip_blanks and word.
  void set_comment(char comment) { comment_ = comment; }

  /// Skips blanks, line breaks and comments; false at the end of the file.
  bool skip_blanks();
  /// The rest of the line without its break; the cursor goes to the next line. Empty at the end of the file.
  std::string_view line();
  /// The next word between blanks; fails at the end of the file.
  std::string_view word(std::string_view what);
  /// The next word, empty at the end of the file; does not move.
  std::string_view peek_word();
  double number(std::string_view what);
  long long integer(std::string_view what);
  /// An integer >= 0 of items that take at least bytes_each bytes of what is left in the file.
  std::size_t count(std::string_view what, std::size_t bytes_each);
  /// The same check for a count read otherwise.
  std::size_t checked_count(double n, std::string_view what, std::size_t bytes_each);
  /// A raw value; swapped turns its bytes round.
  template <class T>
  T raw(std::string_view what, bool swapped = false) {
    need(sizeof(T), what);
    char buffer[sizeof(T)];
    for (std::size_t i = 0; i < sizeof(T); ++i) buffer[i] = bytes_[at_ + (swapped ? sizeof(T) - 1 - i : i)];
    at_ += sizeof(T);
    T value;
    std::memcpy(&value, buffer, sizeof(T));
    return value;
  }
  void skip(std::size_t n_bytes, std::string_view what);
  void need(std::size_t n_bytes, std::string_view what);

  /// Text formats fail with a line number (from 1), binary ones with a byte.
  void set_binary(bool binary) { binary_ = binary; }
  [[noreturn]] void fail(std::string_view problem, std::string_view value = {}, std::string_view allowed = {}) const;
  const std::string& name() const { return name_; }

 private:
  std::string_view bytes_;
  std::string name_;
  std::size_t at_ = 0;
  char comment_ = '\0';
  bool binary_ = false;
};

/// Splits a line at blanks.
std::vector<std::string_view> split_words(std::string_view line);
bool parse_number(std::string_view word, double& value);
bool parse_integer(std::string_view word, long long& value);
/// Lower-case extension with its dot.
std::string lower_case(std::string_view text);

}  // namespace klang::mesh
