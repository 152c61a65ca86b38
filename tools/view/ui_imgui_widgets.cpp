/* SPDX-License-Identifier: MIT */
/* Sections, texts and widgets by Dear ImGui. */
#include <algorithm>
#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <cstring>
#include <string>

#include "view/ui_imgui.h"

using ui_imgui::color;
using ui_imgui::corner;
using ui_imgui::far_corner;
using ui_imgui::guarded;

namespace
{

constexpr size_t line_bytes = 512; /* of labels, which are the viewer's own */

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

} // namespace

bool ui_section(ui *panels, const char *title, const char *key, bool *is_open)
{
    return guarded(panels, false, [title, key, is_open] {
        const ImVec2 at = ImGui::GetCursorScreenPos();
        const float right = at.x + full_width() - UI_INSET_X - ImGui::CalcTextSize(key).x;
        const bool clicked = wide_button(title, UI_COLOR_FIELD, UI_INSET_X + arrow_width);
        *is_open = clicked ? !*is_open : *is_open;
        draw_arrow(at.x + UI_INSET_X, at.y + ImGui::GetFrameHeight() / 2, *is_open);
        ImGui::GetWindowDrawList()->AddText(ImVec2(std::floor(right), at.y + UI_INSET_Y), UI_COLOR_DIM, key);
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

namespace
{

/* Of any length, since names of drivers have any. */
__attribute__((format(printf, 1, 0))) std::string written(const char *format, va_list arguments)
{
    va_list again;
    va_copy(again, arguments);
    const int length = std::vsnprintf(nullptr, 0, format, again);
    va_end(again);
    std::string text(static_cast<size_t>(std::max(length, 0)) + 1, '\0');
    (void)std::vsnprintf(&text[0], text.size(), format, arguments);
    return text;
}

__attribute__((format(printf, 3, 0))) void write_lines(ui *panels, uint32_t rgba, const char *format, va_list arguments)
{
    guarded(panels, [&] { use_color(rgba, written(format, arguments).c_str()); });
}

} // namespace

void ui_text(ui *panels, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    write_lines(panels, UI_COLOR_TEXT, format, arguments);
    va_end(arguments);
}

void ui_note(ui *panels, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    write_lines(panels, UI_COLOR_DIM, format, arguments);
    va_end(arguments);
}

void ui_value(ui *panels, const char *label, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    guarded(panels, [&] {
        char shown[line_bytes];
        const std::string text = written(format, arguments);
        ImGui::BeginGroup();
        begin_row(label);
        const bool is_whole = ui_fit(panels, text.c_str(), full_width(), shown, sizeof shown);
        ImGui::TextUnformatted(shown);
        ImGui::EndGroup();
        if (!is_whole) {
            ui_tooltip(panels, text.c_str());
        }
    });
    va_end(arguments);
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

void ui_focus(ui *panels)
{
    guarded(panels, [] { ImGui::SetKeyboardFocusHere(); });
}

bool ui_field(ui *panels, const char *label, char *text, size_t text_bytes)
{
    return guarded(panels, false, [=] {
        begin_row(label);
        return ImGui::InputText(hidden_label(label).text, text, text_bytes, ImGuiInputTextFlags_EnterReturnsTrue);
    });
}

namespace
{

/* What a field of a path shows while it is typed into, and who is told of keys. */
struct path_field {
    char *text;
    size_t text_bytes;
    const ui_path_keys *keys;
};

/* Of ImGui, for Tab, Up and Down. */
int edit_path(ImGuiInputTextCallbackData *data)
{
    const auto *field = static_cast<const path_field *>(data->UserData);
    (void)std::snprintf(field->text, field->text_bytes, "%s", data->Buf);
    field->keys->edit(field->keys->user, data->EventFlag == ImGuiInputTextFlags_CallbackCompletion ? UI_PATH_COMPLETE
                                         : data->EventKey == ImGuiKey_UpArrow                      ? UI_PATH_PREVIOUS
                                                                                                   : UI_PATH_NEXT);
    if (std::strcmp(field->text, data->Buf) != 0) {
        data->DeleteChars(0, data->BufTextLen);
        data->InsertChars(0, field->text);
    }
    return 0;
}

} // namespace

bool ui_path(ui *panels, char *text, size_t text_bytes, bool takes_focus, const ui_path_keys *keys)
{
    return guarded(panels, false, [=] {
        path_field field = {text, text_bytes, keys};
        if (takes_focus) {
            ImGui::SetKeyboardFocusHere();
        }
        ImGui::SetNextItemWidth(-FLT_MIN);
        return ImGui::InputText("##path", text, text_bytes,
                                ImGuiInputTextFlags_EnterReturnsTrue | ImGuiInputTextFlags_CallbackCompletion |
                                    ImGuiInputTextFlags_CallbackHistory,
                                edit_path, &field);
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
