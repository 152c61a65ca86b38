/* SPDX-License-Identifier: MIT */
/* Compact trees as users reach them: written and read by every command, of meshes, voxels, solids, parts and scenes. */
#include "run_program.h"
#include "support/suite.h"

#include <stdio.h>
#include <string.h>

static const char *const forms[] = {"descriptor", "implied", "shared", "mirrored"};
#define FORMS (sizeof forms / sizeof forms[0])

/* Runs a line with the form in $F. */
static void run_with_form(const char *form, const char *line)
{
    char text[512];
    (void)snprintf(text, sizeof text, "F=%s; %s", form, line);
    run_well(text);
}

static const cJSON *compact_of(const cJSON *document)
{
    const cJSON *compact = cJSON_GetObjectItemCaseSensitive(document, "compact");
    assert_non_null(compact);
    return compact;
}

/* ---- round trips ---- */

static void files_have_the_hash_of_their_tree(void **state)
{
    (void)state;
    need_builds();
    run_well("$SVOCL build scene:knot:500 -d 5 -o a.svo -q");
    for (size_t i = 0; i < FORMS; ++i) {
        run_with_form(forms[i], "$SVOCL build scene:knot:500 -d 5 --tree-form $F -o a.svc -q");
        run_with_form(forms[i], "$SVOCL convert a.svo b.svc --tree-form $F -q && cmp a.svc b.svc");
        run_with_form(forms[i], "$SVOCL build scene:knot:500 -d 5 --tree-form $F -o - -q | cmp - a.svc");
        run_well("test $($SVOCL hash a.svc --path cpu) = $($SVOCL hash a.svo)");
        run_with_form(forms[i], "test $($SVOCL hash a.svc --tree-form $F) = $($SVOCL hash a.svo --tree-form $F)");
        run_with_form(forms[i], "test $($SVOCL hash a.svc --tree-form $F) = "
                                "$($SVOCL hash scene:knot:500 -d 5 --tree-form $F)");
        run_well("test $($SVOCL hash a.svc --tree-form implied --directory-step 16) = "
                 "$($SVOCL hash a.svo --tree-form implied --directory-step 16)");
        run_well("$SVOCL convert a.svc c.svo -q && cmp a.svo c.svo");
        run_well("$SVOCL diff a.svo a.svc");
        cJSON *document = run_json("$SVOCL info a.svc --json");
        assert_string_equal(text_of(compact_of(document), "form"), forms[i]);
        assert_true(number_of(compact_of(document), "leaves") == number_of(document, "leaves"));
        cJSON_Delete(document);
    }
    run_well("$SVOCL convert a.svo c.svo --levels 3 -q && test $($SVOCL hash c.svo) = $($SVOCL hash a.svo --levels 3)");
    run_well("test $($SVOCL hash a.svo --tree-form shared) != $($SVOCL hash a.svo --tree-form implied)");
    run_well("rm a.svo a.svc b.svc c.svo");
}

/* A picture and rays are those of the tree, bit for bit, of a file and of a mesh. */
static void pictures_and_rays_are_those_of_the_tree(void **state)
{
    (void)state;
    need_builds();
    run_well("$SVOCL build scene:statue:500 -d 5 -o a.svo -q && $SVOCL render a.svo --size 40x30 -o a.png -q");
    run_well("$SVOCL render a.svo --size 40x30 --view normal -o n.png -q");
    run_well("$SVOCL trace a.svo --meet voxels --camera auto --size 20x20 -o a.csv");
    assert_non_null(strstr(last.output, " rays hit voxels of a.svo at depth 5"));
    run_well("grep -q '^ray,t,level,face$' a.csv && grep -q 'inf,-1,-1$' a.csv && grep -q ',5,5$' a.csv");
    run_well("awk -F, 'NR > 1 && $2 != \"inf\" && ($3 != 5 || $4 > 5) { exit 1 }' a.csv");
    for (size_t i = 0; i < FORMS; ++i) {
        run_with_form(forms[i], "$SVOCL convert a.svo a.svc --tree-form $F -q");
        run_well("$SVOCL render a.svc --size 40x30 -o b.png -q && cmp a.png b.png");
        run_with_form(forms[i], "$SVOCL render a.svo --size 40x30 --view normal --tree-form $F -o b.png -q");
        run_well("cmp n.png b.png");
        run_with_form(forms[i], "$SVOCL render scene:statue:500 -d 5 --tree-form $F --size 40x30 -o b.png -q");
        run_well("cmp a.png b.png");
        run_well("$SVOCL trace a.svc --camera auto --size 20x20 -o b.csv -q && cmp a.csv b.csv");
        run_with_form(forms[i],
                      "$SVOCL trace scene:statue:500 -d 5 --tree-form $F --camera auto --size 20x20 -o b.csv");
        run_well("cmp a.csv b.csv");
    }
    run_well("rm a.svo a.svc a.png n.png b.png a.csv b.csv");
}

