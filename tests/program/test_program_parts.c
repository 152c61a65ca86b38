/* SPDX-License-Identifier: MIT */
/*
 * `svocl build --max-memory` and `svocl parts` as a user runs them: the file in one piece, byte for byte; damaged
 * parts, runs that were ended, full disks; the steps by several processes.
 */
#include "run_program.h"
#include "support/suite.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define SCENE "scene:statue:20000 -d 7 --need color,normal,rays,material,fill,projected-area"

/* a.svo in one piece. */
static void build_whole(void)
{
    need_builds();
    run_well("$SVOCL build " SCENE " -q -o a.svo");
}

static void parts_that_fit_make_the_same_file(void **state)
{
    (void)state;
    build_whole();
    cJSON *document = run_json("$SVOCL build " SCENE " --max-memory 2M -o b.svo --json");
    assert_true(number_of(document, "parts") > 8);
    assert_true(number_of(document, "peak_resident_bytes") > 1e6);
    cJSON_Delete(document);
    run_well("cmp a.svo b.svo && test ! -e b.svo.parts");
    run_well("$SVOCL build " SCENE " --max-memory 1G -o b.svo");
    assert_non_null(strstr(last.output, "peak resident"));
    run_well("cmp a.svo b.svo");
    run_well("rm a.svo b.svo");
}

/* Whatever makes them, with whatever number of threads. */
static void every_way_makes_the_same_file(void **state)
{
    (void)state;
    static const char *const ways[] = {"--frontend cl --threads 1", "--frontend cl --threads 2 --path gpu",
                                       "--frontend gl-expand --threads 2"};
    build_whole();
    const size_t count = sizeof ways / sizeof ways[0] - (gl_works() ? 0 : 1);
    for (size_t i = 0; i < count; ++i) {
        char line[512];
        (void)snprintf(line, sizeof line, "$SVOCL build " SCENE " --max-memory 6M -q -o b.svo %s && cmp a.svo b.svo",
                       ways[i]);
        run_well(line);
    }
    run_well("rm a.svo b.svo");
}

/* Each file of a folder that is truncated, and each with a flipped byte, is named and built again; others stay. */
static void damaged_parts_are_built_again(void **state)
{
    (void)state;
    build_whole();
    run_well("$SVOCL parts plan " SCENE " --max-memory 6M -o b.svo -q && $SVOCL parts build b.svo.parts");
    run_well("$SVOCL parts status b.svo.parts");
    run_well("cd b.svo.parts && for f in *.part; do"
             "  size=$(stat -c %s $f) && cp $f ../whole && stat -c '%n %i' *.part >../before &&"
             "  for at in 0 20 40 100 $((size / 2)) $((size - 1)); do"
             "    cp ../whole $f && truncate -s $at $f &&"
             "    (cd .. && $SVOCL parts status b.svo.parts | grep -q \"^b.svo.parts/$f: \") || exit 1;"
             "    cp ../whole $f && byte=$(od -An -tu1 -j $at -N 1 $f) &&"
             "    printf \"\\\\$(printf %o $((byte ^ 4)))\" | dd of=$f bs=1 seek=$at conv=notrunc status=none &&"
             "    (cd .. && $SVOCL parts status b.svo.parts | grep -q \"^b.svo.parts/$f: \") || exit 1;"
             "  done; done");
    run_badly("$SVOCL parts stitch b.svo.parts", 75, "b.svo.parts/");
    run_well("test ! -e b.svo");
    run_well("$SVOCL build " SCENE " --max-memory 6M --resume -q -o b.svo && cmp a.svo b.svo");
    run_well("rm a.svo b.svo whole before");
}

