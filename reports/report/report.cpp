#include "reports/report/report.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/output_file.hpp"
#include "core/sound/audio/sound_file.hpp"
#include "reports/kit/audio_clip.hpp"
#include "reports/kit/raster.hpp"
#include "reports/kit/text.hpp"
#include "reports/pages/bubble_page.hpp"
#include "reports/pages/page.hpp"
#include "reports/pages/proxy_page.hpp"
#include "reports/pages/proxy_study_page.hpp"
#include "reports/pages/regression_page.hpp"
#include "reports/pages/spectrogram.hpp"
#include "reports/pages/study_figures.hpp"
#include "reports/scenes/field_files.hpp"
#include "reports/scenes/mode_pictures.hpp"
#include "reports/scenes/study_pictures.hpp"

namespace klang::reports {
namespace {

using namespace detail;

// What keeps a page under about 15 MB whatever the number of specimens.
constexpr std::size_t kMaxMedia = 12;
constexpr double kAudioBytes = 6e6, kLongestClipS = 10.0;
constexpr double kPngScale = 1.5;

class ReportWriter {
 public:
  ReportWriter(const std::filesystem::path& result_json, const ReportOptions& options, Monitor& monitor)
      : result_json_(result_json),
        folder_(result_json.parent_path().empty() ? "." : result_json.parent_path()),
        options_(options),
        monitor_(monitor),
        data_(read_result(result_json)) {}

  ReportResult write() {
    if (data_.kind == "study") return write_study();
    if (data_.kind == "regression") return write_regression();
    if (data_.kind == "papers") return write_papers();
    if (data_.kind == "proxy_study") return write_proxy_study();
    if (data_.kind == "proxy_fit") return write_proxy_fit();
    parts_.media.resize(data_.specimens.size());
    monitor_.progress("report", 0.0);
    plots();
    for (std::size_t i = 0; i < data_.specimens.size(); ++i) {
      monitor_.throw_if_stopped();
      sounds(i);
      monitor_.progress("report", 0.1 + 0.5 * static_cast<double>(i + 1) / static_cast<double>(data_.specimens.size()));
    }
    mode_shapes();
    monitor_.progress("report", 0.95);
    tables();
    list_downloads();
    finish();
    return std::move(result_);
  }

 private:
  ReportResult write_study() {
    monitor_.progress("report", 0.0);
    parts_.study.convergence = convergence_figures(data_.study);
    parts_.study.cost = cost_figures(data_.study);
    for (const auto* figures : {&parts_.study.convergence, &parts_.study.cost}) {
      for (const CaptionedFigure& figure : *figures) add_figure(figure.stem, figure.svg);
    }
    study_pictures();
    auto& list = parts_.downloads;
    list.emplace_back(result_json_.filename().string(), "– the result this page is made of");
    for (const auto& [name, what] :
         {std::pair{"levels.csv", "– every level"}, {"junit.xml", "– the claims for a test report"}}) {
      std::error_code ignored;
      if (std::filesystem::is_regular_file(folder_ / name, ignored)) list.emplace_back(name, what);
    }
    for (const StudyField& field : data_.study.fields) list.emplace_back(field.file, "– for ParaView");
    list.emplace_back("figures/", "– every figure as SVG and PNG");
    finish();
    return std::move(result_);
  }

  ReportResult write_proxy_study() {
    monitor_.progress("report", 0.0);
    add_figure("error", proxy_error_figure(data_.proxy_study));
    add_figure("time", proxy_time_figure(data_.proxy_study));
    const audio::Signal direct = sound_beside(data_.proxy_study.direct_sound),
                        proxy = sound_beside(data_.proxy_study.proxy_sound);
    if (direct.n_frames() >= 16 && proxy.n_frames() >= 16) {
      SpecimenMedia media;
      media.spectrogram = spectrogram_figure("the direct mix", direct, proxy, {}, spectrogram_range(direct, 20000.0),
                                             "Proxies", {}, "Direct");
      media.clip_s = std::min(kLongestClipS, kAudioBytes / 2 / (2 * std::min(48000.0, direct.sample_rate_hz)));
      media.cut = media.clip_s < direct.duration_s();
      media.gain = std::min(clip_gain(direct, media.clip_s), clip_gain(proxy, media.clip_s));
      media.recorded_wav = wav_clip(direct, media.clip_s, media.gain);
      media.fitted_wav = wav_clip(proxy, media.clip_s, media.gain);
      add_figure("spectrogram", *media.spectrogram);
      parts_.media.push_back(std::move(media));
    }
    auto& list = parts_.downloads;
    list.emplace_back(result_json_.filename().string(), "– the result this page is made of");
    std::error_code ignored;
    for (const auto& [name, what] : {std::pair{std::string("study.csv"), "– pieces and thresholds"},
                                     {data_.proxy_study.direct_sound, "– all pieces directly"},
                                     {data_.proxy_study.proxy_sound, "– all pieces by proxies"}})
      if (!name.empty() && std::filesystem::is_regular_file(folder_ / name, ignored)) list.emplace_back(name, what);
    list.emplace_back("figures/", "– every figure as SVG and PNG");
    finish();
    return std::move(result_);
  }

