#include "fit/partial_table.hpp"
