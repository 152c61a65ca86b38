/* SPDX-License-Identifier: MIT */
/* svocl and svocl-lab run one another: each looks beside itself, then along PATH. */
#ifndef SVOCL_TOOLS_SUPPORT_SIBLING_H
#define SVOCL_TOOLS_SUPPORT_SIBLING_H

/* Becomes the program of that name, with the arguments after its name; the list ends with NULL. Returns only where no
   such program can run, with errno set: ENOENT where there is none. */
void sibling_become(const char *name, char *const arguments[]);

#endif
