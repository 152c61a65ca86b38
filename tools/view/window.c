/* SPDX-License-Identifier: MIT */
/* SDL: the window, its context, and events in both directions. */
#include "view/window.h"

#include <SDL.h>
#include <SDL_syswm.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

struct window {
    SDL_Window *handle;
    SDL_GLContext context;
    view_gl gl;
    svo_gl_context *wrapped;
    char *copied; /* SDL's, of the clipboard */
    float x11_scale; /* by the desktop's settings when the window was opened */
};

/* Of an inch of a plain display. */
#define PLAIN_DOTS 96.0F

typedef struct key_pair {
    SDL_Keycode sdl;
    int key;
} key_pair;

/* Keys that are neither a character nor F1 to F12. */
static const key_pair named_keys[] = {
    {SDLK_BACKSPACE, VIEW_KEY_BACKSPACE}, {SDLK_TAB, VIEW_KEY_TAB},       {SDLK_RETURN, VIEW_KEY_ENTER},
    {SDLK_KP_ENTER, VIEW_KEY_ENTER},      {SDLK_ESCAPE, VIEW_KEY_ESCAPE}, {SDLK_DELETE, VIEW_KEY_DELETE},
    {SDLK_LEFT, VIEW_KEY_LEFT},           {SDLK_RIGHT, VIEW_KEY_RIGHT},   {SDLK_UP, VIEW_KEY_UP},
    {SDLK_DOWN, VIEW_KEY_DOWN},           {SDLK_HOME, VIEW_KEY_HOME},     {SDLK_END, VIEW_KEY_END}};

#define NAMED_KEYS (sizeof named_keys / sizeof named_keys[0])

/* ---- opening ---- */

static svo_gl_function find_for_library(void *user, const char *name)
{
    (void)user;
    void *const found = window_find_function(name);
    svo_gl_function function = NULL;
    memcpy(&function, &found, sizeof function);
    return function;
}

static bool wrap_context(window *made, svo_message *why)
{
    svo_message reason = {""};
    const svo_gl_context_options current = {
        .struct_size = sizeof current, .kind = SVO_GL_WRAPPED, .get_proc_address = find_for_library};
    if (svo_gl_context_create(&current, &made->wrapped, &reason) == SVO_OK) {
        return true;
    }
    (void)snprintf(why->text, sizeof why->text, "the window's OpenGL cannot take pictures: %.900s", reason.text);
    return false;
}

static bool open_context(window *made, svo_message *why)
{
    made->context = SDL_GL_CreateContext(made->handle);
    if (made->context == NULL) {
        (void)snprintf(why->text, sizeof why->text,
                       "no context of OpenGL 4.3: %s; LIBGL_ALWAYS_SOFTWARE=1 asks for Mesa's software renderer",
                       SDL_GetError());
        return false;
    }
    const char *missing = view_gl_load(&made->gl, window_find_function);
    GLint version[2] = {0, 0};
    if (missing == NULL) {
        made->gl.GetIntegerv(GL_MAJOR_VERSION, &version[0]);
        made->gl.GetIntegerv(GL_MINOR_VERSION, &version[1]);
        if (version[0] > 4 || (version[0] == 4 && version[1] >= 3)) {
            return wrap_context(made, why);
        }
    }
    (void)snprintf(why->text, sizeof why->text,
                   "OpenGL %d.%d lacks %s; LIBGL_ALWAYS_SOFTWARE=1 asks for Mesa's software renderer", (int)version[0],
                   (int)version[1], missing != NULL ? missing : "what 4.3 has");
    return false;
}

#ifdef SDL_VIDEO_DRIVER_X11
typedef char *get_default(Display *display, const char *program, const char *option);

/* Desktops on X11 say it as the dots of an inch, in a resource that SDL does not read. */
static float scale_of_x11(SDL_Window *handle)
{
    SDL_SysWMinfo info;
    float dots = 0;
    get_default *find = NULL;
    SDL_VERSION(&info.version);
    if (SDL_GetWindowWMInfo(handle, &info) != SDL_TRUE || info.subsystem != SDL_SYSWM_X11) {
        return 1;
    }
    void *library = SDL_LoadObject("libX11.so.6"); /* SDL has it open */
    void *const found = library != NULL ? SDL_LoadFunction(library, "XGetDefault") : NULL;
    memcpy(&find, &found, sizeof find);
    const char *text = find != NULL ? find(info.info.x11.display, "Xft", "dpi") : NULL;
    dots = text != NULL ? strtof(text, NULL) : PLAIN_DOTS;
    if (library != NULL) {
        SDL_UnloadObject(library);
    }
    return dots > 0 ? dots / PLAIN_DOTS : 1;
}
#else
static float scale_of_x11(SDL_Window *handle)
{
    (void)handle;
    return 1;
}
#endif

