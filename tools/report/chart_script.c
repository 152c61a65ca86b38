/* SPDX-License-Identifier: MIT */
/*
 * Axes are logarithmic where values span more than a decade, and then 0 stands on a floor below the least other value,
 * labelled as what it is.
 */
#include "report/chart_script.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "report/palette.h"
#include "report/plot.h"
#include "report/text.h"

#define CHART_WIDTH      460u
#define CHART_HEIGHT     300u
#define BAR_HEIGHT       19u /* pixels of a bar with its distance */
#define BARS_MARGIN      60u
#define DECADE           10.0
#define WIDEST_BAR_LABEL 24

/* ---- points ---- */

static size_t find_curve(chart_points *points, const char *curve)
{
    for (size_t i = 0; i < points->curve_count; ++i) {
        if (strcmp(points->curves[i], curve) == 0) {
            return i;
        }
    }
    if (points->curve_count == CHART_CURVES_MAX) {
        points->failed = true;
        return 0;
    }
    points->curves[points->curve_count] = curve;
    return points->curve_count++;
}

void chart_points_add(chart_points *points, const char *curve, const chart_point *point)
{
    const size_t index = find_curve(points, curve);
    if (!isfinite(point->x) || !isfinite(point->y) || points->failed) {
        return;
    }
    if (points->count == points->capacity) {
        const size_t capacity = points->capacity * 2 + 64;
        chart_point *grown = realloc(points->points, capacity * sizeof *grown);
        if (grown == NULL) {
            points->failed = true;
            return;
        }
        points->points = grown;
        points->capacity = capacity;
    }
    points->points[points->count] = *point;
    points->points[points->count++].curve = index;
}

void chart_points_free(chart_points *points)
{
    free(points->points);
    *points = (chart_points){0};
}

/* ---- axes ---- */

typedef struct axis {
    double least, most; /* of values above 0 */
    bool any_zero, logarithmic;
    double floor; /* where 0 stands, if logarithmic */
} axis;

/* Times are logarithmic always, other figures where they span more than a decade, depths never. */
static axis measure_axis(const chart_points *points, bool of_y, const char *label)
{
    axis found = {.least = HUGE_VAL, .most = 0.0};
    for (size_t i = 0; i < points->count; ++i) {
        const double value = of_y ? points->points[i].y : points->points[i].x;
        found.any_zero = found.any_zero || value <= 0.0;
        found.least = value > 0.0 ? fmin(found.least, value) : found.least;
        found.most = fmax(found.most, value);
    }
    if (found.most <= 0.0) {
        found.least = found.most = 1.0;
    }
    found.logarithmic = strcmp(label, "depth") != 0 &&
                        (found.most > DECADE * found.least || found.any_zero || strncmp(label, "time", 4) == 0);
    const double bottom = pow(DECADE, floor(log10(found.least)));
    found.floor = found.any_zero ? bottom / DECADE : bottom;
    return found;
}

static double lower_end(const axis *of, bool is_y)
{
    return !is_y ? of->least / 1.4 : of->any_zero ? of->floor * 0.7 : of->floor;
}

static double upper_end(const axis *of, bool is_y)
{
    return is_y ? pow(DECADE, ceil(log10(of->most * 1.05))) : of->most * 1.4;
}

static void write_tic(double at, const char *label, bool first, FILE *script)
{
    fprintf(script, "%s'%s' %.9g", first ? "" : ", ", label, at);
}

static void write_tic_label(double at, int power, char label[64])
{
    if (power >= -3 && power < 0) {
        snprintf(label, 64, "%g", at);
    } else {
        snprintf(label, 64, "%s",
                 power >= 0 && power <= 4 ? text_format_number(at).text : text_format_power(power).text);
    }
}

/* Powers of ten; where there are few of them, twice and five times those too. Written by hand: gnuplot's own need a
   markup that names must not fall under. */
