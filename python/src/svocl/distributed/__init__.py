# SPDX-License-Identifier: MIT
"""Trees in parts on Dask's distributed scheduler: pip install 'svocl[distributed]'.

    python -m svocl.distributed model.ply -d 14 -o model.svo                       # workers on this machine
    python -m svocl.distributed model.ply -d 14 -o model.svo --scheduler tcp://head:8786

    with svocl.Parts.create(device, mesh, 14, "model.svo.parts") as parts:
        svocl.distributed.build_parts(client, parts)  # a distributed.Client
        parts.finish("model.svo")

Scheduler and workers need this package installed. A part is a pure function of the plan and its triangles, so it does
not matter which worker builds it, in which order, or how often. Parts that are there stay, so a job that ended early
goes on from there when it is started again.
"""

from ._run import Interrupted, Refused, Share, Summary, build_parts

__all__ = ["Interrupted", "Refused", "Share", "Summary", "build_parts"]