  ReportResult write_papers() {
    parts_.downloads.emplace_back(result_json_.filename().string(), "– the result this page is made of");
    std::error_code ignored;
    if (std::filesystem::is_regular_file(folder_ / "junit.xml", ignored))
      parts_.downloads.emplace_back("junit.xml", "– the claims for a test report");
    finish();
    return std::move(result_);
  }

  ReportResult write_proxy_fit() {
    const auto add = [&](const char* stem, Svg svg, const char* caption) {
      add_figure(stem, svg);
      parts_.proxy.push_back({std::move(svg), stem, caption});
    };
    add("partials", proxy_partials_figure(data_.proxy),
        "Above: the partials, amplitudes at the strike. Below: how far the proxies' partials lie above the body's, "
        "rank by rank.");
    add("shape", proxy_shape_figure(data_.proxy), "Sections through the ellipsoids, to one scale.");
    auto& list = parts_.downloads;
    list.emplace_back(result_json_.filename().string(), "– the result this page is made of");
    for (const auto& [file, what] :
         {std::pair{"target.wav", "Body"}, {"before.wav", "First proxy"}, {"after.wav", "Fitted proxy"}}) {
      const audio::Signal sound = sound_beside(file);
      if (sound.n_frames() == 0) continue;
      parts_.proxy_clips.emplace_back(what, wav_clip(sound, kLongestClipS, clip_gain(sound, kLongestClipS)));
      list.emplace_back(file, "– sound");
    }
    list.emplace_back("figures/", "– every figure as SVG and PNG");
    finish();
    return std::move(result_);
  }

  ReportResult write_regression() {
    monitor_.progress("report", 0.0);
    const auto add = [&](const char* stem, std::optional<Svg> svg, const char* caption) {
      if (!svg) return;
      add_figure(stem, *svg);
      parts_.regression.push_back({std::move(*svg), stem, caption});
    };
    add("spectrum", regression_spectrum_figure(data_.regression),
        "Partials at the strike, side by side, and mean third-octave levels, the noise taken off.");
    add("levels", regression_spectrogram_figure(data_.regression),
        "Levels in bands of a twelfth octave from the onset on. What lies under the floor (12 dB over the louder "
        "noise, or 50 dB under the loudest cell) is set to it, "
        "so that noise shows no difference.");
    add("partials", regression_partials_figure(data_.regression),
        "How far the partials lie from the reference. A mark outside its bar is a failed claim; hollow marks were not "
        "judged.");
    auto& list = parts_.downloads;
    list.emplace_back(result_json_.filename().string(), "– the result this page is made of");
    std::error_code ignored;
    if (std::filesystem::is_regular_file(folder_ / "junit.xml", ignored))
      list.emplace_back("junit.xml", "– the claims for a test report");
    list.emplace_back("figures/", "– every figure as SVG and PNG");
    finish();
    return std::move(result_);
  }

  /// Slices are drawn here, the rest by VTK in its own process; in the order of the result.
  void study_pictures() {
    std::vector<FieldPictureRequest> requests;
    std::vector<std::optional<Svg>> drawn(data_.study.fields.size());
    std::vector<std::size_t> asked;
    for (std::size_t i = 0; i < data_.study.fields.size(); ++i) {
      const StudyField& field = data_.study.fields[i];
      const std::filesystem::path file = beside(field.file);
      if (file.empty()) continue;
      if (field.kind == FieldKind::kSlice) {
        const auto slice = read_slice(file);
        if (slice) {
          drawn[i] = slice_figure(field, *slice);
        } else {
          result_.warnings.push_back(field.file + ": no slice that can be read, left out");
        }
      } else if (options_.pictures) {
        requests.push_back({file, field.kind});
        asked.push_back(i);
      }
    }
    monitor_.throw_if_stopped();
    const DrawnPictures rendered = render_fields(requests, monitor_);
    if (!rendered.warning.empty()) result_.warnings.push_back(rendered.warning);
    for (std::size_t k = 0; k < asked.size(); ++k) {
      const DrawnPicture& picture = rendered.pictures[k];
      if (picture.png.empty()) continue;
      drawn[asked[k]] = picture_figure(data_.study.fields[asked[k]], picture.png, picture.width, picture.height,
                                       picture.low, picture.high);
    }
    for (std::size_t i = 0; i < drawn.size(); ++i) {
      if (!drawn[i]) continue;
      add_figure(file_stem(data_.study.fields[i].name), *drawn[i]);
      parts_.study.pictures.push_back({data_.study.fields[i], std::move(*drawn[i])});
    }
  }

