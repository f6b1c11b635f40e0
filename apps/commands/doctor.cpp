#include <CLI/CLI.hpp>
#include <cstdlib>
#include <memory>

#include "apps/commands/tool_documents.hpp"
#include "apps/kit/command.hpp"
#include "apps/kit/ranks.hpp"
#include "apps/kit/versions.hpp"
#include "core/foundation/base/json.hpp"
#include "core/foundation/base/parallel.hpp"
#include "core/foundation/base/provenance.hpp"
#include "core/foundation/config/fields_json.hpp"
#include "core/foundation/opencl/devices.hpp"

namespace klang::apps {
namespace {

int run_doctor(const CommonOptions& common) {
  const char* display = std::getenv("DISPLAY");
  const auto libraries = library_versions();
  const auto devices = opencl::devices();
  const bool has_xvfb = program_in_path("Xvfb");
  DoctorDocument document;
  document.header = make_header("doctor", "done", common, nlohmann::json::object(), {});
  document.threads = thread_count();
  document.display = display != nullptr ? display : "";
  document.xvfb = has_xvfb;
  nlohmann::json versions;
  say(common, "klang %s, %d threads\n\nlibraries\n", version().c_str(), thread_count());
  for (const auto& [name, text] : libraries) {
    versions[name] = text;
    say(common, "  %-14s %s\n", name.c_str(), text.c_str());
  }
  say(common, "\nOpenCL devices\n");
  for (std::size_t i = 0; i < devices.size(); ++i) {
    const opencl::Device& d = devices[i];
    document.devices.push_back(
        {static_cast<int>(i), d.platform, d.name, d.kind, d.compute_units, d.memory_bytes, d.double_precision});
    say(common, "  %zu: %s: %s (%s, %u compute units, %.1f GB, %s)\n", i, d.platform.c_str(), d.name.c_str(),
        d.kind.c_str(), d.compute_units, static_cast<double>(d.memory_bytes) / 1e9,
        d.double_precision ? "double precision" : "single precision only");
  }
  if (devices.empty()) say(common, "  none\n");
  document.opencl_devices = document.devices;
  document.libraries = {versions.dump()};
  const std::optional<std::string> mpi = mpi_version();
  document.mpi = {mpi.has_value(), mpi};
  say(common, "\nseveral processes\n  %s\n", mpi ? mpi->c_str() : "no MPI: klang runs as one process");
  say(common, "\npictures\n  DISPLAY %s; Xvfb %s\n", display != nullptr ? display : "is not set",
      has_xvfb ? "is installed" : "is NOT installed");
  if (display == nullptr && !has_xvfb) say(common, "  mode pictures will be left out: install the package xvfb\n");
  write_json(common, json_of(document));
  return kDone;
}

}  // namespace

Subcommand add_doctor(CLI::App& program, CommonOptions& common) {
  CLI::App* app = program.add_subcommand("doctor", "What is installed: libraries, OpenCL devices, display, threads");
  app->footer("Example:\n  klang doctor --json doctor.json");
  return {app,
          [&common] { return run_doctor(common); },
          {result_kind<DoctorDocument>("doctor", "the result of `klang doctor`")}};
}

}  // namespace klang::apps
