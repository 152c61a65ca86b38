/* SPDX-License-Identifier: MIT */
/* What must not happen to a user of the program: an input that an output replaces, a suffix that says something else
   than the file, a small file that takes all memory, a progress bar that fills the terminal; and numbers with units. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define XXH_INLINE_ALL
#include <xxhash.h>

#include "run_program.h"
#include "support/suite.h"
#include "svocl/tree.h"

/* ---- outputs and inputs ---- */

/* A textured mesh: m.obj reads m.mtl and tex.png; a copy of each lies in kept. The texture is a picture of a tree. */
static void make_mesh(void)
{
    run_well("$SVOCL render scene:cube -d 3 --size 8x8 -o tex.png -q");
    write_text("m.mtl", "newmtl a\nKd 1 1 1\nmap_Kd tex.png\n");
    write_text("m.obj", "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nusemtl a\nf 1/1 2/2 3/3\n");
    run_well("mkdir kept && cp m.obj m.mtl tex.png kept");
}

static void expect_kept(void)
{
    run_well("for f in kept/*; do cmp $f $(basename $f) || exit 1; done");
}

/* Refused as wrong usage, in one line with both names, and every input is as before. */
static void expect_refused(const char *line, const char *words)
{
    char full[512];
    (void)snprintf(full, sizeof full, "$SVOCL %s", line);
    run_badly(full, 2, words);
    expect_kept();
}

static void no_output_replaces_an_input(void **state)
{
    (void)state;
    need_builds();
    make_mesh();
    run_well("ln -s m.obj link.svo && ln m.obj hard.svo && ln -s tex.png pic.png && ln -s . here");
    expect_refused("build m.obj -o m.obj", "output m.obj would replace m.obj, which this run reads");
    expect_refused("build m.obj -o link.svo", "output link.svo would replace m.obj");
    expect_refused("build m.obj -o hard.svo", "output hard.svo would replace m.obj");
    expect_refused("build m.obj -o here/m.obj", "output here/m.obj would replace m.obj");
    expect_refused("render m.obj -o m.obj", "would replace m.obj");
    expect_refused("export-web m.obj -o m.obj", "would replace m.obj");
    expect_refused("trace m.obj --camera auto -o m.obj", "would replace m.obj");
    expect_refused("build m.obj -d 3 --max-memory 1G -o link.svo", "would replace m.obj");
    expect_refused("parts plan m.obj -d 3 -o link.svo", "would replace m.obj");
    /* What the mesh refers to is known when it is read. */
    expect_refused("render m.obj -d 3 -o tex.png", "output tex.png would replace tex.png");
    expect_refused("render m.obj -d 3 -o pic.png", "output pic.png would replace tex.png");
    run_well("ln -s m.mtl lib.svo && ln m.mtl lib.csv");
    expect_refused("build m.obj -d 3 -o lib.svo", "output lib.svo would replace m.mtl");
    expect_refused("trace m.obj -d 3 --camera auto -o lib.csv", "output lib.csv would replace m.mtl");
    run_badly("$SVOCL build m.obj -d 3 -o - <m.obj >>m.obj", 2, "output standard output would replace m.obj");
    run_badly("$SVOCL build - -d 3 -o link.svo <m.obj", 2, "output link.svo would replace standard input");
    expect_kept();
}

static void no_output_replaces_a_file_of_an_option(void **state)
{
    (void)state;
    need_builds();
    make_mesh();
    write_text("rays.csv", "0,0,5,0,0,-1\n");
    write_text("points.csv", "0,0,5,0,0,-1\n");
    write_text("sun.json", "{\"lights\": [{\"type\": \"sun\", \"direction\": [0, -1, 0], \"radiance\": [1, 1, 1]}]}");
    run_well("cp rays.csv points.csv sun.json kept && ln -s sun.json sun.png && ln -s sun.json sun.csv");
    expect_refused("trace scene:cube -d 3 --rays rays.csv -o rays.csv", "output rays.csv would replace rays.csv");
    expect_refused("gather scene:cube -d 3 --points points.csv -o points.csv", "would replace points.csv");
    expect_refused("reference scene:cube --points points.csv -o points.csv", "would replace points.csv");
    expect_refused("reference scene:cube --points 3 --lights sun.json -o sun.csv", "would replace sun.json");
    expect_refused("render scene:cube -d 3 --view full --lights sun.json -o sun.json", "would replace sun.json");
    expect_refused("render scene:cube -d 3 --view full --lights sun.json -o sun.png", "would replace sun.json");
}

