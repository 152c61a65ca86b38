#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# debian_root.sh PACKAGES PROGRAM FOLDER [MIRROR]: whether the .deb files in the folder PACKAGES install and run in a
# clean Debian 12, which debootstrap makes in FOLDER: the program and Python build an octree with the same hash as
# PROGRAM does here, svocl-lab checks one, a CMake project and a pkg-config command use the libraries, and nothing is
# left after a purge. Then the wheel in PACKAGES does the same as the Python package did. Needs a mirror, debootstrap,
# and root or sudo; without the last two it is skipped (77). FOLDER keeps the downloads and the log.
set -euo pipefail
readonly packages=$1 program=$2 scene='scene:cube -d 6'
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
readonly here
# shellcheck source=tests/install/root.sh
source "$here/root.sh"

# step WHAT USER COMMAND: prints and logs what the command prints; it must succeed.
step()
{
    printf '\n== %s\n$ %s\n' "$1" "$3" | tee -a "$log"
    enter "$2" "$3" >"$folder/output" 2>&1 || {
        cat "$folder/output" >>"$log"
        fail "failed: $3"
    }
    cat "$folder/output" >>"$log"
    if [[ $2 != root ]]; then
        cat "$folder/output"
    fi
}

# expect EXPRESSION: a line of the last step matches it.
expect()
{
    grep -q -E -- "$1" "$folder/output" || fail "no line of that matches $1"
}

clean_root "$3" "${4:-http://deb.debian.org/debian}"
as_root mkdir "$root/packages" "$root/consumer"
as_root cp "$packages"/*.deb "$packages"/svocl-*.whl "$root/packages/"
as_root cp "$here/consumer/CMakeLists.txt" "$here/consumer/hash.py" "$here/../../samples/01_minimal/main.c" \
    "$root/consumer/"

# The program, as its users install it: with what packages recommend.
step 'packages' root 'useradd -m visitor && apt-get -q update'
step 'the program' root 'apt-get -y -q install /packages/libsvocl[0-9]*.deb /packages/svocl_*.deb'
step 'its version' visitor 'svocl --version'
step 'an octree' visitor "svocl build $scene"
step 'its hash' visitor "svocl hash $scene"
# shellcheck disable=SC2086 # words
hash=$("$program" hash $scene | grep -oE '[0-9a-f]{32}')
expect "$hash"
step 'what it loads' visitor 'ldd /usr/bin/svocl && ! readelf -d /usr/bin/svocl 2>/dev/null | grep -i runpath'
expect 'libsvocl\.so[.0-9]* => /(usr/)?lib/'

# The laboratory, and Embree, which it recommends: it is measured beside, and opened when it is asked for.
step 'no laboratory' visitor 'svocl verify scene:cube -d 4 2>&1 | grep "svocl-lab"'
expect 'svocl: verify: svocl-lab is not installed .apt install svocl-lab.'
step 'the laboratory alone' root 'apt-get -y -q install --no-install-recommends /packages/svocl-lab_*.deb'
step 'a check' visitor 'svocl verify scene:cube -d 4'
expect 'exact: 0 missed, 0 surplus'
step 'no Embree' visitor 'svocl bench rays --vs embree --quick 2>&1 | grep "libembree3-3"'
expect 'svocl: bench: --vs embree: libembree3.so.3 cannot be opened .apt install libembree3-3.'
step 'where zsh and fish look' root 'ls /usr/share/zsh/vendor-completions/_svocl \
    /usr/share/fish/vendor_completions.d/svocl.fish /usr/share/man/man1/svocl.1.gz'

# A project of its own, in CMake and with pkg-config.
step 'the libraries for programs' root \
    'apt-get -y -q install --no-install-recommends /packages/libsvocl-dev*.deb cmake make gcc libc6-dev pkg-config'
step 'a CMake project' visitor \
    'cp -r /consumer project && cmake -S project -B build && cmake --build build && build/voxels'
expect '^96776 leaves, 128073 nodes, hash '
# shellcheck disable=SC2016 # expanded in the root
step 'pkg-config' visitor \
    'gcc /consumer/main.c -o voxels $(pkg-config --cflags --libs svocl svocl-gl svocl-io) && ./voxels'
expect '^96776 leaves, 128073 nodes, hash '

# Python: the package, then the wheel where no package is left. A mesh file, which a program of the library's reads.
step 'a mesh file' visitor 'svocl scene cube -o cube.ply'
step 'the Python package' root 'apt-get -y -q install --no-install-recommends /packages/python3-svocl_*.deb'
step 'Python' visitor '/usr/bin/python3 /consumer/hash.py cube.ply 6'
expect "^[0-9.]+ /usr/lib/python3/dist-packages/svocl $hash\$"
readonly modules='find . -type f ! -path "*/__pycache__/*" ! -name svocl-import | sort'
step 'its files' visitor "cd /usr/lib/python3/dist-packages/svocl && $modules >~/files"

step 'removing it' root "apt-get -y -q purge 'libsvocl*' 'svocl*' python3-svocl"
step 'what is left' root "find / -xdev -iname '*svocl*' -not -path '/packages/*' -not -path '/home/*'"
[[ ! -s $folder/output ]] || fail 'the purge left files'

readonly wheel_packages='python3-venv python3-cffi python3-numpy libassimp5 libcjson1 libzstd1'
step 'what a wheel needs' root "apt-get -y -q install --no-install-recommends $wheel_packages"
step 'the wheel' visitor \
    'python3 -m venv --system-site-packages venv && venv/bin/pip install --no-index /packages/svocl-*.whl'
step 'Python with the wheel' visitor 'venv/bin/python /consumer/hash.py cube.ply 6'
expect "^[0-9.]+ /home/visitor/venv/lib/python[0-9.]+/site-packages/svocl $hash\$"
step 'the same files, but for the program that reads meshes' visitor \
    "cd venv/lib/python*/site-packages/svocl && $modules | diff ~/files -"
rm_root
printf '\ndebian_root: passed, log in %s\n' "$log"