  void finish() {
    parts_.warnings = result_.warnings;
    add_file("report.html", page_html(data_, parts_));
    write_all();
    result_.page = folder_ / "report.html";
    monitor_.progress("report", 1.0);
  }

  void add_file(const std::string& name, std::string bytes) { output_.emplace_back(folder_ / name, std::move(bytes)); }

  /// The page comes last, so that it never points at what is not there yet; after a failure files that are
  /// new go again.
  void write_all() {
    std::error_code error;
    std::filesystem::create_directories(folder_ / "figures", error);
    if (error) throw InputError((folder_ / "figures").string(), "cannot be made", error.message());
    std::vector<std::filesystem::path> made;
    try {
      for (const auto& [path, bytes] : output_) {
        const bool is_new = !std::filesystem::exists(path);
        write_file(path, bytes);
        if (is_new) made.push_back(path);
        result_.files.push_back(path);
      }
    } catch (const std::exception&) {
      for (const std::filesystem::path& path : made) std::filesystem::remove(path, error);
      throw;
    }
  }

  void add_figure(const std::string& stem, const Svg& svg) {
    const std::string text = svg.standalone();
    add_file("figures/" + stem + ".svg", text);
    try {
      add_file("figures/" + stem + ".png", png_of_svg(text, kPngScale));
    } catch (const NumericalError& error) {
      result_.warnings.push_back(stem + ".png left out: " + error.what());
    }
  }

  void plots() {
    if (data_.kind == "fit") {
      for (std::size_t first = 0; first < data_.specimens.size() && first < 64; first += 8) {
        parts_.ladders.push_back(ladder_figure(data_, first, 8));
        add_figure(first == 0 ? "ladder" : "ladder-" + std::to_string(first / 8 + 1), parts_.ladders.back());
      }
      parts_.residuals = residual_figure(data_);
    }
    if (data_.kind == "bubbles") {
      parts_.decays = bubble_decay_figure(data_.bubbles);
    } else if (data_.kind != "modes") {
      parts_.decays = decay_figure(data_);
    }
    if (data_.kind == "analysis") parts_.spectrum = spectrum_figure(data_.specimens.front());
    if (data_.kind == "modes") parts_.modes = modes_figure(data_.specimens.front());
    if (parts_.residuals) add_figure("residuals", *parts_.residuals);
    if (parts_.decays) add_figure("decays", *parts_.decays);
    if (parts_.spectrum) add_figure("partials", *parts_.spectrum);
    if (parts_.modes) add_figure("modes", *parts_.modes);
  }

  /// A file that the result names, if it lies in the result's folder and is there.
  std::filesystem::path beside(const std::string& name) {
    if (name.empty()) return {};
    const std::filesystem::path path(name);
    const bool inside = path.is_relative() && std::find(path.begin(), path.end(), "..") == path.end();
    std::error_code ignored;
    if (!inside || !std::filesystem::is_regular_file(folder_ / path, ignored)) {
      result_.warnings.push_back(
          name + (inside ? ": no such file beside the result" : ": lies outside the result's folder") + ", left out");
      return {};
    }
    return folder_ / path;
  }

  audio::Signal sound_beside(const std::string& name) {
    const std::filesystem::path path = beside(name);
    if (path.empty()) return {};
    try {
      return loudest_channel(audio::read_sound(path));
    } catch (const InputError& error) {
      result_.warnings.push_back(std::string(error.what()) + "; left out");
      return {};
    }
  }

  std::string stem_of(std::size_t index) const {
    const std::string stem = file_stem(data_.specimens[index].name);
    for (std::size_t i = 0; i < data_.specimens.size(); ++i) {
      if (i != index && file_stem(data_.specimens[i].name) == stem) return stem + "-" + std::to_string(index + 1);
    }
    return stem;
  }