static float in_quarters(float scale)
{
    return fminf(fmaxf(floorf(4 * scale + 0.5F) / 4, 1), 4);
}

static bool open_window(window *made, const char *title, const window_place *place, svo_message *why)
{
    const Uint32 flags = SDL_WINDOW_OPENGL | SDL_WINDOW_RESIZABLE | SDL_WINDOW_ALLOW_HIGHDPI |
                         (place->fullscreen ? SDL_WINDOW_FULLSCREEN_DESKTOP : 0);
    const int width = (int)place->width;
    const int height = (int)place->height;
    SDL_GL_SetAttribute(SDL_GL_CONTEXT_PROFILE_MASK, SDL_GL_CONTEXT_PROFILE_CORE);
    SDL_GL_SetAttribute(SDL_GL_CONTEXT_MAJOR_VERSION, 4);
    SDL_GL_SetAttribute(SDL_GL_CONTEXT_MINOR_VERSION, 3);
    made->handle = SDL_CreateWindow(title, SDL_WINDOWPOS_UNDEFINED, SDL_WINDOWPOS_UNDEFINED, width, height, flags);
    if (made->handle == NULL) {
        (void)snprintf(why->text, sizeof why->text, "no window of %dx%d pixels: %s", width, height, SDL_GetError());
        return false;
    }
    made->x11_scale = scale_of_x11(made->handle);
    const float scale = place->grows ? in_quarters(made->x11_scale) : 1;
    if (scale > 1) {
        SDL_SetWindowSize(made->handle, (int)((float)width * scale), (int)((float)height * scale));
    }
    return open_context(made, why);
}

/* Without a display SDL draws where nobody sees it. That is for scripts, and only if it is asked for. */
static bool begin_video(svo_message *why)
{
    const bool is_chosen = getenv("SDL_VIDEODRIVER") != NULL;
    const bool is_there = is_chosen || getenv("DISPLAY") != NULL || getenv("WAYLAND_DISPLAY") != NULL;
    const bool works = is_there && SDL_InitSubSystem(SDL_INIT_VIDEO) == 0;
    const char *driver = works ? SDL_GetCurrentVideoDriver() : "none";
    if (works && (is_chosen || (strcmp(driver, "offscreen") != 0 && strcmp(driver, "dummy") != 0))) {
        return true;
    }
    (void)snprintf(why->text, sizeof why->text,
                   "no display: %s; set DISPLAY or WAYLAND_DISPLAY, or SDL_VIDEODRIVER=offscreen for a --script",
                   !is_there ? "none is named"
                   : works   ? "neither X11 nor Wayland answers"
                             : SDL_GetError());
    SDL_Quit();
    return false;
}

window *window_open(const char *title, const window_place *place, svo_message *why)
{
    window *made = calloc(1, sizeof *made);
    if (made == NULL) {
        (void)snprintf(why->text, sizeof why->text, "out of memory for the window");
        return NULL;
    }
    SDL_SetHint(SDL_HINT_NO_SIGNAL_HANDLERS, "1"); /* support/cleanup.h has them */
    if (!begin_video(why)) {
        free(made);
        return NULL;
    }
    if (!open_window(made, title, place, why)) {
        window_close(&made);
        return NULL;
    }
    SDL_GL_SetSwapInterval(1);
    return made;
}

void window_close(window **which)
{
    window *gone = *which;
    if (gone == NULL) {
        return;
    }
    svo_gl_context_destroy(&gone->wrapped);
    if (gone->context != NULL) {
        SDL_GL_DeleteContext(gone->context);
    }
    if (gone->handle != NULL) {
        SDL_DestroyWindow(gone->handle);
    }
    SDL_free(gone->copied);
    SDL_QuitSubSystem(SDL_INIT_VIDEO);
    SDL_Quit();
    free(gone);
    *which = NULL;
}

bool window_use(window *which, svo_message *why)
{
    if (SDL_GL_MakeCurrent(which->handle, which->context) == 0) {
        return true;
    }
    (void)snprintf(why->text, sizeof why->text, "the window's OpenGL context: %s", SDL_GetError());
    return false;
}

const view_gl *window_gl(const window *which)
{
    return &which->gl;
}

svo_gl_context *window_context(const window *which)
{
    return which->wrapped;
}

void *window_find_function(const char *name)
{
    return SDL_GL_GetProcAddress(name);
}

const char *window_renderer(const window *which)
{
    const char *name = (const char *)which->gl.GetString(GL_RENDERER);
    return name != NULL ? name : "unknown renderer";
}

void window_set_title(window *which, const char *title)
{
    SDL_SetWindowTitle(which->handle, title);
}

