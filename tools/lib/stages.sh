# Sourced by tools/test, tools/check and .ci/run. stage NAME COMMAND...: runs the command as a named stage, prints its time
# and ends the script where it fails. A stage that the surrounding script has already passed is not run again.
stage() {
  local name=$1 start=$SECONDS code
  shift
  if [[ " ${KLANG_STAGES_DONE:-} " == *" $name "* ]]; then
    echo "stage $name: passed above"
    return
  fi
  echo "== stage $name =="
  set +e  # not "if": within a condition the command's own "set -e" would not hold
  (set -e; "$@")
  code=$?
  set -e
  if [ $code -ne 0 ]; then
    echo "stage $name: FAILED with $code, $((SECONDS - start)) s" >&2
    exit $code
  fi
  echo "stage $name: passed, $((SECONDS - start)) s"
  export KLANG_STAGES_DONE="${KLANG_STAGES_DONE:-} $name"
}