static void write_log_tics(const axis *of, bool is_y, FILE *script)
{
    static const double steps[] = {1.0, 2.0, 5.0};
    const double low = is_y && of->any_zero ? of->floor * 5.0 : lower_end(of, is_y);
    const double high = upper_end(of, is_y);
    const double decades = log10(high / low);
    const int skip = decades > 7.5 ? 2 : 1;
    const int last = (int)ceil(log10(high));
    bool begun = is_y && of->any_zero;
    fprintf(script, "set %ctics (", is_y ? 'y' : 'x');
    if (begun) {
        write_tic(of->floor, "0", true, script);
    }
    for (int power = (int)floor(log10(low)); power <= last; ++power) {
        for (size_t i = 0; i < (decades < 2.2 ? 3 : 1); ++i) {
            const double at = steps[i] * pow(DECADE, power);
            char label[64] = "";
            if (at < low * 0.999 || at > high * 1.001) {
                continue;
            }
            if ((last - power) % skip == 0) {
                write_tic_label(at, power, label);
            }
            write_tic(at, label, !begun, script);
            begun = true;
        }
    }
    fputs(")\n", script);
}

static void write_axis(const axis *of, bool is_y, const char *label, FILE *script)
{
    const char letter = is_y ? 'y' : 'x';
    fprintf(script, "set %clabel '%s'\n", letter, label);
    if (of->logarithmic) {
        fprintf(script, "set logscale %c\nset %crange [%.9g:%.9g]\n", letter, letter, lower_end(of, is_y),
                upper_end(of, is_y));
        write_log_tics(of, is_y, script);
    } else if (is_y) {
        fputs("set format y '%g'\nset yrange [0:*]\n", script);
    } else {
        fprintf(script, "set xtics 1 format '%%g'\nset xrange [%.9g:%.9g]\n", of->least - 0.3, of->most + 0.3);
    }
}

static void write_frame(FILE *script)
{
    fprintf(script,
            "set encoding utf8\nset border 3 lc rgb '#000000' lw 0.8\nset tics nomirror scale 0.5\nunset key\n"
            "set grid lt 1 lc rgb '#%06x' lw 0.6\nset bmargin 3.4\n",
            PLOT_RULE_COLOR);
}

/* ---- curves ---- */

static double height_of(const axis *y, double value)
{
    return y->logarithmic && value <= 0.0 ? y->floor : value;
}

/* On the front: no other point is at most as large in both, and smaller in one. */
static bool is_on_front(const chart_points *points, size_t index, chart_front front)
{
    const chart_point *mine = &points->points[index];
    for (size_t i = 0; i < points->count; ++i) {
        const chart_point *other = &points->points[i];
        const bool compared = front == FRONT_EACH ? other->curve == mine->curve : other->size == mine->size;
        if (compared && other->x <= mine->x && other->y <= mine->y && (other->x < mine->x || other->y < mine->y)) {
            return false;
        }
    }
    return true;
}

static void write_data(const chart_figure *figure, const chart_points *points, const axis *y, FILE *script)
{
    for (size_t curve = 0; curve < points->curve_count; ++curve) {
        fprintf(script, "$c%zu << EOD\n", curve);
        for (size_t i = 0; i < points->count; ++i) {
            const chart_point *point = &points->points[i];
            if (point->curve == curve) {
                fprintf(script, "%.9g %.9g\n", point->x, height_of(y, point->y));
            }
        }
        fputs("EOD\n", script);
    }
    fputs("$front << EOD\n", script);
    for (size_t i = 0; i < points->count && figure->front != FRONT_NONE; ++i) {
        if (is_on_front(points, i, figure->front)) {
            fprintf(script, "%.9g %.9g\n", points->points[i].x, height_of(y, points->points[i].y));
        }
    }
    fputs("EOD\n", script);
}

static bool has_points(const chart_points *points, size_t curve)
{
    for (size_t i = 0; i < points->count; ++i) {
        if (points->points[i].curve == curve) {
            return true;
        }
    }
    return false;
}

static void write_curves(const chart_figure *figure, const chart_points *points, const chart_points *all, FILE *script)
{
    const axis x = measure_axis(all, false, figure->x_label);
    const axis y = measure_axis(all, true, figure->y_label);
    write_frame(script);
    write_axis(&x, false, figure->x_label, script);
    write_axis(&y, true, figure->y_label, script);
    write_data(figure, points, &y, script);
    const char *separator = "plot ";
    for (size_t curve = 0; curve < points->curve_count; ++curve) {
        const method_style style = palette_of(points->curves[curve], curve);
        if (has_points(points, curve)) {
            fprintf(script, "%s$c%zu with linespoints lt 1 lw 1.5 lc rgb '#%06x' pt %d ps 0.62", separator, curve,
                    palette_rgb(style.color), style.marker);
            separator = ", ";
        }
    }
    if (figure->front != FRONT_NONE) {
        fputs(", $front with points pt 6 ps 1.15 lw 0.8 lc rgb '#000000'", script);
    }
    fputc('\n', script);
}

