#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# wheel_root.sh WHEELS PROGRAM FOLDER [MIRROR]: whether the wheel in the folder WHEELS works where there is nothing but
# Python: in a clean Debian 12 without a compiler, a linker, development packages, an OpenCL loader, a driver, assimp or
# libzip. pip installs it as svocl[cpu,linker], which brings PoCL and the linker that it needs; then a mesh file gives
# the hash that PROGRAM gives here. Prints the seconds of both. Needs a mirror, PyPI, debootstrap, and root or sudo;
# without the last two it is skipped (77). FOLDER keeps the downloads and the log.
set -euo pipefail
readonly wheels=$1 program=$2 scene='scene:cube -d 6'
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
readonly here
# shellcheck source=tests/install/root.sh
source "$here/root.sh"

# step USER COMMAND: prints and logs what the command prints; it must succeed.
step()
{
    printf '$ %s\n' "$2" | tee -a "$log"
    enter "$1" "$2" >"$folder/output" 2>&1 || {
        cat "$folder/output" >>"$log"
        fail "failed: $2"
    }
    tee -a "$log" <"$folder/output" | tail -n 3
}

clean_root "$3" "${4:-http://deb.debian.org/debian}"
as_root mkdir "$root/wheels"
as_root cp "$wheels"/svocl-*manylinux*.whl "$here/consumer/hash.py" "$root/wheels/"
"$program" scene cube -o "$folder/cube.ply"
as_root mv "$folder/cube.ply" "$root/wheels/"
# shellcheck disable=SC2086 # words
hash=$("$program" hash $scene | grep -oE '[0-9a-f]{32}')
step root 'useradd -m visitor && apt-get -q update >/dev/null && apt-get -y -q install --no-install-recommends \
    python3-venv ca-certificates && update-ca-certificates && ! ls /usr/bin/*gcc* /usr/bin/*clang* /usr/bin/ld 2>&1'
begin=$SECONDS
# The certificates of the root, which has those of this machine.
step visitor "python3 -m venv venv && export PIP_CERT=/etc/ssl/certs/ca-certificates.crt &&
    venv/bin/pip install -q \$(echo /wheels/svocl-*.whl)[cpu,linker] && venv/bin/pip list"
installed=$SECONDS
step visitor 'venv/bin/python /wheels/hash.py /wheels/cube.ply 6'
grep -q "$hash\$" "$folder/output" || fail "the hash is not $hash"
printf 'wheel_root: passed: pip %d s, mesh and hash %d s\n' $((installed - begin)) $((SECONDS - installed))
rm_root
