#include "core/audio/sound_file.hpp"
