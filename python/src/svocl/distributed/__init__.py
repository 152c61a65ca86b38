# SPDX-License-Identifier: MIT
"""Trees in parts on Dask's distributed scheduler: pip install 'svocl[distributed]'.

    python -m svocl.distributed model.ply -d 14 -o model.svo                       # workers on this machine
    python -m svocl.distributed model.ply -d 14 -o model.svo --scheduler tls://head:8786

    with svocl.PartsPlanning(device, "/shared/model.ply", 14, "/shared/model.svo.parts", 2 << 30, 64) as planning:
        parts = svocl.distributed.plan_parts(client, planning, device)  # a distributed.Client
    svocl.distributed.build_parts(client, parts)
    svocl.distributed.stitch_parts(client, parts, "/shared/model.svo", 64)

Scheduler and workers need this package installed. A part is a pure function of the plan and its triangles, so it does
not matter which worker builds it, in which order, or how often. Parts that are there stay, so a job that ended early
goes on from there when it is started again.
"""

from ._plan import plan_parts, stitch_parts
from ._run import Interrupted, Refused, Share, Summary, build_parts
from ._store import StoredParts

__all__ = ["Interrupted", "Refused", "Share", "StoredParts", "Summary", "build_parts", "plan_parts", "stitch_parts"]
