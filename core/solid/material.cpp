#include "core/solid/material.hpp"