/* Pixels for each of the units in which the desktop measures the window and the mouse. */
static float pixels_of_unit(const window *which)
{
    int units = 0;
    int pixels = 0;
    SDL_GetWindowSize(which->handle, &units, NULL);
    SDL_GL_GetDrawableSize(which->handle, &pixels, NULL);
    return units > 0 && pixels > 0 ? (float)pixels / (float)units : 1;
}

float window_scale(const window *which)
{
    const float units = pixels_of_unit(which);
    return in_quarters(units > 1.01F ? units : which->x11_scale);
}

void window_size(const window *which, unsigned *width, unsigned *height)
{
    int columns = 0;
    int rows = 0;
    SDL_GL_GetDrawableSize(which->handle, &columns, &rows);
    *width = columns > 0 ? (unsigned)columns : 1;
    *height = rows > 0 ? (unsigned)rows : 1;
}

void window_hide(window *which)
{
    SDL_HideWindow(which->handle);
}

void window_set_fullscreen(window *which, bool fullscreen)
{
    SDL_SetWindowFullscreen(which->handle, fullscreen ? SDL_WINDOW_FULLSCREEN_DESKTOP : 0);
}

void window_finish(window *which)
{
    which->gl.Finish();
}

bool window_show(window *which, svo_message *why)
{
    SDL_GL_SwapWindow(which->handle);
    which->gl.Finish(); /* swapping the buffers of what is not on a screen flushes nothing: commands would pile up */
    return view_gl_check(&which->gl, "showing the window", why);
}

void window_wait(window *which, unsigned milliseconds)
{
    (void)which;
    (void)SDL_WaitEventTimeout(NULL, (int)milliseconds);
}

bool window_is_closing(window *which)
{
    (void)which;
    SDL_PumpEvents();
    return SDL_HasEvent(SDL_QUIT) == SDL_TRUE;
}

/* SDL's text has to be released, and the caller's lives until the next call. */
const char *window_read_clipboard(void *user)
{
    window *which = user;
    SDL_free(which->copied);
    which->copied = SDL_GetClipboardText();
    return which->copied;
}

void window_write_clipboard(void *user, const char *text)
{
    (void)user;
    (void)SDL_SetClipboardText(text);
}

/* ---- keys ---- */

static int key_from_sdl(SDL_Keycode code)
{
    if (code >= SDLK_F1 && code <= SDLK_F12) {
        return VIEW_KEY_F1 + (int)(code - SDLK_F1);
    }
    if (code >= ' ' && code <= '~') {
        return (int)code;
    }
    for (size_t i = 0; i < NAMED_KEYS; ++i) {
        if (named_keys[i].sdl == code) {
            return named_keys[i].key;
        }
    }
    return VIEW_KEY_NONE;
}

static SDL_Keycode key_to_sdl(int key)
{
    if (key >= VIEW_KEY_F1 && key <= VIEW_KEY_F12) {
        return SDLK_F1 + (key - VIEW_KEY_F1);
    }
    for (size_t i = 0; i < NAMED_KEYS; ++i) {
        if (named_keys[i].key == key) {
            return named_keys[i].sdl;
        }
    }
    return key;
}

static int button_from_sdl(Uint8 button)
{
    return button == SDL_BUTTON_RIGHT    ? VIEW_BUTTON_RIGHT
           : button == SDL_BUTTON_MIDDLE ? VIEW_BUTTON_MIDDLE
                                         : VIEW_BUTTON_LEFT;
}

static Uint8 button_to_sdl(int button)
{
    return button == VIEW_BUTTON_RIGHT    ? SDL_BUTTON_RIGHT
           : button == VIEW_BUTTON_MIDDLE ? SDL_BUTTON_MIDDLE
                                          : SDL_BUTTON_LEFT;
}

/* ---- events ---- */

static void read_window_event(const window *which, const SDL_WindowEvent *from, view_event *to)
{
    unsigned width = 0;
    unsigned height = 0;
    window_size(which, &width, &height);
    *to = (view_event){.kind = from->event == SDL_WINDOWEVENT_CLOSE ? VIEW_EVENT_QUIT : VIEW_EVENT_RESIZE,
                       .x = (int)width,
                       .y = (int)height};
}

static void read_key(const SDL_KeyboardEvent *from, view_event *to)
{
    *to = (view_event){.kind = VIEW_EVENT_KEY,
                       .key = key_from_sdl(from->keysym.sym),
                       .is_down = from->state == SDL_PRESSED,
                       .shift = (from->keysym.mod & KMOD_SHIFT) != 0,
                       .control = (from->keysym.mod & KMOD_CTRL) != 0};
}

static void read_drop(const SDL_DropEvent *from, view_event *to)
{
    to->kind = VIEW_EVENT_DROP;
    if (from->file != NULL && strlen(from->file) < sizeof to->path) {
        (void)snprintf(to->path, sizeof to->path, "%s", from->file);
    }
    SDL_free(from->file);
}