  void sounds(std::size_t index) {
    const Specimen& specimen = data_.specimens[index];
    SpecimenMedia& media = parts_.media[index];
    const audio::Signal recorded = sound_beside(specimen.recording), fitted = sound_beside(specimen.resynthesis);
    const audio::Signal& first = recorded.n_frames() > 0 ? recorded : fitted;
    if (first.n_frames() < 16) return;
    double highest = 0;
    for (const Partial& partial : specimen.partials) highest = std::max(highest, partial.frequency_hz);
    for (const BubbleRow& row : data_.bubbles.rows)
      highest = std::max({highest, row.frequency_start_hz, row.frequency_end_hz});
    const bool in_page = index < kMaxMedia;
    if (index == kMaxMedia) {
      result_.warnings.push_back("sounds and spectrograms of " +
                                 counted(data_.specimens.size() - kMaxMedia, "specimen", "specimens") +
                                 " are left out of the page to keep it small; they lie beside it");
    }
    const bool both = recorded.n_frames() > 0 && fitted.n_frames() >= 16;
    SpectrogramRange range = spectrogram_range(first, highest);
    if (data_.kind == "bubbles" && highest > 0) {
      double lowest = highest;
      for (const BubbleRow& row : data_.bubbles.rows)
        if (row.is_bubble) lowest = std::min({lowest, row.frequency_start_hz, row.frequency_end_hz});
      range.low_hz = std::clamp(0.6 * lowest, 100.0, 0.5 * range.high_hz);
    }
    Svg svg = spectrogram_figure(specimen.name.empty() ? "the recording" : specimen.name, first,
                                 both ? fitted : audio::Signal{}, specimen.strikes_s, range, fitted_words(data_),
                                 ridges_of(data_.bubbles));
    add_figure(data_.kind == "fit" ? "spectrogram-" + stem_of(index) : "spectrogram", svg);
    if (!in_page) return;
    media.spectrogram = std::move(svg);
    const double n_clips = 2.0 * static_cast<double>(std::min(kMaxMedia, data_.specimens.size()));
    const double rate = std::min(48000.0, first.sample_rate_hz);
    media.clip_s = std::min(kLongestClipS, kAudioBytes / n_clips / (2 * rate));
    media.cut = media.clip_s < first.duration_s();
    media.gain = clip_gain(first, media.clip_s);
    if (both) media.gain = std::min(media.gain, clip_gain(fitted, media.clip_s));
    if (recorded.n_frames() > 0) media.recorded_wav = wav_clip(recorded, media.clip_s, media.gain);
    if (fitted.n_frames() > 0) media.fitted_wav = wav_clip(fitted, media.clip_s, media.gain);
  }

  struct Wanted {
    std::size_t specimen;
    ModePicture picture;
  };

  /// A specimen's modes worth a picture: those that were heard, else all, by rising frequency; of twins the
  /// first.
  std::vector<ModePicture> candidates(const Specimen& specimen) const {
    std::vector<Predicted> modes;
    if (data_.kind == "modes") {
      for (const Mode& mode : specimen.modes) modes.push_back({specimen.name, mode.index, mode.frequency_hz, {}});
    } else {
      const SpecimenRows rows = rows_of(data_, specimen);
      std::set<int> heard;
      for (const Match& match : rows.matches) heard.insert(match.mode_index);
      for (const Predicted& mode : rows.predicted) {
        if (heard.empty() || heard.count(mode.mode_index)) modes.push_back(mode);
      }
    }
    std::vector<ModePicture> result;
    for (const Predicted& mode : modes) {
      if (mode.mode_index < 0) continue;
      if (!result.empty() && mode.frequency_hz < result.back().frequency_hz * 1.0003) {
        result.back().twins +=
            (result.back().twins.empty() ? " and its twin " : ", ") + std::to_string(mode.mode_index);
        continue;
      }
      ModePicture picture;
      picture.mode_index = mode.mode_index;
      picture.frequency_hz = mode.frequency_hz;
      result.push_back(std::move(picture));
    }
    return result;
  }