static void no_output_replaces_what_a_scene_or_gltf_refers_to(void **state)
{
    (void)state;
    need_builds();
    make_mesh();
    write_text("s.json", "{\"trees\": {\"a\": {\"path\": \"m.obj\", \"depth\": 3}}, "
                         "\"instances\": [{\"tree\": \"a\"}]}");
    run_well("ln -s m.obj view.png && cp s.json kept");
    expect_refused("render s.json -o view.png", "output view.png would replace m.obj");
    expect_refused("render s.json -o s.json", "output s.json would replace s.json");
    run_well("head -c 36 /dev/zero >b.bin && printf '\\0\\0\\200\\077' | dd of=b.bin bs=1 seek=12 conv=notrunc "
             "2>/dev/null && printf '\\0\\0\\200\\077' | dd of=b.bin bs=1 seek=28 conv=notrunc 2>/dev/null");
    write_text("t.gltf", "{\"asset\":{\"version\":\"2.0\"},\"scenes\":[{\"nodes\":[0]}],\"scene\":0,"
                         "\"nodes\":[{\"mesh\":0}],\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0}}]}],"
                         "\"buffers\":[{\"byteLength\":36,\"uri\":\"b.bin\"}],"
                         "\"bufferViews\":[{\"buffer\":0,\"byteOffset\":0,\"byteLength\":36}],"
                         "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\","
                         "\"min\":[0,0,0],\"max\":[1,1,0]}]}");
    run_well("cp b.bin t.gltf kept && ln b.bin b.svo && $SVOCL build t.gltf -d 3 -o good.svo -q");
    expect_refused("build t.gltf -d 3 -o b.svo", "output b.svo would replace b.bin");
}

static void a_conversion_in_place_is_refused(void **state)
{
    (void)state;
    need_builds();
    run_well("$SVOCL build scene:cube -d 3 -o a.svo -q && $SVOCL convert a.svo a.vox -q && mkdir kept && "
             "cp a.svo a.vox kept");
    expect_refused("convert a.vox a.vox", "output a.vox would replace a.vox");
    expect_refused("convert a.svo a.svo", "output a.svo would replace a.svo");
    run_well("$SVOCL build scene:cube -d 4 --max-memory 1M -o p.svo -q && $SVOCL parts plan scene:cube -d 4 -o p.svo "
             "-q && $SVOCL parts build p.svo.parts -q");
    run_badly("$SVOCL parts stitch p.svo.parts -o p.svo.parts/x.svo", 2, "would replace p.svo.parts");
    run_well("$SVOCL parts stitch p.svo.parts && $SVOCL parts remove p.svo.parts && test -s p.svo");
}

static void outputs_of_one_run_are_different_files(void **state)
{
    (void)state;
    run_well("ln -s o.obj o.mtl");
    run_badly("$SVOCL scene atrium --triangles 2000 -o o.obj", 2, "outputs o.mtl and o.obj are one file");
    run_well("rm -f o.obj o.mtl && echo old >o.obj && ln -s o.obj o.mtl");
    run_badly("$SVOCL scene atrium --triangles 2000 -o o.obj", 2, "outputs o.obj and o.mtl are one file");
    run_well("test \"$(cat o.obj)\" = old && rm o.mtl && $SVOCL scene atrium --triangles 2000 -o o.obj -q && "
             "$SVOCL scene atrium --triangles 2000 -o o.obj -q");
}

