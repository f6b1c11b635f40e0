#include <gtest/gtest.h>

#include "fixture.hpp"
#include "reports/report.hpp"

TEST(Report, T) {
  std::filesystem::path dir = "/tmp/rep/fit";
  klang::reports::fixture::write_fit(dir);
  auto r = klang::reports::write_report(dir / "fit.json");
  for (auto& w : r.warnings) std::puts(w.c_str());
  klang::reports::fixture::write_analysis("/tmp/rep/analysis");
  klang::reports::write_report("/tmp/rep/analysis/analysis.json");
  klang::reports::fixture::write_modes("/tmp/rep/modes");
  klang::reports::write_report("/tmp/rep/modes/modes.json");
}