/* A part that is there and whole is not written again. */
static void steps_are_idempotent(void **state)
{
    (void)state;
    build_whole();
    run_well("$SVOCL parts plan " SCENE " --max-memory 6M -o b.svo -q");
    run_badly("$SVOCL parts stitch b.svo.parts", 75, "is missing");
    run_well("seq 0 $(($($SVOCL parts status b.svo.parts --json | grep -c '\"index\"') - 1)) >indices");
    run_well("xargs -a indices -P 3 -I {} $SVOCL parts build b.svo.parts --part {}"
             " && stat -c '%n %i' b.svo.parts/*.part >before");
    run_well("$SVOCL parts build b.svo.parts & $SVOCL parts build b.svo.parts && wait $!"
             " && stat -c '%n %i' b.svo.parts/*.part | cmp - before");
    run_well("$SVOCL parts stitch b.svo.parts && cmp a.svo b.svo");
    run_well("$SVOCL parts stitch b.svo.parts -o c.svo && cmp a.svo c.svo");
    run_well("share() { $SVOCL parts share b.svo.parts --shares 4 \"$@\"; }; share && share &&"
             " (share --part 0 & share --part 2 & share --part 0 & share --part 3 && share --part 1 && wait)"
             " && $SVOCL parts stitch b.svo.parts --shares 4 -o c.svo && cmp a.svo c.svo");
    run_well("$SVOCL parts remove b.svo.parts && test ! -e b.svo.parts");
    run_well("rm a.svo b.svo c.svo indices before");
}

/* A row of the table of exit codes in docs/parts.md: what is done to a folder that is built, what is run then, and what
   comes of it. */
typedef struct exit_row {
    const char *damage;
    const char *command;
    int exit_code;
    const char *words;
} exit_row;

#define RUN_LEASE     "echo m p elsewhere 7 >b.svo.parts/run-7.lease"
#define PLANNER_LEASE "mkdir -p b.svo.parts/planner.lease/7 && echo m p elsewhere 7 >b.svo.parts/planner.lease/7/owner"
#define PLAN          "$SVOCL parts plan scene:statue:2000 -d 5 --need rays --max-memory 1M -o b.svo -q"
#define BUILD         "$SVOCL parts build b.svo.parts"
#define STITCH        "$SVOCL parts stitch b.svo.parts"
#define SHARE         "$SVOCL parts share b.svo.parts --shares 2"
#define HASH          "$SVOCL hash b.svo.parts"
#define NO_DEVICE     "OCL_ICD_VENDORS=/nonexistent "
#define FIRST_PART    "$(ls b.svo.parts/*.part | head -1)"

static const exit_row exit_rows[] = {
    {"true", NO_DEVICE PLAN, 75, "OpenCL"},
    {RUN_LEASE, PLAN, 75, "b.svo.parts: process 7 on elsewhere builds or stitches its parts"},
    {PLANNER_LEASE, PLAN, 75, "b.svo.parts: process 7 on elsewhere plans its parts"},
    {"true", "$SVOCL parts plan nothing.obj -d 4 -o b.svo", 1, "nothing.obj"},
    {"rm -r b.svo.parts && touch b.svo.parts", PLAN, 1, "b.svo.parts"},
    {"true", "$SVOCL parts plan scene:knot -d 9 --max-memory 1K -o b.svo", 2, "--max-memory 1024 is too small"},
    {"rm " FIRST_PART, NO_DEVICE BUILD, 75, "OpenCL"},
    {"true", BUILD " --device none-such", 75, "none-such"},
    {PLANNER_LEASE, BUILD, 75, "b.svo.parts: process 7 on elsewhere plans its parts"},
    {"rm b.svo.parts/*.part && for f in b.svo.parts/*/*.tri; do truncate -s -1 $f; done", BUILD, 1, ".tri"},
    {"rm b.svo.parts/*.part b.svo.parts/*/*.tri", BUILD, 1, "planning the parts again writes it"},
    {"truncate -s -1 b.svo.parts/plan", BUILD, 1, "b.svo.parts/plan"},
    {"rm b.svo.parts/plan", BUILD, 1, "b.svo.parts/plan"},
    {"true", BUILD " --part 1000", 2, "1000"},
    {"rm " FIRST_PART, STITCH, 75, "is missing"},
    {"truncate -s -1 " FIRST_PART, STITCH, 75, ".part"},
    {"cp other.svo.parts/0-0.part " FIRST_PART, STITCH, 75, ".part belongs to plan "},
    {PLANNER_LEASE, STITCH, 75, "b.svo.parts: process 7 on elsewhere plans its parts"},
    {"truncate -s -1 b.svo.parts/*/mesh", STITCH, 1, "/mesh"},
    {"rm " FIRST_PART, HASH, 75, "is missing"},
    {"truncate -s -1 " FIRST_PART, HASH, 75, ".part"},
    {"cp other.svo.parts/0-0.part " FIRST_PART, HASH, 75, ".part belongs to plan "},
    {"truncate -s -1 b.svo.parts/plan", HASH, 1, "b.svo.parts/plan"},
    {"truncate -s -1 b.svo.parts/*/mesh", "$SVOCL convert b.svo.parts c.svo", 1, "/mesh"},
    {"rm " FIRST_PART, SHARE, 75, "is missing"},
    {"true", SHARE " --part 0", 75, "a file of 2 shares has not been begun"},
    {SHARE " && truncate -s -1 " FIRST_PART, SHARE " --part 0 && " SHARE " --part 1", 75, ".part"},
    {PLANNER_LEASE, SHARE, 75, "b.svo.parts: process 7 on elsewhere plans its parts"},
    {SHARE " && " SHARE " --part 1", STITCH " --shares 2", 75, "share 0 of 2 is not written"},
    {"true", SHARE " --part 2", 2, "--part '2' is not a number below 2"},
    {"true", "$SVOCL parts share b.svo.parts", 2, "parts share needs --shares N"},
    {"true", STITCH " --shares 2 --tree-form shared -o b.svc", 2, "--shares does not apply with --tree-form"},
    {"true", STITCH " -o none/b.svo", 1, "none/b.svo"},
    {RUN_LEASE, "$SVOCL parts remove b.svo.parts", 75, "process 7 on elsewhere builds or stitches its parts"},
};