/* Results are read and written again where that is meant. */
static void a_report_reads_its_results_and_spares_them(void **state)
{
    (void)state;
    need_builds();
    run_well("$SVOCL bench voxelize --quick --repeat 1 --scenes cube --depths 2 -o r.json -q");
    run_well("mkdir kept page && cp r.json page/results.json && cp r.json kept");
    run_well("$SVOCL report --quick --from r.json -o out -q");
    run_badly("$SVOCL report --from page/results.json -o page", 2,
              "output page/results.json would replace page/results.json");
    expect_kept();
}

static void frames_spare_the_textures_of_their_scene(void **state)
{
    (void)state;
    need_builds();
    make_mesh();
    write_text(
        "s.json",
        "{\"trees\": {\"a\": {\"path\": \"m.obj\"}}, \"instances\": [{\"tree\": \"a\"}, {\"tree\": \"a\", \"motion\": "
        "[{\"time\": 0, \"translate\": [0, 0, 0]}, {\"time\": 1, \"translate\": [1, 0, 0]}]}]}");
    run_well("ln -s tex.png film_001.png");
    expect_refused("render s.json --animate --frames 3 -d 3 --size 8x8 -o film.png",
                   "output film_001.png would replace tex.png");
    run_well("test ! -e film_000.png");
}

/* ---- suffixes ---- */

static void other_suffixes_are_refused_before_any_work(void **state)
{
    (void)state;
    static const char *const lines[][2] = {
        {"build none.obj -o x.svc", "output x.svc is a compact tree, which needs --tree-form or --solid"},
        {"build none.obj -o x.vox", "output x.vox does not end in .svo or .svc"},
        {"build none.obj -o a.b/x.xyz", "output a.b/x.xyz does not end in .svo or .svc"},
        {"build none.obj --solid winding -o x.svo", "output x.svo does not end in .svc, as files of --solid do"},
        {"build none.obj --tree-form shared -o x.svo", "output x.svo does not end in .svc, as files of --tree-form do"},
        {"build none.obj --max-memory 1M -o x.obj", "output x.obj does not end in .svo or .svc"},
        {"parts plan none.obj -o x.ply", "output x.ply does not end in .svo or .svc"},
        {"parts stitch none.parts -o x.svc", "output x.svc is a compact tree, which needs --tree-form"},
        {"convert none.svo x.svc", "output x.svc is a compact tree, which needs --tree-form or --solid"},
        {"convert none.svo x.vox --tree-form shared", "output x.vox does not end in .svc"},
        {"render none.svo -o x.jpg", "output x.jpg does not end in .png"},
        {"render none.json --animate -o film.gif", "output film.gif does not end in .png"},
        {"export-web none.svo -o x.pdf", "output x.pdf does not end in .html or .htm"},
        {"trace none.obj --camera auto -o x.json", "output x.json does not end in .csv or .txt"},
        {"gather none.svo --points 3 -o x.png", "output x.png does not end in .csv"},
        {"reference none.obj --points 3 -o x.svo", "output x.svo does not end in .csv"},
        {"bench rays -o x.csv", "output x.csv does not end in .json"},
        {"scene cube -o x.stl", "output x.stl does not end in .obj or .ply"},
        {"scene cube -o x", "output x does not end in .obj or .ply"},
        {"convert none.vox x.stl",
         "output x.stl does not end in .svo, .svc, .vox, .svx, .binvox, .nvdb, .vdb, .bt, .ply, .obj or .json"},
    };
    for (size_t i = 0; i < sizeof lines / sizeof lines[0]; ++i) {
        char line[160];
        (void)snprintf(line, sizeof line, "$SVOCL %s", lines[i][0]);
        run_badly(line, 2, lines[i][1]);
    }
    expect_files(NULL, 0);
}

