/* SPDX-License-Identifier: MIT */
/* Writes the seeds of fuzz_light: lights of a tree in each form. make_light_seeds TREE FOLDER */
#include "fuzz.h"
#include "svocl/io.h"
#include "svocl/svocl.h"

static int save(svo_tree *tree, svo_light_form form, const char *path)
{
    static const float sky[6] = {1, 2, 3, 0, 0.5F, 0};
    const svo_light_options options = {.struct_size = sizeof options, .form = form};
    const svo_light_source lamp = {.kind = SVO_SOURCE_POINT, .position = {0.5F, 0.5F, 0.5F}, .value = {1, 2, 3}};
    const svo_finish finish = {.emission = {1, 1, 1}};
    const svo_light_setup setup = {.struct_size = sizeof setup,
                                   .sources = &lamp,
                                   .source_count = 1,
                                   .finishes = &finish,
                                   .finish_count = 1,
                                   .view_resolution = 16,
                                   .bounces = form == 0 ? 0 : 2,
                                   .sky_map = form == 0 ? NULL : sky,
                                   .sky_width = form == 0 ? 0 : 2,
                                   .sky_height = form == 0 ? 0 : 1};
    svo_light *light = NULL;
    svo_message message = {""};
    if (svo_light_create(tree, &options, NULL, &light) != SVO_OK ||
        svo_light_set_sources(light, &setup, NULL) != SVO_OK ||
        svo_light_save(light, svo_to_path(path), NULL, NULL, &message) != SVO_OK) {
        (void)fprintf(stderr, "%s: no light: %s\n", path, message.text);
        return 1;
    }
    svo_light_destroy(&light);
    return 0;
}

int main(int argc, char **argv)
{
    int failed = 0;
    svo_tree *tree = NULL;
    svo_device *device = NULL;
    svo_message message = {""};
    REQUIRE(argc == 3);
    REQUIRE(svo_device_create_default(NULL, &device, &message) == SVO_OK);
    REQUIRE(svo_tree_load(svo_from_path(argv[1]), NULL, &tree, &message) == SVO_OK);
    REQUIRE(svo_tree_upload(tree, device, NULL) == SVO_OK);
    for (uint32_t form = 0; form < SVO_LIGHT_FORM_COUNT; ++form) {
        char path[512];
        (void)snprintf(path, sizeof path, "%s/%s.svl", argv[2], svo_name(SVO_NAME_LIGHT_FORM, form));
        failed += save(tree, (svo_light_form)form, path);
    }
    svo_tree_destroy(&tree);
    svo_device_destroy(&device);
    return failed;
}
