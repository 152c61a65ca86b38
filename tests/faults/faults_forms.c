/* SPDX-License-Identifier: MIT */
/* Scenarios of test_faults: compact trees, solids, scenes of placed trees, lights, probes. */
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "faults_scenario.h"
#include "support/info_of.h"

/*
 * Compact trees.
 */

/* Makes a form and downloads it. */
static svo_status make_compact(subject *of, svo_form form, svo_compact **out)
{
    const svo_compact_options asked = {.struct_size = sizeof asked,
                                       .form = form,
                                       .minimize = form == SVO_FORM_IMPLIED,
                                       .color_tolerance = {2, 2, 2, 2}};
    TRY_TOLD(svo_compact_create(world.device, of->tree, &asked, world.queue, out));
    return told(of, world.device, svo_compact_download(*out, world.queue));
}

static svo_status expand_compact(subject *of, svo_compact *compact)
{
    char hash[SVO_HASH_TEXT_BYTES];
    svo_tree *expanded = NULL;
    svo_status status = SVO_OK;
    SVO_I_TRY_CLEANUP(told(of, world.device, svo_compact_expand(compact, world.queue, &expanded)));
    SVO_I_TRY_CLEANUP(told(of, world.device, svo_tree_download(expanded, world.queue)));
    SVO_I_TRY_CLEANUP(told(of, world.device, svo_tree_hash(expanded, SVO_HASH_ALL, hash)));
    digest(of, hash, sizeof hash);

cleanup:
    svo_tree_destroy(&expanded);
    return status;
}

/* Packs the payload of what is on a device, and what that gives in its place. */
static svo_status pack_compact(subject *of, svo_compact **compact)
{
    const svo_pack_options asked = {.struct_size = sizeof asked, .color_error = 3, .normal_bits = 6};
    svo_compact *packed = NULL;
    char hash[SVO_HASH_TEXT_BYTES];
    TRY_TOLD(svo_compact_pack(*compact, &asked, world.queue, &packed));
    svo_compact_destroy(compact);
    *compact = packed;
    TRY_TOLD(svo_compact_download(packed, world.queue));
    TRY_TOLD(svo_compact_hash(packed, hash));
    digest(of, hash, sizeof hash);
    return SVO_OK;
}

static svo_status run_compact(subject *of)
{
    svo_status status = SVO_OK;
    svo_compact *compact = NULL;
    for (int form = 0; form < SVO_FORM_COUNT; ++form) {
        char hash[SVO_HASH_TEXT_BYTES];
        SVO_I_TRY_CLEANUP(make_compact(of, (svo_form)form, &compact));
        SVO_I_TRY_CLEANUP(told(of, world.device, svo_compact_hash(compact, hash)));
        digest(of, hash, sizeof hash);
        SVO_I_TRY_CLEANUP(expand_compact(of, compact));
        SVO_I_TRY_CLEANUP(pack_compact(of, &compact));
        SVO_I_TRY_CLEANUP(expand_compact(of, compact));
        svo_compact_destroy(&compact);
    }

cleanup:
    svo_compact_destroy(&compact);
    return status;
}

static svo_status run_compact_rays(subject *of)
{
    svo_voxel_hit hits[RAYS];
    uint8_t picture[PICTURE_SIDE * PICTURE_SIDE * 4];
    svo_render_options options = {
        .struct_size = sizeof options, .width = PICTURE_SIDE, .height = PICTURE_SIDE, .view = SVO_VIEW_SHADED};
    svo_status status = SVO_OK;
    svo_compact *compact = NULL;
    memset(picture, 0, sizeof picture);
    (void)svo_camera_fit(svo_tree_target(of->tree), 1.0F, &options.camera);
    SVO_I_TRY_CLEANUP(make_compact(of, SVO_FORM_DESCRIPTOR, &compact));
    SVO_I_TRY_CLEANUP(told(of, world.device,
                           svo_trace_voxels(svo_compact_target(compact), svo_in_host(world.rays), svo_in_host(hits),
                                            RAYS, 0.0F, 0, &(svo_submit){.queue = world.queue})));
    digest(of, hits, sizeof hits);
    SVO_I_TRY_CLEANUP(told(of, world.device,
                           svo_trace_voxels(svo_tree_target(of->tree), svo_in_host(world.rays), svo_in_host(hits), RAYS,
                                            0.0F, 0, &(svo_submit){.queue = world.queue})));
    digest(of, hits, sizeof hits);
    SVO_I_TRY_CLEANUP(told(
        of, world.device,
        svo_render(svo_compact_target(compact), &options, svo_in_host(picture), &(svo_submit){.queue = world.queue})));
    digest(of, picture, sizeof picture);

cleanup:
    svo_compact_destroy(&compact);
    return status;
}

