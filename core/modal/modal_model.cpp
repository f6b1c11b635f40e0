#include "core/modal/modal_model.hpp"