/* What is below merged leaves is there again in each form, and merging saves leaves. */
static void solids_take_every_form(void **state)
{
    (void)state;
    need_builds();
    run_well("$SVOCL build scene:cube -d 4 --solid winding -o a.svc -q");
    run_well("$SVOCL build scene:cube -d 4 --solid winding --tree-form descriptor -o b.svc -q && cmp a.svc b.svc");
    for (size_t i = 0; i < FORMS; ++i) {
        run_with_form(forms[i],
                      "$SVOCL build scene:cube -d 4 --solid winding --tree-form $F --minimize -o b.svc --json");
        run_well("test $($SVOCL hash b.svc --nodes) = $($SVOCL hash a.svc --nodes)");
        cJSON *document = run_json("$SVOCL info b.svc --json");
        assert_int_equal((int)number_of(document, "leaves"), 16 * 16 * 16);
        assert_true(number_of(compact_of(document), "leaves") < 16 * 16 * 16);
        assert_true(cJSON_IsTrue(cJSON_GetObjectItem(compact_of(document), "minimized")));
        cJSON_Delete(document);
        run_with_form(forms[i], "$SVOCL convert scene:cube -d 4 --solid winding --tree-form $F --minimize c.svc -q");
        run_well("cmp b.svc c.svc");
    }
    /* What is expanded is merged again where that is asked for, though the file has the form. */
    run_well("$SVOCL convert a.svc b.svc --tree-form implied -q && $SVOCL info b.svc --json | grep -q ':.*false'");
    run_well(
        "$SVOCL convert b.svc c.svc --tree-form implied --minimize -q && test $(wc -c <c.svc) -lt $(wc -c <b.svc)");
    cJSON *document = run_json("$SVOCL convert scene:cube c.vox -d 4 --solid winding --json");
    assert_int_equal((int)number_of(document, "leaves"), 16 * 16 * 16);
    assert_int_equal((int)number_of(cJSON_GetObjectItem(document, "solid"), "inside_voxels"), 14 * 14 * 14);
    cJSON_Delete(document);
    run_well("rm a.svc b.svc c.svc c.vox");
}

/* A mesh is one step from a voxel file, and a voxel file from a compact tree. */
static void meshes_and_voxels_are_converted_in_one_step(void **state)
{
    (void)state;
    need_builds();
    run_well("$SVOCL build scene:knot:500 -d 4 -o a.svo -q && $SVOCL convert a.svo a.vox -q");
    run_well("$SVOCL scene knot:500 -o m.ply -q && $SVOCL build m.ply -d 4 -o m.svo -q");
    run_well("$SVOCL convert scene:knot:500 b.vox -d 4 -q && cmp a.vox b.vox");
    run_well("$SVOCL convert m.ply b.vox -d 4 -q && $SVOCL convert m.svo a.vox -q && cmp a.vox b.vox");
    run_well("$SVOCL convert - b.vox -d 4 -q <m.ply && cmp a.vox b.vox");
    run_well("$SVOCL convert m.ply b.svo -d 4 -q && cmp m.svo b.svo");
    run_well("$SVOCL convert a.vox v.svc --tree-form shared -q && test $($SVOCL hash v.svc) = $($SVOCL hash a.vox)");
    run_well("$SVOCL build a.vox --tree-form shared -o w.svc -q && cmp v.svc w.svc");
    run_well("$SVOCL convert v.svc w.binvox -q && $SVOCL convert a.vox v.binvox -q && cmp v.binvox w.binvox");
    /* A scene of the models, which is drawn. */
    cJSON *document = run_json("$SVOCL convert a.vox world.json --json");
    const cJSON *written = cJSON_GetObjectItemCaseSensitive(document, "written");
    assert_int_equal((int)number_of(written, "models"), 1);
    assert_int_equal((int)number_of(written, "instances"), 1);
    cJSON_Delete(document);
    run_well("$SVOCL render world.json -o world.png --size 16x16 -q && rm -r world.png world.json world_models");
    run_badly("$SVOCL convert m.ply world.json", 2, "which is made of a .vox file alone");
    run_badly("$SVOCL convert a.vox world.json --axes keep", 2, "--axes does not apply");
    run_well("rm a.svo a.vox m.ply m.svo b.vox b.svo v.svc w.svc v.binvox w.binvox");
}