/* Files of words and of records with payload and a packed one of masks, which are read again and brought to the
   device. */
static svo_status save_and_load(subject *of, svo_form form, const svo_save_options *options)
{
    char hash[SVO_HASH_TEXT_BYTES];
    svo_status status = SVO_OK;
    svo_compact *made = NULL;
    svo_compact *loaded = NULL;
    SVO_I_TRY_CLEANUP(make_compact(of, form, &made));
    if (form == SVO_FORM_IMPLIED) {
        SVO_I_TRY_CLEANUP(pack_compact(of, &made));
    }
    SVO_I_TRY_CLEANUP(svo_compact_save(made, svo_to_path(world.compact_path), options, &of->message));
    SVO_I_TRY_CLEANUP(svo_compact_load(svo_from_path(world.compact_path), NULL, &loaded, &of->message));
    SVO_I_TRY_CLEANUP(svo_compact_hash(loaded, hash));
    digest(of, hash, sizeof hash);
    SVO_I_TRY_CLEANUP(told(of, world.device, svo_compact_upload(loaded, world.device, world.queue)));

cleanup:
    svo_compact_destroy(&loaded);
    svo_compact_destroy(&made);
    return status;
}

static svo_status run_compact_files(subject *of)
{
    const svo_save_options packed = {.struct_size = sizeof packed, .compress = 1};
    SVO_I_TRY(save_and_load(of, SVO_FORM_DESCRIPTOR, NULL));
    SVO_I_TRY(save_and_load(of, SVO_FORM_SHARED, NULL));
    return save_and_load(of, SVO_FORM_IMPLIED, &packed);
}

/*
 * Solids.
 */

/* The inside of a mesh that is not closed. */
static svo_status run_solid(subject *of)
{
    svo_compact *solid = NULL;
    svo_solid_info info = SVO_SOLID_INFO_INIT;
    char hash[SVO_HASH_TEXT_BYTES] = "";
    svo_status status = svo_solid_create(of->tree, NULL, world.queue, &solid, &info);
    if (status == SVO_OK) {
        status = svo_compact_download(solid, world.queue);
    }
    if (status == SVO_OK) {
        status = svo_compact_hash(solid, hash);
    }
    digest(of, &info, sizeof info);
    digest(of, hash, sizeof hash);
    svo_compact_destroy(&solid);
    return told(of, world.device, status);
}

/*
 * Scenes.
 */

/* A picture, voxels and triangles of a scene that was moved and rebuilt. */
static svo_status use_scene(subject *of, svo_scene *scene)
{
    static const float moved[12] = {0, 1, 0, 0.25F, 1, 0, 0, 0, 0, 0, 2, 0};
    svo_scene_hit hits[RAYS];
    svo_scene_triangle_hit triangles[RAYS];
    uint8_t picture[PICTURE_SIDE * PICTURE_SIDE * 4] = {0};
    svo_render_options options = {.struct_size = sizeof options, .width = PICTURE_SIDE, .height = PICTURE_SIDE};
    TRY_TOLD(svo_scene_set_transforms(scene, 1, 1, moved, world.queue));
    TRY_TOLD(svo_scene_rebuild(scene, world.queue));
    TRY_TOLD(svo_trace_voxels(svo_scene_target(scene), svo_in_host(world.rays), svo_in_host(hits), RAYS, 0.0F,
                              SVO_SCENE_CLOSEST, &(svo_submit){.queue = world.queue}));
    digest(of, hits, sizeof hits);
    TRY_TOLD(svo_trace_triangles(svo_scene_target(scene), svo_in_host(world.rays), svo_in_host(triangles), RAYS,
                                 SVO_SCENE_CLOSEST, &(svo_submit){.queue = world.queue}));
    digest(of, triangles, sizeof triangles);
    (void)svo_camera_fit(svo_scene_target(scene), 1.0F, &options.camera);
    TRY_TOLD(svo_render(svo_scene_target(scene), &options, svo_in_host(picture), &(svo_submit){.queue = world.queue}));
    digest(of, picture, sizeof picture);
    return SVO_OK;
}

