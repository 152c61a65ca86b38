/* SPDX-License-Identifier: MIT */
/* The svocl program from the point of view of its users: command lines, exit codes, one-line errors, JSON names,
   files that are complete or absent. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "run_program.h"
#include "support/suite.h"

static void usage_errors_exit_with_code_2(void **state)
{
    (void)state;
    run_badly("$SVOCL", 2, "no command");
    run_badly("$SVOCL voxelize x", 2, "'voxelize'");
    run_badly("$SVOCL build", 2, "INPUT");
    run_badly("$SVOCL build scene:cube -d 0", 2, "depth 0 is below 1");
    run_badly("$SVOCL build scene:cube -d 17", 2, "depth 17 is above 16");
    run_badly("$SVOCL build scene:cube -d nine", 2, "'nine'");
    run_badly("$SVOCL build scene:cube -d", 2, "needs a value");
    run_badly("$SVOCL build scene:cube --size 3x3", 2, "--size");
    run_badly("$SVOCL build scene:cube --deep 3", 2, "'--deep'");
    run_badly("$SVOCL build scene:cube extra", 2, "'extra'");
    run_badly("$SVOCL build scene:cube --origin 0,0,0", 2, "--edge");
    run_badly("$SVOCL build scene:cube --origin 0,0 --edge 1", 2, "'0,0'");
    run_badly("$SVOCL build scene:cube --origin 0,0,0 --edge -1", 2, "'-1'");
    run_badly("$SVOCL build scene:cube --edge nan --origin 0,0,0", 2, "'nan'");
    run_badly("$SVOCL build scene:cube --drop-alpha 0", 2, "--drop-alpha '0' is not a number above 0 and at most 1");
    run_badly("$SVOCL build scene:cube --drop-alpha 1.01", 2, "'1.01'");
    run_badly("$SVOCL build scene:cube --drop-alpha .1x", 2, "'.1x'");
    run_badly("$SVOCL build scene:cube --drop-alpha .5 --solid winding", 2, "--drop-alpha does not apply with --solid");
    run_badly("$SVOCL verify scene:cube --drop-alpha .5", 2, "--drop-alpha does not apply to verify");
    run_badly("$SVOCL build scene:cube --need color,taste", 2, "'color,taste'");
    run_badly("$SVOCL build scene:cube --threads 0", 2, "threads 0 is below 1");
    run_badly("$SVOCL build scene:cube --path fpga", 2, "--path 'fpga' is none of cpu, gpu");
    run_badly("$SVOCL build scene:cube --context glx", 2, "'glx'");
    run_badly("$SVOCL build scene:cube --context osmesa --gl-device 0", 2, "--gl-device");
    run_badly("$SVOCL build scene:cube --frontend cl --share host", 2, "--share");
    run_badly("$SVOCL build scene:cube --frontend cl --context osmesa", 2, "--context");
    run_badly("$SVOCL build scene:cube --compress", 2, "-o FILE");
    run_badly("$SVOCL build scene:cube --plan-only -o a.svo", 2, "-o FILE");
    run_badly("$SVOCL build scene:cube --plan-only --repeat 2", 2, "--repeat");
    run_badly("$SVOCL build scene:castle", 2, "castle");
    run_badly("$SVOCL build scene:cube:0", 2, "0");
    run_badly("$SVOCL scene cube", 2, "-o");
    run_badly("$SVOCL render scene:cube", 2, "-o");
    run_badly("$SVOCL render scene:cube -o a.png --size 0x7", 2, "'0x7'");
    run_badly("$SVOCL render tree.svo -o a.png -d 8", 2, "tree.svo");
}

/* What a command, or what it does with its input, cannot use is refused before anything is read. */
static void options_without_effect_are_refused(void **state)
{
    (void)state;
    static const char *const lines[][2] = {
        {"build scene:cube --plan-only --count-first", "--count-first does not apply"},
        {"build scene:cube --max-memory 1M -o a.svo --frame 2", "--frame do not apply with --max-memory"},
        {"parts plan scene:cube -o a.svo --part 1", "--part does not apply to parts plan"},
        {"parts plan scene:cube -o a.svo --builder sorted", "--builder sorted makes no parts"},
        {"parts build a.svo.parts -d 3", "--depth does not apply to parts build"},
        {"parts build a.svo.parts --json", "--json does not apply to parts build"},
        {"parts status a.svo.parts -o b.svo", "--output does not apply to parts status"},
        {"parts stitch a.svo.parts --part 1", "--part does not apply to parts stitch"},
        {"parts remove a.svo.parts --device 0.0", "--device does not apply to parts remove"},
        {"scene --seed 2", "--seed does not apply without NAME"},
        {"scene cube:20 --seed 5 -o a.ply", "--seed does not apply to a NAME with numbers"},
        {"gather scene:cube --points a.csv --seed 2 -o b.csv", "--seed does not apply to points of a file"},
        {"hash a.svo --device 0.0", "--device does not apply to a finished tree"},
        {"verify a.svo --threads 1", "--threads does not apply to a finished tree"},
        {"hash a.svo --frame 2", "--frame applies to voxel files"},
        {"hash a.svo --hidden", "--hidden applies to voxel files"},
        {"hash a.vox --share host", "--share does not apply to voxels"},
        {"build a.vox --weights area", "--weights does not apply to voxels"},
        {"build a.vox --drop-alpha .5", "--drop-alpha does not apply to voxels"},
        {"convert a.vox a.svo --levels 2", "--levels applies to .svo files"},
        {"trace scene:cube --rays a.csv --size 2x2 -o b.csv", "--size does not apply with --rays"},
        {"trace scene:cube --camera auto --need color -o b.csv", "--need does not apply to rays"},
        {"reference scene:cube --points 3 --weights uniform -o b.csv", "--weights does not apply to paths"},
        {"kernels scene:cube --frontend gl-expand", "OpenGL does not apply"},
        {"render scene:cube -o a.png --gi off", "--gi does not apply"},
        {"render scene:cube -o a.png --through probes --gi off", "--gi does not apply"},
        {"render scene:cube -o a.png --exposure 2", "--exposure does not apply"},
        {"report --from a.json -o a --scenes cube", "--scenes does not apply with --from"},
        {"bench rays --workers 2", "--workers does not apply to bench rays"},
        {"bench rays --need color", "--need does not apply to bench rays"},
        {"bench e1 --depths 5", "--depths does not apply to bench e1"},
        {"bench parts-large --depths 4", "--depths does not apply to bench parts-large"},
        {"bench parts --ray-count 9", "--ray-count does not apply to bench parts"},
        {"bench memory --coverage half-open", "--coverage does not apply to bench memory"},
    };
    for (size_t i = 0; i < sizeof lines / sizeof lines[0]; ++i) {
        char line[128];
        (void)snprintf(line, sizeof line, "$SVOCL %s", lines[i][0]);
        run_badly(line, 2, lines[i][1]);
    }
    expect_files(NULL, 0);
}

static void names_without_meaning_are_refused(void **state)
{
    (void)state;
    run_badly("$SVOCL build scene:cube --coverage thick", 2, "--coverage");
}

/* Help fits a terminal of 80 columns. */
static void expect_narrow(const char *text)
{
    while (*text != '\0') {
        const size_t width = strcspn(text, "\n");
        if (width > 80) {
            fail_msg("%zu columns: %.*s", width, (int)width, text);
        }
        text += width + strspn(text + width, "\n");
    }
}

static void help_goes_to_standard_output(void **state)
{
    (void)state;
    static const char *const lines[] = {"--help",
                                        "help",
                                        "devices --help",
                                        "scene --help",
                                        "help build",
                                        "info --help",
                                        "hash --help",
                                        "verify --help",
                                        "render --help",
                                        "trace --help",
                                        "reference --help",
                                        "stress --help",
                                        "report --help",
                                        "kernels --help",
                                        "man --help",
                                        "--version",
                                        "scene",
                                        "scene --json",
                                        "build -h",
                                        "bench --help",
                                        "man",
                                        "man build",
                                        "completion --help",
                                        "completion bash",
                                        "completion zsh",
                                        "export-web -h"};
    for (size_t i = 0; i < sizeof lines / sizeof lines[0]; ++i) {
        char line[64];
        snprintf(line, sizeof line, "$SVOCL %s", lines[i]);
        run_well(line);
        assert_string_equal(last.errors, "");
        assert_true(strlen(last.output) > 5);
        assert_null(strchr(last.output, '\033'));
        if (strstr(lines[i], "-h") != NULL || strstr(lines[i], "help") != NULL) {
            expect_narrow(last.output);
        }
    }
}

static void scenes_are_written_and_read_again(void **state)
{
    (void)state;
    need_builds();
    run_well("$SVOCL scene knot --triangles 2000 --seed 3 -o knot.obj");
    run_well("$SVOCL scene knot --triangles 2000 --seed 3 -o knot.ply");
    cJSON *made = run_json("$SVOCL build scene:knot:2000:3 -d 6 --json");
    cJSON *read = run_json("$SVOCL build knot.ply -d 6 --json");
    assert_string_equal(text_of(made, "hash"), text_of(read, "hash"));
    cJSON_Delete(made);
    cJSON_Delete(read);
    cJSON *written = run_json("$SVOCL scene knot:2000:3 -o knot.ply --json");
    assert_true(number_of(written, "seed") == 3.0 && number_of(written, "triangles") == 2000.0);
    cJSON_Delete(written);
    run_badly("$SVOCL scene knot -o knot.xyz", 2, "knot.xyz");
}

static void bad_meshes_are_one_line(void **state)
{
    (void)state;
    run_badly("$SVOCL build missing.obj", 1, "missing.obj");
    write_text("empty.obj", "");
    run_badly("$SVOCL build empty.obj", 1, "empty.obj");
    write_text("points.obj", "v 0 0 0\nv 1 0 0\n");
    run_badly("$SVOCL build points.obj", 1, "points.obj");
    write_text("words.ply", "this is no mesh\n");
    run_badly("$SVOCL build words.ply", 1, "words.ply");
    write_text("words.txt", "this is no mesh\n");
    run_badly("$SVOCL hash words.txt", 1, "words.txt");
    write_text("cut.ply",
               "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
               "property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n");
    run_badly("$SVOCL verify cut.ply", 1, "cut.ply");
    run_badly("$SVOCL build .", 1, ".");
}

#define PLY_HEADER(faces)                                                                             \
    "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n" \
    "element face " faces "\nproperty list uchar int vertex_indices\nend_header\n"

