#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Test of the workflows: what they run, but for installing packages, does what they say. check.py SVOCL

Each job runs in a copy of this folder, with a cache that lasts from one job to the next, as a service runs it: with the
mesh as it is, and with another. Exit code 77: skipped.
"""

import os
import pathlib
import shutil
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).parent
FILES = ("part.obj", "part.svo")
FAST = {"POCL_EXTRA_BUILD_FLAGS": "-cl-opt-disable"}
"""The hashes are the same, and kernels compile in a third of the time."""
try:
    import yaml
except ImportError:
    print("skipped: PyYAML is not installed (python3-yaml)")
    sys.exit(77)


def run(script, folder, environment):
    """A step, as both services run it: a shell that ends at the first command that fails."""
    return subprocess.run(["sh", "-e", "-c", script], cwd=folder, env=environment, capture_output=True, text=True)


class GitHub:
    """The steps with `run`, and what they write to $GITHUB_ENV."""

    def __init__(self):
        workflow = yaml.safe_load((HERE / "github.yml").read_text())
        (job,) = workflow["jobs"].values()
        steps = [step for step in job["steps"] if "run" in step and "apt-get" not in step["run"]]
        self.variables = workflow["env"]
        self.always = [step["run"] for step in steps if "if" not in step]
        self.on_failure = [step["run"] for step in steps if step.get("if") == "failure()"]
        (cache,) = [step["with"] for step in job["steps"] if step.get("uses", "").startswith("actions/cache@")]
        self.cache, self.cache_keys = cache["path"], [cache["key"], cache["restore-keys"]]

    def run(self, folder, base):
        environment = {**base, **self.variables, "GITHUB_ENV": str(folder / "environment")}
        done = []
        for script in self.always:
            done.append(run(script, folder, environment))
            if done[-1].returncode != 0:
                return done + [run(script, folder, environment) for script in self.on_failure]
            if (folder / "environment").exists():
                lines = (folder / "environment").read_text().splitlines()
                environment.update(line.split("=", 1) for line in lines)
        return done


class GitLab:
    """before_script and script in one shell, then after_script in another, whose outcome does not count."""

    def __init__(self):
        ((_, self.job),) = yaml.safe_load((HERE / ".gitlab-ci.yml").read_text()).items()
        (self.cache,) = self.job["cache"]["paths"]
        self.cache_keys = [self.job["cache"]["key"]]
        self.variables = self.job["variables"]

    def run(self, folder, base):
        environment = {**base, "CI_PROJECT_DIR": str(folder)}
        for name, value in self.variables.items():
            environment[name] = value.replace("$CI_PROJECT_DIR", str(folder))
        lines = self.job["before_script"] + self.job["script"]
        done = [run("\n".join(line for line in lines if "apt-get" not in line), folder, environment)]
        environment["CI_JOB_STATUS"] = "success" if done[0].returncode == 0 else "failed"
        return done + [run("\n".join(self.job["after_script"]), folder, environment)]


def check(service, program, work, cache):
    name = type(service).__name__
    base = {key: value for key, value in os.environ.items() if not key.startswith(("POCL_", "XDG_", "SVOCL_"))}
    base.update(FAST)
    base["PATH"] = f"{program.parent}:{base['PATH']}"
    for key in service.cache_keys:
        assert service.variables["POCL_KERNELLIB_NAME"] in key, f"{name}: {key} does not say the instruction set"
    folder = work / name
    folder.mkdir()
    for file in FILES:
        shutil.copy(HERE / file, folder)
    if cache.exists():
        shutil.copytree(cache, folder / service.cache)
    done = service.run(folder, base)
    outputs = "".join(step.stdout + step.stderr for step in done)
    assert all(step.returncode == 0 for step in done), f"{name}: {outputs}"
    assert outputs.count("\n") == 2, f"{name} prints more than two hashes: {outputs}"
    assert not (folder / "difference.png").exists()
    for kept in ("pocl", "svocl"):
        assert any((folder / service.cache / kept).iterdir()), f"{name}: {kept} keeps no kernels"
    shutil.rmtree(cache, ignore_errors=True)
    shutil.copytree(folder / service.cache, cache)

    text = (folder / "part.obj").read_text()
    (folder / "part.obj").write_text(text.replace("v 1 2 0", "v 1.2 2 0"))
    done = service.run(folder, base)
    outputs = "".join(step.stdout + step.stderr for step in done)
    assert any(step.returncode != 0 for step in done), f"{name} passes another mesh"
    assert "part.obj: the hash is " in outputs and "first difference: voxel " in outputs, f"{name}: {outputs}"
    assert (folder / "difference.png").read_bytes()[1:4] == b"PNG", f"{name}: no picture"


def main():
    program = pathlib.Path(sys.argv[1]).resolve()
    with tempfile.TemporaryDirectory() as work:
        cache = pathlib.Path(work) / "cache"
        for service in (GitHub(), GitLab()):
            check(service, program, pathlib.Path(work), cache)
        saved = {path.name for path in (cache / "svocl").iterdir()}
        environment = {**os.environ, **FAST, "XDG_CACHE_HOME": str(cache), "POCL_KERNELLIB_NAME": "avx2"}
        run(f"'{program}' kernels part.obj -d 5 -q", HERE, environment)
        assert saved == {path.name for path in (cache / "svocl").iterdir()}, "the cache does not serve the next run"
    print("both workflows pass with the mesh as it is, and name what differs in another")


if __name__ == "__main__":
    main()
