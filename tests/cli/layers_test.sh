#!/usr/bin/env bash
# Layers are enforced by link targets: a file that sees only one layer's include folders cannot include a layer above it.
# $1: build folder, $2: compiler
set -uo pipefail
build=$1 compiler=$2
compiles() {  # compiles LAYERS... -- HEADER
  local flags=() header
  while [ "$1" != "--" ]; do flags+=("-I$build/layers/$1"); shift; done
  header=$2
  echo "#include \"$header\"" | "$compiler" -std=c++20 -fsyntax-only -I/usr/include/eigen3 "${flags[@]}" -x c++ - 2>/dev/null
}
failed=0
expect() { # expect yes|no LAYERS -- HEADER
  local want=$1; shift
  if compiles "$@"; then got=yes; else got=no; fi
  [ $want = $got ] || { echo "expected $want, got $got: $*"; failed=1; }
}
expect yes base audio -- core/audio/signal.hpp
expect no base audio -- core/mesh/tet_mesh.hpp
expect yes base mesh -- core/mesh/shape.hpp
expect no base mesh -- core/solid/material.hpp
expect yes base audio mesh solid modal -- core/modal/oscillator_bank.hpp
expect no base audio mesh solid modal -- fit/partial_table.hpp
expect yes base audio bubble -- core/bubble/bubble_physics.hpp
expect no base audio bubble -- fit/fit.hpp
expect yes base audio mesh solid modal acoustics soundbank -- core/soundbank/proxy.hpp
expect no base audio mesh solid modal acoustics soundbank -- fit/fit.hpp
expect yes base audio mesh solid modal fit -- fit/fit.hpp
expect no base audio mesh solid modal fit -- reports/report.hpp
expect no base audio mesh solid modal datasets -- fit/fit.hpp
expect yes base mesh validate -- validate/study.hpp
expect yes base audio mesh solid modal acoustics dual_domain -- core/bubble/dual_domain/dual_domain.hpp
expect no base audio mesh solid modal acoustics dual_domain -- core/bubble/bubble_physics.hpp
expect no base audio mesh solid modal acoustics fit datasets validate -- reports/report.hpp
exit $failed
