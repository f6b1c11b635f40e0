#pragma once
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "reports/kit/result_data.hpp"
#include "reports/kit/svg_plot.hpp"
#include "reports/pages/figures.hpp"
#include "reports/pages/study_page.hpp"

namespace klang::reports::detail {

/// A picture of a mode shape, as a file beside the page and inside it.
struct ModePicture {
  int mode_index = 0;
  double frequency_hz = 0;
  std::string png;
  std::string file;   ///< name under figures/
  std::string twins;  ///< "and mode 1, its twin", or empty
  int width = 0, height = 0;
  bool tangential = false;  ///< coloured by the size of the motion
};

/// What a specimen's section shows besides numbers.
struct SpecimenMedia {
  std::optional<Svg> spectrogram;
  std::string recorded_wav, fitted_wav;  ///< clips for the players, empty without
  double clip_s = 0, gain = 1;
  bool cut = false;  ///< the clip is shorter than the recording
  std::vector<ModePicture> pictures;
};

struct PageParts {
  std::vector<Svg> ladders;
  std::optional<Svg> residuals, decays, spectrum, modes;
  StudyParts study;
  std::vector<CaptionedFigure> regression;                       ///< spectrum, levels over time, partials
  std::vector<CaptionedFigure> proxy;                            ///< partials, shape
  std::vector<std::pair<std::string, std::string>> proxy_clips;  ///< what it is, WAV
  std::vector<SpecimenMedia> media;                              ///< as data.specimens
  std::vector<std::string> warnings;                             ///< of the report itself
  std::vector<std::pair<std::string, std::string>> downloads;    ///< file beside the page, what it is
};

/// The whole page. The same input gives the same bytes.
std::string page_html(const ResultData& data, const PageParts& parts);

/// Sentences that say what came out; HTML, each without its paragraph tags.
std::vector<std::string> summary_sentences(const ResultData& data);

/// "Converged", "Not converged", ... and its kind for the eye ("good", "fair", "bad").
struct Verdict {
  std::string words, kind, details;
};
Verdict verdict(const ResultData& data);

/// What a result's computed sound is called: "Fitted model", "Resynthesis".
std::string fitted_words(const ResultData& data);

std::string page_css();
std::string page_script();

/// {"parameters.csv", text} and so on: SI units, shortest exact decimals, empty where not measured.
std::vector<std::pair<std::string, std::string>> csv_tables(const ResultData& data);

}  // namespace klang::reports::detail