static void pages_take_the_form_they_hold(void **state)
{
    (void)state;
    need_builds();
    run_well("$SVOCL build scene:cube -d 4 --tree-form implied --directory-step 16 -o a.svc -q");
    run_well("$SVOCL build scene:cube -d 4 -o a.svo -q && $SVOCL export-web a.svo -o a.html -q");
    run_well("sed s/a.svo/a.svc/g a.html >b.html; $SVOCL export-web a.svc -o a.html -q && cmp a.html b.html");
    run_well("$SVOCL convert a.svo a.svc --tree-form shared -q && $SVOCL export-web a.svc -o a.html -q && cmp a.html "
             "b.html");
    run_well("$SVOCL export-web a.svo --tree-form implied --directory-step 16 -o a.html -q");
    run_badly("$SVOCL export-web a.svo --tree-form shared -o a.html", 2,
              "--tree-form shared: pages hold trees in form");
    run_badly("$SVOCL export-web a.svo --tree-form implied --directory-step 64 -o a.html", 2,
              "--directory-step 64: that of pages is 16");
    run_well("rm a.svc a.svo a.html b.html");
}

static void parts_are_stitched_to_a_form(void **state)
{
    (void)state;
    need_builds();
    run_well("$SVOCL scene knot:4000 -o m.ply -q && $SVOCL build m.ply -d 6 --tree-form shared -o a.svc -q");
    run_well("$SVOCL parts plan m.ply -d 6 --max-memory 2M -o b.svo -q && $SVOCL parts build b.svo.parts -q");
    run_well(
        "mkdir tmp && TMPDIR=tmp $SVOCL parts stitch b.svo.parts --tree-form shared -o b.svc -q && cmp a.svc b.svc");
    run_well("rmdir tmp && test ! -e b.svo");
    run_badly("$SVOCL parts stitch b.svo.parts --tree-form shared", 2, "output b.svo does not end in .svc");
    run_badly("$SVOCL parts stitch b.svo.parts --device 0", 2, "--device does not apply to parts stitch without");
    run_badly("$SVOCL parts plan m.ply --tree-form shared -o c.svc", 2, "--tree-form does not apply to parts plan");
    run_well("mv b.svo.parts b.svc.parts");
    run_badly("$SVOCL parts stitch b.svc.parts", 2, "output b.svc is a compact tree, which needs --tree-form");
    run_well("$SVOCL parts remove b.svc.parts && cmp a.svc b.svc");
    run_well("$SVOCL build m.ply -d 6 --max-memory 2M --tree-form shared -o b.svc -q && cmp a.svc b.svc");
    run_well("rm m.ply a.svc b.svc");
}

#define PLACED "\"instances\": [{\"tree\": \"a\"}, {\"tree\": \"b\", \"translate\": [9, 0, 0]}]"

/* Exactly packed payload gives the same tree and the same pictures, by itself and in a scene; another way to pack it
   begins with what was kept. */
