/* SPDX-License-Identifier: MIT */
/*
 * Panels by Dear ImGui. Of ImGui it uses the core alone: the window gives it input and draws its triangles (ui.h), so
 * no backend and no loader of OpenGL come with it.
 *
 * ImGui has no answer to a failed allocation. Its blocks are therefore kept in a list, a failed one throws through
 * ImGui to the function of ui.h that called it, and the blocks are released together: nothing runs in ImGui afterwards.
 * While fonts are packed, stb_truetype holds blocks of its own, so nothing may throw there: a reserve stands by.
 */
#include "view/ui_imgui.h"

#include <algorithm>
#include <cstdint>
#include <cstdlib>

/* DejaVu Sans, which the build embeds: a TrueType file. */
extern "C" {
extern const unsigned char ui_font_bytes[];
extern const unsigned ui_font_byte_count;
}

using ui_imgui::block;
using ui_imgui::color;
using ui_imgui::corner;
using ui_imgui::far_corner;
using ui_imgui::guarded;
using ui_imgui::panels_max;

namespace
{

constexpr size_t reserve_bytes = 1024 * 1024; /* more than packing allocates in all */

/* ---- memory ---- */

void *take_from_reserve(ui *panels, size_t byte_count)
{
    const size_t begin = panels->reserve_used;
    const size_t end = begin + (byte_count + sizeof(block) - 1) / sizeof(block) * sizeof(block);
    if (panels->reserve == nullptr || end > reserve_bytes) {
        return nullptr;
    }
    panels->reserve_used = end;
    return panels->reserve + begin;
}

bool is_in_reserve(const ui *panels, const block *made)
{
    const auto at = reinterpret_cast<uintptr_t>(made);
    const auto begin = reinterpret_cast<uintptr_t>(panels->reserve);
    return panels->reserve != nullptr && at >= begin && at < begin + reserve_bytes;
}

void *allocate(size_t byte_count, void *user)
{
    auto *panels = static_cast<ui *>(user);
    auto *made = static_cast<block *>(std::malloc(sizeof(block) + byte_count));
    if (made == nullptr) {
        made = static_cast<block *>(take_from_reserve(panels, sizeof(block) + byte_count));
    }
    if (made == nullptr) {
        throw std::bad_alloc();
    }
    made->before = &panels->blocks;
    made->after = panels->blocks.after;
    made->after->before = made;
    panels->blocks.after = made;
    return made + 1;
}

void release(void *bytes, void *user)
{
    if (bytes != nullptr) {
        block *made = static_cast<block *>(bytes) - 1;
        made->before->after = made->after;
        made->after->before = made->before;
        if (!is_in_reserve(static_cast<ui *>(user), made)) {
            std::free(made);
        }
    }
}

} // namespace

void ui_imgui::release_all(ui *panels)
{
    ImGui::SetCurrentContext(nullptr);
    panels->context = nullptr;
    while (panels->blocks.after != &panels->blocks) {
        release(panels->blocks.after + 1, panels);
    }
    std::free(panels->reserve);
    panels->reserve = nullptr;
}

