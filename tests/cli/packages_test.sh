#!/usr/bin/env bash
# Makes the Debian packages of the build in $1 and tries them in an empty root: what they hold, what they need, that the program runs from there.
set -euo pipefail
build=$1
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
fail() { echo "$*"; exit 1; }
# gzip: half of the time goes into packing with xz, as the packages are without it.
(cd "$build" && cpack -G DEB -D CPACK_DEBIAN_COMPRESSION_TYPE=gzip -B "$scratch" > "$scratch/cpack.log" 2>&1) || { cat "$scratch/cpack.log"; exit 1; }
program=$(ls "$scratch"/klangprobe_*.deb) library=$(ls "$scratch"/libklangprobe-dev_*.deb)
dpkg-deb -f "$program" Depends | grep -q libsndfile1 || fail "the program's libraries are not among what it depends on"
dpkg-deb -f "$library" Depends | grep -q libeigen3-dev || fail "libklangprobe-dev does not depend on libeigen3-dev"
if ls "$scratch"/klangprobe-mpi_*.deb > /dev/null 2>&1; then
  dpkg-deb -f "$scratch"/klangprobe-mpi_*.deb Depends | grep -q libopenmpi3 || fail "klangprobe-mpi does not depend on MPI"
  ! dpkg-deb -f "$program" Depends | grep -q mpi || fail "klangprobe depends on MPI"
  dpkg-deb -x "$program" "$scratch/root"
  dpkg-deb -x "$scratch"/klangprobe-mpi_*.deb "$scratch/root"
  "$scratch/root/usr/bin/klang" doctor | grep -q "Open MPI" || fail "the installed program does not find klang_mpi.so"
fi
dpkg-deb -x "$program" "$scratch/root"
dpkg-deb -x "$library" "$scratch/root"
[ ! -e "$build/apps/klang_vdb.so" ] || [ -n "$(find "$scratch/root/usr" -path '*/klangprobe/klang_vdb.so')" ] || fail "no klang_vdb.so"
for file in bin/klang share/man/man1/klang.1.gz share/man/man1/klang-bubble.1.gz share/man/man1/klang-bubble-fit.1.gz share/bash-completion/completions/klang \
    share/zsh/vendor-completions/_klang share/fish/vendor_completions.d/klang.fish share/doc/klangprobe/copyright \
    share/doc/libklangprobe-dev/copyright include/klangprobe/core/geometry/mesh/tet_mesh.hpp; do
  [ -s "$scratch/root/usr/$file" ] || fail "no /usr/$file"
done
! readelf -d "$scratch/root/usr/bin/klang" | grep -E 'R(UN)?PATH' || fail "the program has a run path"
"$scratch/root/usr/bin/klang" --version
"$scratch/root/usr/bin/klang" modes --shape rod --dims length_m=0.2,radius_m=0.005 --count 2 --quiet
bash -n "$scratch/root/usr/share/bash-completion/completions/klang"
bash -c "source '$scratch/root/usr/share/bash-completion/completions/klang'; COMP_WORDS=(klang bubble in); COMP_CWORD=2; _klang; [ \"\${COMPREPLY[0]}\" = info ]" \
  || fail "bash does not complete klang bubble in"
cat > "$scratch/CMakeLists.txt" <<'C'
cmake_minimum_required(VERSION 3.25)
project(asks LANGUAGES C CXX)
find_package(klangprobe REQUIRED COMPONENTS fit teapot)
C
! cmake -S "$scratch" -B "$scratch/asks" -DCMAKE_PREFIX_PATH="$scratch/root/usr" > "$scratch/asks.log" 2>&1 || fail "an unknown component was taken"
grep -q teapot "$scratch/asks.log" || { cat "$scratch/asks.log"; fail "the unknown component is not named"; }
echo "packages are whole"