/* What fails for now and what fails for good. */
static void exit_codes_tell_whether_to_try_again(void **state)
{
    (void)state;
    need_builds();
    run_well("$SVOCL parts plan scene:cube -d 4 -o other.svo -q && $SVOCL parts build other.svo.parts");
    run_well(PLAN " && " BUILD " && mv b.svo.parts good");
    for (size_t i = 0; i < sizeof exit_rows / sizeof exit_rows[0]; ++i) {
        char line[512];
        (void)snprintf(line, sizeof line, "rm -rf b.svo.parts && cp -r good b.svo.parts && %s", exit_rows[i].damage);
        run_well(line);
        run_badly(exit_rows[i].command, exit_rows[i].exit_code, exit_rows[i].words);
    }
    run_well("rm -rf good b.svo.parts other.svo.parts");
}

/* Without space every step says so, and succeeds when there is some: a small tmpfs, where one can be mounted. */
static void full_disks_are_tried_again(void **state)
{
    (void)state;
    need_builds();
    run("unshare -m true 2>/dev/null && mkdir disk && unshare -m mount -t tmpfs tmpfs disk 2>/dev/null");
    if (last.exit_code != 0) {
        run_well("rm -rf disk");
        print_message("no tmpfs can be mounted here\n");
        skip();
    }
    run_well(
        "unshare -m sh -c 'mount -t tmpfs -o size=8m tmpfs disk && fill() { cat /dev/zero >disk/full 2>/dev/null; };"
        " plan=\"$SVOCL parts plan scene:statue:2000 -d 6 --max-memory 1M -q -o disk/b.svo\";"
        " fill; $plan 2>>words; test $? = 75 && rm disk/full && $plan || exit 1;"
        " build=\"$SVOCL parts build disk/b.svo.parts\";"
        " fill; $build 2>>words; test $? = 75 && rm disk/full && $build || exit 2;"
        " stitch=\"$SVOCL parts stitch disk/b.svo.parts\";"
        " fill; $stitch 2>>words; test $? = 75 && rm disk/full && $stitch || exit 3;"
        " test $(grep -c \"No space left\" words) = 3'");
    run_well("rm -r disk words");
}

/* A process that is stopped while the folder is planned anew: its lease is in the way until it is stale. What it makes
   then is refused by name, and the file is that of the new plan. */
static void a_stopped_process_changes_no_other_plan(void **state)
{
    (void)state;
    build_whole();
    run_well("$SVOCL parts plan scene:statue:20000:2 -d 7 --max-memory 2M -o b.svo -q");
    run_well(
        "$SVOCL parts build b.svo.parts 2>words & pid=$!;"
        " while test $(ls b.svo.parts/*.part 2>/dev/null | wc -l) -lt 2; do :; done; kill -STOP $pid; echo $pid >pid");
    run_badly("$SVOCL parts plan " SCENE " --max-memory 6M -o b.svo -q", 75, "builds or stitches its parts");
    run_well("touch -d '10 minutes ago' b.svo.parts/*.lease && $SVOCL parts plan " SCENE " --max-memory 6M -o b.svo");
    assert_non_null(strstr(last.errors, "is stale, and is broken"));
    run_well("kill -CONT $(cat pid); while kill -0 $(cat pid) 2>/dev/null && ! grep -q Z /proc/$(cat pid)/stat; do"
             " sleep 0.02; done; grep -q 'planned anew meanwhile: this run belongs to plan' words");
    run_badly("$SVOCL parts stitch b.svo.parts", 75, "b.svo.parts");
    run_well("$SVOCL parts build b.svo.parts && $SVOCL parts stitch b.svo.parts && cmp a.svo b.svo");
    run_well("rm -r a.svo b.svo b.svo.parts words pid");
}

