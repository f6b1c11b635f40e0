#include "apps/commands/proxy_errors_json.hpp"

#include <nlohmann/json.hpp>

#include "fit/proxy/proxy_sound.hpp"

namespace klang::apps {

nlohmann::json proxy_errors_json(const fit::ProxyErrors& e) {
  return {{"partial_rms_cents", e.partial_rms_cents},
          {"log_spectral_distance_db", e.log_spectral_distance_db},
          {"mel_distance_db", e.mel_distance_db},
          {"third_octave_db", e.third_octave_db},
          {"loudness_difference_db", e.loudness_difference_db},
          {"decay_rms_percent", e.decay_rms_percent}};
}

}  // namespace klang::apps
