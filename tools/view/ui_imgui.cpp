/* SPDX-License-Identifier: MIT */
/*
 * Panels by Dear ImGui, compiled where libimgui-dev is installed. Of ImGui it uses the core alone: the window gives it
 * input and draws its triangles (ui.h), so no backend and no loader of OpenGL come with it.
 *
 * ImGui has no answer to a failed allocation. Its blocks are therefore kept in a list, a failed one throws through
 * ImGui to the function of ui.h that called it, and the blocks are released together: nothing runs in ImGui afterwards.
 * While fonts are packed, stb_truetype holds blocks of its own, so nothing may throw there: a reserve stands by.
 */
#include <imgui.h>

#include <algorithm>
#include <cmath>
#include <cstdarg>
#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <new>

#include "view/ui.h"
#include "view/ui_font.h"
#include "view/ui_theme.h"

namespace
{

constexpr size_t line_bytes = 512;
constexpr int panels_max = 8;
constexpr size_t reserve_bytes = 1024 * 1024; /* more than packing allocates in all */

/* The head of each of ImGui's blocks; its size keeps what follows aligned. */
struct alignas(std::max_align_t) block {
    block *before, *after;
};

} // namespace

struct ui {
    ImGuiContext *context;
    ImFont *fonts[2]; /* small, large */
    ui_drawing drawing;
    block blocks; /* the list's end and begin */
    unsigned char *reserve; /* NULL: fonts are not being packed, and nothing lies in it */
    size_t reserve_used;
    bool failed; /* memory ran out */
    bool enabled;
    ui_place panel; /* the one that is being described */
    ui_place covered[panels_max]; /* what the panels of the last frame cover */
    int covered_count;
    const unsigned char *glyphs;
    int glyphs_width, glyphs_height;
};

namespace
{

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

void release_all(ui *panels)
{
    ImGui::SetCurrentContext(nullptr);
    panels->context = nullptr;
    while (panels->blocks.after != &panels->blocks) {
        release(panels->blocks.after + 1, panels);
    }
    std::free(panels->reserve);
    panels->reserve = nullptr;
}

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

/* ---- set-up ---- */

ImVec4 color(uint32_t rgba)
{
    return ImGui::ColorConvertU32ToFloat4(rgba);
}

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
    const float pixels[2] = {UI_TEXT_SMALL, UI_TEXT_LARGE};
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
    const ImGuiKey_ names[UI_KEY_COUNT] = {ImGuiKey_Backspace, ImGuiKey_Delete, ImGuiKey_LeftArrow, ImGuiKey_RightArrow,
                                           ImGuiKey_Home,      ImGuiKey_End,    ImGuiKey_Enter,     ImGuiKey_Escape};
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

/* ---- rows ---- */

float full_width()
{
    return ImGui::GetContentRegionAvail().x;
}

/* Writes the label at the left of a row; the next widget takes the rest. */
void begin_row(const char *label)
{
    const float left = ImGui::GetCursorPosX();
    const float share = std::floor(full_width() * UI_LABEL_SHARE);
    const ImVec2 at = ImGui::GetCursorScreenPos();
    ImGui::PushClipRect(at, ImVec2(at.x + share - UI_GAP, at.y + ImGui::GetFrameHeight()), true);
    ImGui::AlignTextToFramePadding();
    ImGui::TextDisabled("%s", label);
    ImGui::PopClipRect();
    ImGui::SameLine();
    ImGui::SetCursorPosX(left + share);
    ImGui::SetNextItemWidth(-FLT_MIN);
}

/* "##label", which ImGui does not show. */
struct hidden_label {
    char text[line_bytes];
    explicit hidden_label(const char *label)
    {
        (void)std::snprintf(text, sizeof text, "##%s", label);
    }
};

void use_color(uint32_t rgba, const char *text)
{
    ImGui::PushStyleColor(ImGuiCol_Text, color(rgba));
    ImGui::PushTextWrapPos(0);
    ImGui::TextUnformatted(text);
    ImGui::PopTextWrapPos();
    ImGui::PopStyleColor();
}

/* A button of the panel's width with its text at the left. */
bool wide_button(const char *text, uint32_t rgba, float inset)
{
    ImGui::PushStyleColor(ImGuiCol_Button, color(rgba));
    ImGui::PushStyleVar(ImGuiStyleVar_ButtonTextAlign, ImVec2(0, 0.5F));
    ImGui::PushStyleVar(ImGuiStyleVar_FramePadding, ImVec2(inset, UI_INSET_Y));
    const bool pressed = ImGui::Button(text, ImVec2(full_width(), 0));
    ImGui::PopStyleVar(2);
    ImGui::PopStyleColor();
    return pressed;
}

/* ---- drawing ---- */

constexpr float arrow_width = 14;

/* Points down where a section is open, else to the right. */
void draw_arrow(float x, float y, bool is_open)
{
    const float r = 4;
    ImDrawList *list = ImGui::GetWindowDrawList();
    if (is_open) {
        list->AddTriangleFilled(ImVec2(x, y - r / 2), ImVec2(x + 2 * r, y - r / 2), ImVec2(x + r, y + r / 2 + 1),
                                UI_COLOR_DIM);
    } else {
        list->AddTriangleFilled(ImVec2(x + r / 2, y - r), ImVec2(x + r * 3 / 2 + 1, y), ImVec2(x + r / 2, y + r),
                                UI_COLOR_DIM);
    }
}

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

ImVec2 corner(ui_place place)
{
    return {place.x, place.y};
}

ImVec2 far_corner(ui_place place)
{
    return {place.x + place.width, place.y + place.height};
}

} // namespace

