/* SPDX-License-Identifier: MIT */
/*
 * Calls that the library makes fail, one at a time: each allocation, each call of OpenCL, OpenGL and EGL, of the file
 * system, of the import child and of the loader. Each failure ends in a status with words that name the call, or in the
 * right result where the library does without. Nothing is lost, handles can be destroyed, and the same handles work in
 * the next call.
 *
 *     test_faults [STRIDE [SCENARIO]]
 *
 * The first call from each place in the library fails, and every STRIDEth of all; 1: all. Without STRIDE, for a quick
 * run, the first call from every second place, and every 200th of all.
 * SCENARIO: the name of one, in faults_library.c, faults_files.c or faults_opengl.c.
 * The environment variable SVOCL_FAULTS_TRACE prints each failed call beforehand. A build with
 * -fsanitize=address,undefined finds more: memory used after its release, and what is lost in the import child.
 */
#define _POSIX_C_SOURCE 200809L
#include <inttypes.h>
#include <setjmp.h>
#include <signal.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

#include "context/context.h"
#include "faults_scenario.h"
#include "support/gl_contexts.h"
#include "support/info_of.h"

enum { CALLS_MAX = 100000, HANG_SECONDS = 120, SCENARIOS_MAX = 100, QUICK_STRIDE = 200 };

#define CHILD_INDEX_VARIABLE  "SVOCL_FAULTS_CHILD_INDEX"
#define CHILD_NOTES           "places" /* instead of an index */
#define CHILD_REPORT_VARIABLE "SVOCL_FAULTS_CHILD_REPORT"

/*
 * The runner.
 */

static void violation(const scenario *played, uint64_t index, faults_call failed, const char *format, ...)
    __attribute__((format(printf, 4, 5)));
static void violation(const scenario *played, uint64_t index, faults_call failed, const char *format, ...)
{
    char text[1024];
    va_list arguments;
    va_start(arguments, format);
    (void)vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    print_error("%s, call %" PRIu64 ", %s: %s\n", played->name, index, failed.name, text);
    ++world.violations;
}

/* Differences in counts of live objects, as text; empty where there are none. */
static const char *list_lost(const faults_objects *before, const faults_objects *after)
{
    static char text[512];
    size_t length = 0;
    text[0] = '\0';
#define LIST(member, words)                                                                 \
    if (before->member != after->member) {                                                  \
        length += (size_t)snprintf(text + length, sizeof text - length, "%+" PRId64 " %s ", \
                                   after->member - before->member, words);                  \
    }
    FAULTS_OBJECT_LIST(LIST)
#undef LIST
    return text;
}

/* Whether a message says what failed: the call by name or by its error, or what there was no memory for. */
static bool says(const char *message, faults_call failed)
{
    const char *const words[FAULT_KINDS][5] = {
        [FAULT_ALLOCATION] = {"memory", "bytes", "outofmem", "when they are needed"},
        [FAULT_OPENCL] = {"CL_OUT_OF_RESOURCES", "when they are needed"},
        [FAULT_OPENGL] = {"GL_OUT_OF_MEMORY"},
        [FAULT_EGL] = {"EGL_BAD_ALLOC", "EGL does not list", "the EGL display does not list", "has no function",
                       "is not current"},
        [FAULT_FILE] = {"Input/output error", "Too many open files", "the reader", "cannot be read", "reading needs"},
        [FAULT_PROCESS] = {"Cannot allocate memory", "Invalid argument", "No child processes"},
        [FAULT_LOADER] = {"libEGL", "function egl", "function OSMesa", "cannot be opened", "is not current"},
    };
    if (strstr(message, failed.name) != NULL) {
        return true;
    }
    for (size_t i = 0; i < 5 && words[failed.kind][i] != NULL; ++i) {
        if (strstr(message, words[failed.kind][i]) != NULL) {
            return true;
        }
    }
    return false;
}

/* A message begins with the function that the caller called or with the file that it named. */
static bool names_caller(const char *message)
{
    return strncmp(message, "svo_", 4) == 0 || strncmp(message, "/tmp/", 5) == 0;
}

static svo_status run_once(const scenario *played, subject *of)
{
    of->message.text[0] = '\0';
    of->warning[0] = '\0';
    of->digest = 0;
    world.device->message.text[0] = '\0';
    return played->run(of);
}