static svo_status run_scene(subject *of)
{
    static const svo_instance instances[3] = {{0, {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}},
                                              {0, {0, 1, 0, 0, 1, 0, 0, 0, 0, 0, 1, 0}},
                                              {0, {2, 0, 0, 1, 0, 2, 0, 0, 0, 0, -2, 0}}};
    const svo_scene_options options = {.struct_size = sizeof options,
                                       .trees = &of->tree,
                                       .instances = instances,
                                       .tree_count = 1,
                                       .instance_count = 3,
                                       .need = SVO_NEED_RAYS};
    svo_scene *scene = NULL;
    TRY_TOLD(svo_scene_create(world.device, &options, world.queue, &scene));
    const svo_status status = use_scene(of, scene);
    svo_scene_destroy(&scene);
    return status;
}

/* A light that is updated twice, for a tree that has not changed. */
static const float sky_texels[6] = {1, 2, 3, 0, 0.5F, 0};

static svo_status update_light(subject *of, svo_light *light, svo_light_setup setup)
{
    const svo_box changed = {.high = {0.5, 0.5, 0.5}};
    setup.diagnose = 0;
    setup.updatable = 1;
    SVO_I_TRY(svo_light_set_sources(light, &setup, world.queue));
    SVO_I_TRY(svo_light_update(light, of->tree, &changed, 1, world.queue));
    return svo_light_update(light, of->tree, &changed, 1, world.queue); /* from what the first one kept */
}

/* Opacity and light in each form. */
static svo_status run_light(subject *of)
{
    for (int form = 0; form < SVO_LIGHT_FORM_COUNT; ++form) {
        const svo_light_options options = {.struct_size = sizeof options, .form = (svo_light_form)form};
        char hash[SVO_HASH_TEXT_BYTES];
        const svo_gather_point point = {.position = {0.5F, 0.5F, 0.5F}, .normal = {0, 0, 1}};
        svo_gather_result gathered;
        const svo_light_source lamp = {.kind = SVO_SOURCE_POINT, .position = {0.5F, 0.5F, 0.5F}, .value = {1, 2, 3}};
        const svo_finish finish = {.emission = {1, 1, 1}};
        const svo_light_setup setup = {.struct_size = sizeof setup,
                                       .sources = &lamp,
                                       .source_count = 1,
                                       .finishes = &finish,
                                       .finish_count = 1,
                                       .view_resolution = 16,
                                       .diagnose = 1,
                                       .sky_map = sky_texels,
                                       .sky_width = 2,
                                       .sky_height = 1};
        svo_light *light = NULL;
        TRY_TOLD(svo_light_create(of->tree, &options, world.queue, &light));
        svo_status status = form == 0 ? update_light(of, light, setup) : SVO_OK;
        if (status == SVO_OK) {
            status = svo_light_set_sources(light, &setup, world.queue);
        }
        svo_render_options drawn = SVO_RENDER_OPTIONS_INIT;
        uint8_t picture[PICTURE_SIDE * PICTURE_SIDE * 4];
        drawn.width = drawn.height = PICTURE_SIDE;
        (void)svo_camera_fit(svo_tree_target(of->tree), 1.0F, &drawn.camera);
        if (status == SVO_OK) {
            status = svo_light_hash(light, world.queue, hash);
        }
        if (status == SVO_OK) {
            status =
                svo_render(svo_light_target(light), &drawn, svo_in_host(picture), &(svo_submit){.queue = world.queue});
        }
        if (status == SVO_OK) {
            status = svo_gather(light, svo_in_host(&point), svo_in_host(&gathered), 1, NULL,
                                &(svo_submit){.queue = world.queue});
        }
        svo_light_destroy(&light);
        TRY_TOLD(status);
        digest(of, hash, sizeof hash);
        digest(of, picture, sizeof picture);
        digest(of, &gathered, sizeof gathered);
    }
    return SVO_OK;
}

/* A light, written and read again. */
static svo_status run_light_files(subject *of)
{
    const svo_light_source lamp = {.kind = SVO_SOURCE_POINT, .position = {0.5F, 0.5F, 0.5F}, .value = {1, 2, 3}};
    const svo_finish finish = {.emission = {1, 1, 1}};
    const svo_light_setup setup = {.struct_size = sizeof setup,
                                   .sources = &lamp,
                                   .source_count = 1,
                                   .finishes = &finish,
                                   .finish_count = 1,
                                   .view_resolution = 16,
                                   .sky_map = sky_texels,
                                   .sky_width = 2,
                                   .sky_height = 1};
    char hash[SVO_HASH_TEXT_BYTES];
    svo_status status = SVO_OK;
    svo_light *made = NULL;
    svo_light *loaded = NULL;
    SVO_I_TRY_CLEANUP(told(of, world.device, svo_light_create(of->tree, NULL, world.queue, &made)));
    SVO_I_TRY_CLEANUP(told(of, world.device, svo_light_set_sources(made, &setup, world.queue)));
    SVO_I_TRY_CLEANUP(svo_light_save(made, svo_to_path(world.compact_path), NULL, world.queue, &of->message));
    SVO_I_TRY_CLEANUP(
        svo_light_load(of->tree, svo_from_path(world.compact_path), NULL, world.queue, &loaded, &of->message));
    SVO_I_TRY_CLEANUP(told(of, world.device, svo_light_hash(loaded, world.queue, hash)));
    digest(of, hash, sizeof hash);

cleanup:
    svo_light_destroy(&loaded);
    svo_light_destroy(&made);
    return status;
}

