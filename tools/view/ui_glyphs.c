/* SPDX-License-Identifier: MIT */
/* Basic Latin and the Latin supplement of the embedded font. */
#include "view/ui_glyphs.h"

#include <math.h>
#include <stb/stb_truetype.h>
#include <stdlib.h>
#include <string.h>

#include "view/ui_font.h"
#include "view/ui_theme.h"

#define CODE_FIRST 32
#define CODE_COUNT 224 /* up to U+00FF */

typedef struct glyph_size {
    stbtt_packedchar chars[CODE_COUNT];
    float baseline; /* below the line's top */
} glyph_size;

struct ui_glyph_set {
    uint8_t coverage[UI_GLYPHS_WIDTH * UI_GLYPHS_HEIGHT];
    glyph_size sizes[2]; /* small, large */
};

static float pixels_of(bool large)
{
    return large ? UI_TEXT_LARGE : UI_TEXT_SMALL;
}

static void find_baseline(bool large, glyph_size *size)
{
    float descent;
    float gap;
    stbtt_GetScaledFontVMetrics(ui_font_bytes, 0, pixels_of(large), &size->baseline, &descent, &gap);
    size->baseline = roundf(size->baseline);
}

static bool pack(ui_glyph_set *set)
{
    stbtt_pack_context packing;
    if (stbtt_PackBegin(&packing, set->coverage, (int)UI_GLYPHS_WIDTH, (int)UI_GLYPHS_HEIGHT, 0, 1, NULL) == 0) {
        return false;
    }
    int done = 1;
    for (int large = 0; large < 2; ++large) {
        glyph_size *size = &set->sizes[large];
        find_baseline(large == 1, size);
        done &=
            stbtt_PackFontRange(&packing, ui_font_bytes, 0, pixels_of(large == 1), CODE_FIRST, CODE_COUNT, size->chars);
    }
    stbtt_PackEnd(&packing);
    return done != 0;
}

ui_glyph_set *ui_glyph_set_create(void)
{
    ui_glyph_set *set = calloc(1, sizeof *set);
    if (set == NULL || !pack(set)) {
        free(set);
        return NULL;
    }
    /* The packer leaves a pixel free at the left and at the top. */
    set->coverage[0] = 255;
    return set;
}

void ui_glyph_set_destroy(ui_glyph_set **set)
{
    free(*set);
    *set = NULL;
}

const uint8_t *ui_glyph_set_coverage(const ui_glyph_set *set)
{
    return set->coverage;
}

/* The code point at text, and its bytes. */
static int decode(const char *text, size_t *bytes)
{
    const unsigned first = (unsigned char)text[0];
    const unsigned second = (unsigned char)text[first != 0 ? 1 : 0];
    const bool is_pair = (first & 0xE0U) == 0xC0 && (second & 0xC0U) == 0x80;
    *bytes = is_pair ? 2 : 1;
    return (int)(is_pair ? (first & 0x1FU) << 6 | (second & 0x3FU) : first);
}

size_t ui_glyph_bytes(const char *text)
{
    size_t bytes;
    (void)decode(text, &bytes);
    return bytes;
}

/* What the font's part lacks looks like a question mark. */
static const stbtt_packedchar *find(const glyph_size *size, int code)
{
    const bool known = code >= CODE_FIRST && code < CODE_FIRST + CODE_COUNT && !(code >= 127 && code < 160);
    return &size->chars[(known ? code : '?') - CODE_FIRST];
}

float ui_glyph_set_measure(const ui_glyph_set *set, bool large, const char *text, size_t text_bytes)
{
    float width = 0;
    size_t bytes;
    for (size_t i = 0; i < text_bytes && text[i] != '\0'; i += bytes) {
        width += find(&set->sizes[large], decode(text + i, &bytes))->xadvance;
    }
    return ceilf(width);
}

/* Glyphs stand on whole pixels, where they are sharpest. */
static void draw_glyph(const stbtt_packedchar *glyph, float x, float baseline, uint32_t color, ui_drawing *drawing)
{
    const float left = roundf(x + glyph->xoff);
    const float top = roundf(baseline + glyph->yoff);
    const float place[4] = {left, top, left + (float)(glyph->x1 - glyph->x0), top + (float)(glyph->y1 - glyph->y0)};
    const float texture[4] = {(float)glyph->x0 / (float)UI_GLYPHS_WIDTH, (float)glyph->y0 / (float)UI_GLYPHS_HEIGHT,
                              (float)glyph->x1 / (float)UI_GLYPHS_WIDTH, (float)glyph->y1 / (float)UI_GLYPHS_HEIGHT};
    ui_drawing_rectangle(drawing, place, texture, color);
}

void ui_glyph_set_draw(const ui_glyph_set *set, bool large, const float at[2], uint32_t color, const char *text,
                       size_t text_bytes, ui_drawing *drawing)
{
    const glyph_size *size = &set->sizes[large];
    float x = at[0];
    size_t bytes;
    for (size_t i = 0; i < text_bytes && text[i] != '\0'; i += bytes) {
        const stbtt_packedchar *glyph = find(size, decode(text + i, &bytes));
        if (glyph->x1 > glyph->x0) {
            draw_glyph(glyph, x, at[1] + size->baseline, color, drawing);
        }
        x += glyph->xadvance;
    }
}
