#include <cstdio>

#include "core/base/provenance.hpp"

int main() { std::printf("klang %s\n", klang::version().c_str()); }
