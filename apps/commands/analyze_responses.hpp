#pragma once
#include <string>

#include "apps/kit/command.hpp"
#include "core/foundation/base/conventions.hpp"

namespace klang::apps {

/// What `klang analyze` does with FRFs and free decays at several places.
struct ResponsesCommand {
  std::string file, output, csv;
  std::string modes;  ///< modal model whose shapes the measured ones are held against; empty: none
  bool whole = true;  ///< no band was asked for
  Band band;
  double a4_hz = 440.0;
};
int run_analyze_responses(const ResponsesCommand& options, const CommonOptions& common);

}  // namespace klang::apps