static void look(const scenario *played, subject *of)
{
    if (played->look != NULL) {
        played->look(of);
    }
}

static void arm(const scenario *played, uint64_t index)
{
    if (!played->in_child) {
        faults_arm(index);
        return;
    }
    char text[32];
    (void)snprintf(text, sizeof text, "%" PRIu64, index);
    assert_int_equal(setenv(CHILD_INDEX_VARIABLE, text, 1), 0);
    (void)unlink(world.report_path);
}

/* What failed in the child: a line of its report. */
static faults_call read_report(void)
{
    static char name[64];
    unsigned kind = 0;
    faults_call failed = {0};
    FILE *file = fopen(world.report_path, "r");
    if (file != NULL) {
        if (fscanf(file, "%u %63s", &kind, name) == 2) {
            failed = (faults_call){name, (fault_kind)kind};
        }
        (void)fclose(file);
    }
    return failed;
}

static faults_call disarm(const scenario *played)
{
    if (!played->in_child) {
        return faults_disarm();
    }
    (void)unsetenv(CHILD_INDEX_VARIABLE);
    return read_report();
}

/* One failed call. Returns false when the scenario had fewer calls. */
static bool play(const scenario *played, uint64_t index, XXH64_hash_t expected)
{
    subject of = {0};
    played->prepare(&of);
    (void)snprintf(world.current, sizeof world.current, "%s, call %" PRIu64, played->name, index);
    alarm(HANG_SECONDS);
    arm(played, index);
    svo_status status = run_once(played, &of);
    const bool in_run = played->in_child || faults_failed().name != NULL;
    if (!in_run) {
        played->cleanup(&of);
    }
    const faults_call failed = disarm(played);
    alarm(0);
    if (failed.name != NULL && getenv("SVOCL_FAULTS_TRACE") != NULL) {
        print_message("%s, call %" PRIu64 ", %s: %s %s\n", played->name, index, failed.name,
                      svo_name(SVO_NAME_STATUS, status), of.message.text);
    }
    if (in_run) {
        if (status == SVO_OK) {
            look(played, &of);
            world.recovered += failed.name != NULL ? 1 : 0;
            if (of.digest != expected && !says(of.warning, failed)) {
                violation(played, index, failed, "SVO_OK with a wrong result, warning \"%s\"", of.warning);
            }
        } else if (!names_caller(of.message.text) || !says(of.message.text, failed)) {
            violation(played, index, failed, "%s without words on it: \"%s\"", svo_name(SVO_NAME_STATUS, status),
                      of.message.text);
        }
        status = run_once(played, &of);
        look(played, &of);
        if (status != SVO_OK || of.digest != expected) {
            violation(played, index, failed, "the next run: %s \"%s\"", svo_name(SVO_NAME_STATUS, status),
                      of.message.text);
        }
        played->cleanup(&of);
    }
    if (failed.name != NULL) {
        ++world.failed_calls[failed.kind];
    }
    return failed.name != NULL;
}

/* Where the calls of this scenario come from, and from where one has failed so far. */
static struct {
    uint64_t here[CALLS_MAX], known[CALLS_MAX];
    size_t here_count, known_count;
} places;

/* Whether no call from there has failed yet. */
static bool is_new_place(uint64_t place)
{
    for (size_t i = 0; i < places.known_count; ++i) {
        if (places.known[i] == place) {
            return false;
        }
    }
    assert_true(places.known_count < CALLS_MAX);
    places.known[places.known_count++] = place;
    return true;
}

/* What the child wrote into its report. */
static void read_places(void)
{
    FILE *file = fopen(world.report_path, "r");
    assert_non_null(file);
    while (places.here_count < CALLS_MAX && fscanf(file, "%" SCNx64, &places.here[places.here_count]) == 1) {
        ++places.here_count;
    }
    (void)fclose(file);
}