/* ---- the handle ---- */

const char *ui_toolkit(void)
{
    return "Dear ImGui " IMGUI_VERSION;
}

ui *ui_create(void)
{
    auto *panels = static_cast<ui *>(std::calloc(1, sizeof(ui)));
    if (panels == nullptr) {
        return nullptr;
    }
    panels->blocks.before = panels->blocks.after = &panels->blocks;
    guarded(panels, [panels] { set_up(panels); });
    if (panels->failed) {
        ui_destroy(&panels);
    }
    return panels;
}

void ui_destroy(ui **panels)
{
    if (*panels != nullptr) {
        release_all(*panels);
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
    return panels->failed ? 0 : ImGui::GetIO().FontDefault->FontSize + 2 * UI_INSET_Y + UI_GAP;
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
                         ImGuiWindowFlags_NoBringToFrontOnFocus);
        ImGui::GetWindowDrawList()->ChannelsSplit(2);
        ImGui::GetWindowDrawList()->ChannelsSetCurrent(1);
    });
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

bool ui_section(ui *panels, const char *title, bool *is_open)
{
    return guarded(panels, false, [title, is_open] {
        const ImVec2 at = ImGui::GetCursorScreenPos();
        const bool clicked = wide_button(title, UI_COLOR_FIELD, UI_INSET_X + arrow_width);
        *is_open = clicked ? !*is_open : *is_open;
        draw_arrow(at.x + UI_INSET_X, at.y + ImGui::GetFrameHeight() / 2, *is_open);
        return clicked;
    });
}

/* ---- text ---- */

void ui_heading(ui *panels, const char *text)
{
    guarded(panels, [text] {
        use_color(UI_COLOR_ACCENT, text);
        ImGui::Separator();
    });
}

void ui_text(ui *panels, const char *format, ...)
{
    char text[line_bytes];
    va_list arguments;
    va_start(arguments, format);
    (void)std::vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    guarded(panels, [&text] { use_color(UI_COLOR_TEXT, text); });
}

void ui_note(ui *panels, const char *format, ...)
{
    char text[line_bytes];
    va_list arguments;
    va_start(arguments, format);
    (void)std::vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    guarded(panels, [&text] { use_color(UI_COLOR_DIM, text); });
}

