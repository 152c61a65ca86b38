#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# The Python package's tests: makes a virtual environment in FOLDER, makes the source distribution of ROOT/python there,
# builds the wheel from that, installs it and runs pytest on it. The environment stays for the next run. Where it cannot
# be made (no venv module, no headers of Python, no package registry), the test is skipped and says so; a wheel that
# does not build or a failed test is a failure.
#
# usage: python.sh ROOT FOLDER [C_COMPILER [PYTEST_ARGUMENT ...]]
set -euo pipefail

root=$1
folder=$2
compiler=${3:-cc}
shift $(($# < 3 ? $# : 3))
venv=$folder/venv
log=$folder/log
mkdir -p "$folder"
export PIP_DISABLE_PIP_VERSION_CHECK=1 PYTHONDONTWRITEBYTECODE=1

skip()
{
    printf 'skipped: %s\n' "$*"
    exit 77
}

fail()
{
    tail -n 60 "$log"
    printf 'FAILED: %s\n' "$*"
    exit 1
}

command -v python3 >/dev/null || skip "python3 is not installed"
python3 -c 'import os, sys, sysconfig
sys.exit(not os.path.exists(os.path.join(sysconfig.get_path("include"), "Python.h")))' ||
    skip "the headers of Python are not installed (python3-dev)"

# What pyproject.toml asks for: to build, to run and to test. The stamp is written when all of it is there.
requirements=$(python3 - "$root/python/pyproject.toml" <<'END'
import ast, re, sys
text = open(sys.argv[1], encoding="utf-8").read()
for name in ("requires", "dependencies", "test"):
    print("\n".join(ast.literal_eval(re.search(rf"^{name} = (\[.*?\])", text, re.MULTILINE | re.DOTALL).group(1))))
END
)
if [[ $(cat "$venv/requirements" 2>/dev/null) != "$requirements" || ! -x $venv/bin/python ]]; then
    rm -rf "$venv"
    python3 -m venv "$venv" >"$log" 2>&1 || skip "python3 -m venv fails (python3-venv): $(tail -n 1 "$log")"
    mapfile -t packages <<<"$requirements"
    # Packages as wheels alone: what has none for this machine is missing, not compiled here.
    "$venv/bin/pip" install --only-binary :all: "${packages[@]}" >"$log" 2>&1 ||
        skip "packages cannot be installed: $(grep -m 1 ERROR "$log" || tail -n 1 "$log")"
    printf '%s\n' "$requirements" >"$venv/requirements"
fi

# Without isolation, since its environment has what pyproject.toml wants; so no network is needed from here on.
rm -rf "$folder/wheel" "$folder/unpacked"
mkdir "$folder/unpacked"
(cd "$root/python" && PYTHONPATH=native "$venv/bin/python" -c '
import sys, svocl_build
svocl_build.build_sdist(sys.argv[1])' "$folder/unpacked") >"$log" 2>&1 || fail "there is no source distribution"
tar -x -m -f "$folder"/unpacked/svocl-*.tar.gz -C "$folder/unpacked" --strip-components=1
# Files that are as they were keep their times, so that the build folder stays of use.
mkdir -p "$folder/source"
while IFS= read -r -d '' file; do
    ! cmp -s "$folder/source/$file" "$folder/unpacked/$file" ||
        touch -r "$folder/source/$file" "$folder/unpacked/$file"
done < <(cd "$folder/unpacked" && find . -type f -print0)
rm -rf "$folder/source"
mv "$folder/unpacked" "$folder/source"
# Unoptimized, which takes half as long to compile, for it is the binding that is tested.
CC=$compiler "$venv/bin/pip" wheel --no-build-isolation --no-deps --no-index -w "$folder/wheel" \
    --config-settings=build-dir="$folder/build" --config-settings=cmake.define.CMAKE_C_FLAGS_RELEASE=-O0 \
    "$folder/source" >"$log" 2>&1 || fail "the wheel does not build"
"$venv/bin/pip" install --force-reinstall --no-deps --no-index "$folder"/wheel/svocl-*.whl >"$log" 2>&1 ||
    fail "the wheel cannot be installed"
cd "$folder"
exec "$venv/bin/pytest" -c "$root/python/pyproject.toml" -p no:cacheprovider -q "$@" "$root/python/tests"
