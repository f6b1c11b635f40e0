#pragma once
#include <optional>
#include <string>
#include <vector>

#include "core/foundation/config/result_header.hpp"
#include "fit/ringdown/bell.hpp"
#include "fit/ringdown/response_record.hpp"
#include "fit/ringdown/ringdown.hpp"

/// analysis.json of `klang analyze`: amplitude(t) = exp(-decay_per_s t), t from a strike.
namespace klang::fit {

/// Sounds beside a result.
struct SoundFiles {
  std::optional<std::string> recording, resynthesis;

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    visit({"recording", "as it was read"}, self.recording);
    visit({"resynthesis", "what was identified, as sound"}, self.resynthesis);
  }
};

struct AnalysisDocument {
  ResultHeader header;
  std::string name;
  std::optional<double> sample_rate_hz, duration_s;
  std::optional<int> n_channels;
  std::vector<double> strikes_s;
  std::optional<int> amplitude_strike;
  std::vector<std::vector<double>> strike_amplitudes;
  std::optional<double> explained_energy, noise_rms;
  std::optional<int> n_coder_images;
  std::vector<AnalysisPartial> partials;
  std::vector<Partial> steady_tones;
  std::optional<double> a4_hz;  ///< that the notes go by
  std::optional<Bell> bell;
  std::optional<SoundFiles> files;
  std::optional<ResponseRecord> responses;  ///< of FRFs and decays at several places

  template <class Self, class Visitor>
  static void describe(Self& self, Visitor&& visit) {
    ResultHeader::describe(self.header, visit);
    visit({"name", "of the recording"}, self.name);
    visit({"sample_rate_hz", "of the recording"}, self.sample_rate_hz);
    visit({"duration_s", "of the recording"}, self.duration_s);
    visit({"n_channels", "of the recording"}, self.n_channels);
    visit({"strikes_s", "from the recording's start"}, self.strikes_s);
    visit(absent_if_empty(
              {"amplitude_strike", "place in strikes_s of the strike at which the partials' amplitudes are told"}),
          self.amplitude_strike);
    visit({"strike_amplitudes", "[strike][partial], where there are several strikes"}, self.strike_amplitudes);
    visit({"explained_energy", "of the free ringing in band, 0 to 1"}, self.explained_energy);
    visit({"noise_rms", "rms of what the partials leave, full scale = 1, in band"}, self.noise_rms);
    visit(absent_if_empty(
              {"n_coder_images", "of a coded recording: images that its coder made of louder lines, left out"}),
          self.n_coder_images);
    visit({"partials", "ascending in frequency"}, self.partials);
    visit({"steady_tones", "what sounds in band and does not decay: no partials"}, self.steady_tones);
    visit(absent_if_empty({"a4_hz", "that the notes of the partials go by"}), self.a4_hz);
    visit(absent_if_empty({"bell", "with --bell: the partials that founders name"}), self.bell);
    visit(absent_if_empty({"files", "with -o: beside the result"}), self.files);
    visit(absent_if_empty({"responses",
                           "of FRFs and free decays at several places (.uff, .unv, .mat): what they were, stability "
                           "chart, estimators, modal assurance"}),
          self.responses);
  }
};
/// Without what only the recording knows: name, duration, channels, files. Partials and tones have their notes.
AnalysisDocument analysis_document(ResultHeader header, const RingdownResult& result,
                                   double a4_hz = audio::kConcertPitchHz);

}  // namespace klang::fit