static void note_places(const scenario *played)
{
    subject of = {0};
    played->prepare(&of);
    places.here_count = 0;
    if (played->in_child) {
        assert_int_equal(setenv(CHILD_INDEX_VARIABLE, CHILD_NOTES, 1), 0);
        assert_int_equal(run_once(played, &of), SVO_OK);
        assert_int_equal(unsetenv(CHILD_INDEX_VARIABLE), 0);
        read_places();
        played->cleanup(&of);
    } else {
        faults_note(places.here, CALLS_MAX);
        const svo_status status = run_once(played, &of);
        played->cleanup(&of);
        (void)faults_disarm();
        assert_int_equal(status, SVO_OK);
        places.here_count = faults_noted();
    }
    assert_in_range(places.here_count, 1, CALLS_MAX - 1);
}

/* Whether that call shall fail: the first from a place, or from every second one, and every how-manieth of all. Then
   those after the end, to find that there are none. */
static bool is_due(uint64_t index)
{
    if (index >= places.here_count) {
        return true;
    }
    const bool is_new = is_new_place(places.here[index]) && (!world.quick || places.known_count % 2 != 0);
    return is_new || index % world.stride == 0;
}

static void play_all(const scenario *played)
{
    subject of = {0};
    if (played->gl && world.context == NULL) {
        print_message("skipped: no OpenGL\n");
        skip();
    }
    played->prepare(&of);
    const svo_status status = run_once(played, &of);
    look(played, &of);
    if (status != SVO_OK) {
        fail_msg("%s: %s", svo_name(SVO_NAME_STATUS, status), of.message.text);
    }
    const XXH64_hash_t expected = of.digest;
    played->cleanup(&of);
    note_places(played);
    const unsigned violations = world.violations;
    uint64_t index = 0, failed_count = 0;
    for (; index < CALLS_MAX; ++index) {
        if (!is_due(index)) {
            continue;
        }
        const faults_objects before = faults_live;
        const faults_call none = {"?", FAULT_ALLOCATION};
        const bool more = play(played, index, expected);
        const char *lost = list_lost(&before, &faults_live);
        if (lost[0] != '\0') {
            violation(played, index, more && faults_failed().name != NULL ? faults_failed() : none, "left behind: %s",
                      lost);
        }
        if (!more) {
            break;
        }
        ++failed_count;
    }
    print_message("%s: %" PRIu64 " of about %" PRIu64 " calls failed\n", played->name, failed_count, index);
    assert_in_range(index, 1, CALLS_MAX - 1);
    assert_int_equal(world.violations, violations);
}

static void play_scenario(void **state)
{
    play_all(*state);
}

/*
 * What scenarios share.
 */

static void say_where(int number)
{
    (void)number;
    static const char words[] = "hangs: ";
    (void)!write(STDERR_FILENO, words, sizeof words - 1);
    (void)!write(STDERR_FILENO, world.current, strlen(world.current));
    (void)!write(STDERR_FILENO, "\n", 1);
    _exit(1);
}

static void write_text(const char *name, const char *text)
{
    char path[160];
    (void)snprintf(path, sizeof path, "%s/%s", world.folder, name);
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    (void)fputs(text, file);
    assert_int_equal(fclose(file), 0);
}

static void write_meshes(void)
{
    write_text("a.obj", "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nvt 0 0\nvt 1 0\nvt 0 1\nusemtl a\n"
                        "f 1/1 2/2 3/3\nusemtl b\nf 1/1 2/2 4/3\n");
    write_text("a.mtl", "newmtl a\nKd 1 0 0\nmap_Kd a.ppm\nnewmtl b\nKd 0 1 0\n");
    write_text("a.ppm", "P6\n2 2\n255\nabcdefghijkl");
    write_text("a.ply", "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
                        "property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
                        "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n");
    write_text("a.stl", "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n"
                        "endloop\nendfacet\nendsolid a\n");
    write_text("a.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n");
    /* Three positions, three texture coordinates; the picture above. */
    write_text("a.gltf",
               "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{\"mesh\":0}],"
               "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0,\"TEXCOORD_0\":1},\"material\":0}]}],"
               "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\","
               "\"min\":[0,0,0],\"max\":[1,1,0]},"
               "{\"bufferView\":1,\"componentType\":5126,\"count\":3,\"type\":\"VEC2\"}],"
               "\"bufferViews\":[{\"buffer\":0,\"byteLength\":36},"
               "{\"buffer\":0,\"byteOffset\":36,\"byteLength\":24}],"
               "\"buffers\":[{\"byteLength\":60,\"uri\":\"data:application/octet-stream;base64,"
               "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAAAAAAAAAAAAAIA/AAAAAAAAAAAAAIA/\"}],"
               "\"images\":[{\"uri\":\"data:image/png;base64,UDYKMiAyCjI1NQphYmNkZWZnaGlqa2w=\"}],"
               "\"textures\":[{\"source\":0}],"
               "\"materials\":[{\"pbrMetallicRoughness\":{\"baseColorTexture\":{\"index\":0}}}]}");
}

