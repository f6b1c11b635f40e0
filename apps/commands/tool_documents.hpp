#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/foundation/config/result_header.hpp"
#include "core/sound/scene/heard_document.hpp"

/// Results of commands that write files of other kinds, and of `klang doctor`.
namespace klang::apps {

struct ReportDocument {
  ResultHeader header;
  std::string page;
  std::vector<std::string> files;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    ResultHeader::describe(self.header, visit);
    visit({"page", "that was written"}, self.page);
    visit({"files", "beside it"}, self.files);
  }
};

struct ExportedBankRecord {
  std::string name;
  std::int64_t n_partials = 0;
  double pitch_hz = 0.0;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"name", "of the specimen or recording"}, self.name);
    visit({"n_partials", "that were written"}, self.n_partials);
    visit({"pitch_hz", "the lowest of them that is not weak: what keys and scales start from"}, self.pitch_hz);
  }
};

struct ExportDocument {
  ResultHeader header;
  std::vector<ExportedBankRecord> banks;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    ResultHeader::describe(self.header, visit);
    visit({"banks", "of partials, one per thing"}, self.banks);
  }
};

struct DatasetDocument {
  ResultHeader header;
  JsonText truth;
  std::vector<std::string> recordings;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    ResultHeader::describe(self.header, visit);
    visit({"truth", "what the recipe made: parameters, partials or bubbles"}, self.truth);
    visit({"recordings", "files beside truth.json"}, self.recordings);
  }
};

struct SceneExportDocument {
  ResultHeader header;
  std::int64_t n_bubbles = 0;
  std::optional<std::int64_t> n_frames;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    ResultHeader::describe(self.header, visit);
    visit({"n_bubbles", "that were written"}, self.n_bubbles);
    visit(absent_if_empty({"n_frames", "with --vdb: frames that were written"}), self.n_frames);
  }
};

struct SceneSoundDocument {
  ResultHeader header;
  scene::HeardRecord sound;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    ResultHeader::describe(self.header, visit);
    visit({"sound", "as in scene.json"}, self.sound);
  }
};

struct DeviceRecord {
  int index = 0;
  std::string platform, name, kind;
  std::uint64_t compute_units = 0, memory_bytes = 0;
  bool double_precision = false;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"index", "for --device"}, self.index);
    visit({"platform", "OpenCL's"}, self.platform);
    visit({"name", "of the device"}, self.name);
    visit({"kind", "gpu, cpu or other"}, self.kind);
    visit({"compute_units", "that it has"}, self.compute_units);
    visit({"memory_bytes", "of its own"}, self.memory_bytes);
    visit({"double_precision", "whether it has numbers of 64 bits"}, self.double_precision);
  }
};

struct MpiRecord {
  bool built_in = false;
  std::optional<std::string> version;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"built_in", "whether mpirun shares jobs among processes"}, self.built_in);
    visit({"version", "null: none"}, self.version);
  }
};

struct DoctorDocument {
  ResultHeader header;
  int threads = 0;
  std::string display;
  bool xvfb = false;
  JsonText libraries;
  std::vector<DeviceRecord> devices, opencl_devices;
  MpiRecord mpi;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    ResultHeader::describe(self.header, visit);
    visit({"threads", "that are used"}, self.threads);
    visit({"display", "the environment's DISPLAY"}, self.display);
    visit({"xvfb", "whether pictures can be drawn without a display"}, self.xvfb);
    visit({"libraries", "name to version"}, self.libraries);
    visit({"devices", "of OpenCL"}, self.devices);
    visit({"opencl_devices", "the same, as it was called before"}, self.opencl_devices);
    visit({"mpi", "several processes"}, self.mpi);
  }
};

}  // namespace klang::apps