/* In buffers: a tree, then its light over it, which waits for the first. */
static svo_status enqueue_pictures(subject *of, svo_light *light, cl_mem pixels, cl_event done[2])
{
    svo_render_options options = {.struct_size = sizeof options, .width = PICTURE_SIDE, .height = PICTURE_SIDE};
    svo_render_options lit = SVO_RENDER_OPTIONS_INIT;
    (void)svo_camera_fit(svo_tree_target(of->tree), 1.0F, &options.camera);
    lit.width = lit.height = PICTURE_SIDE;
    lit.camera = options.camera;
    lit.row_count = SVO_LIGHT_BAND_ROWS;
    TRY_TOLD(svo_render(svo_tree_target(of->tree), &options, svo_in_buffer(pixels),
                        &(svo_submit){.queue = world.queue, .event = &done[0]}));
    return told(of, world.device,
                svo_render(svo_light_target(light), &lit, svo_in_buffer(pixels),
                           &(svo_submit){.queue = world.queue, .num_wait = 1, .wait = done, .event = &done[1]}));
}

static svo_status run_render_buffers(subject *of)
{
    uint8_t picture[PICTURE_SIDE * PICTURE_SIDE * 4];
    cl_event done[2] = {NULL, NULL};
    svo_light *light = NULL;
    faults_spare(true);
    cl_mem pixels = clCreateBuffer(info_of_device(world.device).context, CL_MEM_READ_WRITE, sizeof picture, NULL, NULL);
    faults_spare(false);
    svo_status status = told(of, world.device, svo_light_create(of->tree, NULL, world.queue, &light));
    if (status == SVO_OK) {
        status = enqueue_pictures(of, light, pixels, done);
    }
    faults_spare(true);
    assert_int_equal(clFinish(world.queue), CL_SUCCESS);
    assert_int_equal(clEnqueueReadBuffer(world.queue, pixels, CL_TRUE, 0, sizeof picture, picture, 0, NULL, NULL),
                     CL_SUCCESS);
    for (int i = 0; i < 2 && done[i] != NULL; ++i) {
        clReleaseEvent(done[i]);
    }
    clReleaseMemObject(pixels);
    faults_spare(false);
    digest(of, picture, sizeof picture);
    svo_light_destroy(&light);
    return status;
}

/* The hash of probes, a ray through them, and diffuse light where they have it. */
static svo_status use_probes(subject *of, svo_probes *probes, bool diffuse)
{
    const svo_ray ray = {.origin = {0.3F, 0.3F, 0.3F}, .direction = {1, 2, 3}, .t_max = 8};
    const svo_gather_point point = {.position = {0.3F, 0.3F, 0.3F}, .normal = {0, 0, 1}};
    svo_probe_irradiance irradiance = {.weight = 0};
    svo_probe_hit hit;
    char hash[SVO_HASH_TEXT_BYTES];
    SVO_I_TRY(svo_probes_hash(probes, world.queue, hash));
    SVO_I_TRY(
        svo_probes_trace(probes, svo_in_host(&ray), svo_in_host(&hit), 1, NULL, &(svo_submit){.queue = world.queue}));
    if (diffuse) {
        SVO_I_TRY(svo_probes_irradiance(probes, svo_in_host(&point), svo_in_host(&irradiance), 1,
                                        &(svo_submit){.queue = world.queue}));
    }
    digest(of, hash, sizeof hash);
    digest(of, &hit, sizeof hit);
    digest(of, &irradiance, sizeof irradiance);
    return SVO_OK;
}

/* Probes with radiance and maps, relit. */
static svo_status probe_tree(subject *of, svo_light *light, svo_probe_options *options)
{
    svo_probes *probes = NULL;
    options->light = light;
    options->diffuse = 1;
    options->tree = of->tree;
    SVO_I_TRY(svo_probes_create(options, world.queue, &probes));
    svo_status status = svo_probes_relight(probes, world.queue);
    if (status == SVO_OK) {
        status = use_probes(of, probes, true);
    }
    svo_probes_destroy(&probes);
    return status;
}