/* Triangles of another folder are refused, and so are parts. */
static void files_of_two_plans_do_not_mix(void **state)
{
    (void)state;
    build_whole();
    run_well("$SVOCL parts plan " SCENE " --max-memory 6M -o b.svo -q"
             " && $SVOCL parts plan scene:statue:20000:2 -d 7 --need color,normal,rays,material,fill,projected-area"
             " --max-memory 6M -o c.svo -q");
    run_well("for f in $(cd c.svo.parts/*/ && ls *.tri); do test ! -e b.svo.parts/*/$f || cp c.svo.parts/*/$f"
             " b.svo.parts/*/; done");
    run_badly("$SVOCL parts build b.svo.parts", 1, ".tri belongs to plan ");
    run_well("$SVOCL parts plan " SCENE " --max-memory 6M -o b.svo -q && $SVOCL parts build b.svo.parts"
             " && $SVOCL parts build c.svo.parts && cp c.svo.parts/*.part b.svo.parts/");
    run_badly("$SVOCL parts stitch b.svo.parts", 75, ".part belongs to plan ");
    run_well("$SVOCL parts build b.svo.parts && $SVOCL parts stitch b.svo.parts && cmp a.svo b.svo");
    run_well("rm -r a.svo b.svo b.svo.parts c.svo.parts");
}

/* Whatever write fails, the old file stays, and the next run goes on. */
static void failed_writes_leave_the_old_file(void **state)
{
    (void)state;
    static const char *const limits[] = {"0", "8", "64", "512", "1500"}; /* of 512 or 1024 bytes */
    build_whole();
    for (size_t i = 0; i < sizeof limits / sizeof limits[0]; ++i) {
        char line[512];
        run_well("echo old >b.svo");
        (void)snprintf(line, sizeof line,
                       "(ulimit -f %s; $SVOCL build " SCENE " --max-memory 6M --resume -q -o b.svo; echo $?) 2>&1"
                       " | tail -1 | grep -q 1 && test $(cat b.svo) = old",
                       limits[i]);
        run_well(line);
    }
    run_well("$SVOCL build " SCENE " --max-memory 6M --resume -q -o b.svo && cmp a.svo b.svo");
    run_well("rm a.svo b.svo");
}

/* A full disk: a small tmpfs, where one can be mounted. */
static void full_disks_leave_the_old_file(void **state)
{
    (void)state;
    build_whole();
    run_well("mkdir disk; unshare -m true 2>/dev/null && unshare -m mount -t tmpfs tmpfs disk 2>/dev/null && touch can"
             "; true");
    run("test -e can");
    if (last.exit_code != 0) {
        run_well("rm -r a.svo disk");
        print_message("no tmpfs can be mounted here\n");
        skip();
    }
    run_well("for size in 64k 1m 3m 4m 5m; do unshare -m sh -c \"mount -t tmpfs -o size=$size tmpfs disk &&"
             " echo old >disk/b.svo && ! $SVOCL build " SCENE " --max-memory 6M -q -o disk/b.svo 2>/dev/null &&"
             " grep -q old disk/b.svo\" || exit 1; done");
    run_well("rm -r a.svo disk can");
}

/* Ended at any time, a run leaves what the next one goes on from. */
static void ended_runs_are_resumed(void **state)
{
    (void)state;
    build_whole();
    for (unsigned tenths = 1; tenths <= 4; ++tenths) {
        char line[512];
        (void)snprintf(line, sizeof line,
                       "echo old >b.svo; timeout -s KILL 0.%u $SVOCL build " SCENE
                       " --max-memory 3M --resume -q -o b.svo; test $(head -c 3 b.svo) = old || cmp a.svo b.svo",
                       2 * tenths);
        run_well(line);
    }
    run_well("$SVOCL build " SCENE " --max-memory 3M --resume -q -o b.svo && cmp a.svo b.svo");
    run_well("rm a.svo b.svo");
}

