/* SPDX-License-Identifier: MIT */
/*
 * Fuzz target: arbitrary bytes as the file of a light, of the tree of seeds/file/nodes.svo. Either they are refused
 * with a one-line message, or all that a light is made of has the lengths that its record says. OpenCL is not used: the
 * linker puts __wrap_svo_i_light_restore in place of what makes the light.
 */
#include <string.h>

#include "core/device.h"
#include "core/tree.h"
#include "fuzz.h"
#include "light/record.h"
#include "svocl/io.h"

#define NAME "input"

/* NOLINTBEGIN(bugprone-reserved-identifier,readability-identifier-naming): names of ld --wrap */
svo_status __wrap_svo_i_light_restore(svo_tree *tree, const char *function, const svo_i_stored_light *stored,
                                      cl_command_queue queue, svo_light **out);
/* NOLINTEND(bugprone-reserved-identifier,readability-identifier-naming) */

/* Reads every byte, so that a sanitizer finds an array that is too short. */
static uint64_t sum_of(const void *bytes, uint64_t byte_count)
{
    uint64_t sum = 0;
    REQUIRE(bytes != NULL || byte_count == 0);
    for (uint64_t i = 0; i < byte_count; ++i) {
        sum += ((const uint8_t *)bytes)[i];
    }
    return sum;
}

svo_status __wrap_svo_i_light_restore(svo_tree *tree, const char *function, const svo_i_stored_light *stored,
                                      cl_command_queue queue, svo_light **out)
{
    const svo_i_light_record *record = &stored->record;
    uint64_t bytes[SVO_LIGHT_BUFFER_COUNT] = {0};
    uint64_t sum = 0;
    (void)queue;
    (void)out;
    REQUIRE(svo_i_light_count_arrays(tree, record, bytes));
    for (int i = 0; i < SVO_LIGHT_BUFFER_COUNT; ++i) {
        sum += sum_of(stored->arrays[i], bytes[i]);
    }
    sum += sum_of(stored->sources, record->source_count * sizeof *stored->sources);
    sum += sum_of(stored->finishes, record->finish_count * sizeof *stored->finishes);
    sum += sum_of(stored->sky_map, UINT64_C(3) * sizeof(float) * stored->sky_width * stored->sky_height);
    REQUIRE(stored->photons.photon_alpha <= 1);
    REQUIRE(sum != UINT64_MAX);
    return svo_i_device_fail(tree->device, SVO_UNSUPPORTED, "%s: no light is made here", function);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t byte_count)
{
    static const uint8_t nothing;
    static svo_device device;
    static svo_tree *tree;
    svo_message message = {""};
    svo_light *light = NULL;
    if (tree == NULL) {
        REQUIRE(svo_tree_load(svo_from_path(FUZZ_TREE), NULL, &tree, &message) == SVO_OK);
    }
    tree->device = &device;
    const svo_status status = svo_light_load(tree, svo_from_memory(data != NULL ? data : &nothing, byte_count, NAME),
                                             NULL, NULL, &light, &message);
    REQUIRE(status != SVO_OK && light == NULL);
    REQUIRE(status == SVO_FILE_DAMAGED || status == SVO_OUT_OF_HOST_MEMORY || status == SVO_INVALID_ARGUMENT ||
            status == SVO_UNSUPPORTED);
    REQUIRE(message.text[0] != '\0' && strchr(message.text, '\n') == NULL);
    tree->device = NULL;
    return 0;
}
