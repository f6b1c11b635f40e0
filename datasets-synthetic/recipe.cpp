#include "datasets-synthetic/recipe.hpp"
