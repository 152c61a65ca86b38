# shellcheck shell=bash
# SPDX-License-Identifier: MIT
#
# Shared by tests of the program's files: a folder that ends with the test, and complaints, of which a test prints all
# before it fails. The test that sources this ends with `exit "$failed"`.
# shellcheck disable=SC2034 # the tests read failed

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
failed=0
complain()
{
    echo "$*"
    failed=1
}

# The command must fail with the exit code and print one line on standard error, which contains words.
expect_failure()
{
    local wanted=$1 words=$2 code=0
    shift 2
    "$@" >"$work/out" 2>"$work/err" || code=$?
    ((code == wanted)) || complain "exit code $code, not $wanted, of: $*"
    if (($(wc -l <"$work/err") != 1)) || ! grep -q -- "$words" "$work/err"; then
        complain "not one line with '$words': $(cat "$work/err")"
    fi
}
