#pragma once
#include <string>

namespace klang::reports::detail {

std::string page_css();
std::string page_script();

}  // namespace klang::reports::detail