/* Names without a suffix, upper case, streams and devices say nothing else than the command does. */
static void names_without_a_suffix_are_written(void **state)
{
    (void)state;
    need_builds();
    run_well(
        "$SVOCL build scene:cube -d 3 -o tree -q && $SVOCL build scene:cube -d 3 -o .hidden -q && cmp tree .hidden");
    run_well("$SVOCL build scene:cube -d 3 -o TREE.SVO -q && cmp tree TREE.SVO");
    run_well("$SVOCL build scene:cube -d 3 -o - -q | cmp - tree && $SVOCL build scene:cube -d 3 -o /dev/null -q");
    run_well("mkfifo x.png && { cat x.png >got & $SVOCL build scene:cube -d 3 -o x.png -q; wait; cmp got tree; }");
    run_well("$SVOCL render scene:cube -d 3 --size 8x8 -o picture -q && $SVOCL build scene:cube -d 3 --solid winding "
             "-o s.SVC -q");
}

/* ---- files that unfold ---- */

/* A full grid of that side as .binvox: runs of 255 voxels. */
static void write_full_binvox(const char *path, unsigned side)
{
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    fprintf(file, "#binvox 1\ndim %u %u %u\ndata\n", side, side, side);
    for (unsigned left = side * side * side; left > 0;) {
        const unsigned run_length = left < 255 ? left : 255;
        const unsigned char bytes[2] = {1, (unsigned char)run_length};
        assert_int_equal(fwrite(bytes, 1, 2, file), 2);
        left -= run_length;
    }
    assert_int_equal(fclose(file), 0);
}

/* The head and the chunk table of a full tree of one color, of a depth that 5 KB are enough for. What is in the chunks
   does not matter: memory for them must not be asked for. */
static void write_full_svo(const char *path, unsigned depth)
{
    enum { HEADER_BYTES = 200, CHUNK_BYTES = 40, BLOCK_BYTES = 128 * 1024 };
    static unsigned char bytes[16384];
    const uint32_t chunk_count = depth + 1, head_bytes = HEADER_BYTES + CHUNK_BYTES * chunk_count;
    const uint32_t version = 3, snap_bits = 20;
    const uint16_t color = 1;
    const double one = 1.0;
    uint64_t offset = head_bytes;
    uint32_t begin = 0;
    memset(bytes, 0, sizeof bytes);
    static const unsigned char signature[8] = {0x89, 'S', 'V', 'O', '\r', '\n', 0x1a, '\n'};
    memcpy(bytes, signature, sizeof signature);
    memcpy(bytes + 8, &version, 4);
    memcpy(bytes + 12, &head_bytes, 4);
    memcpy(bytes + 32, &chunk_count, 4);
    memcpy(bytes + 36, &depth, 4);
    memcpy(bytes + 40, &snap_bits, 4);
    memcpy(bytes + 48, &color, 2);
    memcpy(bytes + 50, &color, 2); /* the same in all nodes */
    memcpy(bytes + 80, &one, 8);
    memcpy(bytes + 88, &one, 8);
    for (unsigned level = 0; level <= depth; ++level) {
        begin += 1u << 3 * level;
        memcpy(bytes + 128 + 4 * (level + 1), &begin, 4);
    }
    unsigned char *entry = bytes + HEADER_BYTES;
    for (unsigned level = 0; level < depth; ++level) {
        for (int is_color = 0; is_color <= (level == 0 ? 1 : 0); ++is_color, entry += CHUNK_BYTES) {
            const uint16_t kind = is_color ? SVO_TREE_COLORS : SVO_TREE_CHILD_MASK;
            const uint16_t on_level = (uint16_t)level;
            const uint32_t codec = 1;
            const uint64_t plain = is_color ? 4 : (uint64_t)1 << 3 * level;
            const uint64_t stored = 4 * (plain / BLOCK_BYTES + 1);
            memcpy(entry, &kind, 2);
            memcpy(entry + 2, &on_level, 2);
            memcpy(entry + 4, &codec, 4);
            memcpy(entry + 8, &offset, 8);
            memcpy(entry + 16, &stored, 8);
            memcpy(entry + 24, &plain, 8);
            offset += stored;
        }
    }
    assert_true(offset <= sizeof bytes);
    memcpy(bytes + 16, &offset, 8);
    const uint64_t hash = XXH3_64bits(bytes + 32, head_bytes - 32);
    memcpy(bytes + 24, &hash, 8);
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(bytes, 1, offset, file), offset);
    assert_int_equal(fclose(file), 0);
}

