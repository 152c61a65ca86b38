/* SPDX-License-Identifier: MIT */
/*
 * OBJ (Wavefront, "Appendix B1. Object Files", 1995) in the import child: the polygonal statements, as tables. Colors
 * may follow positions, as many programs write them. Free-form curves and surfaces are left out with a warning.
 */
#define _POSIX_C_SOURCE 200809L
#include <errno.h>
#include <inttypes.h>
#include <math.h>
#include <stdio.h>

#include "core/message.h"
#include "io/import_formats.h"
#include "io/import_obj_mesh.h"
#include "io/import_reader.h"

#define VERTEX_NUMBERS_MAX 7

typedef struct obj_reader {
    mesh_reader *reader;
    text_cursor cursor;
    number_reader numbers;
    obj_file file;
    uint32_t material; /* of the faces that follow */
    bool begins_run; /* at the next face */
    int64_t position_end; /* one more than the highest position that a face names, and where */
    uint64_t position_end_line;
    uint64_t line_count, point_count, small_count; /* "l" and "p" statements; faces of one or two corners */
    uint64_t unknown_count, first_unknown_line; /* statements that are not read */
    text_word first_unknown;
} obj_reader;

/* Vertices */

static svo_status wrong_count(const obj_reader *obj, const char *what, int count, const char *expected)
{
    return svo_i_fail(obj->reader->message, SVO_IMPORT_FAILED, "line %" PRIu64 ": '%s' with %d numbers; %s are needed",
                      obj->cursor.line, what, count, expected);
}

/* The numbers up to the end of the line or a comment. */
static svo_status read_numbers(obj_reader *obj, float *values, int count_max, int *count)
{
    for (*count = 0; text_skip_blanks(&obj->cursor) && *obj->cursor.at != '#'; ++*count) {
        float ignored;
        SVO_I_TRY(svo_i_read_float(&obj->numbers, &obj->cursor, *count < count_max ? &values[*count] : &ignored));
    }
    return SVO_OK;
}

/* Positions before the first colored one are white. */
static svo_status add_color(obj_reader *obj, const float *channels, int channel_count)
{
    obj_file *file = &obj->file;
    while (file->colors.count < file->positions.count) {
        uint8_t *rgba = list_add(&file->colors, 4);
        if (rgba == NULL) {
            return svo_i_read_out_of_memory(obj->reader);
        }
        memset(rgba, 255, 4);
        const bool is_last = file->colors.count == file->positions.count;
        for (int i = 0; is_last && i < channel_count; ++i) {
            rgba[i] = svo_i_import_color_byte(channels[i]);
        }
    }
    return SVO_OK;
}

/* "v x y z", "v x y z w", "v x y z r g b" or "v x y z r g b a". */
static svo_status read_position(obj_reader *obj)
{
    float values[VERTEX_NUMBERS_MAX];
    int count = 0;
    SVO_I_TRY(read_numbers(obj, values, VERTEX_NUMBERS_MAX, &count));
    if (count < 3 || count == 5 || count > VERTEX_NUMBERS_MAX) {
        return wrong_count(obj, "v", count, "3, 4, 6 or 7");
    }
    if (count == 4) {
        if (values[3] == 0) {
            return svo_i_fail(obj->reader->message, SVO_IMPORT_FAILED, "line %" PRIu64 ": the weight w is 0",
                              obj->cursor.line);
        }
        for (int axis = 0; axis < 3; ++axis) {
            values[axis] /= values[3];
        }
    }
    float *position = list_add(&obj->file.positions, 3 * sizeof *position);
    if (position == NULL || obj->file.positions.count >= GATHER_NO_VERTEX) {
        return svo_i_read_out_of_memory(obj->reader);
    }
    memcpy(position, values, 3 * sizeof *position);
    return count > 4 || obj->file.colors.count > 0 ? add_color(obj, values + 3, count > 4 ? count - 3 : 0) : SVO_OK;
}