namespace
{

/* ---- set-up ---- */

void set_colors(ImGuiStyle &style)
{
    const struct {
        ImGuiCol which;
        uint32_t rgba;
    } colors[] = {
        {ImGuiCol_Text, UI_COLOR_TEXT},
        {ImGuiCol_TextDisabled, UI_COLOR_DIM},
        {ImGuiCol_WindowBg, UI_COLOR_PANEL},
        {ImGuiCol_PopupBg, UI_COLOR_PANEL | 0xFF000000U},
        {ImGuiCol_Border, UI_COLOR_EDGE},
        {ImGuiCol_FrameBg, UI_COLOR_FIELD},
        {ImGuiCol_FrameBgHovered, UI_COLOR_HOVER},
        {ImGuiCol_FrameBgActive, UI_COLOR_PRESSED},
        {ImGuiCol_ScrollbarBg, UI_RGBA(0, 0, 0, 0)},
        {ImGuiCol_ScrollbarGrab, UI_COLOR_PRESSED},
        {ImGuiCol_ScrollbarGrabHovered, UI_COLOR_ACCENT},
        {ImGuiCol_ScrollbarGrabActive, UI_COLOR_ACCENT},
        {ImGuiCol_CheckMark, UI_COLOR_ACCENT},
        {ImGuiCol_SliderGrab, UI_COLOR_CHOSEN},
        {ImGuiCol_SliderGrabActive, UI_COLOR_CHOSEN},
        {ImGuiCol_Button, UI_COLOR_FIELD},
        {ImGuiCol_ButtonHovered, UI_COLOR_HOVER},
        {ImGuiCol_ButtonActive, UI_COLOR_PRESSED},
        {ImGuiCol_Header, UI_COLOR_CHOSEN},
        {ImGuiCol_HeaderHovered, UI_COLOR_HOVER},
        {ImGuiCol_HeaderActive, UI_COLOR_PRESSED},
        {ImGuiCol_Separator, UI_COLOR_EDGE},
        {ImGuiCol_TextSelectedBg, UI_COLOR_CHOSEN},
    };
    for (const auto &each : colors) {
        style.Colors[each.which] = color(each.rgba);
    }
}

void set_style()
{
    ImGuiStyle &style = ImGui::GetStyle();
    style.WindowPadding = ImVec2(UI_PADDING, UI_PADDING);
    style.FramePadding = ImVec2(UI_INSET_X, UI_INSET_Y);
    style.ItemSpacing = ImVec2(UI_GAP, UI_GAP);
    style.ItemInnerSpacing = ImVec2(UI_INSET_X, UI_GAP);
    style.WindowRounding = UI_ROUNDING;
    style.PopupRounding = UI_ROUNDING;
    style.FrameRounding = UI_ROUNDING;
    style.GrabRounding = UI_ROUNDING;
    style.ScrollbarSize = UI_SCROLL_WIDTH;
    style.WindowMinSize = ImVec2(1, 1);
    style.WindowBorderSize = 1;
    set_colors(style);
}

void set_fonts(ui *panels)
{
    ImGuiIO &io = ImGui::GetIO();
    ImFontConfig config;
    config.FontDataOwnedByAtlas = false;
    config.OversampleH = 1;
    config.OversampleV = 1;
    config.PixelSnapH = true;
    const float pixels[2] = {UI_TEXT_SMALL * panels->scale, UI_TEXT_LARGE * panels->scale};
    io.FontGlobalScale = 1 / panels->scale;
    for (int i = 0; i < 2; ++i) {
        /* ImGui takes no const pointer, but with this config it only reads. */
        panels->fonts[i] = io.Fonts->AddFontFromMemoryTTF(const_cast<unsigned char *>(ui_font_bytes),
                                                          static_cast<int>(ui_font_byte_count), pixels[i], &config);
    }
    unsigned char *coverage = nullptr;
    panels->reserve = static_cast<unsigned char *>(std::malloc(reserve_bytes));
    if (panels->reserve == nullptr) {
        throw std::bad_alloc();
    }
    io.Fonts->GetTexDataAsAlpha8(&coverage, &panels->glyphs_width, &panels->glyphs_height);
    if (panels->reserve_used == 0) {
        std::free(panels->reserve);
        panels->reserve = nullptr;
    }
    panels->glyphs = coverage;
    io.Fonts->SetTexID(nullptr);
}

/* ImGui calls keys by names of its own; here each has the number that ui_input gives it. */
void set_keys(ImGuiIO &io)
{
    const ImGuiKey_ names[UI_KEY_COUNT] = {
        ImGuiKey_Backspace, ImGuiKey_Delete, ImGuiKey_LeftArrow, ImGuiKey_RightArrow, ImGuiKey_Home,
        ImGuiKey_End,       ImGuiKey_Enter,  ImGuiKey_Escape,    ImGuiKey_Tab,        ImGuiKey_UpArrow,
        ImGuiKey_DownArrow, ImGuiKey_A,      ImGuiKey_C,         ImGuiKey_V,          ImGuiKey_X};
    for (int i = 0; i < UI_KEY_COUNT; ++i) {
        io.KeyMap[names[i]] = i;
    }
}

void set_up(ui *panels)
{
    ImGui::SetAllocatorFunctions(allocate, release, panels);
    panels->context = ImGui::CreateContext();
    ImGuiIO &io = ImGui::GetIO();
    io.IniFilename = nullptr;
    io.LogFilename = nullptr;
    io.ConfigInputTextCursorBlink = false;
    set_keys(io);
    set_style();
    set_fonts(panels);
}

/* ---- drawing ---- */

int pixel(float coordinate)
{
    return static_cast<int>(std::max(coordinate, 0.0F));
}

void copy_list(const ImDrawList &list, ui_drawing *out)
{
    static_assert(sizeof(ImDrawVert) == sizeof(ui_vertex) && sizeof(ImDrawIdx) == sizeof(uint16_t),
                  "ImGui was configured with other vertices or indices");
    const uint32_t first = ui_drawing_vertices(out, reinterpret_cast<const ui_vertex *>(list.VtxBuffer.Data),
                                               static_cast<size_t>(list.VtxBuffer.Size));
    for (const ImDrawCmd &command : list.CmdBuffer) {
        const ImVec4 &place = command.ClipRect;
        const int clip[4] = {pixel(place.x), pixel(place.y), pixel(place.z), pixel(place.w)};
        ui_drawing_batch(out, static_cast<uint32_t>(reinterpret_cast<uintptr_t>(command.TextureId)), clip);
        ui_drawing_triangles(out, first, list.IdxBuffer.Data + command.IdxOffset, command.ElemCount);
    }
}

} // namespace

