#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# The manual pages and the completion of shells, which the program makes from its tables: every command has a page
# without errors of roff, every option of its help is on it, and bash, zsh and fish complete what the tables say.
#
# usage: manual.sh PROGRAM CMAKE BUILD_DIR
set -euo pipefail

readonly program=$1 cmake=$2 build=$3
# shellcheck source=tests/support/complain.sh
source "${BASH_SOURCE[0]%/*}/../support/complain.sh"

# --- pages ---

mapfile -t commands < <("$program" --help | sed -n 's/^  \([a-z-]\{1,\}\)  .*/\1/p')
((${#commands[@]} >= 16)) || complain "only ${#commands[@]} commands in the help"
"$program" man -o "$work/pages"
for command in "${commands[@]}"; do
    page=$work/pages/svocl-$command.1
    [[ -s $page ]] || complain "no page of $command"
    grep -q -F -e "svocl\\-${command//-/\\-}\\fR" "$work/pages/svocl.1" || complain "svocl.1 lacks $command"
    cmp -s <("$program" man "$command") "$page" || complain "svocl man $command prints another page than it writes"
    while read -r option; do
        grep -q -F -e "\\-\\-${option//-/\\-}\\fR" "$page" || complain "svocl-$command.1 lacks --$option"
    done < <("$program" "$command" --help | grep -o -e '^ .*--[a-z-]*' | sed 's/.*--//')
done
[[ -s $work/pages/svocl-lab.1 ]] || complain "no page of svocl-lab"
for command in bench reference report stress tune verify; do
    grep -q -F "svocl\\-$command\\fR" "$work/pages/svocl-lab.1" || complain "svocl-lab.1 lacks $command"
done
grep -q '^Different' "$work/pages/svocl-diff.1" || complain 'svocl-diff.1 does not say what exit code 1 is'
if command -v mandoc >/dev/null; then
    # STYLE is advice for manuals of BSD; the date is left out, so that pages are the same every day.
    mandoc -T lint -W warning "$work"/pages/*.1 | grep -v 'missing date' >"$work/lint" || true
    [[ ! -s $work/lint ]] || complain "$(cat "$work/lint")"
    mandoc -T ascii "$work/pages/svocl-build.1" | sed 's/.\x08//g' >"$work/text" # without overstrikes
    grep -q -e '-d, --depth D' "$work/text" || complain "svocl-build.1 lacks -d D"
else
    echo "not run: mandoc is not installed"
fi

# --- bash ---

# shellcheck disable=SC2317 # the completion calls it
compopt()
{
    :
}
"$program" completion bash >"$work/completion"
# shellcheck source=/dev/null
source "$work/completion"

# What bash would offer for words, the last of which is completed; bash splits them at : and = before.
expect_completion()
{
    local wanted=$1
    shift
    COMP_WORDS=("$@")
    COMP_CWORD=$(($# - 1))
    COMPREPLY=()
    _svocl svocl "${COMP_WORDS[COMP_CWORD]}" "${COMP_WORDS[COMP_CWORD - 1]}"
    [[ "${COMPREPLY[*]}" == "$wanted" ]] || complain "'$*' completes to '${COMPREPLY[*]}', not '$wanted'"
}
cd "$work"
touch model.obj 'my model.ply'
mkdir folder
expect_completion 'build bench' svocl b
expect_completion '--frontend' svocl build --fro
expect_completion '--max-bytes' svocl export-web --max-b
expect_completion 'probes' svocl render --through p
expect_completion 'model.obj' svocl convert mo
expect_completion '--depth --device' svocl build --de
expect_completion 'cl' svocl build scene : cube --frontend c
expect_completion 'gl-expand gl-hw gl-hybrid' svocl build --frontend = gl
expect_completion 'auto cl gl-expand gl-hw gl-hybrid' svocl build --frontend =
expect_completion 'normal,rays' svocl build --need normal,r
expect_completion 'cube' svocl build scene : cu
expect_completion 'scene:' svocl build sc
expect_completion 'model.obj' svocl build mo
expect_completion 'my model.ply' svocl build my
expect_completion 'model.obj' svocl build -o mod
expect_completion '--picture' svocl diff --pi
expect_completion 'cube' svocl diff model.obj scene : cu
expect_completion 'folder' svocl report --docs f
expect_completion 'knot' svocl scene kn
expect_completion 'voxelize' svocl bench voxeli
expect_completion 'zsh' svocl completion z
expect_completion 'verify' svocl help ver
expect_completion 'grid' svocl bench rays --vs g
expect_completion '' svocl build --device x

# --- zsh ---

if command -v zsh >/dev/null; then
    "$program" completion zsh >"$work/_svocl"
    zsh -n "$work/_svocl" || complain "zsh does not read its completion"
    cat >"$work/ask" <<'END'
zmodload zsh/zpty
zpty shell zsh -f -i
zpty -w shell "PROMPT=; cd $1; fpath=($1 \$fpath); autoload -U compinit; compinit -u -D; zstyle ':completion:*' menu no"
zpty -w shell "bindkey '^I' complete-word; print READY"
zpty -r shell seen '*READY*READY*'
zpty -w -n shell "$2"$'\t'
sleep 1
zpty -w -n shell $'\x01print -r -- "[[\x05]]"\n'
sleep 1
while zpty -r -t shell line; do print -r -- $line; done
END
    # The line is completed, then printed between brackets.
    expect_zsh()
    {
        local seen
        seen=$(timeout 20 zsh -f "$work/ask" "$work" "$1" 2>&1 | tr -d '\r\a' | grep -o '\[\[.*\]\]' |
            tail -n 1) || true
        [[ $seen == "[[$2]]" ]] || complain "zsh completes '$1' to '$seen', not '$2'"
    }
    expect_zsh 'svocl verif' 'svocl verify'
    expect_zsh 'svocl build --fronte' 'svocl build --frontend'
    expect_zsh 'svocl build --frontend gl-e' 'svocl build --frontend gl-expand'
    expect_zsh 'svocl scene stat' 'svocl scene statue'
else
    echo "not run: zsh is not installed"
fi

# --- fish ---

if command -v fish >/dev/null; then
    "$program" completion fish >"$work/svocl.fish"
    # What fish would offer for the line.
    expect_fish()
    {
        local seen
        seen=$(HOME=$work fish --no-config -c "source $work/svocl.fish; complete -C '$1'" | cut -f 1 |
            paste -s -d ' ')
        [[ $seen == "$2" ]] || complain "fish completes '$1' to '$seen', not '$2'"
    }
    expect_fish 'svocl verif' 'verify'
    expect_fish 'svocl build --fronte' '--frontend'
    expect_fish 'svocl build --frontend gl-' 'gl-expand gl-hw gl-hybrid'
    expect_fish 'svocl build --frontend=gl-e' '--frontend=gl-expand'
    expect_fish 'svocl build --need normal,r' 'normal,rays'
    expect_fish 'svocl build --need=normal,r' '--need=normal,rays'
    expect_fish 'svocl build scene:cu' 'scene:cube'
    expect_fish 'svocl build mo' 'model.obj'
    expect_fish 'svocl build -o mo' 'model.obj'
    expect_fish 'svocl report --docs fo' 'folder/'
    expect_fish 'svocl build --device mo' ''
    expect_fish 'svocl scene stat' 'statue'
    expect_fish 'svocl bench voxeli' 'voxelize'
    expect_fish 'svocl completion f' 'fish'
    expect_fish 'svocl help verif' 'verify'
    "$program" --help | sed -n 's/^  \([a-z-]\{1,\}\)  .*/\1/p' | sort >"$work/wanted"
    HOME=$work fish --no-config -c "source $work/svocl.fish; complete -C 'svocl '" | cut -f 1 | sort >"$work/offered"
    lacking=$(comm -23 "$work/wanted" "$work/offered")
    [[ -z $lacking ]] || complain "fish does not offer $lacking"
else
    echo "not run: fish is not installed"
fi

# --- installed ---

"$cmake" --install "$build" --prefix "$work/prefix" >"$work/log" || complain "$(cat "$work/log")"
for file in man/man1/svocl.1 man/man1/svocl-build.1 man/man1/svocl-lab.1 man/man1/svocl-bench.1 \
    bash-completion/completions/svocl zsh/site-functions/_svocl fish/vendor_completions.d/svocl.fish; do
    [[ -s $work/prefix/share/$file ]] || complain "share/$file is not installed"
done
cmp -s "$work/pages/svocl-build.1" "$work/prefix/share/man/man1/svocl-build.1" || complain "another page is installed"
exit "$failed"
