#pragma once
#include <string>
#include <vector>

#include "validate/studies/study.hpp"

namespace klang::validate {

/// A study: its name in CMakeLists.txt and a file NAME_study.cpp with a function NAME_study(), which gives the levels and their
/// errors; run_study judges them. A name with '_' is called with '-'.
struct KnownStudy {
  std::string name;
  Study (*run)(const StudyOptions& options, Monitor& monitor);
};
const std::vector<KnownStudy>& known_studies();

}  // namespace klang::validate