static svo_status read_normal(obj_reader *obj)
{
    float values[3];
    int count = 0;
    SVO_I_TRY(read_numbers(obj, values, 3, &count));
    if (count != 3) {
        return wrong_count(obj, "vn", count, "3");
    }
    float *normal = list_add(&obj->file.normals, sizeof values);
    if (normal == NULL || obj->file.normals.count >= OBJ_NONE) {
        return svo_i_read_out_of_memory(obj->reader);
    }
    memcpy(normal, values, sizeof values);
    return SVO_OK;
}

/* "vt u [v [w]]"; what is not finite becomes 0. */
static svo_status read_uv(obj_reader *obj)
{
    float values[3] = {0, 0, 0};
    int count = 0;
    SVO_I_TRY(read_numbers(obj, values, 3, &count));
    if (count < 1 || count > 3) {
        return wrong_count(obj, "vt", count, "1 to 3");
    }
    float *uv = list_add(&obj->file.uvs, 2 * sizeof *uv);
    if (uv == NULL || obj->file.uvs.count >= OBJ_NONE) {
        return svo_i_read_out_of_memory(obj->reader);
    }
    uv[0] = isfinite(values[0]) ? values[0] : 0;
    uv[1] = isfinite(values[1]) ? values[1] : 0;
    return SVO_OK;
}

/* Faces */

static svo_status bad_index(const obj_reader *obj, const text_cursor *word, const char *what, size_t count)
{
    if (count == 0) {
        return svo_i_fail(obj->reader->message, SVO_IMPORT_FAILED, "line %" PRIu64 ": '%s' is no %s; there is none yet",
                          word->line, text_copy_word(word).text, what);
    }
    return svo_i_fail(obj->reader->message, SVO_IMPORT_FAILED,
                      "line %" PRIu64 ": '%s' is no %s; 1 .. %zu and -1 .. -%zu are", word->line,
                      text_copy_word(word).text, what, count, count);
}

/* One index of a corner, as its position in the table. It may be beyond the table's present end. */
static svo_status read_index(obj_reader *obj, const text_cursor *word, const char *what, size_t count, uint32_t *index)
{
    int64_t value = 0;
    if (!text_take_integer(&obj->cursor, &value) || value == 0 || value > (int64_t)OBJ_NONE - 1 ||
        value < -(int64_t)count) {
        return bad_index(obj, word, what, count);
    }
    *index = (uint32_t)(value > 0 ? value - 1 : value + (int64_t)count);
    return SVO_OK;
}

static bool at_slash(const text_cursor *cursor)
{
    return cursor->at != cursor->end && *cursor->at == '/';
}

/* "v", "v/vt", "v//vn" or "v/vt/vn". */
static svo_status read_corner(obj_reader *obj, obj_corner *corner)
{
    text_cursor *cursor = &obj->cursor;
    const text_cursor word = *cursor;
    *corner = (obj_corner){.uv = OBJ_NONE, .normal = OBJ_NONE};
    SVO_I_TRY(read_index(obj, &word, "position", obj->file.positions.count, &corner->position));
    if (at_slash(cursor)) {
        ++cursor->at;
        if (!at_slash(cursor) && !text_at_word_end(cursor)) {
            SVO_I_TRY(read_index(obj, &word, "texture coordinate", obj->file.uvs.count, &corner->uv));
        }
        if (at_slash(cursor)) {
            ++cursor->at;
            if (!text_at_word_end(cursor)) {
                SVO_I_TRY(read_index(obj, &word, "normal", obj->file.normals.count, &corner->normal));
            }
        }
    }
    if (!text_at_word_end(cursor)) {
        return svo_i_fail(obj->reader->message, SVO_IMPORT_FAILED,
                          "line %" PRIu64 ": '%s' is none of v, v/vt, v//vn and v/vt/vn", word.line,
                          text_copy_word(&word).text);
    }
    if ((int64_t)corner->position >= obj->position_end) {
        obj->position_end = (int64_t)corner->position + 1;
        obj->position_end_line = word.line;
    }
    return SVO_OK;
}

