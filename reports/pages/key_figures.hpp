#pragma once
#include <string>

namespace klang::reports::detail {

/// The few large numbers at the head of a page.
class KeyFigures {
 public:
  /// @param name, value, note  HTML; the note may be empty
  void add(const std::string& name, const std::string& value, const std::string& note = {});
  std::string html() const;  ///< empty without a figure

 private:
  std::string html_;
};

}  // namespace klang::reports::detail