static void triangles_that_are_not_finite_are_counted(void **state)
{
    (void)state;
    need_builds();
    write_text("nan.ply", PLY_HEADER("2") "0 0 0\n1 0 0\n0 1 0\nnan 1 1\n3 0 1 2\n3 0 1 3\n");
    cJSON *document = run_json("$SVOCL build nan.ply -d 4 --json");
    assert_int_equal((int)number_of(document, "triangles"), 2);
    assert_int_equal((int)number_of(document, "refused_triangles"), 1);
    const cJSON *reasons = cJSON_GetObjectItem(document, "refused_reasons");
    assert_int_equal((int)number_of(reasons, "not_finite"), 1);
    cJSON_Delete(document);
    run_well("$SVOCL verify nan.ply -d 4");
    assert_non_null(strstr(last.output, "1 of 2 triangles refused"));
    assert_non_null(strstr(last.output, "exact: 0 missed, 0 surplus"));
    run_well("$SVOCL verify nan.ply -d 4 --tree-form all");
    assert_non_null(strstr(last.output, "the same tree"));
    run_badly("$SVOCL verify nan.ply --tree-form small", 2, "--tree-form 'small' is none of descriptor");
    write_text("all_nan.ply", PLY_HEADER("1") "nan 0 0\n1 0 0\n0 1 0\n0 1 1\n3 0 1 2\n");
    run_badly("$SVOCL build all_nan.ply -d 4", 1, "all_nan.ply: no valid triangle");
}

/* The reader may refuse the whole file; otherwise the triangle is refused and counted. */
static void indices_out_of_range_are_named(void **state)
{
    (void)state;
    need_builds();
    write_text("range.ply", PLY_HEADER("2") "0 0 0\n1 0 0\n0 1 0\n1 1 1\n3 0 1 2\n3 0 1 9\n");
    run("$SVOCL build range.ply -d 4");
    if (last.exit_code == 0) {
        assert_non_null(strstr(last.output, "1 with an index out of range"));
    } else {
        run_badly("$SVOCL build range.ply -d 4", 1, "range.ply");
    }
}

static void missing_drivers_are_one_line(void **state)
{
    (void)state;
    run_badly("OCL_ICD_VENDORS=/nonexistent $SVOCL build scene:cube -d 3", 1, "OpenCL");
    run("OCL_ICD_VENDORS=/nonexistent $SVOCL devices --json");
    assert_int_equal(last.exit_code, 1);
    assert_non_null(strstr(last.errors, "no OpenCL device"));
    run_badly("$SVOCL build scene:cube --device no-such-device", 1, "no-such-device");
    if (!gl_works()) {
        run_badly("$SVOCL build scene:cube -d 3 --frontend gl-expand", 1, "OpenGL");
        return;
    }
    run_badly("__EGL_VENDOR_LIBRARY_FILENAMES=/nonexistent $SVOCL build scene:cube -d 3 --context surfaceless", 1,
              "surfaceless");
    run_badly("__EGL_VENDOR_LIBRARY_FILENAMES=/nonexistent $SVOCL build scene:cube -d 3 --context egl-device", 1,
              "egl");
    run_badly("$SVOCL build scene:cube -d 3 --gl-device 900", 1, "900");
    run_badly("$SVOCL build scene:cube -d 3 --gl-device no-such-renderer", 1,
              "no EGL device matches \"no-such-renderer\"");
}

/* PoCL has no device when it cannot write to its cache folder. */
static void a_platform_without_a_device_is_named(void **state)
{
    (void)state;
    need_builds();
#define WITHOUT_CACHE "env -u POCL_CACHE_DIR -u XDG_CACHE_HOME HOME=/proc $SVOCL "
    run(WITHOUT_CACHE "build scene:cube -d 2");
    if (last.exit_code == 0) {
        print_message("skipped: a platform finds a device without a cache folder\n");
        skip();
    }
    run_badly(WITHOUT_CACHE "build scene:cube -d 2", 1, "no OpenCL device; without any device: platform \"");
    run_badly(WITHOUT_CACHE "build scene:cube -d 2", 1, "its cache folder cannot be written");
    run_badly(WITHOUT_CACHE "build scene:cube -d 2 --device nothing", 1,
              "no OpenCL device matches \"nothing\"; without");
#undef WITHOUT_CACHE
    run_badly("$SVOCL build scene:cube -d 2 --device nothing", 1, "no OpenCL device matches \"nothing\"");
}

static void a_forced_choice_that_does_not_work_fails(void **state)
{
    (void)state;
    need_builds();
    const bool gl = gl_works();
    if (!method_works(NULL, "frontends", "gl-hw")) {
        run_badly("$SVOCL build scene:cube -d 3 --frontend gl-hw", 1, gl ? "gl-hw" : "OpenGL");
    }
    if (!method_works(NULL, "shares", "interop")) {
        run_badly("$SVOCL build scene:cube -d 3 --share interop", 1, gl ? "interop" : "OpenGL");
    }
}

static void failed_writes_leave_nothing(void **state)
{
    (void)state;
    need_builds();
    static const char *const expected[] = {"old.svo"};
    run_badly("$SVOCL build scene:cube -d 3 -o nowhere/a.svo", 1, "nowhere/a.svo");
    run_badly("$SVOCL render scene:cube -d 3 -o nowhere/a.png", 1, "nowhere/a.png");
    run_badly("$SVOCL scene cube -o nowhere/a.obj", 1, "nowhere/a.obj");
    write_text("old.svo", "an older file");
    run_well("$SVOCL build scene:terrain:2000 -d 10"); /* PoCL writes, and caches, some MiB of kernels */
    run_badly("ulimit -f 16384; $SVOCL build scene:terrain:2000 -d 10 -o old.svo", 1, "old.svo");
    char text[64];
    read_text("old.svo", text, sizeof text);
    assert_string_equal(text, "an older file");
    run_badly("$SVOCL render scene:terrain:2000 -d 6 --size 64x64 -o /dev/full", 1, "/dev/full");
    run_badly("ulimit -f 16; $SVOCL scene terrain --triangles 2000 -o a.ply", 1, "a.ply");
    run_badly("ulimit -f 16; $SVOCL scene cornell --triangles 2000 -o a.obj", 1, "a.obj");
    expect_files(expected, 1);
}

/* Every command that writes a file, through a link that leads to a file, and one that leads nowhere yet. */
static void links_stay_and_their_targets_are_written(void **state)
{
    (void)state;
    need_builds();
    static const char *const lines[] = {"build scene:cube -d 3 -o", "render scene:cube -d 3 --size 8x6 -o",
                                        "trace scene:cube -d 3 --camera auto --size 4x4 -o",
                                        "scene cube --triangles 12 -o"};
    static const char *const suffixes[] = {"svo", "png", "csv", "obj"};
    run_well("mkdir data");
    for (size_t i = 0; i < sizeof lines / sizeof lines[0]; ++i) {
        char line[256];
        snprintf(line, sizeof line, "ln -s data/f.%s l.%s && $SVOCL %s l.%s && test -L l.%s && test -s data/f.%s",
                 suffixes[i], suffixes[i], lines[i], suffixes[i], suffixes[i], suffixes[i]);
        run_well(line);
        snprintf(line, sizeof line, "echo old >data/f.%s; $SVOCL %s l.%s && test -L l.%s && ! grep -x old data/f.%s",
                 suffixes[i], lines[i], suffixes[i], suffixes[i], suffixes[i]);
        run_well(line);
    }
    run_well("$SVOCL scene cube --triangles 12 -o a.ply; ln -s a.ply b.ply; $SVOCL scene knot -o b.ply; test -L b.ply");
    run_well("mkdir taken.ply");
    run_badly("$SVOCL scene cube -o taken.ply", 1, "taken.ply: Is a directory");
}

/* A link to standard output, as /dev/stdout is one: the bytes go to it from where it stands. */
static void standard_output_is_a_file(void **state)
{
    (void)state;
    need_builds();
    run_well("$SVOCL render scene:cube -d 3 --size 8x6 -o a.png");
    run_well("ln -s /proc/self/fd/1 out; $SVOCL render scene:cube -d 3 --size 8x6 -o out >b.png");
    run_well("test -L out && cmp a.png b.png");
    run_well("$SVOCL render scene:cube -d 3 --size 8x6 -o - >c.png && cmp a.png c.png");
    run_well("$SVOCL render scene:cube -d 3 --size 8x6 -o /dev/stdout | cmp a.png -");
    run_well("(printf before; $SVOCL scene cube --triangles 12 -o -; printf after) >d; "
             "$SVOCL scene cube --triangles 12 -o d.ply; (printf before; cat d.ply; printf after) | cmp d -");
    run_well("$SVOCL build scene:cube -d 3 -o a.svo && $SVOCL build scene:cube -d 3 -o - | cmp a.svo -");
    run_well("$SVOCL trace scene:cube -d 3 --camera auto --size 4x4 -o a.csv -q && "
             "$SVOCL trace scene:cube -d 3 --camera auto --size 4x4 -o - --quiet");
    assert_int_equal(strncmp(last.output, "ray,t,triangle,u,v\n", 19), 0);
    assert_string_equal(last.errors, "");
    run_well("$SVOCL build scene:cube -d 3 -o - >b.svo"); /* what is printed goes to standard error */
    assert_non_null(strstr(last.errors, "hash"));
    run_well("$SVOCL info b.svo --json");
    run_badly("$SVOCL build scene:cube -d 3 --json -o -", 2, "--json and -o -");
    run_badly("$SVOCL report --quick -o -", 2, "a folder is needed");
    run("$SVOCL build scene:cube -d 3 -o c.svo >&-"); /* the file does not take the place of what is closed */
    run_well("cmp a.svo c.svo");
    run_well("rm -f out *.png *.svo *.csv d d.ply");
    expect_files(NULL, 0);
}

