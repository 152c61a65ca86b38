#!/usr/bin/env bash
# SPDX-License-Identifier: MIT
#
# svocl view in a build that lacks what the viewer needs: one line that names it.
#
# usage: view_left_out.sh PROGRAM MISSING
set -euo pipefail

readonly program=$1 missing=$2
# shellcheck source=tests/support/complain.sh
source "${BASH_SOURCE[0]%/*}/../support/complain.sh"
cd "$work"
expect_failure 1 "svocl: view: this svocl has no viewer: it was built without $missing" "$program" view scene:cube -d 2
exit "$failed"
