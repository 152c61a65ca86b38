/* SPDX-License-Identifier: MIT */
/* What the files of panels by Dear ImGui share: the handle, and how a call of ImGui may fail. ui_imgui.cpp says how. */
#ifndef SVOCL_TOOLS_VIEW_UI_IMGUI_H
#define SVOCL_TOOLS_VIEW_UI_IMGUI_H

#include <imgui.h>

#include <cstddef>
#include <cstdint>
#include <new>

#include "view/ui.h"

namespace ui_imgui
{

constexpr int panels_max = 8;

/* The head of each of ImGui's blocks; its size keeps what follows aligned. */
struct alignas(std::max_align_t) block {
    block *before, *after;
};

} // namespace ui_imgui

struct ui {
    ImGuiContext *context;
    ImFont *fonts[2]; /* small, large */
    ui_drawing drawing;
    ui_imgui::block blocks; /* the list's end and begin */
    unsigned char *reserve; /* NULL: fonts are not being packed, and nothing lies in it */
    size_t reserve_used;
    bool failed; /* memory ran out */
    bool enabled;
    bool is_raised; /* the next panel */
    ui_place panel; /* the one that is being described */
    ui_place covered[ui_imgui::panels_max]; /* what the panels of the last frame cover */
    int covered_count;
    const unsigned char *glyphs;
    int glyphs_width, glyphs_height;
    float scale;
    ui_clipboard clipboard;
};

namespace ui_imgui
{

/* Ends ImGui: releases all that it holds. */
void release_all(ui *panels);

/* Calls what may run out of memory; otherwise, or once memory ran out, returns fallback. */
template <typename result, typename call> result guarded(ui *panels, result fallback, call made)
{
    if (panels->failed) {
        return fallback;
    }
    try {
        return made();
    } catch (const std::bad_alloc &) {
        panels->failed = true;
        release_all(panels);
        return fallback;
    }
}

template <typename call> void guarded(ui *panels, call made)
{
    (void)guarded(panels, 0, [&made] {
        made();
        return 0;
    });
}

inline ImVec4 color(uint32_t rgba)
{
    return ImGui::ColorConvertU32ToFloat4(rgba);
}

inline ImVec2 corner(ui_place place)
{
    return {place.x, place.y};
}

inline ImVec2 far_corner(ui_place place)
{
    return {place.x + place.width, place.y + place.height};
}

} // namespace ui_imgui

#endif