  void mode_shapes() {
    std::vector<std::vector<ModePicture>> candidates_of(data_.specimens.size());
    std::vector<std::filesystem::path> files(data_.specimens.size());
    for (std::size_t i = 0; i < data_.specimens.size(); ++i) {
      files[i] = beside(data_.specimens[i].modes_file);
      if (!files[i].empty()) candidates_of[i] = candidates(data_.specimens[i]);
    }
    if (!options_.pictures) return;
    // One mode of each specimen; then, where all are of one kind and would look alike, the first one's
    // others; then one more of each in turn until the number is reached.
    std::vector<Wanted> wanted;
    const auto limit = static_cast<std::size_t>(std::max(0, options_.max_mode_pictures));
    const auto& bodies = data_.specimens;
    const bool alike = std::all_of(bodies.begin(), bodies.end(), [&](const Specimen& s) {
      return !s.shape_kind.empty() && s.shape_kind == bodies.front().shape_kind;
    });
    if (alike && bodies.size() > 1) {
      for (std::size_t i = 0; i < bodies.size() && wanted.size() < limit; ++i) {
        if (candidates_of[i].empty()) continue;
        wanted.push_back({i, candidates_of[i].front()});
        candidates_of[i].erase(candidates_of[i].begin());
      }
      while (!candidates_of[0].empty() && wanted.size() < limit) {
        wanted.push_back({0, candidates_of[0].front()});
        candidates_of[0].erase(candidates_of[0].begin());
      }
    }
    for (std::size_t rank = 0; wanted.size() < limit; ++rank) {
      bool any = false;
      for (std::size_t i = 0; i < candidates_of.size() && wanted.size() < limit; ++i) {
        if (rank >= candidates_of[i].size()) continue;
        wanted.push_back({i, candidates_of[i][rank]});
        any = true;
      }
      if (!any) break;
    }
    if (wanted.empty()) return;
    std::vector<ModePictureRequest> requests;
    for (const Wanted& entry : wanted) requests.push_back({files[entry.specimen], entry.picture.mode_index});
    RenderResult rendered = render_modes(requests, monitor_);
    if (!rendered.warning.empty()) result_.warnings.push_back(rendered.warning);
    for (std::size_t k = 0; k < wanted.size(); ++k) {
      if (rendered.pictures[k].png.empty()) continue;
      ModePicture& picture = wanted[k].picture;
      std::string number = std::to_string(picture.mode_index);
      number.insert(0, number.size() < 4 ? 4 - number.size() : 0, '0');
      picture.file = data_.kind == "fit" ? "mode-" + stem_of(wanted[k].specimen) + "-" + number + ".png"
                                         : "mode-" + number + ".png";
      picture.png = std::move(rendered.pictures[k].png);
      picture.width = rendered.pictures[k].width;
      picture.height = rendered.pictures[k].height;
      picture.tangential = rendered.pictures[k].tangential;
      add_file("figures/" + picture.file, picture.png);
      parts_.media[wanted[k].specimen].pictures.push_back(std::move(picture));
    }
  }

  void tables() {
    for (const auto& table : csv_tables(data_)) {
      const std::string& name = table.first;
      // A user's own table of that name in this folder is an input and stays.
      std::error_code ignored;
      const bool taken = std::any_of(data_.inputs.begin(), data_.inputs.end(), [&](const ProvenanceInput& input) {
        return std::filesystem::path(input.path).filename() == name && std::filesystem::exists(folder_ / name, ignored);
      });
      add_file(taken ? "report-" + name : name, table.second);
      csv_files_.push_back(taken ? "report-" + name : name);
    }
  }

  void list_downloads() {
    auto& list = parts_.downloads;
    list.emplace_back(result_json_.filename().string(), "– the result this page is made of");
    for (const std::string& name : csv_files_) list.emplace_back(name, "– SI units");
    std::error_code ignored;
    for (const Specimen& specimen : data_.specimens) {
      const auto add = [&](const std::string& name, const char* what) {
        if (!name.empty() && std::filesystem::is_regular_file(folder_ / name, ignored)) list.emplace_back(name, what);
      };
      add(specimen.recording, "– recording");
      add(specimen.resynthesis, "– fitted model’s sound");
      add(specimen.modes_file, "– mode shapes for ParaView");
    }
    list.emplace_back("figures/", "– every figure as SVG and PNG");
  }

  std::filesystem::path result_json_, folder_;
  const ReportOptions& options_;
  Monitor& monitor_;
  ResultData data_;
  std::vector<std::pair<std::filesystem::path, std::string>> output_;
  PageParts parts_;
  ReportResult result_;
  std::vector<std::string> csv_files_;
};

}  // namespace

ReportResult write_report(const std::filesystem::path& result_json, const ReportOptions& options, Monitor& monitor) {
  return ReportWriter(result_json, options, monitor).write();
}

}  // namespace klang::reports
