# SPDX-License-Identifier: MIT
"""svocl.tune: the program's arguments, its answer as types, and its failures as exceptions."""

import json
import stat
from pathlib import Path

import pytest

import svocl

ANSWER = {
    "command": "svocl build model.ply -d 8 -o model.svo",
    "c": "/* depth 8 */",
    "note": "",
    "time_ms": 12.5,
    "time_low_ms": 12.0,
    "time_high_ms": 13.0,
    "memory_bytes": 4096,
}
DOCUMENT = {
    "answer": ANSWER,
    "second": None,
    "sure": 0.75,
    "within_5_percent": 1.0,
    "fresh": {"normal": 4.5},
    "settings": [],
}


def make_program(folder: Path, text: str) -> str:
    """A program that stands for svocl."""
    program = folder / "program"
    program.write_text(f"#!/bin/sh\n{text}\n")
    program.chmod(program.stat().st_mode | stat.S_IXUSR)
    return str(program)


def test_arguments_and_answer(tmp_path: Path) -> None:
    (tmp_path / "answer.json").write_text(json.dumps(DOCUMENT))
    program = make_program(tmp_path, f'printf "%s\\n" "$@" >{tmp_path}/arguments\ncat {tmp_path}/answer.json')
    found = svocl.tune(
        "model.ply",
        error={"normal": 5, "delta-e": None},
        free={"depth": [7, 8], "coverage": None, "builder": "cl"},
        time_s=0.5,
        memory_bytes=1 << 20,
        need=["normal", "rays"],
        lights="sun.json",
        exhaustive=True,
        page=tmp_path / "page.html",
        program=program,
    )
    assert (tmp_path / "arguments").read_text().split("\n")[:-1] == [
        "tune",
        "model.ply",
        "--json",
        "--quiet",
        "--error",
        "normal:5,delta-e",
        "--free",
        "depth:7+8,coverage,builder:cl",
        "--time",
        "0.5s",
        "--memory",
        "1048576",
        "--need",
        "normal,rays",
        "--lights",
        "sun.json",
        "--page",
        str(tmp_path / "page.html"),
        "--exhaustive",
    ]
    assert found.answer == svocl.TuneSetting(ANSWER["command"], "/* depth 8 */", 12.5, 12.0, 13.0, 4096, "")
    assert found.second is None and found.sure == 0.75 and found.near == 1.0
    assert found.fresh == {"normal": 4.5} and found.document == DOCUMENT


def test_failures_are_the_programs_lines(tmp_path: Path) -> None:
    program = make_program(tmp_path, 'echo "svocl: tune: model.ply: no such file" >&2; exit 1')
    with pytest.raises(RuntimeError, match="svocl: tune: model.ply: no such file"):
        svocl.tune("model.ply", program=program)
    with pytest.raises(RuntimeError, match="none-such is not installed"):
        svocl.tune("model.ply", program="none-such")