static void meshes_and_trees_come_through_pipes(void **state)
{
    (void)state;
    need_builds();
    run_well("$SVOCL hash scene:cube -d 4");
    char hash[64];
    snprintf(hash, sizeof hash, "%.32s", last.output);
    static const char *const lines[] = {
        "$SVOCL scene cube -o - | $SVOCL hash - -d 4",
        "$SVOCL scene cube -o - | $SVOCL hash /dev/stdin -d 4",
        "$SVOCL scene cube -o cube.ply -q; $SVOCL hash - -d 4 <cube.ply",
        "$SVOCL scene cube -o cube.ply -q; mkfifo p.ply; cat cube.ply >p.ply & $SVOCL hash p.ply -d 4",
        "$SVOCL build scene:cube -d 4 -o - | $SVOCL hash -",
    };
    for (size_t i = 0; i < sizeof lines / sizeof lines[0]; ++i) {
        run_well(lines[i]);
        if (strncmp(last.output, hash, 32) != 0) {
            fail_msg("%s: %s instead of %s", lines[i], last.output, hash);
        }
    }
    write_text("one.obj", "# a triangle\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    write_text("one.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n");
    write_text("one.stl", "solid one\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n"
                          "endloop\nendfacet\nendsolid one\n");
    static const char *const suffixes[] = {"obj", "off", "stl"};
    for (size_t i = 0; i < 3; ++i) {
        char line[128];
        snprintf(line, sizeof line, "cat one.%s | $SVOCL verify - -d 3 --json", suffixes[i]);
        cJSON *document = run_json(line);
        assert_int_equal((int)number_of(document, "expected_voxels") > 0, 1);
        assert_string_equal(text_of(document, "input"), "standard input");
        cJSON_Delete(document);
    }
    cJSON *info = run_json("$SVOCL build scene:cube -d 3 -o - | $SVOCL info - --json");
    assert_true(number_of(info, "file_bytes") > 200);
    cJSON_Delete(info);
    run_well("printf '0.5,0.4,-1,0,0,2\\n' | $SVOCL trace scene:cube --rays - -o hits.csv && grep '^0,0.5,' hits.csv");
    run_badly("printf 'mtllib a.mtl\\nv 0 0 0\\n' | $SVOCL build -", 1, "standard input: OBJ with a file of materials");
    run_badly("printf '{\"asset\": {}}' | $SVOCL build -", 1, "standard input: glTF in several files");
    run_badly("printf 'no mesh' | $SVOCL build -", 1, "standard input: this format");
    run_badly("$SVOCL build - </dev/null", 1, "standard input: nothing came in");
    run_badly("$SVOCL build /dev/null", 1, "/dev/null: nothing came in");
    run_badly("printf 'ply\\nformat' | $SVOCL build -", 1, "standard input: ");
    run_badly("$SVOCL build scene:cube -d 3 -o - --quiet | $SVOCL build -", 2, "standard input is a finished tree");
    run_badly("$SVOCL trace - --rays - -o a.csv <one.stl", 2, "both read standard input");
}

/* A signal when all bytes of a file are written, and one when they have a temporary name: the old file is there, or in
   the second case the new one. */
static void a_signal_while_writing_leaves_nothing(void **state)
{
    (void)state;
    need_builds();
    static const char *const expected[] = {"old.svo", "old.png", "old.csv", "old.ply", "old.obj"};
    static const char *const lines[] = {
        "scene cube -o old.obj", "scene cube -o old.ply", "build scene:cube -d 3 -o old.svo",
        "render scene:cube -d 3 --size 8x6 -o old.png", "trace scene:cube -d 3 --camera auto --size 4x4 -o old.csv"};
    static const int signals[] = {1, 2, 15}; /* SIGHUP, SIGINT, SIGTERM */
    static const struct {
        const char *settings;
        int replaced; /* files that are not old any more */
    } ways[] = {{"SHIM_AT=fsync", 0},
                {"SHIM_AT=rename", 1},
                {"SHIM_AT=fsync SHIM_NO_TMPFILE=1", 0},
                {"SHIM_AT=rename SHIM_NO_TMPFILE=1", 1}};
    for (size_t i = 0; i < sizeof lines / sizeof lines[0]; ++i) {
        for (size_t way = 0; way < sizeof ways / sizeof ways[0]; ++way) {
            const int number = signals[(i + way) % 3];
            char line[512];
            run_well("for f in svo png csv ply obj; do echo old >old.$f; done");
            snprintf(line, sizeof line,
                     "env --default-signal LD_PRELOAD=$SHIM SHIM_SIGNAL=%d %s ASAN_OPTIONS=verify_asan_link_order=0 "
                     "$SVOCL %s; echo $? $(grep -L -x old old.* | wc -l) $(ls -A | grep -c tmp)",
                     number, ways[way].settings, lines[i]);
            run(line);
            char wanted[32];
            snprintf(wanted, sizeof wanted, "%d %d 0\n", 128 + number, ways[way].replaced);
            if (strcmp(last.output, wanted) != 0) {
                fail_msg("%s: exit code, replaced files and temporary files are %s, not %s", line, last.output, wanted);
            }
            expect_files(expected, sizeof expected / sizeof expected[0]);
        }
    }
    run_well("LD_PRELOAD=$SHIM SHIM_NO_TMPFILE=1 ASAN_OPTIONS=verify_asan_link_order=0 "
             "$SVOCL scene cube -o old.ply && ! grep -q -x old old.ply && ! ls -A | grep tmp");
    /* Ignored signals, as nohup sets SIGHUP, stay ignored. */
    run_well("trap '' HUP; LD_PRELOAD=$SHIM SHIM_SIGNAL=1 SHIM_AT=fsync ASAN_OPTIONS=verify_asan_link_order=0 "
             "$SVOCL scene cube -o old.obj");
}

static void names_that_are_near_are_suggested(void **state)
{
    (void)state;
    run_badly("$SVOCL biuld scene:cube", 2, "unknown command 'biuld', did you mean 'build'?");
    run_badly("$SVOCL help ren", 2, "did you mean 'render'?");
    run_badly("$SVOCL build scene:cube --dept 3", 2, "unknown option '--dept', did you mean '--depth'?");
    run_badly("$SVOCL build scene:cube --fronted=cl", 2, "did you mean '--frontend'?");
    run_badly("$SVOCL build scene:cube --coverage half-opened", 2, "did you mean 'half-open'?");
    run_badly("$SVOCL build scene:cube --need color,normals", 2, "did you mean 'normal'?");
    run_badly("$SVOCL bench voxelise", 2, "did you mean 'voxelize'?");
    run("$SVOCL quark");
    assert_null(strstr(last.errors, "did you mean"));
}

/* The report of what was done is left out; what was asked for is not. */
static void quiet_prints_results_and_errors_alone(void **state)
{
    (void)state;
    need_builds();
    static const char *const silent[] = {"build scene:cube -d 3 -o a.svo",
                                         "build scene:cube -d 3",
                                         "verify scene:cube -d 3",
                                         "render a.svo --size 8x6 -o a.png",
                                         "trace scene:cube -d 3 --camera auto --size 4x4 -o a.csv",
                                         "scene cube -o a.obj"};
    static const char *const loud[] = {"info a.svo", "hash a.svo", "scene", "build scene:cube -d 3 --json",
                                       "build scene:cube -d 3 --plan-only"};
    char line[256];
    for (size_t i = 0; i < sizeof silent / sizeof silent[0]; ++i) {
        snprintf(line, sizeof line, "$SVOCL %s --quiet", silent[i]);
        run_well(line);
        assert_string_equal(last.output, "");
        assert_string_equal(last.errors, "");
    }
    for (size_t i = 0; i < sizeof loud / sizeof loud[0]; ++i) {
        snprintf(line, sizeof line, "$SVOCL %s -q", loud[i]);
        run_well(line);
        assert_true(strlen(last.output) > 20);
    }
    run_badly("$SVOCL hash missing.svo -q", 1, "missing.svo");
    run_badly("$SVOCL hash a.svo -q -v", 2, "--quiet and --verbose");
}

/* Each JSON text begins with the program's version. */
static void every_json_has_a_version(void **state)
{
    (void)state;
    need_builds();
    run_well("$SVOCL --version");
    char version[32] = "";
    assert_int_equal(sscanf(last.output, "svocl %31s", version), 1);
    static const char *const lines[] = {"build scene:cube -d 3 --plan -o a.svo",
                                        "build scene:cube -d 3 --plan-only",
                                        "info a.svo",
                                        "hash a.svo",
                                        "hash scene:cube -d 3",
                                        "verify scene:cube -d 3",
                                        "render a.svo --size 8x6 -o a.png",
                                        "trace scene:cube -d 3 --camera auto --size 4x4 -o a.csv",
                                        "scene",
                                        "scene cube -o a.obj",
                                        "devices",
                                        "stress --count 0 --frontend cl",
                                        "bench rays scene:cube --ray-count 10 --repeat 1 -o b.json",
                                        "bench memory --scenes cube --depths 3 --repeat 1 -o c.json"};
    for (size_t i = 0; i < sizeof lines / sizeof lines[0]; ++i) {
        char line[256];
        snprintf(line, sizeof line, "$SVOCL %s --json", lines[i]);
        cJSON *document = run_json(line);
        assert_string_equal(text_of(document, "version"), version);
        assert_string_equal(document->child->string, "version");
        cJSON_Delete(document);
    }
    run_well("head -n 2 b.json c.json | grep -c '\"version\"' | grep -x 2");
}

/* File names are bytes: those that are not UTF-8 are escaped in JSON, in tables and in messages. */
static void names_that_are_not_utf8_are_escaped(void **state)
{
    (void)state;
    need_builds();
    run_well("$SVOCL build scene:cube -d 3 -o \"$(printf 'caf\\351 \\303\\251.svo')\"");
    cJSON *info = run_json("$SVOCL info caf* --json");
    assert_string_equal(text_of(info, "file"), "caf\\xe9 \xc3\xa9.svo");
    cJSON_Delete(info);
    run_well("$SVOCL info caf*");
    assert_non_null(strstr(last.output, "caf\\xe9 \xc3\xa9.svo"));
    run_badly("$SVOCL info \"$(printf 'no\\377\\300\\200\\355\\240\\200.svo')\"", 1,
              "no\\xff\\xc0\\x80\\xed\\xa0\\x80.svo");
}

static void a_full_standard_output_is_an_error(void **state)
{
    (void)state;
    if (access("/dev/full", W_OK) != 0) {
        print_message("skipped: no /dev/full\n");
        skip();
    }
    run_badly("$SVOCL scene >/dev/full", 1, "standard output");
}

static void check_stages(const cJSON *document)
{
    static const char *const names[] = {"import", "grid", "voxelize", "drop",     "subdivide",
                                        "link",   "pack", "filter",   "transfer", "compile"};
    const cJSON *stages = array_of(document, "stages");
    assert_int_equal(cJSON_GetArraySize(stages), 10);
    for (int i = 0; i < 10; ++i) {
        const cJSON *stage = cJSON_GetArrayItem(stages, i);
        assert_string_equal(text_of(stage, "name"), names[i]);
        assert_true(number_of(stage, "ms") >= 0.0);
        assert_true(strlen(text_of(stage, "clock")) > 0);
    }
}

static void build_has_its_json_names(void **state)
{
    (void)state;
    need_builds();
    static const char *const numbers[] = {"triangles", "refused_triangles", "fragments", "leaves", "nodes",
                                          "depth",     "peak_bytes"};
    static const char *const texts[] = {"hash",    "frontend", "frontend_reason", "share",
                                        "builder", "context",  "device",          "renderer"};
    cJSON *document = run_json("$SVOCL build scene:knot:2000 -d 7 --need color,normal,rays --repeat 3 --json -o a.svo");
    for (size_t i = 0; i < sizeof numbers / sizeof numbers[0]; ++i) {
        assert_true(number_of(document, numbers[i]) >= 0.0);
    }
    for (size_t i = 0; i < sizeof texts / sizeof texts[0]; ++i) {
        assert_true(strlen(text_of(document, texts[i])) > 0);
    }
    assert_int_equal(strlen(text_of(document, "hash")), 32);
    check_stages(document);
    assert_true(cJSON_GetArraySize(array_of(document, "buffers")) > 0);
    text_of(cJSON_GetArrayItem(array_of(document, "buffers"), 0), "name");
    number_of(cJSON_GetArrayItem(array_of(document, "buffers"), 0), "bytes");
    cJSON *info = run_json("$SVOCL info a.svo --json");
    assert_true(cJSON_IsTrue(cJSON_GetObjectItem(info, "checksum_ok")));
    static const char *const shared[] = {"depth", "triangles", "refused_triangles", "fragments", "nodes", "leaves"};
    for (size_t i = 0; i < sizeof shared / sizeof shared[0]; ++i) {
        assert_true(number_of(info, shared[i]) == number_of(document, shared[i]));
    }
    assert_string_equal(text_of(info, "hash"), text_of(document, "hash"));
    assert_int_equal(cJSON_GetArraySize(array_of(info, "levels")), 8);
    assert_int_equal(cJSON_GetArraySize(array_of(info, "need")), 3);
    cJSON_Delete(info);
    cJSON_Delete(document);
    run_well("$SVOCL verify a.svo");
}

/* Whether the plan leaves it out. Every entry must have a reason. */
static bool leaves_out(const cJSON *plan, const char *what)
{
    const cJSON *entry = NULL;
    bool found = false;
    cJSON_ArrayForEach(entry, array_of(plan, "left_out"))
    {
        found = found || strcmp(text_of(entry, "what"), what) == 0;
        assert_non_null(strchr(text_of(entry, "reason"), ' '));
    }
    return found;
}

static void check_planned_buffers(const cJSON *plan)
{
    static const char *const certainties[] = {"exact", "bound", "estimate"};
    const cJSON *buffer = NULL;
    double tree_bytes = 0.0;
    double all_bytes = 0.0;
    cJSON_ArrayForEach(buffer, array_of(plan, "buffers"))
    {
        bool known = false;
        for (size_t i = 0; i < 3; ++i) {
            known = known || strcmp(text_of(buffer, "certainty"), certainties[i]) == 0;
        }
        assert_true(known);
        assert_true(strlen(text_of(buffer, "name")) > 0);
        all_bytes += number_of(buffer, "bytes");
        tree_bytes += cJSON_IsTrue(cJSON_GetObjectItem(buffer, "persistent")) ? number_of(buffer, "bytes") : 0.0;
    }
    assert_true(number_of(plan, "tree_bytes") == tree_bytes);
    assert_true(number_of(plan, "peak_bytes") >= tree_bytes && number_of(plan, "peak_bytes") <= all_bytes);
}

static void plans_have_their_json_names(void **state)
{
    (void)state;
    need_builds();
    cJSON *plan = run_json("$SVOCL build scene:atrium -d 5 --plan-only --json");
    assert_string_equal(text_of(plan, "input"), "scene:atrium");
    assert_int_equal((int)number_of(plan, "depth"), 5);
    assert_true(number_of(plan, "expected_fragments") > number_of(plan, "triangles"));
    assert_int_equal(cJSON_GetArraySize(array_of(plan, "need")), 2);
    assert_int_equal(cJSON_GetArraySize(array_of(plan, "constant")), 0);
    check_planned_buffers(plan);
    assert_true(leaves_out(plan, "leaf lists"));
    assert_true(leaves_out(plan, "material"));
    assert_true(leaves_out(plan, "64-bit Morton codes"));
    assert_false(leaves_out(plan, "color"));
    const cJSON *kernels = NULL;
    cJSON_ArrayForEach(kernels, array_of(plan, "kernels"))
    {
        assert_true(strlen(text_of(kernels, "name")) > 0);
        text_of(kernels, "defines");
    }
    assert_true(cJSON_GetArraySize(array_of(plan, "kernels")) >= 2);
    cJSON_Delete(plan);
    expect_files(NULL, 0);
}

/* --plan plans and builds; --plan-only builds nothing. */
static void a_plan_is_printed_before_the_build(void **state)
{
    (void)state;
    need_builds();
    run_well("$SVOCL build scene:cube -d 5 --plan");
    const char *left_out = strstr(last.output, "left out");
    assert_non_null(left_out);
    assert_non_null(strstr(left_out, "\nstages\n"));
    assert_non_null(strstr(left_out, "hash"));
    run_well("$SVOCL build scene:cube -d 5 --plan-only");
    assert_non_null(strstr(last.output, "left out"));
    assert_non_null(strstr(last.output, "device memory"));
    assert_null(strstr(last.output, "hash"));
}

/* A small scene starts no OpenGL, and the plan says so, but not if OpenGL was requested. */
static void the_plan_leaves_opengl_out_of_small_scenes(void **state)
{
    (void)state;
    need_builds();
    cJSON *small = run_json("$SVOCL build scene:cube -d 5 --plan --json");
    assert_string_equal(text_of(small, "frontend"), "cl");
    assert_string_equal(text_of(small, "renderer"), "none");
    assert_true(leaves_out(cJSON_GetObjectItem(small, "plan"), "OpenGL"));
    cJSON_Delete(small);
    cJSON *large = run_json("$SVOCL build scene:cube -d 9 --plan-only --json");
    assert_false(leaves_out(large, "OpenGL"));
    cJSON_Delete(large);
    if (gl_works()) {
        cJSON *forced = run_json("$SVOCL build scene:cube -d 5 --frontend gl-expand --plan-only --json");
        assert_false(leaves_out(forced, "OpenGL"));
        cJSON_Delete(forced);
    }
}

static void info_says_what_is_stored_once(void **state)
{
    (void)state;
    need_builds();
    write_text("flat.ply", PLY_HEADER("2") "0 0 0\n1 0 0\n0 1 0\n1 1 0\n3 0 1 2\n3 1 3 2\n");
    run_well("$SVOCL build flat.ply -d 5 --need color,normal,fill -o flat.svo");
    cJSON *info = run_json("$SVOCL info flat.svo --json");
    const cJSON *constant = array_of(info, "constant");
    assert_int_equal(cJSON_GetArraySize(constant), 2);
    assert_string_equal(cJSON_GetStringValue(cJSON_GetArrayItem(constant, 0)), "color");
    assert_string_equal(cJSON_GetStringValue(cJSON_GetArrayItem(constant, 1)), "normal");
    assert_int_equal(cJSON_GetArraySize(array_of(info, "need")), 3);
    cJSON_Delete(info);
    run_well("$SVOCL info flat.svo");
    assert_non_null(strstr(last.output, "stored once"));
    assert_non_null(strstr(last.output, "color, normal: the same in every node"));
    run_well("$SVOCL build scene:cube -d 3 -o cube.svo && $SVOCL info cube.svo");
    assert_null(strstr(last.output, "stored once"));
}

static void upper_levels_of_a_file(void **state)
{
    (void)state;
    need_builds();
    run_well("$SVOCL build scene:knot:2000 -d 6 --origin -2,-2,-2 --edge 4 --compress -o whole.svo");
    cJSON *info = run_json("$SVOCL info whole.svo --levels 4 --json");
    assert_int_equal((int)number_of(info, "depth"), 4);
    cJSON_Delete(info);
    run_well("$SVOCL render whole.svo --levels 4 --view level --size 40x40 -o upper.png");
    run_well("$SVOCL convert whole.svo upper.binvox --levels 4");
    run_badly("$SVOCL info whole.svo --levels 7", 1, "last_level 7 is not in 1 .. 6, the depth of whole.svo");
    run_badly("$SVOCL info whole.svo --levels 0", 2, "levels 0 is below 1");
    run_badly("$SVOCL hash scene:cube --levels 3", 2, "--levels applies to .svo files, not to scene:cube");
    info = run_json("$SVOCL info - --levels 3 --json <whole.svo");
    assert_int_equal((int)number_of(info, "depth"), 3);
    cJSON_Delete(info);
}

static void info_names_what_is_wrong_with_a_file(void **state)
{
    (void)state;
    need_builds();
    run_well("$SVOCL build scene:cube -d 5 --compress -o good.svo");
    run_well("head -c 300 good.svo >cut.svo");
    run_badly("$SVOCL info cut.svo", 1, "cut.svo");
    run_well("cp good.svo hurt.svo; printf X | dd of=hurt.svo bs=1 seek=400 conv=notrunc");
    run_badly("$SVOCL info hurt.svo", 1, "hurt.svo");
    run_badly("$SVOCL render hurt.svo -o a.png", 1, "hurt.svo");
    run_badly("$SVOCL hash hurt.svo", 1, "hurt.svo");
    write_text("foreign.svo", "solid cube\nendsolid cube\n");
    run_badly("$SVOCL info foreign.svo", 1, "foreign.svo");
    write_text("empty.svo", "");
    run_badly("$SVOCL info empty.svo", 1, "empty.svo");
    run_badly("$SVOCL info missing.svo", 1, "missing.svo");
    run_badly("$SVOCL build good.svo", 2, "good.svo");
    run_badly("$SVOCL verify good.svo", 1, "good.svo");
}

static void devices_has_its_json_names(void **state)
{
    (void)state;
    need_builds();
    cJSON *document = run_json("$SVOCL devices --path gpu --json");
    const cJSON *platform = cJSON_GetArrayItem(array_of(document, "platforms"), 0);
    number_of(cJSON_GetArrayItem(array_of(platform, "devices"), 0), "max_allocation_bytes");
    assert_string_equal(text_of(cJSON_GetArrayItem(array_of(platform, "devices"), 0), "path"), "gpu");
    if (gl_works()) {
        assert_true(cJSON_GetArraySize(array_of(document, "renderers")) >= 3);
    }
    const cJSON *pair = NULL;
    cJSON_ArrayForEach(pair, array_of(document, "pairs"))
    {
        assert_int_equal(cJSON_GetArraySize(array_of(pair, "frontends")), 2);
        assert_int_equal(cJSON_GetArraySize(array_of(pair, "shares")), 3);
        assert_int_equal(cJSON_GetArraySize(array_of(pair, "builders")), 3);
        const cJSON *method = NULL;
        cJSON_ArrayForEach(method, array_of(pair, "shares"))
        {
            const bool works = cJSON_IsTrue(cJSON_GetObjectItem(method, "works"));
            assert_true(works == (strlen(text_of(method, "reason")) == 0));
        }
    }
    cJSON_Delete(document);
}

static void verify_finds_every_scene_exact(void **state)
{
    (void)state;
    need_builds();
    static const char *const names[] = {"atrium", "statue", "knot", "terrain", "needles", "dust", "cornell", "cube"};
    static const char *const counts[] = {"missed_voxels",    "surplus_voxels",   "missed_pairs",        "surplus_pairs",
                                         "node_differences", "grid_differences", "rounding_differences"};
    for (size_t i = 0; i < sizeof names / sizeof names[0]; ++i) {
        char line[128];
        snprintf(line, sizeof line, "$SVOCL verify scene:%s:3000 -d 6 --json", names[i]);
        cJSON *document = run_json(line);
        for (size_t k = 0; k < sizeof counts / sizeof counts[0]; ++k) {
            assert_true(number_of(document, counts[k]) == 0.0);
        }
        assert_true(number_of(document, "expected_voxels") > 0.0);
        cJSON_Delete(document);
    }
}

/* A vertex 2^-25 before the middle of the grid is in the voxel before it. To the nearest of 2^20 steps, it would be in
   the next one. */
static void verify_takes_the_mesh_as_given(void **state)
{
    (void)state;
    need_builds();
    write_text("near.obj", "v 0.49999997 0.1 0.1\nv 0.4 0.1 0.1\nv 0.4 0.11 0.1\nf 1 2 3\n");
    cJSON *document = run_json("$SVOCL verify near.obj -d 4 --origin 0,0,0 --edge 1 --json");
    assert_true(cJSON_IsTrue(cJSON_GetObjectItem(document, "exact")));
    assert_int_equal((int)number_of(document, "expected_voxels"), 2);
    assert_int_equal((int)number_of(document, "expected_pairs"), 2);
    assert_int_equal((int)number_of(document, "surplus_voxels"), 0);
    assert_null(cJSON_GetObjectItem(document, "input_surplus_voxels"));
    cJSON_Delete(document);
    run_well("$SVOCL verify near.obj -d 4 --origin 0,0,0 --edge 1");
    assert_non_null(strstr(last.output, "exact: 0 missed, 0 surplus"));
    run_well("$SVOCL build near.obj -d 4 --origin 0,0,0 --edge 1 --need rays -o near.svo");
    document = run_json("$SVOCL verify near.svo --json");
    assert_true(cJSON_IsTrue(cJSON_GetObjectItem(document, "exact")));
    assert_int_equal((int)number_of(document, "expected_voxels"), 2);
    cJSON_Delete(document);
    run_well("$SVOCL build near.obj -d 4 --coverage thin --need rays -o thin.svo");
    run_badly("$SVOCL verify thin.svo", 1, "no positions to compare with, give the mesh");
}

/* The last line of standard output. */
static void last_line(char *text, size_t text_bytes)
{
    size_t length = strlen(last.output);
    while (length > 0 && last.output[length - 1] == '\n') {
        last.output[--length] = '\0';
    }
    const char *newline = strrchr(last.output, '\n');
    snprintf(text, text_bytes, "%s", newline != NULL ? newline + 1 : last.output);
}

static void expect_hash(const char *more, const char *hash)
{
    char line[256];
    char found[64];
    snprintf(line, sizeof line, "$SVOCL hash scene:statue:4000 -d 7 --need color,normal,rays %s", more);
    run_well(line);
    last_line(found, sizeof found);
    if (strcmp(found, hash) != 0) {
        fail_msg("%s: %s instead of %s", line, found, hash);
    }
}

static void the_hash_is_the_same_by_every_method(void **state)
{
    (void)state;
    need_builds();
    char hash[64];
    run_well("$SVOCL hash scene:statue:4000 -d 7 --need color,normal,rays");
    last_line(hash, sizeof hash);
    assert_int_equal(strlen(hash), 32);
    for (int i = 0; i < 3; ++i) {
        expect_hash("", hash);
    }
    expect_hash("--threads 1", hash);
    expect_hash("--threads 2", hash);
    expect_hash("--path cpu", hash);
    expect_hash("--path gpu", hash);
    expect_hash("--frontend auto", hash);
    expect_hash("--frontend cl", hash);
    if (gl_works()) {
        expect_hash("--frontend gl-expand", hash);
    }
    expect_hash("--builder cl", hash);
    expect_hash("--builder sorted", hash);
    if (method_works(NULL, "builders", "gl-compute")) {
        expect_hash("--builder gl-compute", hash);
    }
    static const char *const contexts[] = {"surfaceless", "egl-device", "osmesa"};
    static const char *const shares[] = {"host", "copy"};
    for (size_t c = 0; c < 3; ++c) {
        for (size_t s = 0; s < 2; ++s) {
            char more[64];
            snprintf(more, sizeof more, "--context %s --share %s", contexts[c], shares[s]);
            if (method_works(contexts[c], "shares", shares[s])) {
                expect_hash(more, hash);
            } else {
                print_message("not run, does not work here: %s\n", more);
            }
        }
    }
}

/* All commands mean the same by default: normals, of the triangles where the mesh has none. */
static void scans_without_normals_get_those_of_their_triangles(void **state)
{
    (void)state;
    need_builds();
    write_text("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 2 4\n");
    run_well("$SVOCL hash a.obj -d 5 >1 && $SVOCL hash a.obj -d 5 --need normal >2 && cmp 1 2");
    run_well("$SVOCL build a.obj -d 5 -o a.svo -q && $SVOCL hash a.svo >2 && cmp 1 2");
    run_well("$SVOCL render a.obj -d 5 -o 1.png -q --size 48x32 && $SVOCL render a.svo -o 2.png -q --size 48x32 && "
             "cmp 1.png 2.png");
    run_well("rm 1 2 1.png 2.png a.obj a.svo");
}

/* A tetrahedron of which one face has corners of its own, an ulp or so off. */
static void welding_closes_cracks(void **state)
{
    (void)state;
    need_builds();
#define WHOLE "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 .7\n"
    write_text("whole.obj", WHOLE "f 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n");
    write_text("cracked.obj", WHOLE "v .9999999 0 0\nv 0 1 1e-7\nv 0 -1e-8 .7\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 5 6 7\n");
#undef WHOLE
    run_well(
        "$SVOCL hash whole.obj -d 4 --need projected-area >1 && $SVOCL hash cracked.obj -d 4 --need projected-area "
        ">2 && ! cmp -s 1 2");
    run_well("$SVOCL hash cracked.obj -d 4 --need projected-area --weld 1e-6 | cmp - 1");
    cJSON *document = run_json("$SVOCL build cracked.obj -d 4 --weld 1e-6 --json");
    assert_int_equal(number_of(cJSON_GetObjectItem(document, "import"), "welded_vertices"), 3);
    cJSON_Delete(document);
    run_well("$SVOCL build cracked.obj -d 4 --need projected-area --weld 1e-6 --max-memory 1G -o c.svo -q && "
             "$SVOCL hash c.svo | cmp - 1");
    run_badly("$SVOCL hash whole.obj --weld -1", 2, "--weld '-1' is not a number of at least 0");
    run_badly("$SVOCL hash scene:cube --weld 1", 2, "--weld applies to mesh files, not to scene:cube");
    run_badly("$SVOCL hash c.svo --weld 1", 2, "build options do not apply");
    run_well("rm -rf 1 2 whole.obj cracked.obj c.svo*");
}

/* z is up in .vox, and where --axes z-up says so; trees have y up. */
static void files_with_z_up_are_turned(void **state)
{
    (void)state;
    need_builds();
    /* Voxels (0, 0, 0), (0, 0, 1), (0, 0, 2) and (0, 1, 0) of a .vox file stand upright in the tree: y is 0 to 2. */
    run_well(
        "printf 'VOX "
        "\\226\\0\\0\\0MAIN\\0\\0\\0\\0\\70\\0\\0\\0SIZE\\14\\0\\0\\0\\0\\0\\0\\0\\1\\0\\0\\0\\2\\0\\0\\0\\3\\0\\0\\0"
        "XYZI\\24\\0\\0\\0\\0\\0\\0\\0\\4\\0\\0\\0\\0\\0\\0\\1\\0\\0\\1\\1\\0\\0\\2\\1\\0\\1\\0\\1' >a.vox");
    run_well("$SVOCL convert a.vox a.svo && $SVOCL convert a.svo b.vox");
    assert_non_null(strstr(last.output, "0, 0, -2 to 1, 3, 0"));
    run_well("$SVOCL convert a.vox a.svo --axes keep");
    assert_non_null(strstr(last.output, "0, 0, 0 to 1, 2, 3"));
    run_well("$SVOCL convert a.svo c.vox --axes keep && $SVOCL convert b.vox b.obj --axes keep -q && "
             "$SVOCL convert c.vox c.obj --axes keep -q && cmp b.obj c.obj && cmp b.vox c.vox");
    /* Other formats have y up, unless they are said to have z up. */
    run_well("$SVOCL convert b.vox y.binvox && $SVOCL convert b.vox z.binvox --axes keep");
    run_well("$SVOCL hash a.vox --need none >1 && $SVOCL hash y.binvox --need none >2 && $SVOCL hash z.binvox --axes "
             "z-up --need none >3 && "
             "cmp 1 2 && cmp 1 3");
    run_well("! $SVOCL hash z.binvox --need none | cmp -s - 1");
    /* Meshes, and their normals. */
    write_text("z.obj", "v 0 0 0\nv 1 0 0\nv 1 3 0\nv 0 0 2\nvn 0 1 0\nf 1//1 2//1 3//1\nf 1//1 3//1 4//1\n");
    write_text("y.obj", "v 0 0 0\nv 1 0 0\nv 1 0 -3\nv 0 2 0\nvn 0 0 -1\nf 1//1 2//1 3//1\nf 1//1 3//1 4//1\n");
    run_well("$SVOCL hash z.obj --axes z-up >1 && $SVOCL hash y.obj >2 && cmp 1 2 && $SVOCL hash z.obj >3");
    run_well("! cmp -s 1 3 && $SVOCL hash z.obj --axes keep | cmp - 3");
    run_badly("$SVOCL hash scene:cube --axes z-up", 2, "--axes z-up applies to files, not to scene:cube");
    run_badly("$SVOCL build z.obj -o z.svo --axes z-up --max-memory 1G", 2,
              "--axes z-up does not apply to builds in parts");
    run_badly("$SVOCL hash a.svo --axes keep", 2, "build options do not apply");
    run_badly("$SVOCL hash a.vox --axes up", 2, "--axes");
    run_well("rm 1 2 3 a.vox b.vox c.vox b.obj c.obj a.svo y.binvox z.binvox y.obj z.obj");
}

/* A .vox file with a name, two models and a chunk that svocl does not know becomes itself; other forms of it say what
   they lack. */
static void vox_files_keep_what_they_hold(void **state)
{
    (void)state;
    need_builds();
    run_well("model='SIZE\\14\\0\\0\\0\\0\\0\\0\\0\\1\\0\\0\\0\\1\\0\\0\\0\\1\\0\\0\\0"
             "XYZI\\10\\0\\0\\0\\0\\0\\0\\0\\1\\0\\0\\0\\0\\0\\0\\1' && "
             "printf \"VOX \\226\\0\\0\\0MAIN\\0\\0\\0\\0\\211\\0\\0\\0$model${model}LAYR\\27\\0\\0\\0\\0\\0\\0\\0"
             "\\0\\0\\0\\0\\1\\0\\0\\0\\5\\0\\0\\0_name\\2\\0\\0\\0upzNEW\\2\\0\\0\\0\\0\\0\\0\\0ab\" >a.vox");
    run_well("$SVOCL convert a.vox b.vox && cmp a.vox b.vox");
    assert_non_null(strstr(last.output, "; all that the file holds\n"));
    assert_null(strstr(last.errors, "left out"));
    run_well("$SVOCL convert - c.vox -q --axes keep <a.vox && cmp a.vox c.vox");
    cJSON *document = run_json("$SVOCL convert a.vox b.vox --json");
    const cJSON *written = cJSON_GetObjectItem(document, "written");
    assert_true(cJSON_IsTrue(cJSON_GetObjectItem(written, "is_copy")));
    assert_int_equal((int)number_of(written, "models"), 2);
    cJSON_Delete(document);
    static const char lacks[] = "a.vox: left out: 1 model, 1 name, 1 layer, 1 chunk of another kind";
    run_well("$SVOCL convert a.vox a.svo");
    assert_non_null(strstr(last.errors, lacks));
    run_well("$SVOCL build a.vox");
    assert_non_null(strstr(last.errors, lacks));
    run_well("$SVOCL convert a.vox b.vox --frame 1");
    assert_non_null(strstr(last.errors, lacks));
    run_well("! cmp -s a.vox b.vox && $SVOCL convert a.vox a.svo -q");
    assert_string_equal(last.errors, "");
    document = run_json("$SVOCL convert a.vox a.svo --json 2>1");
    assert_string_equal(text_of(cJSON_GetObjectItem(document, "voxels"), "left_out"), strstr(lacks, "1 model"));
    cJSON_Delete(document);
    run_badly("$SVOCL convert a.vox no/b.vox", 1, "no/b.vox");
    run_well("printf TDCZ >t.vox && printf broken >d.vox");
    run_badly("$SVOCL convert t.vox b.vox", 1, "t.vox: a .vox file that Teardown compressed (TDCZ)");
    run_badly("$SVOCL convert d.vox b.vox", 1, "d.vox: byte 0: neither");
    run_well("rm a.vox b.vox c.vox t.vox d.vox a.svo 1");
}

/* A .ply file without faces is a point cloud: the grid's options apply, and its voxels have counts and colors. */
static void point_clouds_become_voxels(void **state)
{
    (void)state;
    need_builds();
    run_well("printf 'ply\nformat ascii 1.0\nelement vertex 4\nproperty double x\nproperty double y\nproperty double "
             "z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\nend_header\n0 0 0 10 0 0\n.1 .1 .1 "
             "20 0 0\n4 4 4 0 9 0\nnan 0 0 0 0 0\n' >a.ply");
    cJSON *document = run_json("$SVOCL info a.ply --json");
    const cJSON *points = cJSON_GetObjectItem(document, "points");
    assert_int_equal((int)number_of(points, "points"), 4);
    assert_int_equal((int)number_of(points, "taken"), 3);
    assert_int_equal((int)number_of(points, "not_finite"), 1);
    assert_string_equal(text_of(points, "color"), "rgb");
    cJSON_Delete(document);
    run_well("$SVOCL info a.ply");
    assert_non_null(strstr(last.output, "PLY"));
    run_well("$SVOCL build a.ply -d 3 --counts --max-memory 64M -o a.svo && $SVOCL convert a.svo b.ply");
    assert_non_null(strstr(last.errors, "1 of 4 points are left out: a coordinate is not finite"));
    run_well("$SVOCL hash a.ply -d 3 --counts >1 && $SVOCL hash a.svo >2 && $SVOCL hash - -d 3 --counts <a.ply >3");
    run_well("cmp 1 2 && cmp 1 3");
    document = run_json("$SVOCL convert a.ply a.bt --voxel-size 0.5 --json");
    points = cJSON_GetObjectItem(document, "points");
    assert_int_equal((int)number_of(points, "voxels"), 2);
    assert_int_equal((int)number_of(points, "count_max"), 2);
    cJSON_Delete(document);
    run_well("$SVOCL convert a.ply b.svo --voxel-size 0.5 --need none && $SVOCL convert a.bt c.svo --need none && "
             "$SVOCL hash b.svo >1 && $SVOCL hash c.svo >2 && cmp 1 2");
    run_well("$SVOCL build a.ply -d 2 --origin 0,0,0 --edge 2 -q && $SVOCL render a.ply -d 3 -o a.png --size 16x16");
    assert_non_null(strstr(last.errors, "left out"));
    run_badly("$SVOCL build a.ply -d 3 --coverage closed", 2, "option --coverage does not apply to voxels");
    run_badly("$SVOCL build a.bt --counts", 2, "--counts applies to point clouds, not to a.bt");
    run_badly("$SVOCL build scene:cube --counts", 2, "--counts applies to point clouds, not to scene:cube");
    run_badly("$SVOCL build a.ply --max-memory 1M", 1, "--max-memory 1048576 is below 4194304");
    run_well("printf LASF >d.las && cp d.las d.laz && printf '%104s\207' LASF >e.laz");
    run_badly("$SVOCL build d.las", 1, "d.las: the file ends in the header, at byte 4");
    run_badly("$SVOCL convert a.ply a.las", 2, "a.las does not end in .svo");
    run_badly("$SVOCL mesh a.ply -o b.obj", 2, "a.ply has no triangles");
    run_well("rm a.ply b.ply a.bt a.svo b.svo c.svo a.png d.las 1 2 3");
}

/* Merged faces are a mesh that is read back as the voxels that they were made of: the surface, and with --solid all. */
static void merged_faces_are_read_back(void **state)
{
    (void)state;
    need_builds();
    run_well("$SVOCL convert scene:statue:500 a.vox -d 5 --solid winding -q && $SVOCL convert a.vox a.binvox -q");
    run_well("$SVOCL convert scene:statue:500 s.svo -d 5 --origin=-1,-1,-1 --edge 3 --need color -q");
    static const char *const names[] = {"m.ply", "m.obj"};
    for (size_t i = 0; i < 2; ++i) {
        char line[320];
        (void)snprintf(line, sizeof line, "$SVOCL convert a.vox %s --merge", names[i]);
        run_well(line);
        assert_non_null(strstr(last.output, " rectangles of "));
        (void)snprintf(line, sizeof line,
                       "$SVOCL convert %s b.vox --voxel-size 1 --solid winding -q && $SVOCL convert b.vox b.binvox -q "
                       "&& cmp a.binvox b.binvox",
                       names[i]);
        run_well(line);
        /* A voxel is 3 / 32 wide. */
        (void)snprintf(line, sizeof line,
                       "$SVOCL convert s.svo %s --merge -q && $SVOCL convert %s t.svo -d 5 --origin=-1,-1,-1 --edge 3 "
                       "--need color -q",
                       names[i], names[i]);
        run_well(line);
        run_well("$SVOCL hash s.svo --nodes >1 && $SVOCL hash t.svo --nodes >2 && cmp 1 2");
    }
    run_well(
        "$SVOCL convert a.vox m.obj --merge -q --axes z-up && $SVOCL convert m.obj b.vox --voxel-size 1 --axes z-up "
        "--solid winding -q && $SVOCL convert b.vox b.binvox -q && cmp a.binvox b.binvox");
    run_well("$SVOCL convert s.svo m.ply --merge"); /* nothing is left out */
    assert_string_equal(last.errors, "");
    cJSON *document = run_json("$SVOCL convert a.vox m.ply --merge --json");
    const cJSON *written = cJSON_GetObjectItem(document, "written");
    assert_true(number_of(written, "faces") > 6.0 && number_of(written, "voxel_faces") > number_of(written, "faces"));
    cJSON_Delete(document);
    run_badly("$SVOCL convert a.vox b.svo --merge", 2, "--merge applies to .ply and .obj, not to OUT b.svo");
    run_badly("$SVOCL convert a.vox b.vox --merge", 2, "--merge applies to .ply and .obj, not to OUT b.vox");
    run_well("rm a.vox a.binvox b.vox b.binvox s.svo t.svo m.ply m.obj 1 2");
}

/* --voxel-size makes the grid: the tree is that of --origin, --edge and --depth. */
static void voxels_have_a_size(void **state)
{
    (void)state;
    need_builds();
    write_text("a.obj", "v -0.3 0 0\nv 1.2 0 0.7\nv 0 0.9 0\nf 1 2 3\n");
    run_well("$SVOCL hash a.obj --voxel-size 0.25 >1");
    run_well("$SVOCL hash a.obj --origin=-0.5,0,0 --edge 2 -d 3 >2 && cmp 1 2");
    run_well("$SVOCL build a.obj --voxel-size 0.25 -o a.svo -q && $SVOCL hash a.svo >2 && cmp 1 2");
    run_well("$SVOCL build a.obj --voxel-size 0.25 -o p.svo -q --max-memory 1G && cmp a.svo p.svo");
    run_well("$SVOCL convert a.obj c.svo --voxel-size 0.25 -q && cmp a.svo c.svo && $SVOCL diff a.svo c.svo");
    run_well("$SVOCL diff a.obj a.obj --voxel-size 0.25");
    cJSON *document = run_json("$SVOCL build a.obj --voxel-size 0.01 --json");
    assert_int_equal((int)number_of(document, "depth"), 8);
    cJSON_Delete(document);
    run_badly("$SVOCL build a.obj --voxel-size 1e-5", 1,
              "--voxel-size 1e-05 makes 150002 voxels along x, above the limit of 65536 (depth 16)");
    run_badly("$SVOCL build a.obj --voxel-size 0", 2, "voxel-size '0' is not a number above 0");
    run_badly("$SVOCL build a.obj --voxel-size 1 -d 4", 2, "--voxel-size and --depth exclude each other");
    run_badly("$SVOCL build a.obj --voxel-size 1 --origin 0,0,0 --edge 4", 2,
              "--voxel-size and --origin exclude each other");
    run_badly("$SVOCL build a.svo --voxel-size 1", 2, "a mesh or voxels are needed");
    run_badly("$SVOCL hash a.svo --voxel-size 1", 2, "build options do not apply");
    run_well("$SVOCL convert a.svo a.vox -q");
    run_badly("$SVOCL build a.vox --voxel-size 1", 2, "--voxel-size does not apply to voxels");
    run_well("rm a.obj a.svo p.svo c.svo a.vox 1 2");
}

static void voxel_files_are_converted(void **state)
{
    (void)state;
    need_builds();
    /* Two voxels of a cube of eight. */
    run_well(
        "printf '#binvox 1\\ndim 2 2 2\\ntranslate 3 4 5\\nscale 2\\ndata\\n\\000\\003\\001\\002\\000\\003' >a.binvox");
    run_well("$SVOCL convert a.binvox a.svo");
    assert_non_null(strstr(last.output, "2 leaves"));
    cJSON *document = run_json("$SVOCL convert a.svo b.vox --json");
    assert_string_equal(text_of(cJSON_GetObjectItem(document, "written"), "format"), "vox");
    cJSON_Delete(document);
    run_well("$SVOCL hash a.svo >one.txt && $SVOCL hash a.binvox >two.txt && cmp one.txt two.txt");
    /* What a format does not hold is said. */
    run_well("$SVOCL convert a.svo b.vox && $SVOCL convert a.binvox d.ply");
    assert_null(strstr(last.output, "left out"));
    run_well("$SVOCL convert a.binvox b.vox");
    assert_non_null(strstr(last.output, "left out           the place and the width of voxels\n"));
    run_well("$SVOCL convert a.svo b.vox -q && $SVOCL convert b.vox e.binvox");
    assert_non_null(strstr(last.output, "left out           materials\n"));
    document = run_json("$SVOCL convert b.vox e.binvox --json");
    const cJSON *left_out = cJSON_GetObjectItem(cJSON_GetObjectItem(document, "written"), "left_out");
    assert_int_equal(cJSON_GetArraySize(left_out), 1);
    assert_string_equal(cJSON_GetArrayItem(left_out, 0)->valuestring, "materials");
    cJSON_Delete(document);
    /* Materials of .vox files begin at 1. */
    run_well("$SVOCL hash a.svo --nodes >one.txt && $SVOCL convert b.vox c.svo -q");
    run_well("$SVOCL hash c.svo --nodes >two.txt && cmp one.txt two.txt");
    run_well("$SVOCL hash - --nodes <b.vox >two.txt && cmp one.txt two.txt");
    run_well("$SVOCL convert b.vox d.ply -q && $SVOCL convert b.vox d.obj && $SVOCL render b.vox -o d.png --size 9x9");
    document = run_json("$SVOCL build b.vox -d 3 --json");
    assert_int_equal((int)number_of(document, "depth"), 3);
    assert_int_equal((int)number_of(cJSON_GetObjectItem(document, "voxels"), "distinct_voxels"), 2);
    cJSON_Delete(document);
    run_badly("$SVOCL convert a.binvox", 2, "OUT is missing");
    run_badly("$SVOCL convert a.binvox x.tga", 2, "output x.tga does not end in .svo, .svc, .vox");
    run_badly("$SVOCL convert x.obj x.vox", 1, "x.obj");
    run_badly("$SVOCL convert a.binvox x.vox -d 3", 2, "--depth does not apply from voxels to voxels");
    run_badly("$SVOCL convert a.svo x.vox -d 3", 2, "--depth does not apply to IN that is a finished tree");
    run_badly("$SVOCL convert a.svo x.vox --frame 1", 2, "--frame");
    run_badly("$SVOCL convert a.binvox x.vox --compress", 2, "--compress");
    run_badly("$SVOCL convert a.binvox no/x.vox", 1, "no/x.vox");
    run_badly("$SVOCL convert no.vox x.vox", 1, "no.vox");
    run_badly("$SVOCL verify b.vox", 2, "no rays");
    run_badly("$SVOCL build b.vox --need normal", 2, "no normal");
    run_badly("$SVOCL build b.vox --coverage closed", 2, "--coverage");
    run_badly("$SVOCL build scene:cube --hidden", 2, "--hidden");
    run_badly("head -c 51 a.binvox >e.binvox; $SVOCL hash e.binvox", 1, "e.binvox: data: ");
    static const char *const kept[] = {"a.binvox", "a.svo", "b.vox",    "c.svo",   "d.obj",
                                       "d.ply",    "d.png", "e.binvox", "one.txt", "two.txt"};
    expect_files(kept, sizeof kept / sizeof kept[0]);
}

static void hash_says_what_ran(void **state)
{
    (void)state;
    need_builds();
    const bool gl = gl_works();
    cJSON *document = run_json(gl ? "$SVOCL hash scene:cube -d 5 --share copy --nodes --json"
                                  : "$SVOCL hash scene:cube -d 5 --frontend cl --nodes --json");
    assert_string_equal(text_of(document, "share"), gl ? "copy" : "none");
    static const char *const texts[] = {"hash", "frontend", "builder", "context", "device", "renderer"};
    for (size_t i = 0; i < sizeof texts / sizeof texts[0]; ++i) {
        assert_true(strlen(text_of(document, texts[i])) > 0);
    }
    assert_string_equal(text_of(document, "hash"), text_of(document, "nodes_hash"));
    cJSON_Delete(document);
    if (!gl) {
        run_badly("$SVOCL hash scene:cube -d 5 --builder gl-compute", 1, "OpenGL");
        return;
    }
    document = run_json("$SVOCL hash scene:cube -d 5 --builder gl-compute --nodes --json");
    assert_string_equal(text_of(document, "builder"), "gl-compute");
    assert_string_equal(text_of(document, "share"), "none");
    cJSON_Delete(document);
}

/* A few triangles start no OpenGL; a requested front end starts only what it needs. */
static void opengl_is_started_only_for_what_needs_it(void **state)
{
    (void)state;
    need_builds();
    cJSON *small = run_json("$SVOCL hash scene:cube -d 5 --json");
    assert_string_equal(text_of(small, "frontend"), "cl");
    assert_string_equal(text_of(small, "share"), "none");
    assert_string_equal(text_of(small, "renderer"), "none");
    assert_string_equal(text_of(small, "context"), "none");
    assert_non_null(strstr(text_of(small, "frontend_reason"), "too few to start OpenGL"));
    cJSON_Delete(small);
    cJSON *forced = run_json("$SVOCL hash scene:cube -d 5 --frontend cl --json");
    assert_string_equal(text_of(forced, "frontend"), "cl");
    assert_string_equal(text_of(forced, "frontend_reason"), "requested");
    cJSON_Delete(forced);
    cJSON *large = run_json("$SVOCL hash scene:cube -d 9 --need none --json");
    print_message("%s: %s\n", text_of(large, "frontend"), text_of(large, "frontend_reason"));
    assert_true(strlen(text_of(large, "frontend_reason")) > 0);
    cJSON_Delete(large);
    run_well("$SVOCL build scene:cube -d 5");
    assert_non_null(strstr(last.output, "too few to start OpenGL"));
    run_well("$SVOCL devices");
    assert_non_null(strstr(last.output, "cl   works"));
}

static void rays_from_a_file_become_hits(void **state)
{
    (void)state;
    need_builds();
    write_text("rays.csv",
               "ox,oy,oz,dx,dy,dz\n0.5,0.4,-1,0,0,2\n5,5,5,1,0,0\n\n0.5,nan,0.5,1,0,1\r\n0.3,0.2,0.5,1,0,0");
    run_well("$SVOCL trace scene:cube --rays rays.csv -o hits.csv");
    run_well("cat hits.csv");
    assert_non_null(strstr(last.output, "ray,t,triangle,u,v\n0,0.5,"));
    assert_non_null(strstr(last.output, "\n1,inf,-1,0,0\n2,inf,-1,0,0\n3,0.6999999"));
    run_well("$SVOCL build scene:cube -d 4 --need rays -o cube.svo");
    run_well("$SVOCL trace cube.svo --rays rays.csv -o again.csv && cmp hits.csv again.csv");
    cJSON *document = run_json("$SVOCL trace scene:cube --camera auto --size 8x6 -o seen.csv --json");
    assert_int_equal((int)number_of(document, "rays"), 48);
    assert_true(number_of(document, "hits") > 10);
    cJSON_Delete(document);
    write_text("bad.csv", "0,0,0,1,0,0\n1,2,3,4,5\n");
    run_badly("$SVOCL trace scene:cube --rays bad.csv -o none.csv", 1, "bad.csv:2");
    run_badly("$SVOCL trace scene:cube --rays nowhere.csv -o none.csv", 1, "nowhere.csv");
    write_text("empty.csv", "");
    run_badly("$SVOCL trace scene:cube --rays empty.csv -o none.csv", 1, "empty.csv: no ray");
    write_text("heading.csv", "ox,oy,oz,dx,dy,dz\n\n");
    run_badly("$SVOCL trace scene:cube --rays heading.csv -o none.csv", 1, "heading.csv: no ray");
    run_badly("$SVOCL trace scene:cube -o none.csv", 2, "--rays");
    run_badly("$SVOCL trace scene:cube --rays rays.csv", 2, "-o");
    run_badly("$SVOCL trace scene:cube --camera 1,2 -o none.csv", 2, "'1,2'");
    static const char *const kept[] = {"rays.csv", "hits.csv", "cube.svo",  "again.csv",
                                       "seen.csv", "bad.csv",  "empty.csv", "heading.csv"};
    expect_files(kept, sizeof kept / sizeof kept[0]);
}

/* A small measurement: both sides run and agree. */
static void rays_are_compared_with_embree(void **state)
{
    (void)state;
    need_builds();
    run("$SVOCL bench rays scene:knot:3000 --vs embree --ray-count 5000 --repeat 2 --json");
    if (strstr(last.errors, "libembree-dev") != NULL) {
        print_message("skipped: built without libembree-dev\n");
        skip();
    }
    cJSON *document = run_json("$SVOCL bench rays scene:knot:3000 --vs embree --ray-count 5000 --repeat 2 --json");
    const cJSON *set = NULL;
    cJSON_ArrayForEach(set, array_of(document, "sets"))
    {
        text_of(set, "name");
        assert_int_equal((int)number_of(set, "rays"), 5000);
        assert_true(number_of(set, "ours_mrays") > 0 && number_of(set, "embree_mrays") > 0);
        assert_true(number_of(set, "ratio") > 0);
        assert_int_equal((int)number_of(set, "wrong_ids"), 0);
        assert_int_equal((int)number_of(set, "missed"), 0);
    }
    cJSON_Delete(document);
    run_badly("$SVOCL bench", 2, "rays");
    run_badly("$SVOCL bench sums", 2, "'sums'");
}

static void every_view_is_a_picture(void **state)
{
    (void)state;
    static const char *const views[] = {"shaded", "normal", "depth", "steps", "level", "triangles"};
    need_builds();
    for (size_t i = 0; i < sizeof views / sizeof views[0]; ++i) {
        char line[128];
        snprintf(line, sizeof line, "$SVOCL render scene:cube -d 4 --size 32x24 --view %s -o %s.png", views[i],
                 views[i]);
        run_well(line);
        run("test -s shaded.png");
        assert_int_equal(last.exit_code, 0);
    }
    run_badly("$SVOCL render scene:cube --view none -o a.png", 2, "none");
    run_well("$SVOCL build scene:cube -d 4 -o plain.svo");
    run_badly("$SVOCL render plain.svo --view triangles -o a.png", 1, "leaf lists");
}

static void a_picture_is_written(void **state)
{
    (void)state;
    need_builds();
    run_well("$SVOCL build scene:cornell:2000 -d 6 -o a.svo");
    run_well("$SVOCL render a.svo --size 40x30 -o a.png");
    run_well("$SVOCL render scene:cornell:2000 -d 6 --size 40x30 -o b.png");
    run_well("cmp a.png b.png");
    unsigned char header[24];
    FILE *file = fopen("a.png", "rb");
    assert_non_null(file);
    assert_int_equal(fread(header, 1, sizeof header, file), sizeof header);
    fclose(file);
    assert_memory_equal(header, "\x89PNG\r\n\x1a\n", 8);
    assert_int_equal(header[19], 40);
    assert_int_equal(header[23], 30);
}

/* What a mesh file holds and the mesh does not is a warning in text and JSON, and an error where that is asked for. */
static void a_mesh_that_is_not_read_whole_is_named(void **state)
{
    (void)state;
    need_builds();
    write_text("part.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 5 5 5\nf 1 2 3\nl 1 2\n");
    run_well("$SVOCL build part.obj -d 3");
    assert_non_null(strstr(last.errors, "warning: part.obj: 1 of 4 vertices belong to no face\n"));
    assert_non_null(strstr(last.errors, "warning: part.obj: 1 lines and 0 points are left out\n"));
    cJSON *document = run_json("$SVOCL build part.obj -d 3 --json");
    assert_int_equal(number_of(document, "warning_count"), 2);
    const cJSON *warnings = array_of(document, "warnings");
    assert_int_equal(cJSON_GetArraySize(warnings), 2);
    assert_string_equal(cJSON_GetArrayItem(warnings, 1)->valuestring, "part.obj: 1 of 4 vertices belong to no face");
    const cJSON *import = cJSON_GetObjectItem(document, "import");
    assert_string_equal(text_of(import, "reader"), "obj");
    assert_int_equal(number_of(import, "declared_vertices"), 4);
    assert_int_equal(number_of(import, "used_vertices"), 3);
    cJSON_Delete(document);
    run_badly("$SVOCL build part.obj -d 3 --strict", 1, "part.obj: 1 lines and 0 points are left out");
    run_badly("$SVOCL hash part.obj -d 3 --strict", 1, "part.obj: ");
    document = run_json("cat part.obj | $SVOCL build - -d 3 --json");
    assert_string_equal(cJSON_GetArrayItem(array_of(document, "warnings"), 1)->valuestring,
                        "standard input: 1 of 4 vertices belong to no face");
    cJSON_Delete(document);
    run_badly("cat part.obj | $SVOCL build - -d 3 --strict", 1, "standard input: 1 lines and 0 points are left out");
    run_badly("printf 'v 0 0 x\\n' | $SVOCL build - -d 3", 1, "standard input: line 1");
    run_badly("$SVOCL build part.obj --import-seconds 0", 2, "import-seconds 0 is below 1");
    write_text("whole.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    document = run_json("$SVOCL build whole.obj -d 3 --json --strict --import-seconds 7");
    assert_int_equal(number_of(document, "warning_count"), 0);
    assert_int_equal(cJSON_GetArraySize(array_of(document, "warnings")), 0);
    cJSON_Delete(document);
}

/* The program alone, copied out of its installation, reads mesh files itself. */
static void the_program_alone_reads_meshes(void **state)
{
    (void)state;
    need_builds();
    write_text("one.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    run_well("cp \"$SVOCL\" alone && ./alone hash one.obj -d 3");
}

/* On a terminal, with nothing compiled: the bar shows different parts of the same step. */
static void the_bar_moves_inside_a_build(void **state)
{
    (void)state;
    need_builds();
    run("command -v script");
    if (last.exit_code != 0) {
        print_message("skipped: the program script, which makes a terminal, is not installed\n");
        skip();
    }
    /* No kernel is kept anywhere, so the build lasts for seconds. */
    run_well("mkdir cache && XDG_CACHE_HOME=$PWD/cache POCL_CACHE_DIR=$PWD/cache "
             "script -qec \"$SVOCL build scene:knot -d 6 --frontend cl\" /dev/null");
    unsigned parts = 0;
    double previous = 0.0;
    static const char step[] = "building the tree: ";
    for (const char *at = strstr(last.output, step); at != NULL; at = strstr(at + 1, step)) {
        const char *comma = strchr(at, ',');
        assert_non_null(comma);
        const double percent = strtod(comma + 1, NULL);
        assert_true(percent >= previous && percent <= 100.0);
        parts += percent > previous && percent < 100.0;
        previous = percent;
    }
    if (parts < 2) {
        fail_msg("the bar shows %u parts of the build: %s", parts, last.output);
    }
    run_well("rm -r cache");
}

/* Kernels saved by one command are loaded by another; one that is damaged is a warning. */
static void kernels_are_saved_and_loaded(void **state)
{
    (void)state;
    need_builds();
    cJSON *document = run_json("$SVOCL kernels scene:cube -d 5 --kernels kept --json");
    const int count = cJSON_GetArraySize(array_of(document, "kernels"));
    assert_true(count > 0);
    assert_int_equal((int)number_of(document, "saved"), count);
    cJSON_Delete(document);
    run_well("$SVOCL kernels scene:cube -d 5 --kernels kept");
    assert_non_null(strstr(last.output, " 0 programs saved"));
    assert_non_null(strstr(last.output, "voxelize"));
    run_well("$SVOCL hash scene:cube -d 5 --frontend cl > plain.txt");
    run_well("$SVOCL hash scene:cube -d 5 --frontend cl --kernels kept > loaded.txt && cmp plain.txt loaded.txt");
    assert_string_equal(last.errors, "");
    run_well("for f in kept/*; do printf x >> $f; break; done");
    run_well("$SVOCL hash scene:cube -d 5 --frontend cl --kernels kept > loaded.txt && cmp plain.txt loaded.txt");
    assert_non_null(strstr(last.errors, "warning: kept/"));
    assert_non_null(strstr(last.errors, "is damaged"));
    run_badly("$SVOCL hash scene:cube -d 5 --kernels plain.txt", 1, "plain.txt");
    /* Code that others may have written is not run, and the folder is made so that they cannot. */
    run_well("chmod 0777 kept");
    run_badly("$SVOCL hash scene:cube -d 5 --frontend cl --kernels kept", 1, "kept is no folder that you alone");
    run_badly("$SVOCL kernels scene:cube -d 5 --kernels kept", 1, "kept is no folder that you alone");
    run_well("rm -r kept && umask 0 && $SVOCL kernels scene:cube -d 5 --kernels kept -q");
    run_well("test -z \"$(find kept -perm /022)\" && $SVOCL hash scene:cube -d 5 --frontend cl --kernels kept -q");
    run_well("rm -r kept");
}

/* Without --kernels the user's folder serves, if only the user may write to it. A damaged file shows whether it is
   read. */
static void kernels_have_a_folder_of_their_own(void **state)
{
    (void)state;
    need_builds();
    static const char hash[] = "XDG_CACHE_HOME=$PWD/own $SVOCL hash scene:cube -d 5 --frontend cl";
    char command[256];
    run_badly("env -u HOME -u XDG_CACHE_HOME $SVOCL kernels scene:cube -d 5", 2, "--kernels");
    run_badly("env -u HOME XDG_CACHE_HOME=own $SVOCL kernels scene:cube -d 5", 2, "--kernels");
    run_badly("HOME=/dev/null XDG_CACHE_HOME= $SVOCL kernels scene:cube -d 5", 1, "/dev/null");
    run_well("XDG_CACHE_HOME=$PWD/own $SVOCL kernels scene:cube -d 5");
    run_well("XDG_CACHE_HOME=$PWD/none $SVOCL hash scene:cube -d 5 --frontend cl > plain.txt && test ! -e none/svocl");
    snprintf(command, sizeof command, "%s > own.txt && cmp plain.txt own.txt", hash);
    run_well(command);
    assert_string_equal(last.errors, "");
    run_well("test \"$(stat -c %a own/svocl)\" = 700 && chmod 500 own/svocl");
    run_well(command);
    assert_string_equal(last.errors, "");
    run_well("chmod 700 own/svocl && for f in own/svocl/*; do printf x >> $f; break; done");
    run_well(command);
    assert_non_null(strstr(last.errors, "is damaged"));
    run_well("chmod 770 own/svocl");
    run_well(command);
    assert_string_equal(last.errors, "");
    run_badly("XDG_CACHE_HOME=$PWD/own $SVOCL kernels scene:cube -d 5", 1, "you alone");
    run_well("rm -r own none");
}

/* Both load the folder that both write: files appear whole. */
static void two_processes_save_into_one_folder(void **state)
{
    (void)state;
    need_builds();
    run_well("$SVOCL hash scene:cube -d 5 --frontend cl > plain.txt && "
             "$SVOCL kernels scene:cube -d 5 --kernels both > first.txt & "
             "$SVOCL kernels scene:cube -d 5 --kernels both > second.txt && wait");
    run_well("$SVOCL hash scene:cube -d 5 --frontend cl --kernels both > loaded.txt && cmp plain.txt loaded.txt");
    assert_string_equal(last.errors, "");
    run_well("test -z \"$(ls both | grep -v 'kernels$')\" && rm -r both");
}

TEST_GROUP(program)
{
    const struct CMUnitTest tests[] = {IN_FOLDER(usage_errors_exit_with_code_2),
                                       IN_FOLDER(options_without_effect_are_refused),
                                       IN_FOLDER(names_without_meaning_are_refused),
                                       IN_FOLDER(help_goes_to_standard_output),
                                       IN_FOLDER(scenes_are_written_and_read_again),
                                       IN_FOLDER(bad_meshes_are_one_line),
                                       IN_FOLDER(triangles_that_are_not_finite_are_counted),
                                       IN_FOLDER(indices_out_of_range_are_named),
                                       IN_FOLDER(a_mesh_that_is_not_read_whole_is_named),
                                       IN_FOLDER(the_program_alone_reads_meshes),
                                       IN_FOLDER(missing_drivers_are_one_line),
                                       IN_FOLDER(a_platform_without_a_device_is_named),
                                       IN_FOLDER(a_forced_choice_that_does_not_work_fails),
                                       IN_FOLDER(failed_writes_leave_nothing),
                                       IN_FOLDER(links_stay_and_their_targets_are_written),
                                       IN_FOLDER(standard_output_is_a_file),
                                       IN_FOLDER(meshes_and_trees_come_through_pipes),
                                       IN_FOLDER(a_signal_while_writing_leaves_nothing),
                                       IN_FOLDER(names_that_are_near_are_suggested),
                                       IN_FOLDER(quiet_prints_results_and_errors_alone),
                                       IN_FOLDER(every_json_has_a_version),
                                       IN_FOLDER(names_that_are_not_utf8_are_escaped),
                                       IN_FOLDER(a_full_standard_output_is_an_error),
                                       IN_FOLDER(build_has_its_json_names),
                                       IN_FOLDER(plans_have_their_json_names),
                                       IN_FOLDER(a_plan_is_printed_before_the_build),
                                       IN_FOLDER(the_plan_leaves_opengl_out_of_small_scenes),
                                       IN_FOLDER(info_says_what_is_stored_once),
                                       IN_FOLDER(upper_levels_of_a_file),
                                       IN_FOLDER(info_names_what_is_wrong_with_a_file),
                                       IN_FOLDER(devices_has_its_json_names),
                                       IN_FOLDER(opengl_is_started_only_for_what_needs_it),
                                       IN_FOLDER(verify_finds_every_scene_exact),
                                       IN_FOLDER(verify_takes_the_mesh_as_given),
                                       IN_FOLDER(the_hash_is_the_same_by_every_method),
                                       IN_FOLDER(scans_without_normals_get_those_of_their_triangles),
                                       IN_FOLDER(welding_closes_cracks),
                                       IN_FOLDER(files_with_z_up_are_turned),
                                       IN_FOLDER(vox_files_keep_what_they_hold),
                                       IN_FOLDER(point_clouds_become_voxels),
                                       IN_FOLDER(merged_faces_are_read_back),
                                       IN_FOLDER(voxels_have_a_size),
                                       IN_FOLDER(voxel_files_are_converted),
                                       IN_FOLDER(hash_says_what_ran),
                                       IN_FOLDER(a_picture_is_written),
                                       IN_FOLDER(rays_from_a_file_become_hits),
                                       IN_FOLDER(rays_are_compared_with_embree),
                                       IN_FOLDER(every_view_is_a_picture),
                                       IN_FOLDER(the_bar_moves_inside_a_build),
                                       IN_FOLDER(kernels_are_saved_and_loaded),
                                       IN_FOLDER(kernels_have_a_folder_of_their_own),
                                       IN_FOLDER(two_processes_save_into_one_folder)};
    return cmocka_run_group_tests_name("program", tests, NULL, NULL);
}
