#pragma once
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "core/foundation/config/result_header.hpp"
#include "validate/debris/debris_study.hpp"

/// study.json of `klang proxy study`.
namespace klang::validate {

struct PieceRecord {
  std::string name;
  double volume_m3 = 0.0;
  int elements = 0;
  std::optional<double> lowest_direct_hz;
  double lowest_hz = 0.0;
  int modes = 0, proxy_modes = 0;
  bool bank_too_short = false, clamped = false;
  std::array<double, 3> axes{};
  double scale_m = 0.0, cell_distance = 0.0, onset_s = 0.0;
  std::optional<fit::ProxyErrors> errors;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"name", "of the piece"}, self.name);
    visit({"volume_m3", "of the piece"}, self.volume_m3);
    visit({"elements", "of its mesh"}, self.elements);
    visit({"lowest_direct_hz", "of the mesh; null: no mode is heard"}, self.lowest_direct_hz);
    visit(needed({"lowest_hz", "by the single-frequency calculation"}), self.lowest_hz);
    visit({"modes", "that are heard, of the mesh"}, self.modes);
    visit({"proxy_modes", "the same of the proxy"}, self.proxy_modes);
    visit({"bank_too_short", "the bank's cell ends below the highest frequency"}, self.bank_too_short);
    visit({"clamped", "thinner than the bank"}, self.clamped);
    visit({"axes", "of the proxy, length 1"}, self.axes);
    visit({"scale_m", "of the axes"}, self.scale_m);
    visit({"cell_distance", "of its shape to the cell's"}, self.cell_distance);
    visit({"onset_s", "in the mix"}, self.onset_s);
    visit({"errors", "proxy against direct; null where one of them is silent"}, self.errors);
  }
};

struct ThresholdRecord {
  double threshold_hz = 0.0;
  int replaced = 0;
  double modes_replaced_percent = 0.0;
  std::optional<double> log_spectral_distance_db, mel_distance_db, third_octave_db, loudness_difference_db;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    describe_replaced(self, visit);
    describe_errors(self, visit);
  }
  template <class Self, class Visitor>
  static void describe_replaced(Self& self, Visitor&& visit) {
    visit(needed({"threshold_hz", "pieces whose lowest frequency lies above it sound by their proxies"}),
          self.threshold_hz);
    visit({"replaced", "pieces"}, self.replaced);
    visit(needed({"modes_replaced_percent", "of all modes"}), self.modes_replaced_percent);
  }
  template <class Self, class Visitor>
  static void describe_errors(Self& self, Visitor&& visit) {
    visit({"log_spectral_distance_db", "mix against the all-direct mix"}, self.log_spectral_distance_db);
    visit({"mel_distance_db", "in mel bands"}, self.mel_distance_db);
    visit({"third_octave_db", "levels, rms"}, self.third_octave_db);
    visit({"loudness_difference_db", "A-weighted energy, with proxies minus direct"}, self.loudness_difference_db);
  }
};

struct PieceTimes {
  std::string name;
  std::optional<double> direct_s, proxy_s;
  DirectTimes direct_stages;
  ProxyTimes proxy_stages;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"name", "of the piece"}, self.name);
    visit({"direct_s", "all stages"}, self.direct_s);
    visit({"proxy_s", "all stages"}, self.proxy_s);
    visit({"direct_stages", "of the direct way"}, self.direct_stages);
    visit({"proxy_stages", "of the proxy"}, self.proxy_stages);
  }
};

struct ThresholdTimes {
  double threshold_hz = 0.0;
  std::optional<double> direct_s, with_proxies_s;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"threshold_hz", "as above"}, self.threshold_hz);
    describe_times(self, visit);
  }
  template <class Self, class Visitor>
  static void describe_times(Self& self, Visitor&& visit) {
    visit({"direct_s", "all pieces directly"}, self.direct_s);
    visit({"with_proxies_s", "the single-frequency calculation of every piece included"}, self.with_proxies_s);
  }
};

/// All that does not come out the same again.
struct DebrisTimings {
  std::string what;
  std::vector<PieceTimes> pieces;
  std::vector<ThresholdTimes> thresholds;
  DirectTimes direct_stages;
  ProxyTimes proxy_stages;
  std::optional<double> preparation_s, direct_s, proxy_s, proxy_without_lowest_s, speedup, speedup_without_lowest;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"what", "is timed"}, self.what);
    visit({"pieces", "as above"}, self.pieces);
    visit({"thresholds", "as above"}, self.thresholds);
    visit({"direct_stages", "of all pieces"}, self.direct_stages);
    visit({"proxy_stages", "of all pieces"}, self.proxy_stages);
    visit({"preparation_s", "of the bank, once"}, self.preparation_s);
    visit({"direct_s", "of all pieces"}, self.direct_s);
    visit({"proxy_s", "of all pieces, preparation included"}, self.proxy_s);
    visit({"proxy_without_lowest_s", "without the single-frequency calculation"}, self.proxy_without_lowest_s);
    visit({"speedup", "direct over proxy"}, self.speedup);
    visit({"speedup_without_lowest", "without the single-frequency calculation"}, self.speedup_without_lowest);
  }
};

struct DebrisDocument {
  ResultHeader header;
  std::string loudness;
  std::vector<PieceRecord> pieces;
  std::vector<ThresholdRecord> thresholds;
  DebrisTimings timings;
  std::string direct_sound, proxy_sound;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    ResultHeader::describe(self.header, visit);
    visit({"loudness", "which"}, self.loudness);
    visit({"pieces", "one after the other"}, self.pieces);
    visit({"thresholds", "ascending: from all replaced to none"}, self.thresholds);
    visit({"timings", "do not come out the same again"}, self.timings);
    visit({"direct_sound", "beside the result: all pieces directly"}, self.direct_sound);
    visit({"proxy_sound", "beside the result: all pieces by proxies"}, self.proxy_sound);
  }
};

/// Names the sounds direct.wav and proxy.wav.
DebrisDocument debris_document(ResultHeader header, const DebrisStudyResult& result);

/// One row per threshold: threshold_hz, replaced, modes_replaced_percent, direct_s, with_proxies_s and the measures.
std::string thresholds_csv(const DebrisDocument& document);

}  // namespace klang::validate