static void write_bytes(const char *name, const char *head, size_t head_bytes, const void *data, size_t data_bytes)
{
    char path[160];
    (void)snprintf(path, sizeof path, "%s/%s", world.folder, name);
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(head, 1, head_bytes, file), head_bytes);
    assert_int_equal(fwrite(data, 1, data_bytes, file), data_bytes);
    assert_int_equal(fclose(file), 0);
}

/* Files that are read in blocks: a facet and a quad. */
static void write_binary_meshes(void)
{
    static const char ply[] = "ply\nformat binary_little_endian 1.0\nelement vertex 4\nproperty float x\n"
                              "property float y\nproperty float z\nelement face 1\n"
                              "property list int int vertex_indices\nend_header\n";
    const struct {
        float vertices[12];
        int32_t face[5];
    } quad = {{0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0}, {4, 0, 1, 2, 3}};
    const struct {
        uint32_t count;
        float facet[12];
        char attribute[4];
    } facets = {1, {0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0}, {0}};
    const char head[80] = "binary";
    write_bytes("b.ply", ply, sizeof ply - 1, &quad, sizeof quad);
    write_bytes("b.stl", head, sizeof head, &facets, sizeof facets - 2);
}

static void make_gl_buffer(void)
{
    const svo_i_gl_functions *gl = svo_i_gl_context_functions(world.context);
    svo_message message = {""};
    assert_int_equal(svo_i_gl_context_make_current(world.context, &message), SVO_OK);
    gl->GenBuffers(1, &world.gl_buffer);
    gl->BindBuffer(GL_COPY_READ_BUFFER, world.gl_buffer);
    gl->BufferData(GL_COPY_READ_BUFFER, sizeof world.rays, world.rays, GL_STATIC_DRAW);
    svo_i_gl_context_release_current(world.context);
}

static void open_gl(void)
{
    svo_message message = {""};
    if (context_of_kind(SVO_GL_SURFACELESS, 0, &world.context, &message) != SVO_OK) {
        print_message("no OpenGL: %s\n", message.text);
        return;
    }
    svo_gl_options options = {.struct_size = sizeof options, .share = SVO_GL_SHARE_HOST};
    if (svo_gl_create(world.device, world.context, &options, &world.host) != SVO_OK) {
        fail_msg("%s", svo_device_message(world.device));
    }
    options.share = SVO_GL_SHARE_COPY;
    if (svo_gl_create(world.device, world.context, &options, &world.copy) != SVO_OK) {
        fail_msg("%s", svo_device_message(world.device));
    }
    make_gl_buffer();
    own_context_make_or_skip(false, &world.own);
    own_context_bind(&world.own, false);
}

/* A device with one compiled program, that of pictures. */
static void open_saver(void)
{
    svo_message message = {""};
    svo_tree *tree = NULL;
    uint8_t picture[4];
    svo_render_options options = {.struct_size = sizeof options, .width = 1, .height = 1};
    if (svo_device_create(info_of_device(world.device).context, info_of_device(world.device).device, NULL, &world.saver,
                          &message) != SVO_OK ||
        svo_tree_load(svo_from_path(world.tree_path), NULL, &tree, &message) != SVO_OK) {
        fail_msg("%s", message.text);
    }
    (void)svo_camera_fit(svo_tree_target(tree), 1.0F, &options.camera);
    size_t saved = 0;
    if (svo_tree_upload(tree, world.saver, NULL) != SVO_OK ||
        svo_render(svo_tree_target(tree), &options, svo_in_host(picture), NULL) != SVO_OK ||
        svo_device_save_kernels(world.saver, world.kernels_folder, &saved) != SVO_OK) {
        fail_msg("%s", svo_device_message(world.saver));
    }
    assert_int_equal(saved, 1);
    svo_tree_destroy(&tree);
}

