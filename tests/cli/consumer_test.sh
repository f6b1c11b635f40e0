#!/usr/bin/env bash
# Installs the build in $1 to a fresh prefix, builds tests/consumer ($2) against it and runs it.
set -euo pipefail
build=$1 consumer=$2
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
cmake --install "$build" --prefix "$scratch/prefix" > "$scratch/install.log" || { cat "$scratch/install.log"; exit 1; }
cmake -S "$consumer" -B "$scratch/build" -G Ninja -DCMAKE_BUILD_TYPE=Release -DCMAKE_PREFIX_PATH="$scratch/prefix" \
  > "$scratch/configure.log" 2>&1 || { cat "$scratch/configure.log"; exit 1; }
cmake --build "$scratch/build" > "$scratch/build.log" 2>&1 || { cat "$scratch/build.log"; exit 1; }
"$scratch/build/consumer"
mkdir "$scratch/wrong"
printf 'cmake_minimum_required(VERSION 3.22)\nproject(wrong CXX)\nfind_package(klangprobe COMPONENTS fitt modal modall)\nmessage(STATUS "SAID ${klangprobe_NOT_FOUND_MESSAGE}")\n' > "$scratch/wrong/CMakeLists.txt"
cmake -S "$scratch/wrong" -B "$scratch/wrong/build" -DCMAKE_PREFIX_PATH="$scratch/prefix" 2>&1 | grep 'SAID klangprobe has no component fitt, modall$'
"$scratch/prefix/bin/klang" --version