/* The run that a face belongs to, begun if it is the first. */
static obj_run *current_run(obj_reader *obj)
{
    if (obj->begins_run) {
        obj_run *run = list_add(&obj->file.runs, sizeof *run);
        if (run == NULL) {
            return NULL;
        }
        *run = (obj_run){.material = obj->material};
        obj->begins_run = false;
    }
    return (obj_run *)obj->file.runs.items + (obj->file.runs.count - 1);
}

static svo_status add_face(obj_reader *obj, size_t corner_begin)
{
    obj_file *file = &obj->file;
    const size_t corner_count = file->corners.count - corner_begin;
    if (corner_count < 3) {
        file->corners.count = corner_begin;
        ++obj->small_count;
        return SVO_OK;
    }
    obj_run *run = current_run(obj);
    uint32_t *face = list_add(&file->faces, sizeof *face);
    if (run == NULL || face == NULL || corner_count > UINT32_MAX / 4) {
        return svo_i_read_out_of_memory(obj->reader);
    }
    *face = (uint32_t)corner_count;
    ++run->face_count;
    const obj_corner *corners = (const obj_corner *)file->corners.items + corner_begin;
    for (size_t i = 0; i < corner_count && !run->has_uvs; ++i) {
        run->has_uvs = corners[i].uv != OBJ_NONE;
    }
    return SVO_OK;
}

static svo_status read_face(obj_reader *obj)
{
    const size_t corner_begin = obj->file.corners.count;
    while (text_skip_blanks(&obj->cursor) && *obj->cursor.at != '#') {
        obj_corner *corner = list_add(&obj->file.corners, sizeof *corner);
        if (corner == NULL) {
            return svo_i_read_out_of_memory(obj->reader);
        }
        SVO_I_TRY(read_corner(obj, corner));
    }
    return add_face(obj, corner_begin);
}

/* Materials */

static svo_status read_material_name(obj_reader *obj)
{
    size_t length = 0;
    const uint64_t line = obj->cursor.line;
    const char *name = text_rest_of_line(&obj->cursor, &length);
    if (length == 0) {
        return SVO_OK;
    }
    obj->material = svo_i_mtl_find(&obj->file.library, name, length);
    if (obj->material == MTL_NO_MATERIAL) {
        return svo_i_read_out_of_memory(obj->reader);
    }
    mtl_material *material = svo_i_mtl_get(&obj->file.library, obj->material);
    material->used_line = material->used_line == 0 ? line : material->used_line;
    obj->begins_run = true;
    return SVO_OK;
}

static svo_status read_library_file(obj_reader *obj, const char *name, bool *found)
{
    file_bytes library;
    const char *trouble = svo_i_file_open_beside(obj->reader->path, name, &library);
    svo_i_stream_work(obj->reader->stream, obj->reader->work, (stream_work){library.byte_count, 0});
    *found = trouble == NULL;
    if (!*found) {
        return SVO_OK;
    }
    const svo_status status =
        svo_i_file_tell_beside(obj->reader->stream, obj->reader->path, name) == 0
            ? svo_i_mtl_read(&obj->file.library, obj->reader, name, library.bytes, library.byte_count)
            : svo_i_read_out_of_memory(obj->reader);
    svo_i_file_close(&library);
    return status;
}

/* The file of the OBJ file's own name, which many programs mean by a name that does not exist. */
static svo_status read_fallback_library(obj_reader *obj, bool *found)
{
    const char *slash = strrchr(obj->reader->path, '/');
    char *name = strdup(slash != NULL ? slash + 1 : obj->reader->path);
    if (name == NULL) {
        return svo_i_read_out_of_memory(obj->reader);
    }
    svo_status status = SVO_OK;
    char *dot = strrchr(name, '.');
    if (dot != NULL && strlen(dot) == 4) {
        memcpy(dot, ".mtl", sizeof ".mtl");
        status = read_library_file(obj, name, found);
    }
    free(name);
    return status;
}