static void payload_is_packed(void **state)
{
    (void)state;
    need_builds();
    run_well("$SVOCL build scene:knot:2000 -d 6 --tree-form shared -o a.svc -q");
    run_well("$SVOCL convert a.svc b.svc --tree-form shared --color-error 0 -q");
    run_well("test \"$($SVOCL hash a.svc -q)\" = \"$($SVOCL hash b.svc -q)\"");
    run_well("test $(wc -c < b.svc) -lt $(wc -c < a.svc)");
    run_well("$SVOCL info b.svc > out.txt && grep -q 'error at most 0, 0 in the mean' out.txt");
    run_well("$SVOCL render a.svc --size 32x24 -o a.png -q && $SVOCL render b.svc --size 32x24 -o b.png -q");
    run_well("cmp a.png b.png");
    write_text("s.json",
               "{\"form\": \"shared\", \"trees\": {\"a\": {\"path\": \"a.svc\"}, \"b\": {\"path\": \"a.svc\"}}, " PLACED
               "}");
    write_text("p.json",
               "{\"form\": \"shared\", \"trees\": {\"a\": {\"path\": \"b.svc\"}, \"b\": {\"path\": \"a.svc\"}}, " PLACED
               "}");
    cJSON *plain = run_json("$SVOCL render s.json --size 32x24 -o a.png --json");
    cJSON *packed = run_json("$SVOCL render p.json --size 32x24 -o b.png --json");
    assert_true(number_of(packed, "device_bytes") < number_of(plain, "device_bytes"));
    cJSON_Delete(plain);
    cJSON_Delete(packed);
    run_well("cmp a.png b.png && rm s.json p.json");
    run_well("$SVOCL convert b.svc c.svc --tree-form shared --color-error 9 --normal-bits 5 -q");
    run_well("test $(wc -c < c.svc) -lt $(wc -c < b.svc)");
    run_badly("$SVOCL build scene:cube -d 3 --color-error 3", 2, "--color-error requires --tree-form");
    run_badly("$SVOCL build scene:cube -d 3 --normal-bits 6", 2, "--normal-bits requires --tree-form");
    run_badly("$SVOCL export-web b.svc --tree-form implied --color-error 3 -o p.html", 2,
              "pages hold payload unpacked");
    run_well("$SVOCL export-web b.svc -o p.html -q && rm a.svc b.svc c.svc a.png b.png out.txt p.html");
}

/* ---- scenes ---- */

static void scenes_take_voxels_and_forms(void **state)
{
    (void)state;
    need_builds();
    run_well("$SVOCL convert scene:statue:500 a.vox -d 3 -q && $SVOCL convert a.vox b.svx -q");
    run_well("$SVOCL build a.vox -o a.svo -q && $SVOCL build b.svx -o b.svo -q");
    run_well("$SVOCL convert b.svo b.svc --tree-form shared -q");
    write_text("t.json", "{\"trees\": {\"a\": {\"path\": \"a.svo\"}, \"b\": {\"path\": \"b.svo\"}}, " PLACED "}");
    run_well(
        "$SVOCL render t.json --size 40x30 -o t.png -q && $SVOCL render t.json --view ao -d 5 --size 20x20 -o o.png");
    write_text("v.json", "{\"trees\": {\"a\": {\"path\": \"a.vox\"}, \"b\": {\"path\": \"b.svx\"}}, " PLACED "}");
    run_well("$SVOCL render v.json --size 40x30 -o v.png -q && cmp t.png v.png");
    run_well("$SVOCL render v.json --view ao -d 5 --size 20x20 -o v.png -q && cmp o.png v.png");
    for (size_t i = 0; i < FORMS; ++i) {
        char text[512];
        run_with_form(forms[i], "$SVOCL render v.json --tree-form $F --size 40x30 -o v.png -q && cmp t.png v.png");
        (void)snprintf(text, sizeof text,
                       "{\"trees\": {\"a\": {\"path\": \"a.vox\", \"form\": \"%s\"}, "
                       "\"b\": {\"path\": \"b.svc\", \"form\": \"%s\"}}, " PLACED "}",
                       forms[i], forms[i]);
        write_text("f.json", text);
        cJSON *document = run_json("$SVOCL render f.json --size 40x30 -o v.png --json && cmp t.png v.png");
        assert_string_equal(text_of(document, "form"), forms[i]);
        cJSON_Delete(document);
    }
    write_text("f.json", "{\"form\": \"implied\", \"trees\": {\"a\": {\"path\": \"a.vox\"},\n"
                         "\"b\": {\"path\": \"b.svc\", \"form\": \"shared\"}}, " PLACED "}");
    run_badly("$SVOCL render f.json -o v.png", 1,
              "f.json:2: tree 'b' has form 'shared', and 'a' has 'implied'; the trees of a scene have one form");
    cJSON *document =
        run_json("$SVOCL render f.json --tree-form descriptor --size 40x30 -o v.png --json && cmp t.png v.png");
    assert_string_equal(text_of(document, "form"), "descriptor");
    cJSON_Delete(document);
    write_text("f.json", "{\"trees\": {\"a\": {\"path\": \"a.vox\",\n\"form\": \"share\"}}, " PLACED "}");
    run_badly("$SVOCL render f.json -o v.png", 1,
              "f.json:2: 'form' is none of built, descriptor, implied, shared, mirrored");
    run_well("rm a.vox b.svx a.svo b.svo b.svc t.json v.json f.json t.png o.png v.png");
}

