#include "core/sound/liquid_scene/foam_text.hpp"

#include <zlib.h>

#include <cstdlib>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "core/foundation/base/errors.hpp"

namespace klang::liquid_scene {
namespace {

constexpr std::size_t kDeepest = 100;  // cases have about ten
constexpr std::size_t kHeadBytes = 4096;

struct CloseFile {
  void operator()(gzFile_s* file) const { gzclose(file); }
};

/// Brackets outside comments and quotes, byte by byte.
class Brackets {
 public:
  /// @param binary: lists hold any bytes, so that a count goes from one byte that is no text to the next
  Brackets(const std::filesystem::path& file, bool binary) : file_(file), binary_(binary) {}

  void take(char c) {
    const char before = before_;
    before_ = c;
    const auto byte = static_cast<unsigned char>(c);
    if (byte < ' ' && c != '\n' && c != '\r' && c != '\t' && c != '\f' && c != '\v') {
      if (!binary_ && !rubbish_) rubbish_ = true;
      if (binary_) *this = Brackets(file_, true);
      return;
    }
    switch (within_) {
      case Within::kLine:
        if (c == '\n') within_ = Within::kText;
        return;
      case Within::kBlock:
        if (before == '*' && c == '/') within_ = Within::kText;
        return;
      case Within::kQuotes:
        if (c == '"' && before != '\\') within_ = Within::kText;
        return;
      case Within::kText:
        break;
    }
    if (before == '/' && c == '/') {
      within_ = Within::kLine;
    } else if (before == '/' && c == '*') {
      within_ = Within::kBlock;
      before_ = ' ';
    } else if (c == '"') {
      within_ = Within::kQuotes;
    } else if (c == '{' || c == '(') {
      open_.push_back(c);
      if (open_.size() > kDeepest)
        throw InputError(file_.string(), "its brackets nest too deep", "", "up to " + std::to_string(kDeepest));
    } else if (c == '}' || c == ')') {
      if (!open_.empty() && (open_.back() == '{') == (c == '}'))
        open_.pop_back();
      else
        uneven_ = true;
    }
  }
  void end() const {
    if (binary_) return;
    if (rubbish_) throw InputError(file_.string(), "holds bytes that are no text, and is not said to be binary");
    if (uneven_ || !open_.empty()) throw InputError(file_.string(), "its brackets do not close");
  }

 private:
  enum class Within { kText, kLine, kBlock, kQuotes };
  std::filesystem::path file_;
  bool binary_, rubbish_ = false, uneven_ = false;
  Within within_ = Within::kText;
  char before_ = ' ';
  std::vector<char> open_;
};

/// Whether the head's entry "format" is "binary".
bool says_binary(std::string_view head) {
  const std::size_t format = head.find("format");
  return format != std::string_view::npos &&
         head.substr(format, head.find(';', format) - format).find("binary") != std::string_view::npos;
}

/// polyMesh/boundary, packed or not: where another file stands there VTK's reader ends at a null pointer, or reads no fields.
bool is_boundary(const std::filesystem::path& file) {
  return file.parent_path().filename() == "polyMesh" && file.stem() == "boundary";
}

bool is_time(const std::string& name) {
  char* end = nullptr;
  std::strtod(name.c_str(), &end);
  return end != name.c_str() && *end == '\0';
}

}  // namespace

std::size_t check_foam_file(const std::filesystem::path& file) {
  const std::unique_ptr<gzFile_s, CloseFile> opened(gzopen(file.c_str(), "rb"));  // reads what is not packed as it is
  if (!opened) throw InputError(file.string(), "cannot be read");
  std::string block(std::size_t{1} << 16, '\0');
  std::unique_ptr<Brackets> brackets;
  bool is_foam = false;
  std::size_t size = 0;
  for (;;) {
    const int n = gzread(opened.get(), block.data(), static_cast<unsigned>(block.size()));
    if (n < 0) throw InputError(file.string(), "is damaged: it cannot be unpacked");
    if (n == 0) break;
    const std::string_view bytes(block.data(), static_cast<std::size_t>(n));
    if (!brackets) {
      const std::string_view head = bytes.substr(0, kHeadBytes);
      is_foam = head.find("FoamFile") != std::string_view::npos;
      if (is_foam && is_boundary(file) && head.find("polyBoundaryMesh") == std::string_view::npos)
        throw InputError(file.string(), "is damaged: it is no list of patches, class polyBoundaryMesh");
      brackets = std::make_unique<Brackets>(file, is_foam && says_binary(head));
    }
    size += bytes.size();
    for (const char c : bytes) brackets->take(c);
  }
  if (is_foam) brackets->end();  // other files in such folders are not read
  return size;
}

std::size_t check_foam_case(const std::filesystem::path& folder) {
  std::size_t size = check_foam_file(folder / "system" / "controlDict");
  std::error_code error;
  const auto look_through = [&](const std::filesystem::path& top, const auto& wanted) {
    for (auto it = std::filesystem::recursive_directory_iterator(top, error);
         !error && it != std::filesystem::recursive_directory_iterator(); it.increment(error))
      if (it->is_regular_file(error) && wanted(it->path())) size += check_foam_file(it->path());
  };
  look_through(folder / "constant",
               [](const std::filesystem::path& file) { return file.parent_path().filename() == "polyMesh"; });
  for (auto it = std::filesystem::directory_iterator(folder, error);
       !error && it != std::filesystem::directory_iterator(); it.increment(error))
    if (it->is_directory(error) && is_time(it->path().filename().string()))
      look_through(it->path(), [](const std::filesystem::path&) { return true; });
  return size;
}

}  // namespace klang::liquid_scene