/* Each word of the line as the name of a file. */
static svo_status read_library_words(obj_reader *obj, char *names, bool *found)
{
    char *rest = NULL;
    bool all = true;
    for (char *name = strtok_r(names, " \t", &rest); name != NULL; name = strtok_r(NULL, " \t", &rest)) {
        SVO_I_TRY(read_library_file(obj, name, found));
        all = all && *found;
    }
    *found = all;
    return SVO_OK;
}

/* "mtllib NAME", where NAME may have blanks in it, or several names. */
static svo_status read_library(obj_reader *obj)
{
    size_t length = 0;
    bool found = false;
    const char *begin = text_rest_of_line(&obj->cursor, &length);
    if (length == 0 || obj->reader->path == NULL) {
        return SVO_OK;
    }
    svo_status status = SVO_OK;
    char *name = text_copy(begin, length), *words = text_copy(begin, length);
    if (name == NULL || words == NULL) {
        status = svo_i_read_out_of_memory(obj->reader);
        goto cleanup;
    }
    SVO_I_TRY_CLEANUP(read_library_file(obj, name, &found));
    if (!found && strpbrk(name, " \t") != NULL) {
        SVO_I_TRY_CLEANUP(read_library_words(obj, words, &found));
    }
    if (!found) {
        SVO_I_TRY_CLEANUP(read_fallback_library(obj, &found));
    }
    if (!found) {
        svo_i_read_warn(obj->reader, "line %" PRIu64 ": material library %s cannot be read", obj->cursor.line, name);
    }
cleanup:
    free(name);
    free(words);
    return status;
}

/* Statements */

static void note_unknown(obj_reader *obj)
{
    static const char *const ignored[] = {"s",          "mg",        "vp",    "lod",      "usemap",  "maplib",
                                          "shadow_obj", "trace_obj", "bevel", "c_interp", "d_interp"};
    for (size_t i = 0; i < sizeof ignored / sizeof ignored[0]; ++i) {
        if (text_take_word(&obj->cursor, ignored[i])) {
            return;
        }
    }
    if (obj->unknown_count++ == 0) {
        obj->first_unknown = text_copy_word(&obj->cursor);
        obj->first_unknown_line = obj->cursor.line;
    }
}

static svo_status read_rare_statement(obj_reader *obj)
{
    text_cursor *cursor = &obj->cursor;
    if (text_take_word(cursor, "usemtl")) {
        return read_material_name(obj);
    }
    if (text_take_word(cursor, "mtllib")) {
        return read_library(obj);
    }
    if (text_take_word(cursor, "g") || text_take_word(cursor, "o")) {
        obj->begins_run = true;
    } else if (text_take_word(cursor, "l")) {
        ++obj->line_count;
    } else if (text_take_word(cursor, "p")) {
        ++obj->point_count;
    } else {
        note_unknown(obj);
    }
    return SVO_OK;
}

/* "fo" is "f" in old files. */
static svo_status read_statement(obj_reader *obj)
{
    text_cursor *cursor = &obj->cursor;
    if (*cursor->at == '#') {
        return SVO_OK;
    }
    if (text_take_word(cursor, "v")) {
        return read_position(obj);
    }
    if (text_take_word(cursor, "f") || text_take_word(cursor, "fo")) {
        return read_face(obj);
    }
    if (text_take_word(cursor, "vn")) {
        return read_normal(obj);
    }
    if (text_take_word(cursor, "vt")) {
        return read_uv(obj);
    }
    return read_rare_statement(obj);
}

