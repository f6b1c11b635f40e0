#pragma once
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

/// Result folders as `klang fit`, `klang analyze` and `klang modes` leave them, made from closed formulas:
/// enough to build every part of a page without running a fit.
namespace klang::reports::fixture {

struct FitFixture {
  int n_specimens = 6;
  bool sounds = true;
  bool shapes = true;
  double sample_rate_hz = 48000;
  std::string first_name = "D3";
};

/// Writes folder/fit.json, recording-*.wav, resynthesis-*.wav and modes-*.vtu; gives back the JSON.
nlohmann::json write_fit(const std::filesystem::path& folder, const FitFixture& fixture = {});
/// Writes folder/analysis.json and its two sounds.
nlohmann::json write_analysis(const std::filesystem::path& folder);
/// Writes folder/modes.json and folder/modes.vtu.
nlohmann::json write_modes(const std::filesystem::path& folder);

}  // namespace klang::reports::fixture