void ui_value(ui *panels, const char *label, const char *format, ...)
{
    char text[line_bytes];
    va_list arguments;
    va_start(arguments, format);
    (void)std::vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    guarded(panels, [label, &text] {
        ImGui::BeginGroup();
        begin_row(label);
        ImGui::TextUnformatted(text);
        ImGui::EndGroup();
    });
}

void ui_gap(ui *panels)
{
    guarded(panels, [] { ImGui::Dummy(ImVec2(0, 0)); });
}

/* ---- widgets ---- */

int ui_buttons(ui *panels, const char *const *names, int count)
{
    return guarded(panels, -1, [names, count] {
        const float left = ImGui::GetCursorPosX();
        const float step = (full_width() + UI_GAP) / static_cast<float>(count);
        int pressed = -1;
        ImGui::BeginGroup();
        for (int i = 0; i < count; ++i) {
            const float begin = std::round(step * static_cast<float>(i));
            const float end = std::round(step * static_cast<float>(i + 1));
            if (i > 0) {
                ImGui::SameLine();
                ImGui::SetCursorPosX(left + begin);
            }
            if (ImGui::Button(names[i], ImVec2(end - begin - UI_GAP, 0))) {
                pressed = i;
            }
        }
        ImGui::EndGroup();
        return pressed;
    });
}

bool ui_tabs(ui *panels, const char *const *names, int count, int *chosen)
{
    return guarded(panels, false, [names, count, chosen] {
        const int before = *chosen;
        const float right = ImGui::GetCursorPosX() + full_width();
        float x = ImGui::GetCursorPosX();
        for (int i = 0; i < count; ++i) {
            const float width = ImGui::CalcTextSize(names[i]).x + 2 * UI_INSET_X;
            if (i > 0 && x + width <= right) {
                ImGui::SameLine();
                ImGui::SetCursorPosX(x);
            } else {
                x = ImGui::GetCursorPosX();
            }
            ImGui::PushStyleColor(ImGuiCol_Button, color(i == before ? UI_COLOR_CHOSEN : UI_COLOR_FIELD));
            if (ImGui::Button(names[i])) {
                *chosen = i;
            }
            ImGui::PopStyleColor();
            x += width + UI_GAP / 2;
        }
        return *chosen != before;
    });
}

bool ui_item(ui *panels, const char *text, bool chosen)
{
    return guarded(panels, false, [text, chosen] {
        return wide_button(text, chosen ? UI_COLOR_CHOSEN : UI_RGBA(0, 0, 0, 0), UI_INSET_X);
    });
}

bool ui_checkbox(ui *panels, const char *label, bool *value)
{
    return guarded(panels, false, [label, value] { return ImGui::Checkbox(label, value); });
}

bool ui_choice(ui *panels, const char *label, const char *const *names, int count, int *chosen)
{
    return guarded(panels, false, [=] {
        const int before = *chosen;
        begin_row(label);
        if (ImGui::BeginCombo(hidden_label(label).text, before >= 0 && before < count ? names[before] : "")) {
            for (int i = 0; i < count; ++i) {
                if (ImGui::Selectable(names[i], i == before)) {
                    *chosen = i;
                }
            }
            ImGui::EndCombo();
        }
        return *chosen != before;
    });
}

bool ui_slider(ui *panels, const char *label, float *value, float low, float high, const char *format)
{
    return guarded(panels, false, [=] {
        begin_row(label);
        return ImGui::SliderFloat(hidden_label(label).text, value, low, high, format, ImGuiSliderFlags_AlwaysClamp);
    });
}

bool ui_slider_count(ui *panels, const char *label, int *value, int low, int high)
{
    return guarded(panels, false, [=] {
        begin_row(label);
        return ImGui::SliderInt(hidden_label(label).text, value, low, high, "%d", ImGuiSliderFlags_AlwaysClamp);
    });
}

bool ui_numbers(ui *panels, const char *label, float *values, int count, float step, const char *format)
{
    return guarded(panels, false, [=] {
        begin_row(label);
        return ImGui::DragScalarN(hidden_label(label).text, ImGuiDataType_Float, values, count, step, nullptr, nullptr,
                                  format, ImGuiSliderFlags_NoRoundToFormat);
    });
}