/* Names of files that killed processes were writing, on file systems without O_TMPFILE, go with the folder. */
static void what_killed_processes_left_is_removed(void **state)
{
    (void)state;
    build_whole();
    run_well("$SVOCL parts plan " SCENE " --max-memory 6M -o b.svo -q && touch b.svo.parts/.svocl-1234-0.tmp");
    run_well("$SVOCL build " SCENE " --max-memory 6M --resume -q -o b.svo && cmp a.svo b.svo && test ! -e b.svo.parts");
    run_well("$SVOCL parts plan " SCENE " --max-memory 6M -o b.svo -q && touch b.svo.parts/.svocl-mine");
    run_well("$SVOCL parts remove b.svo.parts && test $(ls -A b.svo.parts) = .svocl-mine");
    run_well("rm -r a.svo b.svo b.svo.parts");
}

/* A folder of another input or of another plan is not mixed in. */
static void parts_of_other_trees_are_replaced(void **state)
{
    (void)state;
    build_whole();
    run_well("$SVOCL parts plan scene:statue:20000:2 -d 7 --max-memory 6M -o b.svo -q"
             " && $SVOCL parts build b.svo.parts");
    run_badly("$SVOCL build " SCENE " --max-memory 6M -q -o b.svo", 1, "--resume");
    run_well("$SVOCL build " SCENE " --max-memory 6M --resume -q -o b.svo && cmp a.svo b.svo");
    run_well("rm a.svo b.svo");
}

/* A binary STL file of facets along a spiral, each with a normal of its own. */
static void write_facets(const char *name, uint32_t count)
{
    const char header[80] = "facets";
    FILE *file = fopen(name, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(header, 1, sizeof header, file), sizeof header);
    assert_int_equal(fwrite(&count, sizeof count, 1, file), 1);
    for (uint32_t i = 0; i < count; ++i) {
        const uint32_t row = i / 1000;
        const float x = (float)(i % 1000);
        const float y = (float)row;
        const float z = (float)(i % 7919) * 0.05f;
        const float facet[12] = {x, y, 1, x, y, z, x + 1, y, z, x, y + 1, z};
        const uint16_t attribute = 0;
        assert_int_equal(fwrite(facet, sizeof facet, 1, file), 1);
        assert_int_equal(fwrite(&attribute, sizeof attribute, 1, file), 1);
    }
    assert_int_equal(fclose(file), 0);
}

/* A mesh in blocks takes no memory of its own: 50 MB of facets are 100 MB in memory and as many in a plan. The first
   builds fill the caches of kernels, since compilers take memory. */
static void mesh_files_are_read_in_blocks(void **state)
{
    (void)state;
    need_builds();
    write_facets("facets.stl", 1000000);
    run_well("$SVOCL build scene:cube -d 4 -o c.svo -q && $SVOCL build facets.stl -d 7 --max-memory 16M -o a.svo -q");
    cJSON *small = run_json("$SVOCL build scene:cube -d 4 -o c.svo --json");
    cJSON *large = run_json("$SVOCL build facets.stl -d 7 --max-memory 16M -o a.svo --json");
    assert_true(cJSON_IsTrue(cJSON_GetObjectItemCaseSensitive(large, "mesh_in_blocks")));
    const double most = number_of(small, "peak_resident_bytes") + 80.0 * 1048576.0;
    if (number_of(large, "peak_resident_bytes") > most) {
        fail_msg("%.0f bytes were resident, above %.0f", number_of(large, "peak_resident_bytes"), most);
    }
    cJSON_Delete(small);
    cJSON_Delete(large);
    run_well("$SVOCL build facets.stl -d 7 -q -o b.svo && cmp a.svo b.svo");
    run_well("$SVOCL build facets.stl -d 7 --need rays --max-memory 64M -o b.svo");
    assert_non_null(strstr(last.output, "rays needs the whole mesh"));
    run_well("truncate -s 49999999 facets.stl");
    run_badly("$SVOCL build facets.stl -d 7 --max-memory 16M -o b.svo", 1, "facets.stl: byte 80");
    run_well("rm -r a.svo b.svo c.svo facets.stl");
}

