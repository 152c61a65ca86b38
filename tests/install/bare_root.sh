#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# bare_root.sh FOLDER [MIRROR]: whether `tools/dev demo` and then `tools/dev test` do what they say in a clean Debian
# 12, which debootstrap makes in FOLDER, from a clone of what is committed here and nothing beside it. Prints how long
# each takes, how much it installs, and which tests are skipped: only those may be that want a browser, or packages from
# PyPI where it is not reached. Needs a mirror, git, debootstrap, and root or sudo; without the last three it is skipped
# (77). FOLDER keeps the downloads and the log.
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
readonly here
# shellcheck source=tests/install/root.sh
source "$here/root.sh"

readonly may_skip='report_browser|web_browser|web_live|python'

git -C "$here" rev-parse HEAD >/dev/null 2>&1 || skip 'this is no clone, or git is not installed'
clean_root "$1" "${2:-http://deb.debian.org/debian}"
as_root git clone --quiet --local --no-hardlinks "$(git -C "$here" rev-parse --show-toplevel)" "$root/root/svocl"

# MiB of everything but the clone and what is built in it.
installed_mib()
{
    as_root du -smx --exclude="$root/root" --exclude="$root/var/cache/apt/archives" "$root" | cut -f 1
}

# command NAME: runs tools/dev NAME in the clone.
command_of_clone()
{
    local name=$1 start=$SECONDS before
    before=$(installed_mib)
    printf '== tools/dev %s\n' "$name" | tee -a "$log"
    enter root "cd svocl && tools/dev $name" >"$folder/output" 2>&1 || {
        cat "$folder/output" >>"$log"
        fail "tools/dev $name failed"
    }
    cat "$folder/output" >>"$log"
    printf '%-12s %d s, %d MiB installed\n' "$name" $((SECONDS - start)) $(($(installed_mib) - before)) | tee -a "$log"
}

command_of_clone demo
grep '^picture' "$folder/output"
as_root test -s "$root/root/svocl/demo/atrium.png" || fail 'there is no picture'
command_of_clone test
grep -E 'tests? passed, [0-9]+ tests? failed out of|\(Skipped\)|\(Disabled\)|\(Not Run\)' "$folder/output"
if grep -E '\((Skipped|Disabled|Not Run)\)' "$folder/output" | grep -v -E -- "- ($may_skip) "; then
    fail 'these tests did not run'
fi
rm_root
printf 'bare_root: passed, log in %s\n' "$log"
