#include "core/sound/audio/versions.hpp"

#include <fftw3.h>
#include <samplerate.h>
#include <sndfile.h>

namespace klang::audio {

std::map<std::string, std::string> library_versions() {
  return {{"FFTW", fftw_version}, {"libsndfile", sf_version_string()}, {"libsamplerate", src_get_version()}};
}

}  // namespace klang::audio