/* Makes what the process keeps: a part of the device, for handles with a limit of threads. */
static void open_part(void)
{
    const svo_device_options options = {.struct_size = sizeof options, .device_name = "o", .max_threads = 1};
    svo_device *device = NULL;
    const svo_status status = svo_device_create_default(&options, &device, NULL);
    assert_true(status == SVO_OK || status == SVO_UNSUPPORTED);
    svo_device_destroy(&device);
    world.kept = faults_live;
}

static int open_world(void **state)
{
    (void)state;
    svo_message message = {""};
    (void)signal(SIGALRM, say_where);
    open_part();
    if (svo_device_create_default(NULL, &world.device, &message) != SVO_OK) {
        fail_msg("%s", message.text);
    }
    world.queue = clCreateCommandQueue(info_of_device(world.device).context, info_of_device(world.device).device,
                                       CL_QUEUE_PROFILING_ENABLE, NULL);
    assert_non_null(world.queue);
    assert_int_equal(svo_frontend_create_cl(world.device, &world.cl), SVO_OK);
    attributed_mesh_create(7, TRIANGLES, 0.0, &world.mesh);
    world.floats = world.mesh.mesh;
    world.floats.positions = world.float_positions;
    world.floats.positions_double = NULL;
    assert_int_equal(world.floats.vertex_count * 3, sizeof world.float_positions / sizeof world.float_positions[0]);
    for (size_t i = 0; i < world.floats.vertex_count * 3; ++i) {
        world.float_positions[i] = (float)world.mesh.base.positions[i];
    }
    uint64_t random = 3;
    for (size_t i = 0; i < RAYS; ++i) {
        for (size_t axis = 0; axis < 3; ++axis) {
            world.rays[i].origin[axis] = (float)random_unit(&random) * 4.0F - 2.0F;
            world.rays[i].direction[axis] = 0.5F - world.rays[i].origin[axis];
            world.points[i].position[axis] = (float)random_unit(&random);
        }
        world.rays[i].t_max = 10.0F;
        world.points[i].max_distance = 10.0F;
    }
    (void)snprintf(world.folder, sizeof world.folder, "/tmp/test_faults.XXXXXX");
    assert_non_null(mkdtemp(world.folder));
    (void)snprintf(world.obj_path, sizeof world.obj_path, "%s/a.obj", world.folder);
    (void)snprintf(world.ply_path, sizeof world.ply_path, "%s/a.ply", world.folder);
    (void)snprintf(world.stl_path, sizeof world.stl_path, "%s/a.stl", world.folder);
    (void)snprintf(world.off_path, sizeof world.off_path, "%s/a.off", world.folder);
    (void)snprintf(world.gltf_path, sizeof world.gltf_path, "%s/a.gltf", world.folder);
    (void)snprintf(world.kernels_folder, sizeof world.kernels_folder, "%s/kernels", world.folder);
    (void)snprintf(world.tree_path, sizeof world.tree_path, "%s/a.svo", world.folder);
    (void)snprintf(world.compact_path, sizeof world.compact_path, "%s/a.svc", world.folder);
    (void)snprintf(world.vox_path, sizeof world.vox_path, "%s/a.vox", world.folder);
    (void)snprintf(world.packed_path, sizeof world.packed_path, "%s/b.svo", world.folder);
    (void)snprintf(world.report_path, sizeof world.report_path, "%s/report", world.folder);
    assert_int_equal(setenv(CHILD_REPORT_VARIABLE, world.report_path, 1), 0);
    write_meshes();
    write_binary_meshes();
    world.kernel = make_kernel(svo_tree_target(NULL), "kernel void empty(SVO_TREE_PARAMETERS) {}");
    subject of = {0};
    prepare_host_tree(&of);
    assert_int_equal(run_save(&of), SVO_OK);
    destroy_all(&of);
    open_saver();
    open_gl();
    return 0;
}