/* ---- what does not apply ---- */

static void what_no_form_has_is_refused_before_any_work(void **state)
{
    (void)state;
    static const char *const lines[][2] = {
        {"build none.obj --minimize", "--minimize requires --tree-form"},
        {"build none.obj --directory-step 16", "--directory-step requires --tree-form"},
        {"build none.obj --tree-form shared --directory-step 16", "--directory-step requires --tree-form implied"},
        {"build none.obj --tree-form share", "did you mean 'shared'?"},
        {"build none.obj --tree-form shared --plan-only", "--tree-form does not apply with --plan-only"},
        {"render none.obj --tree-form shared --view full -o a.png", "--tree-form does not apply to views of light"},
        {"render none.obj --tree-form shared --view triangles -o a.png", "--tree-form does not apply to --view triang"},
        {"render none.svc --view triangles -o a.png", "none.svc is a compact tree, which has no triangles"},
        {"render none.obj --tree-form shared --through probes -o a.png", "--tree-form does not apply with --through"},
        {"render none.svo --tree-form shared --paged 1M -o a.png", "--tree-form does not apply with --paged"},
        {"render none.json --tree-form shared --animate -o a.png", "--tree-form does not apply with --animate"},
        {"trace none.svc --meet triangles --camera auto -o a.csv", "--meet triangles: compact trees have none"},
        {"trace none.obj --tree-form shared --meet triangles --camera auto -o a.csv", "compact trees have none"},
        {"hash none.svo --tree-form shared --nodes", "--nodes does not apply with --tree-form"},
        {"hash none.svo --tree-form shared --light faces", "--tree-form does not apply with --light"},
        {"convert none.svo a.svo --axes z-up", "--axes does not apply from a tree to a tree"},
        {"convert none.svo -", "output - has no suffix that tells the format"},
        {"export-web none.svo --tree-form descriptor -o a.html", "pages hold trees in form implied alone"},
        {"build none.svo --tree-form shared -o a.svc", "none.svo is a finished tree, a mesh or voxels are needed here"},
        {"verify none.svc", "none.svc is a compact tree, which has no leaf lists to compare"},
        {"gather none.svo --points 3 --tree-form shared -o a.csv", "--tree-form does not apply"},
    };
    for (size_t i = 0; i < sizeof lines / sizeof lines[0]; ++i) {
        char line[160];
        (void)snprintf(line, sizeof line, "$SVOCL %s", lines[i][0]);
        run_badly(line, 2, lines[i][1]);
    }
    expect_files(NULL, 0);
}

TEST_GROUP(program_forms)
{
    const struct CMUnitTest tests[] = {
        IN_FOLDER(files_have_the_hash_of_their_tree),
        IN_FOLDER(pictures_and_rays_are_those_of_the_tree),
        IN_FOLDER(solids_take_every_form),
        IN_FOLDER(meshes_and_voxels_are_converted_in_one_step),
        IN_FOLDER(pages_take_the_form_they_hold),
        IN_FOLDER(parts_are_stitched_to_a_form),
        IN_FOLDER(payload_is_packed),
        IN_FOLDER(scenes_take_voxels_and_forms),
        IN_FOLDER(what_no_form_has_is_refused_before_any_work),
    };
    return cmocka_run_group_tests_name("program_forms", tests, NULL, NULL);
}
