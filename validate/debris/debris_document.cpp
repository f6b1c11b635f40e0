#include "validate/debris/debris_document.hpp"

#include "core/foundation/config/fields_csv.hpp"

namespace klang::validate {
namespace {

PieceRecord piece_record(const DebrisPieceResult& p) {
  PieceRecord record;
  record.name = p.name;
  record.volume_m3 = p.volume_m3;
  record.elements = p.n_elements;
  if (p.n_modes > 0) record.lowest_direct_hz = p.lowest_direct_hz;
  record.lowest_hz = p.lowest_hz;
  record.modes = p.n_modes;
  record.proxy_modes = p.n_proxy_modes;
  record.bank_too_short = p.bank_too_short;
  record.clamped = p.clamped;
  record.axes = {p.axes[0], p.axes[1], p.axes[2]};
  record.scale_m = p.scale_m;
  record.cell_distance = p.cell_distance;
  record.onset_s = p.onset_s;
  record.errors = p.errors;
  return record;
}

DebrisTimings timings_of(const DebrisStudyResult& result) {
  DebrisTimings timings;
  timings.what = "processor time of all threads";
  DirectTimes& direct = timings.direct_stages;
  ProxyTimes& proxy = timings.proxy_stages;
  for (const DebrisPieceResult& p : result.pieces) {
    timings.pieces.push_back({p.name, p.direct.total_s(), p.proxy.total_s(), p.direct, p.proxy});
    direct.mesh_s += p.direct.mesh_s;
    direct.modes_s += p.direct.modes_s;
    direct.transfer_s += p.direct.transfer_s;
    direct.audio_s += p.direct.audio_s;
    proxy.lowest_s += p.proxy.lowest_s;
    proxy.retrieval_s += p.proxy.retrieval_s;
    proxy.transfer_s += p.proxy.transfer_s;
    proxy.audio_s += p.proxy.audio_s;
  }
  for (const DebrisThreshold& t : result.thresholds)
    timings.thresholds.push_back({t.threshold_hz, t.direct_s, t.with_proxies_s});
  timings.preparation_s = result.preparation_s;
  timings.direct_s = result.direct_s;
  timings.proxy_s = result.proxy_s;
  timings.proxy_without_lowest_s = result.proxy_without_lowest_s;
  timings.speedup = result.direct_s / result.proxy_s;
  timings.speedup_without_lowest = result.direct_s / result.proxy_without_lowest_s;
  return timings;
}

/// A line of study.csv.
struct ThresholdRow {
  ThresholdRecord record;
  ThresholdTimes times;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    ThresholdRecord::describe_replaced(self.record, visit);
    ThresholdTimes::describe_times(self.times, visit);
    ThresholdRecord::describe_errors(self.record, visit);
  }
};

}  // namespace

DebrisDocument debris_document(ResultHeader header, const DebrisStudyResult& result) {
  DebrisDocument document;
  document.header = std::move(header);
  document.loudness =
      "A-weighted energy (IEC 61672-1); pieces: absolute difference, thresholds: with proxies minus direct";
  for (const DebrisPieceResult& piece : result.pieces) document.pieces.push_back(piece_record(piece));
  for (const DebrisThreshold& t : result.thresholds)
    document.thresholds.push_back({t.threshold_hz, t.n_replaced, t.modes_replaced_percent, t.log_spectral_distance_db,
                                   t.mel_distance_db, t.third_octave_db, t.loudness_difference_db});
  document.timings = timings_of(result);
  document.direct_sound = "direct.wav";
  document.proxy_sound = "proxy.wav";
  return document;
}

std::string thresholds_csv(const DebrisDocument& document) {
  std::vector<ThresholdRow> rows;
  for (std::size_t i = 0; i < document.thresholds.size(); ++i)
    rows.push_back({document.thresholds[i], document.timings.thresholds.at(i)});
  return csv_table(rows);
}

}  // namespace klang::validate