static void read_place(const window *which, int x, int y, view_event *to)
{
    const float pixels = pixels_of_unit(which);
    to->x = (int)((float)x * pixels);
    to->y = (int)((float)y * pixels);
}

/* The wheel's steps are where the mouse was last. */
static bool read_event(const window *which, const SDL_Event *from, view_event *to)
{
    const SDL_Keymod held = SDL_GetModState();
    *to = (view_event){.shift = (held & KMOD_SHIFT) != 0, .control = (held & KMOD_CTRL) != 0};
    switch (from->type) {
    case SDL_QUIT:
        to->kind = VIEW_EVENT_QUIT;
        return true;
    case SDL_WINDOWEVENT:
        read_window_event(which, &from->window, to);
        return from->window.event == SDL_WINDOWEVENT_CLOSE || from->window.event == SDL_WINDOWEVENT_SIZE_CHANGED;
    case SDL_KEYDOWN:
    case SDL_KEYUP:
        read_key(&from->key, to);
        return to->key != VIEW_KEY_NONE;
    case SDL_TEXTINPUT:
        to->kind = VIEW_EVENT_TEXT;
        (void)snprintf(to->text, sizeof to->text, "%s", from->text.text);
        return true;
    case SDL_MOUSEMOTION:
        to->kind = VIEW_EVENT_MOVE;
        read_place(which, from->motion.x, from->motion.y, to);
        return true;
    case SDL_MOUSEBUTTONDOWN:
    case SDL_MOUSEBUTTONUP:
        to->kind = VIEW_EVENT_BUTTON;
        to->button = button_from_sdl(from->button.button);
        to->is_down = from->type == SDL_MOUSEBUTTONDOWN;
        read_place(which, from->button.x, from->button.y, to);
        return true;
    case SDL_MOUSEWHEEL:
        to->kind = VIEW_EVENT_WHEEL;
        read_place(which, from->wheel.mouseX, from->wheel.mouseY, to);
        to->steps = from->wheel.preciseY;
        return true;
    case SDL_DROPFILE:
        read_drop(&from->drop, to);
        return true;
    default:
        return false;
    }
}

bool window_poll(window *which, view_event *event)
{
    SDL_Event next;
    while (SDL_PollEvent(&next) == 1) {
        if (read_event(which, &next, event)) {
            return true;
        }
    }
    return false;
}

/* Modifiers of a pushed event must be those of SDL's state too: only keys carry their own. */
static void write_modifiers(const view_event *from)
{
    SDL_SetModState((from->shift ? KMOD_LSHIFT : KMOD_NONE) | (from->control ? KMOD_LCTRL : KMOD_NONE));
}

static void write_event(const view_event *from, SDL_Event *to)
{
    memset(to, 0, sizeof *to);
    switch (from->kind) {
    case VIEW_EVENT_KEY:
        to->type = from->is_down ? SDL_KEYDOWN : SDL_KEYUP;
        to->key.state = from->is_down ? SDL_PRESSED : SDL_RELEASED;
        to->key.keysym.sym = key_to_sdl(from->key);
        to->key.keysym.mod = (Uint16)SDL_GetModState();
        return;
    case VIEW_EVENT_TEXT:
        to->type = SDL_TEXTINPUT;
        (void)snprintf(to->text.text, sizeof to->text.text, "%s", from->text);
        return;
    case VIEW_EVENT_MOVE:
        to->type = SDL_MOUSEMOTION;
        to->motion.x = from->x;
        to->motion.y = from->y;
        return;
    case VIEW_EVENT_BUTTON:
        to->type = from->is_down ? SDL_MOUSEBUTTONDOWN : SDL_MOUSEBUTTONUP;
        to->button.button = button_to_sdl(from->button);
        to->button.x = from->x;
        to->button.y = from->y;
        return;
    case VIEW_EVENT_WHEEL:
        to->type = SDL_MOUSEWHEEL;
        to->wheel.mouseX = from->x;
        to->wheel.mouseY = from->y;
        to->wheel.preciseY = from->steps;
        return;
    case VIEW_EVENT_DROP:
        to->type = SDL_DROPFILE;
        to->drop.file = SDL_strdup(from->path);
        return;
    case VIEW_EVENT_RESIZE:
    case VIEW_EVENT_QUIT:
        to->type = SDL_QUIT;
        return;
    }
}

bool window_push(window *which, const view_event *event)
{
    SDL_Event made;
    if (event->kind == VIEW_EVENT_RESIZE) {
        SDL_SetWindowSize(which->handle, event->x, event->y);
        return true;
    }
    write_modifiers(event);
    write_event(event, &made);
    if (SDL_PushEvent(&made) == 1) {
        return true;
    }
    if (event->kind == VIEW_EVENT_DROP) {
        SDL_free(made.drop.file);
    }
    return false;
}
