# SPDX-License-Identifier: MIT
"""Writes the C source of svocl._native, the binding that cffi makes from svocl's public headers.

The headers are the one place that declares the API. The C compiler's preprocessor reduces them to declarations, cffi
parses those, and the source that it writes is compiled against the headers themselves: a size, an offset or a value
that differs does not compile or does not load.
"""

import argparse
import os
import re
import subprocess
import tempfile

import cffi

# What the headers use of others, for the parser alone.
CL_TYPES = """
#pragma once
typedef int32_t cl_int;
typedef uint32_t cl_uint;
""" + "\n".join(
    f"typedef struct _cl_{name} *cl_{name};"
    for name in ("context", "device_id", "command_queue", "mem", "event", "kernel")
)

# Of OpenCL: events that svocl returns are waited for and released.
CL_FUNCTIONS = """
cl_int clWaitForEvents(cl_uint count, const cl_event *events);
cl_int clReleaseEvent(cl_event event);
"""

# Called by the library on the thread that called it; src/svocl/_callbacks.py has the Python side.
CALLBACKS = """
extern "Python" void svocl_python_log(void *user, svo_log_level level, const char *text);
extern "Python" int svocl_python_progress(void *user, svo_stage stage, double fraction);
extern "Python" int svocl_python_fraction(void *user, double fraction);
"""

# The same, with types of svocl::io.
IO_CALLBACKS = """
extern "Python" svo_status svocl_python_voxel_part(void *user, const svo_voxel_part *part);
"""


def preprocess(compiler: str, include: str, text: str, options: list[str]) -> str:
    """Runs the preprocessor over text; of all system headers only CL/cl.h has content."""
    with tempfile.TemporaryDirectory() as folder:
        os.mkdir(os.path.join(folder, "CL"))
        contents: dict[str, str] = {"CL/cl.h": CL_TYPES, "stddef.h": "", "stdint.h": "", "input.c": text}
        for name, content in contents.items():
            with open(os.path.join(folder, name), "w", encoding="utf-8") as file:
                file.write(content)
        # Static assertions and attributes are the compiler's; cffi does not parse them.
        command = [compiler, "-E", "-P", "-nostdinc", "-I", folder, "-I", include, "-D_Static_assert(condition, text)="]
        command += ["-D__attribute__(attributes)=", *options, os.path.join(folder, "input.c")]
        return subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True).stdout


def declarations(compiler: str, include: str, text: str) -> str:
    """The declarations of the headers that text includes, and their macros that are integers."""
    code = preprocess(compiler, include, text, [])
    macros = preprocess(compiler, include, text, ["-dM"])
    integers = re.findall(r"^#define (SVO_[A-Z0-9_]+) (?:0x[0-9a-fA-F]+|[0-9]+|UINT32_MAX)u?$", macros, re.MULTILINE)
    # Functions of the headers themselves are for C alone; cffi parses none.
    code = re.sub(r"^static inline [^{;]*\{.*?^\}$", "", code, flags=re.MULTILINE | re.DOTALL)
    # Lone semicolons are left where an assertion was.
    lines = [line for line in code.splitlines() if line.strip() != ";"]
    return "\n".join(lines + [f"#define {name} ..." for name in sorted(integers)])


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--compiler", required=True, help="the C compiler, for its preprocessor")
    parser.add_argument("--include", required=True, help="the folder of svocl/svocl.h")
    parser.add_argument("--output", required=True, help="the C file to write")
    parser.add_argument(
        "--io", action="store_true", help="bind io.h, paged.h, parts.h, parts_tree.h and points.h of svocl too"
    )
    arguments = parser.parse_args()
    includes = '#include "svocl/svocl.h"\n'
    callbacks = CALLBACKS
    if arguments.io:
        callbacks += IO_CALLBACKS
        includes += "".join(f'#include "svocl/{name}.h"\n' for name in ("io", "paged", "parts", "parts_tree", "points"))
    builder = cffi.FFI()
    builder.cdef(declarations(arguments.compiler, arguments.include, includes) + CL_FUNCTIONS + callbacks)
    builder.set_source("svocl._native", includes)
    builder.emit_c_code(arguments.output)


if __name__ == "__main__":
    main()