/* ---- the handle ---- */

const char *ui_toolkit(void)
{
    return "Dear ImGui " IMGUI_VERSION;
}

ui *ui_create(float scale)
{
    auto *panels = static_cast<ui *>(std::calloc(1, sizeof(ui)));
    if (panels == nullptr) {
        return nullptr;
    }
    panels->blocks.before = panels->blocks.after = &panels->blocks;
    panels->scale = scale;
    guarded(panels, [panels] { set_up(panels); });
    if (panels->failed) {
        ui_destroy(&panels);
    }
    return panels;
}

void ui_destroy(ui **panels)
{
    if (*panels != nullptr) {
        ui_imgui::release_all(*panels);
        ui_drawing_free(&(*panels)->drawing);
        std::free(*panels);
        *panels = nullptr;
    }
}

const uint8_t *ui_glyphs(const ui *panels, unsigned *width, unsigned *height)
{
    *width = static_cast<unsigned>(panels->glyphs_width);
    *height = static_cast<unsigned>(panels->glyphs_height);
    return panels->glyphs;
}

namespace
{

const char *read_clipboard(void *user)
{
    const auto *panels = static_cast<ui *>(user);
    return panels->clipboard.read(panels->clipboard.user);
}

void write_clipboard(void *user, const char *text)
{
    const auto *panels = static_cast<ui *>(user);
    panels->clipboard.write(panels->clipboard.user, text);
}

} // namespace

void ui_set_clipboard(ui *panels, const ui_clipboard *clipboard)
{
    panels->clipboard = *clipboard;
    guarded(panels, [panels] {
        ImGuiIO &io = ImGui::GetIO();
        io.GetClipboardTextFn = read_clipboard;
        io.SetClipboardTextFn = write_clipboard;
        io.ClipboardUserData = panels;
    });
}

/* ---- frames ---- */

void ui_begin(ui *panels, const ui_input *input)
{
    guarded(panels, [panels, input] {
        ImGuiIO &io = ImGui::GetIO();
        io.DisplaySize = ImVec2(input->width, input->height);
        io.DeltaTime = input->seconds;
        io.MousePos = input->mouse[0] < 0 ? ImVec2(-FLT_MAX, -FLT_MAX) : ImVec2(input->mouse[0], input->mouse[1]);
        std::copy(input->buttons, input->buttons + 3, io.MouseDown);
        std::copy(input->keys, input->keys + UI_KEY_COUNT, io.KeysDown);
        io.KeyCtrl = input->control;
        io.KeyShift = input->shift;
        io.MouseWheel = input->wheel;
        io.AddInputCharactersUTF8(input->typed);
        io.FontDefault = panels->fonts[input->large ? 1 : 0];
        panels->covered_count = 0;
        ImGui::NewFrame();
    });
}

