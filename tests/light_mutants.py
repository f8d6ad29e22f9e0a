"""Faults of light transport: each is planted, built, and must fail `fathom validate --light`; see light_mutants.sh.
Without arguments it only looks whether all can be planted."""
import subprocess
import sys

# Name, file below src, a law that breaks (part of its name), the text, and the fault in its place. Each text is in its file
# once, as test light_mutants asks: whoever changes the code moves the fault along.
PATH, EMITTERS, SHAPES = "integrate/path/path.c", "light/emitters.c", "light/emitters_shapes.c"
LAMPS = "light/emitters_lamps.c"
SHAPE, TREE, PICK, LOBES = "light/shape.h", "light/tree.c", "light/kernels/tree.c", "material/kernels/lobes.h"
ONE, SKY = "light/kernels/face.c", "light/kernels/sky.c"
VOLUMES, MET, CARRIED = "integrate/path/path_volumes.c", "integrate/path/path_met.c", "integrate/path/path.h"
FACETS, DIFFUSE, SHEEN, FILM = ("material/kernels/" + name for name in ("facets.h", "diffuse.h", "sheen.h", "film.h"))
MUTANTS = [
    ("MIS weights add up to 0.99", "integrate/path/path_kernels.h", "rectangle", "return 1 / (1 + chosen", "return 0.99f / (1 + chosen"),
    ("emission counts whole where lights were asked for, too", MET, "rectangle",
     "const float share = path_share(p->density[slot], p->light_factor * met->density, met->sky ? ~0u : 0);",
     "const float share = met->density < 0 ? met->density : 1;"),
    ("lights count whole where rays find them, too", "integrate/kernels/path.c", "rectangle",
     "path_share(factor * asked, density[i], sky), 1);", "1 + 0 * density[i], 1);"),
    ("emission by the balance heuristic, lights by the power heuristic", MET, "rectangle",
     "const float share = path_share(p->density[slot], p->light_factor * met->density, met->sky ? ~0u : 0);",
     "const float share = p->density[slot] < INFINITY ? p->density[slot] / (p->density[slot] + met->density) : 1;"),
    ("the sky's MIS factor counts for light samples alone", MET, "even sky", "p->light_factor * met->density", "met->density"),
    ("roulette without its weight", "integrate/kernels/path.c", "furnace, sphere",
     "for (int c = 0; c < 3; ++c) weight[c][i] /= divisor;", "(void)divisor;"),
    ("roulette ends more paths than it says", "integrate/kernels/path.c", "furnace, sphere", "stays |= u[i] < chance[i] ?", "stays |= u[i] < chance[i] * 0.9f ?"),
    ("one bounce too many", PATH, "four bounces",
     "p->ends = p->depth >= w->run.plan->max_depth", "p->ends = p->depth > w->run.plan->max_depth"),
    ("one bounce too few", PATH, "four bounces",
     "p->ends = p->depth >= w->run.plan->max_depth", "p->ends = p->depth + 1 >= w->run.plan->max_depth"),
    ("facets hide light that the shading normal faces", "material/kernels/matte.h", "octahedron",
     "(side > 0 ? ~0u : 0) | s->smooth[i]", "(side > 0 ? ~0u : 0)"),
    ("light samples find a sphere's far side, too", SHAPES, "sphere of half",
     "if (view.outside && inside) return 0;", "(void)inside;"),
    ("light's samples forget the chance of the light", EMITTERS, "disk of",
     "answers->density[i] * c->chance[i]", "answers->density[i] * (c->chance[i] > 0 ? 1 : 0)"),
    ("the second triangle of a pair gets no samples", EMITTERS, "box of triangles",
     "face->quad = emitters_is_quad(e, run);", "face->quad = emitters_is_quad(e, run) && !run->paired;"),
    ("a light met by a ray forgets the chance to be asked", EMITTERS, "four kinds",
     "density * emitters_shares(e, p, n)->of[EMITTER_FINITE]", "density"),
    ("the outside met by a ray forgets the chance to be asked", "light/emitters_outside.c", "four kinds",
     "shares->of[EMITTER_OUTSIDE] * light.density[i]", "light.density[i] + 0 * shares->of[0]"),
    ("a light met by a ray forgets what the region sees", EMITTERS, "before a wall",
     "emitters_view(e, p, n), slot)", "NULL, slot)"),
    ("the outside met by a ray forgets the region", "light/emitters_outside.c", "sun and sky through",
     "shares->of[EMITTER_OUTSIDE] * light.density[i]", "e->shares.of[EMITTER_OUTSIDE] * light.density[i] + 0 * shares->of[0]"),
    ("the sun's samples forget the region", EMITTERS, "sun and sky through", "c->shares[i]->of[part]", "e->shares.of[part]"),
    ("the sky met by a ray forgets what surfaces see of it", SKY, "sky through a hole",
     "find_tables(s, lanes, p, view);\n    look_up(", "look_up("),
    ("a region's samples keep the density of the whole sky", SKY, "sky through a hole",
     "const float *sums = s->views + (size_t)table[i] * sky_view_size(s);",
     "const float *sums = s->views + (size_t)(table[i] > SKY_VIEWS ? SKY_VIEWS : table[i]) * sky_view_size(s);"),
    ("the sun forgets the chance to be asked", "light/emitters_outside.c", "four kinds",
     "(float)(chance * sun->chance)", "(float)(chance > 0 ? sun->chance : 0)"),
    ("rays that find a sun's disc count whole", MET, "directional light with",
     ".density = disc.density,", ".density = 0 * disc.density,"),
    ("rough glass loses what facets scatter twice", "material/shader.c", "rough glass",
     "out->glass_again[side] = part * (1 - crosses) * mixture_scale(lost[side]);", "out->glass_again[side] = 0;"),
    ("brushed glass loses what its larger alpha scatters twice", "material/shader.c", "brushed glass",
     "energy_glass_stretched(out->along, out->alpha,", "energy_glass_stretched(out->alpha, out->alpha,"),
    ("brushed glass keeps facets' light as glass of one alpha", "material/kernels/rough_glass.h", "brushed glass",
     "from = smith_of(b, true, i, l[0], l[1], lz);", "from = smith_of(b, false, i, l[0], l[1], lz);"),
    ("the film over a solid's base counts inside, too", "material/kernels/film.h", "partly diffuse",
     "return film > base ? film - base : 0;", "return film;"),
    ("the dielectric over a solid's base counts inside, too", "material/kernels/block.h", "partly diffuse",
     "const float f90 = m->mirror90 - (out->inside[i] && !rough ? m->base_f90 : 0);", "const float f90 = m->mirror90;"),
    ("rough glass takes the missing light of the wrong side", "material/kernels/rough_glass.h", "rough glass",
     "other = at->cross[i] ? !side : side;", "other = side;"),
    ("light that passed a pane counts whole", "material/kernels/shader.c", "pane",
     "out->straight[i] = past ? ~0u : out->pane[i];", "out->straight[i] = past ? ~0u : 0;"),
    ("shadow rays pass panes untinted", "integrate/wave/wave_walk.c", "pane",
     "part[c][i] = b.at[i]->clear ? b.pass_share[c][i] : 0;", "part[c][i] = b.at[i]->clear ? 1 : 0;"),
    ("lamps send 3.1 instead of pi", LAMPS, "point light",
     "(float)SHAPE_PI * (seen->radiance[k][i]", "3.1f * (seen->radiance[k][i]"),
    ("spots have no falloff", LAMPS, "spot light", "(seen->radiance[k][i] * seen->falloff[i])", "seen->radiance[k][i]"),
    ("a lamp's radius changes its light", LAMPS, "point light with a radius", "(double)falloff / (r * r),", "(double)falloff / (3 * r),"),
    ("rays that find a lamp's sphere count whole", LAMPS, "point light with a radius",
     "if (!ray->smooth) disc.density =", "if (ray->smooth) disc.density ="),
    ("rays find no lamps", PATH, "lamp in a mirror", "if (!first && p->shows_lamps)", "if (first && p->shows_lamps)"),
    ("a spot's sphere is as bright from all sides", LAMPS, "spot light in a mirror", "(double)falloff / (r * r),", "1 / (r * r) + 0 * (double)falloff,"),
    ("a volume absorbs no light of lamps in mirrors", MET, "lamp in a mirror and", "= lamp->radiance[c] * left[c];", "= lamp->radiance[c] + 0 * left[c];"),
    ("the light tree chooses with another probability", PICK, "forty", "*chance *= (double)weight[found] / sum;",
     "*chance *= 1.0 / TREE_WIDE + 0 * sum;"),
    ("the choice of a few lights forgets one of them", PICK, "four kinds", "chance[i] = own / sum;",
     "chance[i] = own / (sum - f->weight[0][i] / 2);"),
    ("the light tree tells rays another probability", TREE, "disk of",
     "chance *= sum > 0 ? (double)weight[slot % TREE_WIDE] / sum : 0;",
     "chance *= sum > 0 ? 0.25 * (double)weight[slot % TREE_WIDE] / sum : 0;"),
    ("lists tell rays another probability", TREE, "disk of", "return sum > 0 ? own / sum : 0;",
     "return sum > 0 ? 0.25 * own / sum : 0;"),
    ("lists choose far lights with another probability", PICK, "forty", "*chance *= own / part[near];",
     "*chance *= 1.0 / v->far_count;"),
    ("lists choose the far light before", PICK, "forty", "return v->child[low];",
     "return v->child[low > 0 ? low - 1 : 0];"),
    ("the tree picks the child before", PICK, "forty", "*chance *= (double)weight[found] / sum;\n    return found;",
     "*chance *= (double)weight[found] / sum;\n    return found > 0 && weight[found - 1] > 0 ? found - 1 : found;"),
    ("an environment's blocks are taken evenly along a row", SKY, "spherical harmonics",
     "choose(sums + s->rows + (size_t)row[i] * s->columns, s->columns, &u[i])", "(uint32_t)(u[i] * (float)s->columns)"),
    ("an environment's rows of blocks are taken evenly", SKY, "spherical harmonics",
     "choose(sums, s->rows, &v[i])", "(uint32_t)(v[i] * (float)s->rows)"),
    ("an environment tells rays the density of all directions alike", SKY, "spherical harmonics",
     "s->scales[((size_t)table[i] * s->rows", "s->scales[((size_t)(0 * table[i] + SKY_VIEWS) * s->rows"),
    ("directions by the cosine, density even", SHAPE, "even sky",
     "along > 0 ? along / SHAPE_PI : 0", "along > 0 ? 0.5 / SHAPE_PI : 0"),
    ("a hundredth of a triangle's solid angle lost", SHAPE, "disk of",
     "double angle = 2 * shape_angle(", "double angle = 1.98 * shape_angle("),
    ("directions over a triangle are not even", SHAPE, "disk of", "0.5 * u * s->angle", "0.5 * u * u * s->angle"),
    ("the only triangle loses a hundredth of its solid angle", ONE, "tilted triangle", "2 * angle_of(", "1.98f * angle_of("),
    ("directions over the only triangle are not even", ONE, "tilted triangle", "turn_by(u * s->angle", "turn_by(u * u * s->angle"),
    ("the only quad is twice its first triangle", ONE, "rectangle", "one.angle + two.angle", "one.angle + one.angle"),
    ("a quad is twice its first triangle", "light/kernels/shapes.c", "box of quads",
     "all += other.angle;", "all += first;"),
    ("a sphere's cone is flat", SHAPE, "sphere cut", "square / (1 + sqrt(1 - square))", "square / 2"),
    ("directions over a cone are not even", SHAPE, "sphere above", "x = u * cone->cap", "x = u * u * cone->cap"),
    ("a squeezed sphere's Jacobian lacks a factor", SHAPES, "squeezed", "density * (k * k * k / fabs(", "density * (k * k / fabs("),
    ("a moving lamp is asked where it was as the shutter opened", SHAPES, "lamp that rises",
     "run->instance, time, &out->moved)", "run->instance, 0 * time, &out->moved)"),
    ("a ray that meets a moving lamp asks for the density of another time", MET, "panel that",
     ".time = p->wave.times ? p->wave.times[slot] : 0", ".time = p->wave.times ? 1 - p->wave.times[slot] : 0"),
    ("Lambert's cosine lost", DIFFUSE, "even sky",
     "return chosen(lit, fabsf(z) * (1 / PI), 0);", "return chosen(lit, 1 / PI + 0 * z, 0);"),
    ("photons also start where they leave a sphere", "integrate/caustics/photons.c", "lamp by a mirror",
     "light->direction, i)) > 0)) return false;", "light->direction, i)) > 0) && 0) return false;"),
    ("a cosine's density over 3", DIFFUSE, "even sky",
     "return take * fabsf(z) * (1 / PI);", "return take * fabsf(z) * (1 / 3.0f);"),
    ("light from behind lost", DIFFUSE, "lit from behind",
     "chosen(at->cross[i], b->take[SHADER_TAKE_BEHIND][i], 0)", "chosen(at->cross[i], 0.5f * b->take[SHADER_TAKE_BEHIND][i], 0)"),
    ("GGX without shadowing", FACETS, "GGX", "return d * lz / (2 * (z * from + lz * to));", "return d / (4 * z) + 0 * from;"),
    ("visible normals' density lacks the masking", FACETS, "GGX", "*density = d / (2 * (z + to));", "*density = d / (4 * z);"),
    ("Schlick's power is 4", "math/power.h", "Schlick", "static inline float power5(float x) {",
     "static inline float power5(float x) {\n    return x * x * x * x;"),
    ("Fresnel's parallel part lost", "material/kernels/glass.h", "glass slab",
     "return 0.5f * (parallel * parallel + across * across);", "return 0.48f * parallel * parallel + 0.5f * across * across;"),
    ("Phong's density of another exponent", LOBES, "Phong", "(b->shininess[i] + 1) / (2 * PI * wide)",
     "(b->shininess[i] + 2) / (2 * PI * wide)"),
    ("Blinn's half vector without its Jacobian", LOBES, "Blinn", "4 * (cosine > 0x1p-23f ? cosine : 0x1p-23f)", "4"),
    ("absorption of nine tenths of the way", "integrate/media.c", "absorbing",
     "expf(-s->absorption[c] * length)", "expf(-s->absorption[c] * 0.9f * length)"),
    ("shadow rays stop at what is covered in part", "integrate/wave/wave_walk.c", "coverage", ".hole;", ".hole * 0;"),
    ("shapes that cast no shadow let all light through", "integrate/wave/wave_walk.c", "casts no shadow",
     "FATHOM_CASTS_NO_SHADOW && !sized", "FATHOM_CASTS_NO_SHADOW"),
    ("emission behind sheets counts whole where lights were asked for, too", PATH, "lamp behind",
     "++p->passes[slot];", "++p->passes[slot], p->density[slot] = INFINITY;"),
    ("passing a sheet is a bounce", CARRIED, "sky through", "return p->depth - p->passes[slot];", "return p->depth - 0 * p->passes[slot];"),
    ("refraction scales radiance by the squared index", "material/kernels/block.h", "lamp in",
     "m->cross[c] * open : 0", "m->cross[c] * open / (eta * eta) : 0"),
    ("a leaf keeps what it should let through", DIFFUSE, "leaf lit", "f[c][i] += m->leaf[c] * value;", "f[c][i] += 0.9f * m->leaf[c] * value;"),
    ("fibres lie twice as close", SHEEN, "sheen", "float exponent = 1 / m->sheen_alpha,", "float exponent = 2 / m->sheen_alpha,"),
    ("fibres mask the viewer alone", SHEEN, "sheen", "b->sheen_lambda[i] + sheen_lambda(m, at->l[2][i])",
     "b->sheen_lambda[i] + 0 * sheen_lambda(m, at->l[2][i])"),
    ("fibres by the cosine, density even", "material/kernels/shader.c", "sheen", "float r = sqrtf(u[0][i] * (2 - u[0][i])), cosine, sine;",
     "float r = sqrtf(u[0][i]), cosine, sine;"),
    ("both alphas change places", "material/kernels/stretch.h", "brushed",
     "float ax = b->at[i]->along, ay = b->alpha[i], ratio = ay / ax,", "float ay = b->at[i]->along, ax = b->alpha[i], ratio = ay / ax,"),
    ("anisotropy to the first power", "material/shader.c", "brushed", "m->anisotropy * m->anisotropy", "m->anisotropy * 1"),
    ("a film's light takes no second way", "material/film.c", "thin film", "k <= 2; ++k", "k <= 1; ++k"),
    ("a film of another thickness", "material/film.c", "thin film", "2 * index * thickness * inner * k", "2 * index * thickness * k"),
    ("a film's base loses what Schlick's curve reflects", "material/layers.h", "film over",
     "m->film_again[c] * (1 - all) + rest);", "m->film_again[c] * (1 - all) + 0 * rest);"),
    ("facets of a rough film are taken as seen from the normal", "material/kernels/energy.c", "rough film",
     "place[k] = sqrtf(f.along > 0 ? (f.along < 1 ? f.along : 1) : 0) * ENERGY_FACETS_STEPS;",
     "place[k] = sqrtf(m->v[2] + 0 * f.along) * ENERGY_FACETS_STEPS;"),
    ("all channels of a film keep what the brightest reflects", FILM.replace("kernels/film.h", "film.c"), "film over",
     "c < 3 && !m->multiscatter; ++c", "c < 3; ++c"),
    ("one colour in three counts twice", VOLUMES, "dispersive", "v->shader.channel[i] ? 3 : 0", "v->shader.channel[i] ? 2 : 0"),
    ("red never has its turn", VOLUMES, "dispersive", "(p->pixel[slot] >> 40)) % 3)", "(p->pixel[slot] >> 40)) % 2 + 1)"),
    ("hidden surfaces are seen", VOLUMES, "overlap", "hidden |= 1u << i;", "hidden |= 0u << i;"),
    ("volumes know no index but their own", "integrate/media.c", "two indices that overlap", "*around = other->ior;", "*around = 1;"),
    ("the lower priority wins", "integrate/media.c", "two indices that overlap", "return other->priority <= priority &&", "return other->priority >= priority &&"),
    ("the lower priority fills the space", "integrate/media.c", "one absorbing",
     "priority >= m->shaders[m->in[slot][best]].priority", "priority < m->shaders[m->in[slot][best]].priority"),
    ("a lens of half the radius", "camera/camera.c", "out of focus",
     "out->lens_radius = camera->lens_radius,", "out->lens_radius = camera->lens_radius / 2,"),
]


