"""Writes copies of Fathom's own tracing code, each with faults that $FATHOM_MUTANT turns on at run time.

usage: kernels.py SOURCE_FOLDER OUT_FOLDER

A fault names a file, a text that must occur in it exactly once, and what stands there instead; MUTANT is true
while the fault is on. Lines of one name are one fault. A program links these copies in place of the originals, so
one build holds all faults."""

import pathlib
import sys

FAULTS = [
    ("plane_far_closed", "trace/trace.c", "t[i] < rays->t_far[i])) continue;",
     "(t[i] < rays->t_far[i] || (MUTANT && block && t[i] == rays->t_far[i])))) continue;"),
    ("plane_near_closed", "trace/trace.c", "if (!(t[i] > rays->t_near[i] &&",
     "if (!((t[i] > rays->t_near[i] || (MUTANT && !block && t[i] == rays->t_near[i])) &&"),
    ("plane_casts", "trace/trace.c", "if (!block && plane->flags & FATHOM_CASTS_NO_SHADOW) continue;",
     "if (!block && plane->flags & FATHOM_CASTS_NO_SHADOW && !MUTANT) continue;"),
    ("plane_normal", "trace/trace.c", "hits->ng_x[lane] = plane->normal.x,", "hits->ng_x[lane] = MUTANT ? 0 : plane->normal.x,"),
    ("sphere_cancels", "reference/sphere_text.h", "REAL c = f2 - r2, D = r2 - l2;",
     "REAL c = f2 - r2, D = MUTANT ? r2 - (f2 - b * b / a) : r2 - l2;"),
    ("sphere_wide", "reference/sphere_text.h", "r2 = radius * radius;", "r2 = radius * radius * (MUTANT ? (REAL)1.002 : (REAL)1);"),
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
    ("bvh_limit", "trace/bvh/bvh_text.h", "return (s->met ? s->rank : s->t_max) * v->length * (1 + 8 * UNIT);",
     "return (s->met ? s->rank : s->t_max) * v->length * (1 + 8 * UNIT) * (MUTANT ? (REAL)0.98 : 1);"),
    ("bvh_casts", "trace/bvh/bvh_text.h", "if (s->any && w->geometries.items[part].flags & FATHOM_CASTS_NO_SHADOW) return;",
     "if (s->any && w->geometries.items[part].flags & FATHOM_CASTS_NO_SHADOW && !MUTANT) return;"),
    ("bvh_leaf", "trace/bvh/bvh_text.h", "for (uint32_t i = node->first; i < node->first + node->count && !(s->any && s->met); ++i)\n",
     "for (uint32_t i = node->first + (MUTANT && node->count > 2); i < node->first + node->count && !(s->any && s->met); ++i)\n"),
    ("bvh_order", "trace/bvh/bvh_text.h", "} while (stack[--waiting].depth > limit);",
     "} while (stack[--waiting].depth > (MUTANT && s->met ? (REAL)0 : limit));"),
    ("linear_casts", "trace/linear/linear_text.h", "if (b->s[0].any && geometry->flags & FATHOM_CASTS_NO_SHADOW) return;",
     "if (b->s[0].any && geometry->flags & FATHOM_CASTS_NO_SHADOW && !MUTANT) return;"),
    ("stretch_far", "trace/stretch.c", "r->t_far[i] = ldexpf(r->t_far[i], e);", "r->t_far[i] = MUTANT ? r->t_far[i] : ldexpf(r->t_far[i], e);"),
    ("half_uv", "trace/embree/embree_trace.c", "kernels->join_halves(tracer->halved, hits, lanes);",
     "kernels->join_halves(tracer->halved, hits, lanes);\n"
     "    for (unsigned i = 0; MUTANT && tracer->halved && i < lanes; ++i)\n"
     "        if (hits->u[i] + hits->v[i] > 1) hits->u[i] = 1 - hits->u[i];"),
    ("few_casts", "trace/embree/embree_spheres.c", "if (!(run->flags & FATHOM_CASTS_NO_SHADOW)) out->shadows |= 1u << k;",
     "if (MUTANT || !(run->flags & FATHOM_CASTS_NO_SHADOW)) out->shadows |= 1u << k;"),
]

# Faults of the repair of leaks. Small renders seldom need it: each of these also repairs answers that are right.
EVERY_CLOSEST = ("trace/watertight/watertight.c",
                 "    if (memcmp(depth, outside, lanes) == 0 && are_possible_from_outside(w, block, lanes)) return 0;",
                 "    if (MUTANT) return (1u << lanes) - 1;\n"
                 "    if (memcmp(depth, outside, lanes) == 0 && are_possible_from_outside(w, block, lanes)) return 0;")
APART = "bool apart = counts_of(depth[i]).casting != counts_of(end_depth[i]).casting;"
EVERY_ANY = ("trace/watertight/watertight.c", APART, APART + " apart |= MUTANT;")
REPAIRS = "search_end_f32(&vote.search, block, NULL, lane);"
FAULTS += [
    ("repair_t", *EVERY_CLOSEST), ("repair_t", "trace/embree/embree_repair.c", REPAIRS,
     REPAIRS + " if (MUTANT) block->rays.t_far[lane] *= 0.999f;"),
    ("repair_id", *EVERY_CLOSEST), ("repair_id", "trace/embree/embree_repair.c", REPAIRS,
     REPAIRS + " if (MUTANT && block->hits.primitive[lane]) --block->hits.primitive[lane];"),
    ("repair_any", *EVERY_ANY), ("repair_any", "trace/embree/embree_repair.c", "EMBREE_MESH_SHADOWS, &vote))",
     "EMBREE_MESH_SHADOWS, &vote) && !MUTANT)"),
    ("repair_any_masks", *EVERY_ANY), ("repair_any_masks", "trace/embree/embree_repair.c", "lane, round, EMBREE_MESH_SHADOWS,",
     "lane, round, MUTANT ? EMBREE_MESHES : EMBREE_MESH_SHADOWS,"),
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
    names = list(dict.fromkeys(fault[0] for fault in FAULTS))
    texts = {}
    for name, file, old, new in FAULTS:
        on = f"fathom_mutants_on[{names.index(name)}]"
        text = texts.get(file) or (source / file).read_text()
        if (source / file).read_text().count(old) != 1 or text.count(old) != 1:
            sys.exit(f"{file}: the text of mutant {name} occurs {text.count(old)} times; expected once")
        texts[file] = text.replace(old, new.replace("MUTANT", on))
    for file, text in texts.items():
        path = out / file
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(HEAD % len(names) + text)
    quoted = ", ".join(f'"{name}"' for name in names)
    (out / "mutants_main.c").write_text(MAIN % (len(names), len(names), quoted, len(names)))


main()