static void files_that_unfold_have_a_limit(void **state)
{
    (void)state;
    need_builds();
    write_full_binvox("full.binvox", 16);
    run_well("$SVOCL convert full.binvox full.svx -q && $SVOCL convert full.binvox full.vox -q && "
             "$SVOCL convert full.binvox full.svo -q");
    static const char *const names[] = {"binvox", "svx", "vox"};
    for (size_t i = 0; i < 3; ++i) {
        char line[160];
        (void)snprintf(line, sizeof line, "$SVOCL convert full.%s x.ply --max-voxels 4095", names[i]);
        run_badly(line, 1, "voxels are above the limit of 4095 (--max-voxels)");
        (void)snprintf(line, sizeof line, "$SVOCL convert full.%s x.ply --max-voxels 4096 -q && rm x.ply", names[i]);
        run_well(line);
    }
    run_badly("$SVOCL info full.svo --max-voxels 4680", 1,
              "full.svo: 4681 voxels are above the limit of 4680 (--max-voxels)");
    run_well("$SVOCL info full.svo --max-voxels 4681 -q && $SVOCL info full.svo --levels 1 --max-voxels 9 -q");
    run_well("$SVOCL build scene:cube -d 5 --solid winding -o s.svc -q && $SVOCL hash s.svc -q");
    run_badly("$SVOCL hash s.svc --max-voxels 30000", 1, "voxels are above the limit of 30000 (--max-voxels)");
    run_badly("$SVOCL scene cube --max-voxels 3 -o x.ply", 2, "--max-voxels does not apply");
}

/* Without the option the limit is what memory holds; the process has little of it here. */
static void files_that_unfold_beyond_memory_are_refused(void **state)
{
    (void)state;
    need_builds();
    write_full_binvox("full.binvox", 160);
    run_well("$SVOCL convert full.binvox full.svx -q && test $(stat -c %s full.svx) -lt 200000");
    run_badly(
        "ulimit -v 600000; $SVOCL convert full.binvox x.ply", 1,
        "full.binvox: 4096000 voxels need 781.2 MiB of memory, and 585.9 MiB are there for 3072000 (--max-voxels)");
    run_badly("ulimit -v 600000; $SVOCL convert full.svx x.ply", 1, "voxels need");
    write_full_svo("bomb.svo", 10);
    run_well("test $(stat -c %s bomb.svo) -lt 6000");
    run_badly(
        "ulimit -v 2000000; $SVOCL info bomb.svo", 1,
        "bomb.svo: 1227133513 voxels need 5.3 GiB of memory, above half of the 1.9 GiB that are there (--max-voxels)");
    run_badly("ulimit -v 2000000; $SVOCL render bomb.svo -o x.png", 1, "above half of the 1.9 GiB");
}

/* A driver that gets no memory may end the process, so the library asks before it does. Whatever is short, of the
   loader, the driver, its compiler, the mesh or the buffers, the error is one line that names the limit. */
static void short_memory_is_told_as_such(void **state)
{
    (void)state;
    need_builds();
    static const char *const limits[] = {"60000", "200000", "310000", "350000", "420000", "500000", "600000"};
    char line[200];
    for (size_t i = 0; i < sizeof limits / sizeof limits[0]; ++i) {
        (void)snprintf(line, sizeof line, "ulimit -v %s; $SVOCL build scene:knot:20000 -d 8 --threads 2", limits[i]);
        run_badly(line, 1, "out of memory");
        run_badly(line, 1, "RLIMIT_AS (ulimit -v) is ");
    }
    run_badly("ulimit -v 500000; $SVOCL build scene:cube -d 3 --threads 2 --max-memory 2M -o p.svo", 75,
              "out of memory: compiling kernels needs about 192.0 MiB, and RLIMIT_AS (ulimit -v) is 488.3 MiB");
    run_well("rm -r p.svo.parts");
    run_badly("ulimit -v 9000000; $SVOCL build scene:cube -d 14 --threads 2", 1,
              "out of memory: RLIMIT_AS (ulimit -v) is 8.6 GiB, which leaves ");
    run_well("ulimit -v 9000000; $SVOCL build scene:cube -d 3 --threads 2 -q");
}

