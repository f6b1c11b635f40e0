#include "apps/commands/regress_sound.hpp"

#include <CLI/CLI.hpp>
#include <filesystem>

#include "apps/kit/field_options.hpp"
#include "apps/kit/number_options.hpp"
#include "core/foundation/base/errors.hpp"
#include "core/foundation/base/json.hpp"
#include "core/sound/audio/sound_file.hpp"
#include "core/sound/stage/modal_voice.hpp"

namespace klang::apps {
namespace {

audio::Signal sound_of_model(const std::string& path, const RegressSoundOptions& options) {
  options.damping.validate();
  stage::SynthesisOptions synthesis;
  synthesis.duration_s = checked("command line", "--model-duration-s", options.model_duration_s, 0.1, 60.0);
  synthesis.sample_rate_hz = checked("command line", "--model-rate-hz", options.model_rate_hz, 1000.0, 768000.0);
  const modal::ModalModel model = modal::read_modal_model(path);
  const Eigen::VectorXd decays = decay_per_s(options.damping, model);
  if (!(decays.size() > 0 && decays.minCoeff() > 0.0)) {
    throw InputError(path, "a model needs damping to be held against a sound", "", damping_option_names());
  }
  audio::Signal sound =
      stage::synthesise(model, decays, read_strikes(options.strikes, options.model_duration_s, model), synthesis);
  const double peak = sound.samples.cwiseAbs().maxCoeff();
  if (!(peak > 0.0)) throw InputError(path, "the strikes excite no mode");
  sound.samples *= 0.5 / peak;
  sound.origin = path;
  return sound;
}

}  // namespace

void RegressSoundOptions::add_to(CLI::App& app, CommonOptions& common) {
  add_band_option(app, common, band, "LOW:HIGH in Hz in which partials are looked for");
  add_fields(app, common, description, {{"max_duration_s"}, {"min_snr_db"}});
  add_damping_options(app, damping);
  add_strike_option(app, strikes);
  app.add_option("--model-duration-s", model_duration_s, "Length of a model's sound")->capture_default_str();
  app.add_option("--model-rate-hz", model_rate_hz, "Sample rate of a model's sound")->capture_default_str();
}

validate::DescriptionOptions RegressSoundOptions::checked_description() const {
  validate::DescriptionOptions options = description;
  options.band = parse_band("--band-hz", band);
  options.validate();
  return options;
}

nlohmann::json RegressSoundOptions::used() const {
  nlohmann::json options = {{"band_hz", band},
                            {"max_duration_s", description.max_duration_s},
                            {"min_snr_db", description.min_snr_db},
                            {"model_duration_s", model_duration_s},
                            {"model_rate_hz", model_rate_hz}};
  damping.write(options);
  return options;
}

audio::Signal read_sound_or_model(const std::string& path, const RegressSoundOptions& options) {
  if (std::filesystem::path(path).extension() == ".vtu") return sound_of_model(path, options);
  return audio::read_sound(path);
}

}  // namespace klang::apps
