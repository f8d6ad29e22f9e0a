#include "integrate/path/path.h"

#include <math.h>

void path_absorb(path_wave *p, vertex_block *v) {
    for (unsigned i = 0; i < v->surface.count; ++i) {
        const uint32_t slot = v->path.slot[i];
        float left[3];
        const vec3_f32 way = sub_f32(lane_f32(v->surface.p, i), of_slot(p->p, slot));
        media_left(p->media, slot, sqrtf(dot_f32(way, way)) - p->passed[slot], left);
        for (int c = 0; c < 3; ++c) v->path.weight[c][i] *= left[c];
    }
}

uint32_t path_meet_volumes(const path_wave *p, const vertex_block *v, float around[LANES]) {
    uint32_t hidden = 0;
    for (unsigned i = 0; i < LANES; ++i) {
        const shader *s = v->shader.at[i];
        around[i] = 1;
        if (!s->encloses || !s->priority) continue;
        if (!media_meet(p->media, v->path.slot[i], v->surface.material[i], v->surface.entering[i] != 0,
                        &around[i]))
            hidden |= 1u << i;
    }
    return hidden;
}

/* If the volume inside or the one around disperses light, so does the surface between them. The shader has
 * the index of the path's channel alone. */
static void disperse(const path_wave *p, const vertex_block *v, unsigned i, shader *made) {
    const uint32_t material = v->surface.material[i], channel = v->shader.channel[i];
    const shader *own = &p->wave.run.plan->shaders[material],
                 *other = media_around(p->media, v->path.slot[i], material, v->surface.entering[i] != 0);
    if (!(made->lobes & SHADER_SOLID) || !((own->lobes | other->lobes) & SHADER_DISPERSIVE)) return;
    const float eta = shader_index(own, channel) / shader_index(other, channel);
    made->lobes |= SHADER_DISPERSIVE;
    made->eta_spread = (eta - made->eta) * ((float)channel - 2);
}

static void prepare_between(const path_wave *p, uint32_t material, float around, shader *made) {
    fathom_material m = p->wave.run.plan->scene->materials.items[material].value;
    m.ior /= around;
    shader_prepare(&m, made);
}

void path_hide_surfaces(path_wave *p, vertex_block *v, const float around[LANES], uint32_t hidden) {
    wave *w = &p->wave;
    for (unsigned i = 0; i < LANES; ++i) {
        const uint32_t material = v->surface.material[i];
        shader *made = &w->made[v - w->vertices][i];
        if (hidden >> i & 1) {
            v->shader.at[i] = &p->hidden;
        } else if (around[i] != 1) {
            if (v->shader.at[i] != made) prepare_between(p, material, around[i], made);
            v->shader.at[i] = made;
            if (w->run.plan->dispersive) disperse(p, v, i, made);
        }
    }
}

void path_hide_backs(path_wave *p, vertex_block *v) {
    for (unsigned i = 0; i < v->surface.count; ++i) {
        if (v->surface.entering[i] || !p->wave.run.plan->shaders[v->surface.material[i]].one_sided) continue;
        if (!path_in_view(p, v->path.slot[i])) continue;
        v->shader.at[i] = &p->hidden;
        p->looked_through = true;
    }
}

void path_choose_channels(const path_wave *p, vertex_block *v) {
    for (unsigned i = 0; i < LANES; ++i) {
        const uint32_t slot = v->path.slot[i];
        const uint32_t turn = (uint32_t)((p->index[slot] + (p->pixel[slot] >> 40)) % 3);
        v->shader.channel[i] = p->channel[slot] ? p->channel[slot] : 1 + turn;
    }
}

bool path_part_channels(const path_wave *p, const vertex_block *v, unsigned i, bool crosses, float rgb[3]) {
    const shader *s = v->shader.at[i];
    const bool denser = (v->surface.entering[i] != 0) != (s->eta > 1); /* on the viewer's side */
    if (!(s->lobes & SHADER_DISPERSIVE) || p->channel[v->path.slot[i]]) return false;
    if (!crosses && !denser) return false;
    for (uint32_t c = 0; c < 3; ++c) rgb[c] *= c + 1 == v->shader.channel[i] ? 3 : 0;
    return true;
}

void path_dim_lights(const path_wave *p, const vertex_block *v, const light_block *ray,
                     const uint32_t behind[LANES], lanes3 gain) {
    for (unsigned i = 0; i < v->surface.count; ++i) {
        float left[3];
        if (behind[i] && p->wave.run.plan->shaders[v->surface.material[i]].encloses)
            media_left_behind(p->media, v->path.slot[i], v->surface.material[i], v->surface.entering[i] != 0,
                              ray->distance[i], left);
        else
            media_left(p->media, v->path.slot[i], ray->distance[i], left);
        for (int c = 0; c < 3; ++c) gain[c][i] *= left[c];
    }
}

void path_part_lights(const path_wave *p, const vertex_block *v, const uint32_t behind[LANES], lanes3 gain) {
    for (unsigned i = 0; i < v->surface.count; ++i) {
        float rgb[3] = {gain[0][i], gain[1][i], gain[2][i]};
        if (!path_part_channels(p, v, i, behind[i] != 0, rgb)) continue;
        for (int c = 0; c < 3; ++c) gain[c][i] = rgb[c];
    }
}
