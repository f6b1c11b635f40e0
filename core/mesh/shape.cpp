#include "core/mesh/shape.hpp"
