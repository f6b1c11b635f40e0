#include "core/foundation/base/nearest_word.hpp"

#include <algorithm>
#include <cctype>
#include <sstream>

namespace klang {
namespace {

constexpr std::size_t kLongestWord = 64, kShortestPart = 4;

std::string folded(std::string_view word) {
  std::string text(word);
  for (char& c : text) c = c == '_' ? '-' : static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

/// Optimal string alignment distance.
std::size_t distance_of(const std::string& a, const std::string& b) {
  std::vector<std::vector<std::size_t>> d(a.size() + 1, std::vector<std::size_t>(b.size() + 1));
  for (std::size_t i = 0; i <= a.size(); ++i) d[i][0] = i;
  for (std::size_t j = 0; j <= b.size(); ++j) d[0][j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    for (std::size_t j = 1; j <= b.size(); ++j) {
      d[i][j] = std::min({d[i - 1][j] + 1, d[i][j - 1] + 1, d[i - 1][j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1)});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
        d[i][j] = std::min(d[i][j], d[i - 2][j - 2] + 1);
    }
  }
  return d[a.size()][b.size()];
}

}  // namespace

std::string word_list(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text.append(text.empty() ? "" : ", ").append(word);
  return text;
}

std::string nearest_word(std::string_view word, const std::vector<std::string>& known) {
  if (word.empty() || word.size() > kLongestWord) return {};
  const std::string asked = folded(word);
  std::string nearest;
  std::size_t fewest = kLongestWord;
  const auto consider = [&](const std::string& folded_word, const std::string& candidate) {
    const std::size_t distance = distance_of(asked, folded_word);
    const std::size_t most = std::max(asked.size(), folded_word.size()) / 3;
    if (distance > most || distance >= fewest) return;
    fewest = distance;
    nearest = candidate;
  };
  for (const std::string& candidate : known)
    if (candidate.size() <= kLongestWord) consider(folded(candidate), candidate);
  if (!nearest.empty() || asked.size() < kShortestPart) return nearest;
  for (const std::string& candidate : known) {
    if (candidate.size() > kLongestWord) continue;
    std::istringstream parts(folded(candidate));
    for (std::string part; std::getline(parts, part, '-');)
      if (part.size() >= kShortestPart) consider(part, candidate);
  }
  return nearest;
}

std::string did_you_mean(std::string_view word, const std::vector<std::string>& known) {
  const std::string nearest = nearest_word(word, known);
  return nearest.empty() ? std::string() : "; did you mean " + nearest;
}

InputError unknown_word(std::string_view place, std::string_view problem, std::string_view value, std::string_view word,
                        const std::vector<std::string>& known) {
  const std::string said =
      InputError(place, problem, value, word_list(known)).what();  // with a hint where the value is the word
  const std::string hint = did_you_mean(word, known);
  return InputError(said.ends_with(hint) ? said : said + hint);
}

}  // namespace klang
