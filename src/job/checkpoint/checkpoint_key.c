/* The settings that must be the same for a render to be continued. */
#include "job/checkpoint/checkpoint_state.h"

#include <stdio.h>
#include <string.h>

/* Settings with the same meaning get the same key. */
void checkpoint_key_of(const fathom_settings *settings, uint64_t scene, checkpoint_key *out) {
    fathom_settings s = *settings;
    const settings_region r = settings_region_of(&s);
    s.crop[0] = r.x, s.crop[1] = r.y, s.crop[2] = r.x + r.width, s.crop[3] = r.y + r.height;
    if (!s.min_spp && (s.max_time > 0 || s.target_error > 0)) s.min_spp = ADAPTIVE_MIN_SPP;
    *out = (checkpoint_key){.scene = scene};
    snprintf(out->version, sizeof out->version, "%s", fathom_version());
    settings_print(&s, out->settings);
}

void checkpoint_key_set_tracer(checkpoint_key *key, const char *tracer) {
    memset(key->tracer, 0, sizeof key->tracer);
    snprintf(key->tracer, sizeof key->tracer, "%s", tracer);
}

bool checkpoint_key_is_whole(const checkpoint_key *key) {
    return !key->version[sizeof key->version - 1] && !key->tracer[sizeof key->tracer - 1] &&
           !key->settings[sizeof key->settings - 1];
}

static bool differs(const char *name, const char *saved, const char *now, key_difference *out) {
    snprintf(out->name, sizeof out->name, "%s", name);
    snprintf(out->saved, sizeof out->saved, "%s", saved);
    snprintf(out->now, sizeof out->now, "%s", now);
    return true;
}

typedef struct line {
    char name[PARAMETER_NAME], value[PARAMETER_TEXT];
} line;

/* The next "name=value; ". */
static line take_line(const char **text) {
    line l = {.name = ""};
    const size_t length = strcspn(*text, ";"), name = strcspn(*text, "=;");
    snprintf(l.name, sizeof l.name, "%.*s", (int)name, *text);
    if (name < length) snprintf(l.value, sizeof l.value, "%.*s", (int)(length - name - 1), *text + name + 1);
    *text += length;
    *text += strspn(*text, "; ");
    return l;
}

/* The name of a setting as users know it: the option that sets it, if there is one. */
static const char *known_name(const char *name, char option[PARAMETER_NAME + 2]) {
    for (size_t i = 0; i < settings_table.count; ++i) {
        const fathom_parameter *p = &settings_table.rows[i];
        parameter_name(p, ' ', option);
        if (strcmp(name, option) != 0 || p->type == FATHOM_PARAMETER_BOOL) continue;
        if (!p->group) return "a loss by --leave-out-below of";
        if (!(p->flags & FATHOM_PARAMETER_COMMAND)) return name;
        option[0] = option[1] = '-';
        parameter_name(p, '-', option + 2);
        return option;
    }
    return name;
}

static bool settings_differ(const char *saved, const char *now, key_difference *out) {
    while (*saved || *now) {
        const line a = take_line(&saved), b = take_line(&now);
        if (strcmp(a.name, b.name) != 0) return differs("another list of settings:", a.name, b.name, out);
        char option[PARAMETER_NAME + 2];
        if (strcmp(a.value, b.value) != 0) return differs(known_name(a.name, option), a.value, b.value, out);
    }
    return false;
}

bool checkpoint_key_differs(const checkpoint_key *saved, const checkpoint_key *now, key_difference *out) {
    char texts[2][32];
    if (strcmp(saved->version, now->version) != 0)
        return differs("Fathom", saved->version, now->version, out);
    snprintf(texts[0], sizeof texts[0], "%#llx", (unsigned long long)saved->scene);
    snprintf(texts[1], sizeof texts[1], "%#llx", (unsigned long long)now->scene);
    if (saved->scene != now->scene) return differs("a scene of contents", texts[0], texts[1], out);
    if (settings_differ(saved->settings, now->settings, out)) return true;
    return saved->tracer[0] && now->tracer[0] && strcmp(saved->tracer, now->tracer) != 0 &&
           differs("the tracer", saved->tracer, now->tracer, out);
}

fathom_status checkpoint_key_compare(fathom_context *context, const char *path, const checkpoint_key *saved,
                                     const checkpoint_key *now) {
    key_difference d;
    if (!checkpoint_key_differs(saved, now, &d)) return FATHOM_OK;
    return fail_file(context, FATHOM_BAD_INPUT, path,
                     "the checkpoint was saved with %s %s, and this render has %s; expected the same render, "
                     "or another checkpoint file",
                     d.name, d.saved, d.now);
}
