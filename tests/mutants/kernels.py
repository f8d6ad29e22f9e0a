"""Writes copies of Fathom's own tracing code, each with faults that $FATHOM_MUTANT turns on at run time.

usage: kernels.py SOURCE_FOLDER OUT_FOLDER

A fault names a file, a text that must occur in it exactly once, and what stands there instead; MUTANT is true
while the fault is on. A program links these copies in place of the originals, so one build holds all faults."""

import pathlib
import sys

FAULTS = [
    ("plane_far_closed", "trace/trace.c", "if (t[i] > rays->t_near[i] && t[i] < rays->t_far[i])\n                    set_hit",
     "if (t[i] > rays->t_near[i] && (t[i] < rays->t_far[i] || (MUTANT && t[i] == rays->t_far[i])))\n                    set_hit"),
    ("plane_near_closed", "trace/trace.c", "if (t[i] > rays->t_near[i] && t[i] < rays->t_far[i]) rays->t_far[i] = -INFINITY",
     "if ((t[i] > rays->t_near[i] || (MUTANT && t[i] == rays->t_near[i])) && t[i] < rays->t_far[i]) rays->t_far[i] = -INFINITY"),
    ("plane_casts", "trace/trace.c", "if (plane->flags & FATHOM_CASTS_NO_SHADOW) continue;",
     "if (plane->flags & FATHOM_CASTS_NO_SHADOW && !MUTANT) continue;"),
    ("plane_normal", "trace/trace.c", "hits->ng_x[lane] = plane->normal.x,", "hits->ng_x[lane] = MUTANT ? 0 : plane->normal.x,"),
    ("sphere_cancels", "reference/sphere_text.h", "REAL c = f2 - r2, D = r2 - l2;",
     "REAL c = f2 - r2, D = MUTANT ? r2 - (f2 - b * b / a) : r2 - l2;"),
    ("sphere_near_closed", "reference/sphere_text.h", "*t = roots[0] > t_min ? roots[0] : roots[1];",
     "*t = (MUTANT ? roots[0] >= t_min : roots[0] > t_min) ? roots[0] : roots[1];"),
    ("triangle_culls", "reference/triangle_text.h", "if (negative & positive) return false;\n    REAL sum",
     "if ((negative & positive) | (MUTANT && negative)) return false;\n    REAL sum"),
    ("triangle_near_closed", "reference/triangle_text.h", "if (!((t > t_min) & (t < t_max))) return false;",
     "if (!(((t > t_min) | (MUTANT && t == t_min)) & (t < t_max))) return false;"),
    ("triangle_weight", "reference/triangle_text.h", "hit->t = t, hit->u = weight[0], hit->v = weight[1];",
     "hit->t = t, hit->u = weight[0] + (MUTANT ? (REAL)0x1p-12 : 0), hit->v = weight[1];"),
    ("quad_uv", "reference/quad_text.h", "hit->t = second.t, hit->u = 1 - second.u, hit->v = 1 - second.v;",
     "hit->t = second.t, hit->u = MUTANT ? second.u : 1 - second.u, hit->v = 1 - second.v;"),
    ("instance_shift", "trace/search_text.h", "(SUM)row[3] * (SUM)w);", "(SUM)row[3] * (SUM)w * (MUTANT ? (SUM)0.9999 : (SUM)1));"),
    ("sphere_normal", "trace/search_text.h", "n = FN(sub)(FN(madd)(s->org, s->best.t, s->dir),",
     "n = FN(sub)(FN(madd)(s->org, MUTANT ? s->best.t * (REAL)1.01 : s->best.t, s->dir),"),
    ("bvh_limit", "trace/bvh/bvh_text.h", "return (s->met ? s->best.t : s->t_max) * v->length * (1 + 8 * UNIT);",
     "return (s->met ? s->best.t : s->t_max) * v->length * (1 + 8 * UNIT) * (MUTANT ? (REAL)0.98 : 1);"),
    ("bvh_casts", "trace/bvh/bvh_text.h", "if (s->any && w->geometries.items[part].flags & FATHOM_CASTS_NO_SHADOW) return;",
     "if (s->any && w->geometries.items[part].flags & FATHOM_CASTS_NO_SHADOW && !MUTANT) return;"),
    ("bvh_leaf", "trace/bvh/bvh_text.h", "for (uint32_t i = node->first; i < node->first + node->count && !(s->any && s->met); ++i) {",
     "for (uint32_t i = node->first + (MUTANT && node->count > 2); i < node->first + node->count && !(s->any && s->met); ++i) {"),
    ("bvh_order", "trace/bvh/bvh_text.h", "} while (stack[--waiting].depth > limit);",
     "} while (stack[--waiting].depth > (MUTANT && s->met ? (REAL)0 : limit));"),
    ("linear_casts", "trace/linear/linear_text.h", "if (b->s[0].any && geometry->flags & FATHOM_CASTS_NO_SHADOW) return;",
     "if (b->s[0].any && geometry->flags & FATHOM_CASTS_NO_SHADOW && !MUTANT) return;"),
    ("stretch_far", "trace/stretch.c", "r->t_far[i] = ldexpf(r->t_far[i], e);", "r->t_far[i] = MUTANT ? r->t_far[i] : ldexpf(r->t_far[i], e);"),
    ("half_uv", "trace/embree/embree_trace.c", "hits->u[lane] = second ? 1 - hits->u[lane] : hits->u[lane];",
     "hits->u[lane] = second && !MUTANT ? 1 - hits->u[lane] : hits->u[lane];"),
    ("few_casts", "trace/embree/embree_spheres.c", "if (!(run->flags & FATHOM_CASTS_NO_SHADOW)) out->shadows |= 1u << k;",
     "if (MUTANT || !(run->flags & FATHOM_CASTS_NO_SHADOW)) out->shadows |= 1u << k;"),
]

HEAD = """#ifndef MUTANT_IS
#define MUTANT_IS
#include <stdbool.h>
extern bool fathom_mutants_on[%d];
#endif
"""

MAIN = """#include <stdbool.h>
#include <stdlib.h>
#include <string.h>
extern bool fathom_mutants_on[%d];
bool fathom_mutants_on[%d];
static const char *const names[] = {%s};
__attribute__((constructor)) static void choose(void) {
    const char *name = getenv("FATHOM_MUTANT");
    for (unsigned i = 0; name && i < %d; ++i) fathom_mutants_on[i] = strcmp(name, names[i]) == 0;
}
"""


def main():
    source, out = map(pathlib.Path, sys.argv[1:3])
    texts = {}
    for number, (name, file, old, new) in enumerate(FAULTS):
        text = texts.get(file) or (source / file).read_text()
        if text.count(old) != 1:
            sys.exit(f"{file}: the text of mutant {name} occurs {text.count(old)} times; expected once")
        texts[file] = text.replace(old, new.replace("MUTANT", f"fathom_mutants_on[{number}]"))
    count = len(FAULTS)
    for file, text in texts.items():
        path = out / file
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(HEAD % count + text)
    names = ", ".join(f'"{f[0]}"' for f in FAULTS)
    (out / "mutants_main.c").write_text(MAIN % (count, count, names, count))


main()