/* Numbers to drag, and a patch of the color that opens ImGui's choice of colors. */
bool ui_color(ui *panels, const char *label, float rgb[3])
{
    return guarded(panels, false, [=] {
        const hidden_label hidden(label);
        begin_row(label);
        ImGui::SetNextItemWidth(-ImGui::GetFrameHeight() - UI_GAP);
        bool changed = ImGui::DragFloat3(hidden.text, rgb, 0.01F, 0, 0, "%.2f", ImGuiSliderFlags_NoRoundToFormat);
        ImGui::SameLine();
        ImGui::PushID("patch");
        changed |= ImGui::ColorEdit3(
            hidden.text, rgb, ImGuiColorEditFlags_HDR | ImGuiColorEditFlags_Float | ImGuiColorEditFlags_NoInputs);
        ImGui::PopID();
        std::transform(rgb, rgb + 3, rgb, [](float value) { return std::max(value, 0.0F); });
        return changed;
    });
}

bool ui_field(ui *panels, const char *label, char *text, size_t text_bytes)
{
    return guarded(panels, false, [=] {
        begin_row(label);
        return ImGui::InputText(hidden_label(label).text, text, text_bytes, ImGuiInputTextFlags_EnterReturnsTrue);
    });
}

void ui_tooltip(ui *panels, const char *text)
{
    guarded(panels, [text] {
        if (ImGui::IsItemHovered() && !ImGui::IsMouseDown(0)) {
            ImGui::BeginTooltip();
            ImGui::PushTextWrapPos(260);
            ImGui::TextUnformatted(text);
            ImGui::PopTextWrapPos();
            ImGui::EndTooltip();
        }
    });
}

/* ---- free drawing ---- */

bool ui_canvas(ui *panels, const char *name, float height, ui_place *place, float mouse[2])
{
    *place = {0, 0, 1, height};
    return guarded(panels, false, [=] {
        const ImVec2 at = ImGui::GetCursorScreenPos();
        *place = {at.x, at.y, full_width(), height};
        (void)ImGui::InvisibleButton(name, ImVec2(place->width, height));
        if (mouse != nullptr) {
            const bool known = ImGui::IsItemHovered() || ImGui::IsItemActive();
            const ImVec2 now = ImGui::GetIO().MousePos;
            mouse[0] = known ? std::min(std::max((now.x - at.x) / place->width, 0.0F), 1.0F) : -1;
            mouse[1] = known ? std::min(std::max((now.y - at.y) / height, 0.0F), 1.0F) : -1;
        }
        return ImGui::IsItemActive();
    });
}

void ui_fill(ui *panels, ui_place place, uint32_t rgba)
{
    guarded(panels, [=] { ImGui::GetWindowDrawList()->AddRectFilled(corner(place), far_corner(place), rgba); });
}

void ui_line(ui *panels, const float from[2], const float to[2], uint32_t rgba)
{
    guarded(panels,
            [=] { ImGui::GetWindowDrawList()->AddLine(ImVec2(from[0], from[1]), ImVec2(to[0], to[1]), rgba, 1.2F); });
}

void ui_fill_text(ui *panels, float x, float y, uint32_t rgba, const char *text)
{
    guarded(panels, [=] { ImGui::GetWindowDrawList()->AddText(ImVec2(std::round(x), std::round(y)), rgba, text); });
}

void ui_fill_image(ui *panels, ui_place place, uint32_t texture, const float part[4])
{
    guarded(panels, [=] {
        ImGui::GetWindowDrawList()->AddImage(reinterpret_cast<ImTextureID>(static_cast<uintptr_t>(texture)),
                                             corner(place), far_corner(place), ImVec2(part[0], part[1]),
                                             ImVec2(part[2], part[3]));
    });
}

float ui_text_width(const ui *panels, const char *text)
{
    return panels->failed ? 0 : ImGui::CalcTextSize(text).x;
}
