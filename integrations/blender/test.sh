#!/usr/bin/env bash
# Tests of the extension with Blender as a Python module, in an environment of its own: .venv-blender
# at the root, made anew when a pinned version changes. Where Blender cannot be had, one line says
# why, and nothing fails.
set -euo pipefail
cd "$(dirname "$0")"
unset PYTHONPATH  # what is tested comes with the .zip
venv=$(cd ../.. && pwd)/.venv-blender
log=$(mktemp)
trap 'rm -f "$log"' EXIT

skip() {
  echo "test-blender: skipped, $1"
  exit 0
}

if ! cmp --silent requirements.txt "$venv/requirements.txt"; then
  for python in "${BLENDER_PYTHON:-python3.11}" python3; do
    command -v "$python" >/dev/null || continue
    "$python" -c 'import sys; sys.exit(sys.version_info[:2] != (3, 11))' && break
    python=
  done
  [ -n "$python" ] && command -v "$python" >/dev/null ||
    skip "Blender as a module needs Python 3.11 (set BLENDER_PYTHON to one)"
  "$python" -m venv --clear "$venv" >"$log" 2>&1 || skip "no environment: $(tail -n 1 "$log")"
  "$venv/bin/python" -m pip install --quiet --disable-pip-version-check --no-compile \
    -r requirements.txt >"$log" 2>&1 ||
    skip "Blender cannot be installed: $(grep -i error "$log" | tail -n 1)"
  cp requirements.txt "$venv/requirements.txt"
fi
"$venv/bin/python" -c 'import bpy' >"$log" 2>&1 || skip "Blender does not start: $(tail -n 1 "$log")"
exec "$venv/bin/python" -m pytest "$@"
