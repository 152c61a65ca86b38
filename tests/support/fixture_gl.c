/* SPDX-License-Identifier: MIT */
/* The OpenGL part of the fixture. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include "fixture.h"
#include "support/gl_contexts.h"

static void open_context(const fixture_options *options, fixture *out)
{
    svo_message message = {""};
    const unsigned first = options->context > 0 ? options->context - 1 : 0;
    const unsigned end = options->context > 0 ? options->context : SVO_GL_CONTEXT_KINDS;
    for (unsigned kind = first; kind < end; ++kind) {
        if (context_of_kind((svo_gl_context_kind)kind, 0, &out->context, &message) == SVO_OK) {
            return;
        }
    }
    fixture_skip(out, message.text);
}

void fixture_open(const fixture_options *options, fixture *out)
{
    fixture_open_cl(options, out);
    open_context(options, out);
    const svo_gl_options gl_options = {
        .struct_size = sizeof gl_options, .share = options->share, .no_int64 = options->no_int64};
    const svo_status status = svo_gl_create(out->device, out->context, &gl_options, &out->gl);
    if (status == SVO_UNSUPPORTED && options->share != SVO_GL_SHARE_AUTO) {
        fixture_skip(out, svo_device_message(out->device));
    }
    if (status != SVO_OK) {
        fail_msg("%s", svo_device_message(out->device));
    }
    out->frontend = svo_gl_frontend(out->gl);
}

static svo_status by_gl(const fixture *opened, svo_plan *plan, svo_tree **out, svo_build_report *report)
{
    return svo_gl_build(opened->gl, plan, opened->queue, out, report);
}

void fixture_build_in_gl(const fixture *opened, const svo_mesh *mesh, unsigned depth, const svo_plan_options *options,
                         built *out)
{
    fixture_build_by(opened, mesh, depth, options, by_gl, out);
}

void fixture_close_gl(fixture *opened)
{
    svo_gl_destroy(&opened->gl);
    svo_gl_context_destroy(&opened->context);
}
