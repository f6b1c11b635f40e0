#!/usr/bin/env bash
# Every reference file that a source quotes is in tests/reference, every file there is quoted, and nothing points elsewhere.
# $1: root of the project
set -uo pipefail
cd "$1" || exit 1
failed=0
cited=$(grep -rhoE 'tests/reference/[a-z_]+\.json' --include='*.cpp' --include='*.hpp' core fit validate reports tests | sort -u)
[ -n "$cited" ] || { echo "no source quotes a reference file"; exit 1; }
for file in $cited; do
  [ -f "$file" ] || { echo "$file is quoted and is not there"; failed=1; }
done
for file in tests/reference/*.json; do
  grep -qx "$file" <<< "$cited" || { echo "$file is quoted nowhere"; failed=1; }
done
outside=$(grep -rnE '(^|[^/a-z_])reference/[a-z_]+\.json' --include='*.cpp' --include='*.hpp' core fit validate reports tests)
[ -z "$outside" ] || { echo "reference files outside tests/reference:"; echo "$outside"; failed=1; }
exit $failed