/* ---- numbers ---- */

static void sizes_have_units(void **state)
{
    (void)state;
    need_builds();
    static const struct {
        const char *text;
        double bytes;
    } sizes[] = {{"4GB", 4e9}, {"4G", 4294967296.0}, {"1.5GiB", 1610612736.0}, {"900000000b", 9e8}};
    for (size_t i = 0; i < sizeof sizes / sizeof sizes[0]; ++i) {
        char line[160];
        (void)snprintf(line, sizeof line, "$SVOCL build scene:cube -d 3 --max-memory %s -o a.svo --json",
                       sizes[i].text);
        cJSON *document = run_json(line);
        assert_true(number_of(document, "max_memory_bytes") == sizes[i].bytes);
        cJSON_Delete(document);
    }
    run_well("$SVOCL export-web scene:cube -d 3 --max-bytes 0.5MiB -o a.html -q");
    static const char *const wrong[] = {"4X", "GB", "1.5", "1.GB", "-1", "4GBs", "", "1e9"};
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; ++i) {
        char line[160];
        (void)snprintf(line, sizeof line, "$SVOCL build scene:cube --max-memory '%s' -o b.svo", wrong[i]);
        run_badly(line, 2, "is not a number of bytes, such as 65536, 512M, 4GB or 1.5GiB");
    }
    run_badly("$SVOCL build scene:cube --max-memory 99999999999999T -o b.svo", 2, "is above");
    run_badly("$SVOCL export-web scene:cube --max-bytes 300MB -o b.html", 2,
              "max-bytes 300MB is above 268435456 bytes");
    run_badly("$SVOCL build scene:cube -d 3 --max-memory 0 -o b.svo", 2, "max-memory 0 is below 1");
}

static void wrong_numbers_are_wrong_usage(void **state)
{
    (void)state;
    need_builds();
    run_badly("$SVOCL build scene:cube -depth 8", 2, "unknown option '-depth', did you mean '--depth 8'?");
    run_badly("$SVOCL build scene:cube -quiet", 2, "did you mean '--quiet'?");
    run_badly("$SVOCL build scene:cube -output=a.svo", 2, "did you mean '--output a.svo'?");
    run_badly("$SVOCL build scene:cube --resolution 256", 2, "did you mean '--depth 8', for 256 voxels");
    run_badly("$SVOCL build scene:cube --resolution=300", 2, "did you mean '--depth 9', for 512 voxels");
    run_badly("$SVOCL build scene:cube --resolution fine", 2, "did you mean '--depth D', for 2^D voxels");
    run_badly("$SVOCL build scene:cube --payload-level 9", 2, "--payload-level 9 is above the depth, 8");
    write_full_binvox("full.binvox", 4);
    run_badly("$SVOCL build full.binvox --payload-level 3", 2, "--payload-level 3 is above the depth, 2");
    run_well("rm full.binvox");
    run_badly("$SVOCL build scene:cube -d 8 --max-memory 10 -o a.svo", 2, "--max-memory 10 is too small");
    run_badly("$SVOCL parts plan scene:cube -d 8 --max-memory 10 -o a.svo", 2, "--max-memory 10 is too small");
    /* This one would do for the least part, did it have fewer triangles. */
    run_badly("$SVOCL build scene:knot:4000 -d 4 --max-memory 20000 -o a.svo", 2, "--max-memory 20000 is too small");
    expect_files(NULL, 0);
    run_badly("$SVOCL build scene:cube -d 16", 1, "svocl build --max-memory builds it in parts");
    assert_true(strstr(last.errors, "iB at depth 16") != NULL || strstr(last.errors, "fragments at depth 16") != NULL);
}

