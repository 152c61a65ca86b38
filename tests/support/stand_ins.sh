# shellcheck shell=bash
# SPDX-License-Identifier: MIT
#
# Shared by tests on other people's models. model_folders WORK PART FOLDER... sets the array folders: what stand_ins.py
# writes below WORK, or the part of it that is not '.', then those of the folders that exist.
# shellcheck disable=SC2034 # the tests read folders

model_folders()
{
    local work=$1 part=$2 one
    shift 2
    folders=()
    if command -v python3 >/dev/null; then
        "${BASH_SOURCE[0]%/*}/stand_ins.py" "$work/stand-ins"
        folders+=("$work/stand-ins/$part")
    fi
    for one; do
        [[ ! -d $one ]] || folders+=("$one")
    done
    if ((${#folders[@]} == 0)); then
        echo "skipped: no python3, which writes stand-ins (apt install python3), and no folder $*"
        exit 77
    fi
}