/* A folder that nobody stitched: what is said, written and drawn of it is that of the stitched tree. */
static void folders_are_trees(void **state)
{
    (void)state;
    build_whole();
    run_well("$SVOCL parts plan " SCENE " --max-memory 6M -o b.svo -q && $SVOCL parts build b.svo.parts");
    run_well("test $($SVOCL hash a.svo) = $($SVOCL hash b.svo.parts) &&"
             " test $($SVOCL hash a.svo --nodes) = $($SVOCL hash b.svo.parts/plan --nodes) &&"
             " test $($SVOCL hash a.svo --levels 5) = $($SVOCL hash b.svo.parts --levels 5)");
    cJSON *whole = run_json("$SVOCL info a.svo --json");
    cJSON *parts = run_json("$SVOCL info b.svo.parts --json");
    assert_true(number_of(parts, "nodes") == number_of(whole, "nodes"));
    assert_true(number_of(parts, "list_entries") == number_of(whole, "list_entries"));
    assert_true(number_of(parts, "parts") > 1);
    assert_string_equal(text_of(parts, "hash"), text_of(whole, "hash"));
    cJSON_Delete(whole);
    cJSON_Delete(parts);
    run_well(
        "$SVOCL parts check b.svo.parts | grep -q whole && $SVOCL parts check b.svo.parts --sample 2 | grep -q ^2");
    run_well("$SVOCL convert b.svo.parts c.svo -q && cmp a.svo c.svo");
    run_well("$SVOCL convert b.svo.parts c.svo --levels 5 -q && $SVOCL convert a.svo d.svo --levels 5 -q &&"
             " cmp c.svo d.svo");
    run_well("part=$(basename " FIRST_PART " .part) && $SVOCL convert b.svo.parts c.svo --region $part -q &&"
             " test $($SVOCL hash c.svo) = $($SVOCL hash b.svo.parts --region $part)");
    run_well("$SVOCL render a.svo --paged 200K -q -o a.png --size 64x48 &&"
             " $SVOCL render b.svo.parts --paged 200K -q -o b.png --size 64x48 && cmp a.png b.png");
    run_well("$SVOCL render b.svo.parts --paged 200K --levels 5 -q -o b.png --size 64x48 &&"
             " $SVOCL render d.svo --paged 200K -q -o a.png --size 64x48 && cmp a.png b.png");
    run_well("$SVOCL trace a.svo --camera auto --size 16x16 -q -o a.csv &&"
             " $SVOCL trace b.svo.parts --camera auto --size 16x16 -q -o b.csv && cmp a.csv b.csv");
    run_badly("$SVOCL hash b.svo.parts --region 2-99", 2, "is not LEVEL-CODE");
    run_badly("$SVOCL hash a.svo --region 1-0", 2, "--region applies to folders of parts");
    run_badly("$SVOCL hash b.svo.parts --levels 8", 1, "last_level 8");
    run_well("rm -r a.svo c.svo d.svo b.svo.parts a.png b.png a.csv b.csv");
}

/* Deeper than a file can be: the parts are those of the mesh, by the exact reference, and of no other. */
static void deep_folders_are_compared(void **state)
{
    (void)state;
    run_well("$SVOCL parts plan scene:statue:2000 -d 20 --need none --origin=-8190,-8190,-8190 --edge 16384"
             " --max-memory 4M -o b.svo -q && $SVOCL parts build b.svo.parts -q");
    cJSON *found = run_json("$SVOCL verify scene:statue:2000 --parts b.svo.parts --sample 20 --json");
    assert_true(number_of(found, "regions") == 20 && number_of(found, "expected_voxels") > 1000);
    assert_true(cJSON_IsTrue(cJSON_GetObjectItemCaseSensitive(found, "exact")));
    cJSON_Delete(found);
    run_badly("$SVOCL verify scene:statue:2500 --parts b.svo.parts --sample 20 -q", 1, "not exact: ");
    run_badly("$SVOCL verify scene:statue:2000 --parts b.svo.parts -d 8", 2, "--depth does not apply with --parts");
    run_badly("$SVOCL verify scene:statue:2000 --sample 20", 2, "--sample requires --parts");
    run_badly("$SVOCL verify scene:statue:2000 --parts none", 1, "none/plan");
    run_badly("$SVOCL parts stitch b.svo.parts", 1, "depth 20 is above the 16 of a .svo file");
    run_badly("$SVOCL hash b.svo.parts --region 3-0", 1, "from level 3 to level 20 are more than 16 levels");
    run_badly("$SVOCL build scene:cube -d 17 --max-memory 1M -o a.svo", 2, "depth 17 is above 16; svocl parts plan");
    run_badly("$SVOCL parts plan scene:cube -d 21 -o a.svo", 2, "depth 21 is above 20");
    run_well("$SVOCL render b.svo.parts --paged 1M -q -o b.png --size 64x48 && rm -r b.png b.svo.parts");
}