static int close_world(void **state)
{
    (void)state;
    uint64_t sum = 0;
    print_message("failed calls:");
    for (unsigned i = 0; i < FAULT_KINDS; ++i) {
        print_message(" %s %" PRIu64 ",", fault_kind_name((fault_kind)i), world.failed_calls[i]);
        sum += world.failed_calls[i];
    }
    print_message(" in all %" PRIu64 "; of those without effect on the result %" PRIu64 "\n", sum, world.recovered);
    if (world.context != NULL) {
        own_context_destroy(&world.own);
        svo_message message = {""};
        assert_int_equal(svo_i_gl_context_make_current(world.context, &message), SVO_OK);
        svo_i_gl_context_functions(world.context)->DeleteBuffers(1, &world.gl_buffer);
        svo_i_gl_context_release_current(world.context);
    }
    clReleaseKernel(world.kernel);
    svo_gl_destroy(&world.host);
    svo_gl_destroy(&world.copy);
    svo_gl_context_destroy(&world.context);
    attributed_mesh_destroy(&world.mesh);
    svo_frontend_destroy(&world.cl);
    clReleaseCommandQueue(world.queue);
    svo_device_destroy(&world.saver);
    svo_device_destroy(&world.device);
    remove_kernels();
    (void)rmdir(world.kernels_folder);
    const char *const names[] = {"a.gltf", "a.obj", "a.mtl", "a.ppm", "a.ply", "a.stl", "b.ply",
                                 "b.stl",  "a.off", "a.svo", "b.svo", "a.svc", "a.vox", "report"};
    for (size_t i = 0; i < sizeof names / sizeof names[0]; ++i) {
        char path[160];
        (void)snprintf(path, sizeof path, "%s/%s", world.folder, names[i]);
        (void)unlink(path);
    }
    if (rmdir(world.folder) != 0) { /* a temporary file was left */
        print_error("%s is not empty\n", world.folder);
        ++world.violations;
    }
    const char *lost = list_lost(&world.kept, &faults_live);
    if (lost[0] != '\0') {
        print_error("left behind at the end: %s\n", lost);
        ++world.violations;
    }
    return 0;
}

/* In the import child: the calls of svo_import_child_main fail. The report is written even where it crashes. */
static void report_child(void)
{
    const faults_call failed = faults_disarm();
    const size_t noted = faults_noted();
    FILE *file = failed.name != NULL || noted > 0 ? fopen(getenv(CHILD_REPORT_VARIABLE), "w") : NULL;
    if (file != NULL && failed.name != NULL) {
        (void)fprintf(file, "%u %s\n", (unsigned)failed.kind, failed.name);
    }
    for (size_t i = 0; file != NULL && i < noted; ++i) {
        (void)fprintf(file, "%" PRIx64 "\n", places.here[i]);
    }
    if (file != NULL) {
        (void)fclose(file);
    }
}

int main(int argc, char **argv)
{
    int exit_code = 0;
    const char *child_index = getenv(CHILD_INDEX_VARIABLE);
    if (child_index != NULL && strcmp(child_index, CHILD_NOTES) == 0) {
        faults_note(places.here, CALLS_MAX);
    } else if (child_index != NULL) {
        faults_arm(strtoull(child_index, NULL, 10));
    }
    if (svo_import_child_main(argc, argv, &exit_code) != 0) {
        report_child();
        return exit_code;
    }
    (void)faults_disarm();
    world.quick = argc < 2;
    world.stride = world.quick ? QUICK_STRIDE : strtoull(argv[1], NULL, 10);
    if (world.stride == 0 || argc > 3) {
        (void)fprintf(stderr, "usage: %s [STRIDE [SCENARIO]]\n", argv[0]);
        return 2;
    }
    const scenario_list *const lists[] = {&library_scenarios, &form_scenarios, &file_scenarios, &opengl_scenarios};
    struct CMUnitTest tests[SCENARIOS_MAX];
    size_t count = 0;
    for (size_t i = 0; i < sizeof lists / sizeof lists[0]; ++i) {
        for (size_t k = 0; k < lists[i]->count; ++k) {
            const scenario *row = &lists[i]->rows[k];
            if (argc < 3 || strcmp(argv[2], row->name) == 0) {
                assert_true(count < SCENARIOS_MAX);
                tests[count++] = (struct CMUnitTest){
                    .name = row->name, .test_func = play_scenario, .initial_state = (void *)(uintptr_t)row};
            }
        }
    }
    assert_in_range(count, 1, SCENARIOS_MAX);
    const int failed = _cmocka_run_group_tests("test_faults", tests, count, open_world, close_world);
    return failed != 0 || world.violations > 0 ? 1 : 0; /* cmocka does not count what close_world finds */
}