def build(folder):
    made = subprocess.run(["ninja", "-C", folder, "fathom_cli"], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    return made.stdout[-2000:] if made.returncode else None


# Standard errors. Regions are told apart by many paths, and so in larger renders.
ERROR, ERRORS = "0.002", {"sun and sky through": "0.0005"}


def judge(folder, law):
    command = [folder + "/bin/fathom", "validate", "--light", "--light-error", ERRORS.get(law, ERROR), "-q"]
    return subprocess.run(command + (["--light-only", law] if law else []), stderr=subprocess.DEVNULL).returncode


def read(path):
    with open("src/" + path, encoding="utf-8") as file:
        return file.read()


def misplaced():
    counts = ((path, read(path).count(old), old) for name, path, law, old, new in MUTANTS)
    return [f"src/{path}: expected once, found {count} times: {old}" for path, count, old in counts if count != 1]


def planted(folder, path, law, old, new):
    text = read(path)
    try:
        with open("src/" + path, "w", encoding="utf-8") as file:
            file.write(text.replace(old, new))
        problem = build(folder)
        return problem if problem else judge(folder, law)
    finally:
        with open("src/" + path, "w", encoding="utf-8") as file:
            file.write(text)


def main(folder=None, laws="named", only=""):
    missed = misplaced()
    if missed or not folder:
        sys.exit("\n".join(missed) or 0)
    for name, path, law, old, new in MUTANTS:
        if only not in name:
            continue
        result = planted(folder, path, law if laws == "named" else None, old, new)
        if isinstance(result, str):
            sys.exit(f"{name}: does not build\n{result}")
        print(f"found  {name}" if result == 1 else f"MISSED {name}: exit code {result}", flush=True)
        if result != 1:
            missed.append(name)
    problem = build(folder)
    if problem:
        sys.exit(problem)
    print(f"{len(missed)} faults missed")
    return 1 if missed else 0


sys.exit(main(*sys.argv[1:]))
