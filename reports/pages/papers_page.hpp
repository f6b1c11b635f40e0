#pragma once
#include <string>
#include <vector>

#include "reports/kit/result_data.hpp"

/// The page of `klang validate papers`.
namespace klang::reports::detail {

/// A paper's tables one after the other; not_computed at the end.
std::vector<std::pair<std::string, std::string>> papers_sections(const PapersData& data);  ///< name, HTML
std::string papers_key_figures(const PapersData& data);
std::vector<std::string> papers_sentences(const PapersData& data);

}  // namespace klang::reports::detail
