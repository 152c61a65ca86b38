#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# recipe_root.sh PACKAGES FOLDER [MIRROR]: the job of samples/16_ci/.gitlab-ci.yml, every line of it, in a clean Debian
# 12, which debootstrap makes in FOLDER, with the package of svocl in PACKAGES. It runs twice, the second time with the
# cache of the first. Prints what is installed and the seconds of each line. Needs a mirror, debootstrap, python3-yaml,
# and root or sudo; without the last three it is skipped (77).
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
readonly here packages=$1
# shellcheck source=tests/install/root.sh
source "$here/root.sh"

python3 -c 'import yaml' 2>/dev/null || skip 'PyYAML is not installed (apt install python3-yaml)'
readonly sample=$here/../../samples/16_ci
clean_root "$2" "${3:-http://deb.debian.org/debian}"
as_root mkdir -p "$root/root/work/packages"
as_root cp -r "$sample/." "$root/root/work/"
as_root cp "$packages"/svocl_*.deb "$root/root/work/packages/"

# MiB of everything but the job's folder and what apt downloaded.
installed_mib()
{
    as_root du -smx --exclude="$root/root" --exclude="$root/var/cache/apt" \
        --exclude="$root/var/lib/apt/lists" "$root" | cut -f 1
}

# The lines of the job, each with its time; the first one that fails ends it.
python3 - "$sample/.gitlab-ci.yml" <<'END' | as_root tee "$root/root/work/job.sh" >/dev/null
import shlex, sys, yaml
((_, job),) = yaml.safe_load(open(sys.argv[1], encoding="utf-8")).items()
print("set -e\nexport CI_PROJECT_DIR=$PWD")
for name, value in job["variables"].items():
    print(f'export {name}="{value}"')
for line in job["before_script"] + job["script"]:
    print(f"begun=$(date +%s%N); {{ {line}; }} >output 2>&1 || {{ cat output; exit 1; }}")
    print(f"printf '%8.2f s  %s\\n' \"$((($(date +%s%N) - begun) / 10000000))e-2\" {shlex.quote(line)}")
END

before=$(installed_mib)
for run in first second; do
    printf '== %s run\n' "$run" | tee -a "$log"
    enter root 'cd work && bash job.sh' >"$folder/output" 2>&1 || {
        cat "$folder/output" >>"$log"
        fail "the $run run failed"
    }
    tee -a "$log" <"$folder/output"
    printf '%d MiB installed\n' $(($(installed_mib) - before)) | tee -a "$log"
done
enter root 'cd work && du -sk .cache' | sed 's/\t.*/ KiB in the cache/' | tee -a "$log"
rm_root
printf 'recipe_root: passed, log in %s\n' "$log"