static svo_status probe_scene(subject *of, svo_probe_options options)
{
    const svo_instance instance = {0, {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}};
    const svo_scene_options placed = {.struct_size = sizeof placed,
                                      .trees = &of->tree,
                                      .instances = &instance,
                                      .tree_count = 1,
                                      .instance_count = 1,
                                      .need = SVO_NEED_RAYS};
    svo_scene *scene = NULL;
    svo_probes *probes = NULL;
    SVO_I_TRY(svo_scene_create(world.device, &placed, world.queue, &scene));
    options.scene = scene;
    svo_status status = svo_probes_create(&options, world.queue, &probes);
    if (status == SVO_OK) {
        status = use_probes(of, probes, false);
    }
    svo_probes_destroy(&probes);
    svo_scene_destroy(&scene);
    return status;
}

static svo_status run_probes(subject *of)
{
    const svo_light_setup setup = {
        .struct_size = sizeof setup, .sky = {1, 1, 1}, .sky_map = sky_texels, .sky_width = 2, .sky_height = 1};
    svo_probe_options options = {
        .struct_size = sizeof options, .counts = {2, 1, 1}, .resolution = 64, .field_size = 4, .cones = 1};
    svo_light *light = NULL;
    TRY_TOLD(probe_scene(of, options));
    TRY_TOLD(svo_light_create(of->tree, NULL, world.queue, &light));
    svo_status status = svo_light_set_sources(light, &setup, world.queue);
    if (status == SVO_OK) {
        status = probe_tree(of, light, &options);
    }
    svo_light_destroy(&light);
    TRY_TOLD(status);
    return SVO_OK;
}

/*
 * Kernels of the caller's.
 */

static void prepare_kernels(subject *of)
{
    const svo_compact_options records = {.struct_size = sizeof records, .form = SVO_FORM_DESCRIPTOR};
    svo_probe_options options = {
        .struct_size = sizeof options, .counts = {1, 1, 1}, .resolution = 64, .field_size = 4, .cones = 1};
    prepare_tree(of);
    options.tree = of->tree;
    if (svo_compact_create(world.device, of->tree, &records, world.queue, &of->compact) != SVO_OK ||
        svo_light_create(of->tree, NULL, world.queue, &of->light) != SVO_OK ||
        svo_probes_create(&options, world.queue, &of->probes) != SVO_OK) {
        fail_msg("%s", svo_device_message(world.device));
    }
    of->kernels[0] = make_kernel(svo_compact_target(of->compact), "kernel void empty(SVO_TREE_PARAMETERS) {}");
    of->kernels[1] = make_kernel(svo_light_target(of->light), "kernel void empty(SVO_LIGHT_PARAMETERS) {}");
    of->kernels[2] = make_kernel(svo_probes_target(of->probes), "kernel void empty(SVO_PROBES_PARAMETERS) {}");
}

static void cleanup_kernels(subject *of)
{
    for (int i = 0; i < 3; ++i) {
        clReleaseKernel(of->kernels[i]);
    }
    svo_probes_destroy(&of->probes);
    svo_light_destroy(&of->light);
    svo_compact_destroy(&of->compact);
    destroy_all(of);
}

static svo_status run_kernels(subject *of)
{
    TRY_TOLD(svo_kernel_set_arguments(svo_compact_target(of->compact), of->kernels[0], 0));
    TRY_TOLD(svo_kernel_set_arguments(svo_light_target(of->light), of->kernels[1], 0));
    return told(of, world.device, svo_kernel_set_arguments(svo_probes_target(of->probes), of->kernels[2], 0));
}

static const scenario rows[] = {
    {"compact", false, false, prepare_tree, run_compact, NULL, destroy_all},
    {"compact_rays", false, false, prepare_tree, run_compact_rays, NULL, destroy_all},
    {"compact_files", false, false, prepare_tree, run_compact_files, NULL, destroy_all},
    {"solid", false, false, prepare_tree, run_solid, NULL, destroy_all},
    {"scene", false, false, prepare_tree, run_scene, NULL, destroy_all},
    {"light", false, false, prepare_tree, run_light, NULL, destroy_all},
    {"light_files", false, false, prepare_host_tree, run_light_files, NULL, destroy_all},
    {"render_buffers", false, false, prepare_tree, run_render_buffers, NULL, destroy_all},
    {"probes", false, false, prepare_tree, run_probes, NULL, destroy_all},
    {"form_arguments", false, false, prepare_kernels, run_kernels, NULL, cleanup_kernels},
};
const scenario_list form_scenarios = {rows, sizeof rows / sizeof rows[0]};