void chart_points_legend(const chart_points *points, FILE *page)
{
    fputs("<ul class=\"legend\">\n", page);
    for (size_t curve = 0; curve < points->curve_count; ++curve) {
        const method_style style = palette_of(points->curves[curve], curve);
        fprintf(page,
                "<li><svg class=\"key\" viewBox=\"-4 -2 8 4\" aria-hidden=\"true\"><path d=\"M-4 0H4\" fill=\"none\" "
                "stroke=\"var(--method-%d)\" stroke-width=\".5\"/><path d=\"%s\" fill=\"var(--method-%d)\"/></svg>",
                style.color, palette_marker_path(style.marker), style.color);
        text_escape(points->curves[curve], page);
        fputs("</li>\n", page);
    }
    fputs("</ul>\n", page);
}

/* ---- bars ---- */

/* Bytes in the unit that keeps the longest bar short; other figures as they are. */
static double bar_unit(const chart_figure *figure, double most, const char **unit)
{
    const size_t length = strlen(figure->x_label);
    const bool bytes = length > 3 && strcmp(figure->x_label + length - 3, ", B") == 0;
    *unit = !bytes ? figure->x_label : most >= 0x1p20 ? "MiB" : most >= 0x1p10 ? "KiB" : "bytes";
    return !bytes ? 1.0 : most >= 0x1p20 ? 0x1p20 : most >= 0x1p10 ? 0x1p10 : 1.0;
}

static void write_bars(const chart_figure *figure, const chart_points *points, FILE *script)
{
    const axis measured = measure_axis(points, true, "");
    const char *unit = "";
    const double scale = bar_unit(figure, measured.most, &unit);
    size_t longest = 0;
    fputs("$bars << EOD\n", script);
    for (size_t i = 0; i < points->count; ++i) {
        const char *label = points->curves[points->points[i].curve];
        longest = strlen(label) > longest ? strlen(label) : longest;
        fprintf(script, "%zu %.9g \"%s\" \"%s\"\n", i, points->points[i].y / scale, label,
                text_format_number(points->points[i].y / scale).text);
    }
    fputs("EOD\n", script);
    write_frame(script);
    fprintf(
        script,
        "unset grid\nset border 0\nset ytics scale 0\nunset xtics\nset xlabel '%s'\nset lmargin %zu\nset bmargin 2\n"
        "set xrange [0:%.9g]\nset yrange [%zu.5:-0.5]\nset style fill solid noborder\n"
        "plot $bars using (0):1:(0):2:($1-0.34):($1+0.34):ytic(3) with boxxyerror lc rgb '#%06x', "
        "$bars using 2:1:4 with labels left offset 0.6,0\n",
        unit, longest < WIDEST_BAR_LABEL ? longest + 1 : WIDEST_BAR_LABEL, measured.most / scale * 1.18,
        points->count - 1, palette_rgb(PALETTE_BLUE));
}

int chart_points_draw(program *state, const chart_figure *figure, const chart_points *points, const chart_points *all,
                      const char *name, const char *what, FILE *page)
{
    char *text = NULL;
    size_t text_bytes = 0;
    char label[512];
    FILE *script = open_memstream(&text, &text_bytes);
    if (script == NULL || points->failed) {
        if (script != NULL) {
            fclose(script);
        }
        free(text);
        return program_fail(state, PROGRAM_FAILED, "chart %s: out of memory or more than %u curves", name,
                            CHART_CURVES_MAX);
    }
    const bool bars = figure->x == NULL;
    if (points->count == 0) {
        fputs("<p class=\"missing\">Nothing was measured here.</p>\n", page);
    } else if (bars) {
        write_bars(figure, points, script);
    } else {
        write_curves(figure, points, all, script);
    }
    fclose(script);
    snprintf(label, sizeof label, "%s%s%s", what, what[0] != '\0' ? ". " : "", figure->caption);
    int exit_code = PROGRAM_DONE;
    if (points->count > 0 && text != NULL) {
        exit_code = plot_draw(state, text, name, label, CHART_WIDTH,
                              bars ? BARS_MARGIN + BAR_HEIGHT * (unsigned)points->count : CHART_HEIGHT, page);
    }
    free(text);
    return exit_code;
}