static svo_status read_statements(obj_reader *obj)
{
    while (obj->cursor.at != obj->cursor.end) {
        if (text_skip_blanks(&obj->cursor)) {
            SVO_I_TRY(read_statement(obj));
        }
        text_skip_line(&obj->cursor);
    }
    const size_t position_count = obj->file.positions.count;
    if (obj->position_end > (int64_t)position_count) {
        return svo_i_fail(obj->reader->message, SVO_IMPORT_FAILED,
                          "line %" PRIu64 ": position %" PRId64 " does not exist; the file has %zu",
                          obj->position_end_line, obj->position_end, position_count);
    }
    return SVO_OK;
}

static void warn(const obj_reader *obj)
{
    const mesh_reader *reader = obj->reader;
    if (obj->line_count > 0 || obj->point_count > 0) {
        svo_i_read_warn(reader, "%" PRIu64 " lines and %" PRIu64 " points are left out", obj->line_count,
                        obj->point_count);
    }
    svo_i_read_count_faces(reader, obj->small_count, obj->file.faces.count + obj->small_count);
    if (obj->unknown_count > 0) {
        svo_i_read_warn(reader, "%" PRIu64 " statements are not read; the first is '%s' in line %" PRIu64,
                        obj->unknown_count, obj->first_unknown.text, obj->first_unknown_line);
    }
    svo_i_read_warn_odd(&obj->numbers);
    for (uint32_t i = 0; i < obj->file.library.materials.count; ++i) {
        const mtl_material *material = svo_i_mtl_get(&obj->file.library, i);
        if (material->used_line > 0 && !material->is_defined) {
            svo_i_read_warn(reader, "line %" PRIu64 ": material %s is in no library that was read; gray is used",
                            material->used_line, material->name);
        }
    }
}

/* A copy of the text in which a backslash before a line break is a blank and the break is TEXT_CONTINUED; *copy stays
   NULL where there is none. */
static svo_status join_lines(const mesh_reader *reader, text_cursor *cursor, char **copy)
{
    const char *from = cursor->at;
    while ((from = memchr(from, '\\', (size_t)(cursor->end - from))) != NULL) {
        const char *next = ++from;
        next += next != cursor->end && *next == '\r' ? 1 : 0;
        if (next == cursor->end || *next != '\n') {
            continue;
        }
        if (*copy == NULL) {
            const size_t byte_count = (size_t)(cursor->end - cursor->at);
            *copy = malloc(byte_count);
            if (*copy == NULL) {
                return svo_i_read_out_of_memory(reader);
            }
            memcpy(*copy, cursor->at, byte_count);
        }
        const size_t offset = (size_t)(from - cursor->at), length = (size_t)(next - from);
        memset(*copy + offset - 1, ' ', length + 1);
        (*copy)[offset + length] = TEXT_CONTINUED;
    }
    if (*copy != NULL) {
        cursor->end = *copy + (cursor->end - cursor->at);
        cursor->at = *copy;
    }
    return SVO_OK;
}

static void release(obj_file *file)
{
    free(file->positions.items);
    free(file->colors.items);
    free(file->uvs.items);
    free(file->normals.items);
    free(file->corners.items);
    free(file->faces.items);
    free(file->runs.items);
    svo_i_mtl_free(&file->library);
}

svo_status svo_i_read_obj(mesh_reader *reader)
{
    svo_status status = SVO_OK;
    char *copy = NULL;
    obj_reader obj = {.reader = reader, .numbers = {.reader = reader}, .material = MTL_NO_MATERIAL, .begins_run = true};
    SVO_I_TRY(svo_i_read_begin_text(reader, &obj.cursor));
    SVO_I_TRY_CLEANUP(join_lines(reader, &obj.cursor, &copy));
    SVO_I_TRY_CLEANUP(read_statements(&obj));
    warn(&obj);
    SVO_I_TRY_CLEANUP(svo_i_obj_gather(reader, &obj.file));
cleanup:
    release(&obj.file);
    free(copy);
    return status;
}