const ui_drawing *ui_end(ui *panels)
{
    guarded(panels, [panels] {
        ImGui::Render();
        const ImDrawData *data = ImGui::GetDrawData();
        ui_drawing_clear(&panels->drawing);
        for (int i = 0; i < data->CmdListsCount; ++i) {
            copy_list(*data->CmdLists[i], &panels->drawing);
        }
    });
    return panels->failed || panels->drawing.failed ? nullptr : &panels->drawing;
}

/* A panel's window is as high as its place, but only what it covers counts. */
bool ui_wants_mouse(const ui *panels)
{
    if (panels->failed) {
        return false;
    }
    const ImVec2 mouse = ImGui::GetIO().MousePos;
    const ui_place *end = panels->covered + panels->covered_count;
    return ImGui::IsAnyItemActive() || ImGui::IsPopupOpen(nullptr, ImGuiPopupFlags_AnyPopup) ||
           std::any_of(panels->covered, end, [mouse](const ui_place &place) {
               return mouse.x >= place.x && mouse.x < place.x + place.width && mouse.y >= place.y &&
                      mouse.y < place.y + place.height;
           });
}

/* ImGui's wish alone would last a frame longer than the field's focus. */
bool ui_wants_keys(const ui *panels)
{
    return !panels->failed && ImGui::GetIO().WantTextInput && ImGui::IsAnyItemActive();
}

float ui_row_height(const ui *panels)
{
    return panels->failed ? 0 : ImGui::GetIO().FontDefault->FontSize / panels->scale + 2 * UI_INSET_Y + UI_GAP;
}

/* ---- panels ---- */

/* The background is drawn last, when its height is known, below the rest. */
void ui_panel_begin(ui *panels, const char *name, ui_place place)
{
    guarded(panels, [panels, name, place] {
        panels->panel = place;
        panels->enabled = true;
        ImGui::SetNextWindowPos(corner(place));
        ImGui::SetNextWindowSize(ImVec2(place.width, place.height));
        ImGui::Begin(name, nullptr,
                     ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoCollapse |
                         ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoSavedSettings | ImGuiWindowFlags_NoBackground |
                         ImGuiWindowFlags_NoNav | ImGuiWindowFlags_NoFocusOnAppearing |
                         (panels->is_raised ? 0 : ImGuiWindowFlags_NoBringToFrontOnFocus));
        panels->is_raised = false;
        ImGui::GetWindowDrawList()->ChannelsSplit(2);
        ImGui::GetWindowDrawList()->ChannelsSetCurrent(1);
    });
}

void ui_raise(ui *panels)
{
    panels->is_raised = true;
}

float ui_panel_end(ui *panels)
{
    return guarded(panels, 0.0F, [panels] {
        ui_enable(panels, true);
        ui_place &place = panels->panel;
        const float content = ImGui::GetCursorPosY() - UI_GAP + UI_PADDING;
        place.height = std::min(place.height, content);
        ImDrawList *list = ImGui::GetWindowDrawList();
        list->ChannelsSetCurrent(0);
        list->PushClipRect(corner(place), far_corner(place));
        list->AddRectFilled(corner(place), far_corner(place), UI_COLOR_PANEL, UI_ROUNDING);
        list->AddRect(corner(place), far_corner(place), UI_COLOR_EDGE, UI_ROUNDING);
        list->PopClipRect();
        list->ChannelsMerge();
        ImGui::End();
        if (panels->covered_count < panels_max) {
            panels->covered[panels->covered_count++] = place;
        }
        return place.height;
    });
}

void ui_push(ui *panels, int number)
{
    guarded(panels, [number] { ImGui::PushID(number); });
}

void ui_pop(ui *panels)
{
    guarded(panels, [] { ImGui::PopID(); });
}

void ui_enable(ui *panels, bool enabled)
{
    guarded(panels, [panels, enabled] {
        if (enabled != panels->enabled && enabled) {
            ImGui::EndDisabled();
        } else if (enabled != panels->enabled) {
            ImGui::BeginDisabled();
        }
        panels->enabled = enabled;
    });
}