/* A mesh without a valid triangle leaves no folder; where one cannot be removed, that is said too. */
static void a_folder_that_stays_is_named(void **state)
{
    (void)state;
    need_builds();
    run_well("(head -c 80 /dev/zero; printf '\\1\\0\\0\\0'; for i in $(seq 12); do printf '\\0\\0\\300\\177'; done;"
             " printf '\\0\\0') >nan.stl");
    run_badly("$SVOCL parts plan nan.stl -d 4 --max-memory 1M -o b.svo", 1, "nan.stl: no valid triangle in it");
    assert_null(strstr(last.errors, "b.svo.parts"));
    run_well("test ! -e b.svo.parts && mkdir -p b.svo.parts/1-0.part"); /* what unlink does not take */
    run_badly("$SVOCL parts plan nan.stl -d 4 --max-memory 1M -o b.svo", 1,
              "all 1 are refused; b.svo.parts: cannot be emptied: Is a directory");
    run_well("rm -r b.svo.parts nan.stl");
}

static void wrong_usage_is_refused(void **state)
{
    (void)state;
    run_badly("$SVOCL build scene:cube --max-memory 1M", 2, "-o FILE");
    run_badly("$SVOCL build scene:cube --max-memory 1X -o a.svo", 2, "512M");
    run_badly("$SVOCL build scene:cube --max-memory 0 -o a.svo", 2, "below 1");
    run_badly("$SVOCL build scene:cube --resume -o a.svo", 2, "--max-memory");
    run_badly("$SVOCL build scene:cube --max-memory 1M --compress -o a.svo", 2, "--compress");
    run_badly("$SVOCL build scene:cube --max-memory 1M --builder gl-compute -o a.svo", 2, "gl-compute");
    run_badly("$SVOCL build scene:cube --max-memory 1M --builder sorted -o a.svo", 2, "sorted");
    run_badly("$SVOCL parts", 2, "ACTION");
    run_badly("$SVOCL parts grow a.svo.parts", 2, "none of plan");
    run_badly("$SVOCL parts status a.svo.parts", 1, "a.svo.parts/plan");
    run_badly("$SVOCL parts plan scene:cube", 2, "-o FILE");
    need_builds();
    run_badly("$SVOCL build scene:knot -d 9 --max-memory 1K -q -o a.svo", 2, "--max-memory 1024 is too small");
    run_well("test ! -e a.svo && test ! -e a.svo.parts");
    run_badly("$SVOCL build scene:knot -d 16 --max-memory 1G -q -o a.svo", 1,
              "nodes are expected at depth 16, above 2^32 - 2");
    run_well("test ! -e a.svo.parts");
}

TEST_GROUP(program_parts)
{
    const struct CMUnitTest tests[] = {
        IN_FOLDER(parts_that_fit_make_the_same_file),
        IN_FOLDER(every_way_makes_the_same_file),
        IN_FOLDER(damaged_parts_are_built_again),
        IN_FOLDER(steps_are_idempotent),
        IN_FOLDER(exit_codes_tell_whether_to_try_again),
        IN_FOLDER(full_disks_are_tried_again),
        IN_FOLDER(a_stopped_process_changes_no_other_plan),
        IN_FOLDER(files_of_two_plans_do_not_mix),
        IN_FOLDER(failed_writes_leave_the_old_file),
        IN_FOLDER(full_disks_leave_the_old_file),
        IN_FOLDER(ended_runs_are_resumed),
        IN_FOLDER(what_killed_processes_left_is_removed),
        IN_FOLDER(parts_of_other_trees_are_replaced),
        IN_FOLDER(mesh_files_are_read_in_blocks),
        IN_FOLDER(folders_are_trees),
        IN_FOLDER(deep_folders_are_compared),
        IN_FOLDER(a_folder_that_stays_is_named),
        IN_FOLDER(wrong_usage_is_refused),
    };
    return cmocka_run_group_tests_name("program_parts", tests, NULL, NULL);
}