static void json_that_is_not_says_where(void **state)
{
    (void)state;
    need_builds();
    write_text("nan.json", "{\"lights\":[{\"type\":\"sun\",\n\"direction\":[0,NaN,1]}]}");
    run_badly("$SVOCL render scene:cube -d 3 --view full --lights nan.json -o x.png", 1,
              "nan.json:2: not JSON at column 16, 'NaN'");
    write_text("cut.json", "{\"trees\": {\"a\": {\"path\":\n \"m.obj\"");
    run_badly("$SVOCL render cut.json -o x.png", 1, "cut.json:2: not JSON at column 9, where the text ends");
    run_badly("$SVOCL report --from cut.json -o out", 1, "cut.json: line 2: not JSON at column 9, where the text ends");
}

/* ---- the progress bar ---- */

/* Rays from a pipe that says nothing for a while, so that the bar is drawn; each width in a terminal of its own. */
static const char in_terminals[] =
    "for n in 30 40 60 80 200; do mkfifo r$n; { sleep 2; echo 0,0,5,0,0,-1 >r$n; } & "
    "script -qec \"stty cols $n rows 24; $SVOCL trace scene:cube -d 3 --rays r$n -o h$n.csv\" /dev/null "
    "</dev/null >shown.$n & done; wait";

static void the_bar_stays_in_one_line(void **state)
{
    (void)state;
    need_builds();
    static const size_t widths[] = {30, 40, 60, 80, 200};
    static char text[TEXT_BYTES];
    run_well(in_terminals);
    for (size_t i = 0; i < sizeof widths / sizeof widths[0]; ++i) {
        char name[32];
        size_t drawn = 0, longest = 0;
        (void)snprintf(name, sizeof name, "shown.%zu", widths[i]);
        read_text(name, text, sizeof text);
        for (const char *at = strstr(text, "\r\033[K"); at != NULL; at = strstr(at, "\r\033[K")) {
            at += strlen("\r\033[K");
            const size_t length = strcspn(at, "\r\n");
            if (strncmp(at, "trace ", 6) != 0) {
                continue; /* the report follows the last one */
            }
            assert_int_not_equal(at[length], '\n');
            longest = length > longest ? length : longest;
            ++drawn;
        }
        if (drawn < 2 || longest >= widths[i]) {
            fail_msg("%zu columns: drawn %zu times, the longest %zu wide: %s", widths[i], drawn, longest, text);
        }
        assert_non_null(strstr(text, " rays"));
        assert_true((widths[i] >= 60) == (strstr(text, "trace [") != NULL));
    }
}

TEST_GROUP(program_safety)
{
    const struct CMUnitTest tests[] = {
        IN_FOLDER(no_output_replaces_an_input),
        IN_FOLDER(no_output_replaces_a_file_of_an_option),
        IN_FOLDER(no_output_replaces_what_a_scene_or_gltf_refers_to),
        IN_FOLDER(a_conversion_in_place_is_refused),
        IN_FOLDER(outputs_of_one_run_are_different_files),
        IN_FOLDER(a_report_reads_its_results_and_spares_them),
        IN_FOLDER(frames_spare_the_textures_of_their_scene),
        IN_FOLDER(other_suffixes_are_refused_before_any_work),
        IN_FOLDER(names_without_a_suffix_are_written),
        IN_FOLDER(files_that_unfold_have_a_limit),
        IN_FOLDER(files_that_unfold_beyond_memory_are_refused),
        IN_FOLDER(short_memory_is_told_as_such),
        IN_FOLDER(sizes_have_units),
        IN_FOLDER(wrong_numbers_are_wrong_usage),
        IN_FOLDER(json_that_is_not_says_where),
        IN_FOLDER(the_bar_stays_in_one_line),
    };
    return cmocka_run_group_tests_name("program_safety", tests, NULL, NULL);
}
