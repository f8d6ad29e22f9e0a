/* Materials for path tracing: BSDFs that are evaluated and sampled for sixteen points at a time.
 *
 * Densities are per solid angle and cover all lobes. A smooth lobe (mirror, clear glass) samples a single
 * direction, which has no finite density: the sample gets the density INFINITY, and evaluate() leaves smooth
 * lobes out. Directions l and v point away from the surface.
 *
 * Sides. n is the shading normal, or the geometric normal if the viewer is below the shading normal's
 * horizon. Light is reflected if l·n > 0 and l·ng > 0, and is transmitted if both are < 0; any other
 * direction carries no light, in evaluate() and in sample(). If a normal map rotated n, the same condition
 * also holds for the normal without the map (`base` in surface/surface.h), and where n mirrors the viewer
 * below that normal's horizon, rough lobes take the nearest normal towards `base` that does not (lift_by() in
 * kernels/block.h); Lambert's cosine stays that of the map's normal. Smooth lobes follow MODEL.md: they
 * scatter about the geometric normal if the shading normal would send them through the surface.
 *
 * metallicRoughness. With m = metallic, c = baseColor, s = specular, T = transmission, F0 = s min(1, ((ior -
 * 1) / (ior + 1))^2 specularColor), h the half vector, S(f0, f90) = f0 + (f90 - f0) (1 - v·h)^5, L =
 * S(largest channel of F0, s), D the GGX distribution, G2 the height-correlated Smith masking and shadowing:
 *
 *   f = (m S(c, 1) + (1 - m) S(F0, s)) D G2 / (4 n·v n·l) + (1 - m) (1 - L) c ((1 - T) / pi + T t)
 *
 * t is the transmission term. thickness 0 is a thin wall: t is the reflection term D G2 / (4 n·v n·l) with l
 * mirrored to the viewer's side. thickness > 0 bounds a solid: t is the refraction term of Walter et al.
 * (2007). Radiance is divided by the squared index of its medium: refraction does not scale it, and a viewer
 * outside sees the emission inside glass unscaled. In the denser medium, the dielectric's S uses the angle on
 * the other side, and total reflection has S = f90; the metal's S keeps its own angle. Lobes whose facets
 * deflect transmitted light by less than 2^-13 radians (alpha min(|ior - 1|, 1)) transmit smoothly; rough
 * ones whose index differs from 1 by less than 2^-13 transmit straight.
 *
 * `multiscatter` adds the light that leaves the facets after more than one scattering (Kulla & Conty 2017);
 * the added terms are reciprocal. With E(mu) the albedo of D G2 / (4…) and <> the cosine-weighted mean: metal
 * and dielectric add Q (1 - E(n·v)) (1 - E(n·l)) / (pi <1 - E>), with Q = <S>^2 <E> / (1 - <S> (1 - <E>)) and
 * <S> = f0 + (f90 - f0) / 21. Thin walls transmit (1 - m) T c (1 - Q) times the same factor, with the
 * dielectric's Q. The base below has the weight (1 - R(n·v)) (1 - R(n·l)) / <1 - R> instead of 1 - L, with R
 * the dielectric's albedo over all orders of scattering.
 *
 * Rough glass: with A the dielectric's albedo in D G2 / (4…) and refraction together, for c = 1, M = 1 - A,
 * and i and o for the viewer's and the other side, (1 - m) T (1 - q) M_i(v) M_i(l) / (pi <M_i>) is added to
 * the reflected light and (1 - m) T c q M_i(v) M_o(l) / (pi <M_o>) to the transmitted light, instead of the
 * dielectric's Q. q = <1 - L> <M_o> / max(<M_i>, <M_o>) makes both reciprocal: <1 - L> is the mean light that
 * a smooth surface transmits to the viewer's side, 1 / eta^2 times as much on the side of the denser medium.
 * A of anisotropic glass depends on the azimuth, too. A of glass with a film is that of Schlick's reflectance
 * with the film's mean over the channels at normal incidence: up to 2 % of the light is lost or gained.
 *
 * White materials therefore reflect and transmit all light.
 *
 * A clear coat of strength k = clearcoat, index 1.5 and its own roughness lies over all of this: k S(0.04, 1)
 * D G2 / (4 n·v n·l) is added, and all else is multiplied by C(n·v) C(n·l), where C(mu) is 1 - k times the
 * coat's albedo. With `multiscatter`, Lambert's term is divided by <(1 - R) C> instead of <1 - R>; the other
 * lobes lose the light that the coat reflects back down.
 *
 * A coat over a normal map, or with one, has a normal of its own (KHR_materials_clearcoat): its cosines use
 * this normal, and it is never a mirror but a lobe with an alpha of at least SHADER_SMOOTH_ALPHA. If this
 * normal would mirror the viewer to a direction behind the surface, the coat takes the surface's normal
 * without a map, or the geometric normal if that fails as well. The coat reflects light that is above its own
 * horizon, above that of the surface without a map and above the geometric one; the mapped normal of the
 * layers below it does not count.
 *
 * Fibres (KHR_materials_sheen) lie between these lobes and the coat: sheenColor D / (4 n·v n·l (1 + Λ(v) +
 * Λ(l))) with α = max(sheenRoughness, 0.07)², see kernels/sheen.h. All lobes below are multiplied by
 * min(s(n·v), s(n·l)), s(mu) = 1 - max(sheenColor) E(mu), E the fibres' albedo: some light between fibres and
 * base is lost, but none is gained. If E > 1, the fibres are multiplied by the smaller 1 / E of both
 * directions.
 *
 * anisotropy: GGX's alpha is mix(α, 1, anisotropy²) along the tangent, rotated by anisotropyRotation, and
 * α across it; surfaces without texture coordinates take an arbitrary tangent. iridescence: S is mixed
 * with the reflectance of a thin film on it (film.c), of dielectric and metal each by itself. The film's
 * largest channel does not reach the base. With `multiscatter`, the film takes from each channel of the
 * base what it reflects in that channel: L, R and <S> are those of the channel, so a white base returns
 * all light. The base then shows the complementary colour of the film's reflection, and under an even sky
 * a film on white is invisible. R is Schlick's part by the azimuth and the film's difference from it as a
 * mean over the azimuth (energy_facets()).
 *
 * diffuseTransmission moves this fraction of Lambert's lobe to the other side, with its own colour: the same
 * in both directions, for thin walls and for solids.
 *
 * dispersion: the three channels refract with the indices ior - d, ior and ior + d, d = 0.025 (ior - 1)
 * dispersion, each at least 1.0001. A path that crosses such a surface carries one channel from then on,
 * multiplied by three (integrate/path/path.c). Between two volumes, each index is the quotient of theirs. F0
 * uses ior; angles, and therefore total reflection, use the channel's own index.
 *
 * Viewed from inside a solid, the base has no layer over it: the dielectric's reflection has the weight (1
 * - m) T, and Lambert's term has no factor. With the layer, total reflection and the base together would
 * reflect more than all light. Solids with a film count as viewed from outside.
 *
 * opacity is coverage: a smooth lobe passes light straight through the surface, and all else is multiplied by
 * opacity. */
#pragma once

#include "material/energy.h"
#include "scene/scene.h"
#include "surface/surface.h"

/* GGX lobes with a smaller alpha are mirrors. Unit vectors in float give the slope of a half vector to
 * 2^-23, so at this alpha the distribution is exact to 2 * 2^-23 / 2^-13 = 0.2 %. The lobe is then 2^-13
 * radians wide: less than a pixel if 8,000 pixels span a right angle. */
#define SHADER_SMOOTH_ALPHA 0x1p-13f

/* Curves of films have nodes at cosines (k / FILM_STEPS)^2, and are cubic in the cosine's square root
 * between nodes. */
enum { FILM_STEPS = 64 };

/* A material's constants, made once before rendering. */
typedef struct shader {
    fathom_model model;
    float emission[3];   /* radiance of both sides, times opacity */
    float albedo[3];     /* for the AOV: approximate fraction of white light that is reflected or transmitted;
                            not times opacity, because AOVs do not count paths that pass a hole */
    float absorption[3]; /* per unit of length, of the enclosed volume: -ln(colour) / distance; else 0 */
    bool transmits;      /* some lobe transmits light to the other side */
    bool encloses;       /* transmitted light enters or leaves a volume; false for a thin wall */
    bool clear;          /* light that it transmits goes straight through: a smooth thin wall, or classic
                            glass of index 1 */
    bool one_sided;      /* the camera looks through its back */
    /* Only kernels use the members below. */
    uint32_t lobes;                /* SHADER_ bits */
    float diffuse[3];              /* Lambert's reflectance; with SHADER_EVEN divided by mean_under */
    float highlight[3], shininess; /* classic */
    float k_r[3], k_t[3], ior;     /* classic; ior: of either model */
    uint32_t blinn, fresnel;       /* all ones or 0; blinn: the highlight is Blinn's */
    uint32_t from_behind, even;    /* the same; even: with SHADER_EVEN */
    float alpha, f0[3], f90;       /* of the GGX lobe, dielectric and metal mixed */
    float mirror0[3], mirror90;    /* the same if the lobe is a mirror */
    float layer0, layer90; /* of the dielectric alone: the light it reflects does not reach the base */
    float cross[3];        /* transmittance of the base */
    float eta;             /* index inside divided by outside; 1: a thin wall */
    float again[3], again_cross[3]; /* factors of light that scatters more than once between facets */
    float coat, coat_alpha;         /* strength of the clear coat; its GGX lobe's alpha */
    float hole;                     /* 1 - opacity; the other factors are multiplied by opacity */
    float missing_share;            /* fraction of `missing` that is reflected */
    energy_curve facets;            /* albedos of the GGX lobe, unless it is anisotropic */
    energy_curve coat_facets;       /* of the clear coat */
    float coat_strength;            /* as `coat`, but not multiplied by opacity */
    float leaf[3];     /* Lambert's reflectance for light from the other side; divided as `diffuse` */
    float along;       /* alpha along the tangent; `alpha` is across it */
    float layer_again; /* fraction of the light scattered more than once that the layer reflects */
    float mean_under;  /* with SHADER_EVEN: the mean of `under`, divisor of diffuse and leaf; else 1 */
    uint32_t priority; /* of the volume where volumes overlap; 0: none */
    float eta_spread;  /* difference of eta between neighbouring channels, for dispersion */
    float sheen[3], sheen_most, sheen_alpha;
    /* With SHADER_SOLID: the dielectric over the base; its share of f0, f90 (or mirror0, mirror90) and again.
     * Under a film base_f90 is the base's weight. */
    float base_f0[3], base_f90, base_again[3];
    float metal_rise[3]; /* with SHADER_INNER_METAL: m (1 - c), the metal's contribution to f90 - f0 */
    /* The members from here on are set only if the lobes need them. */
    energy_stretch stretch;
    /* With SHADER_GLASS, viewed from outside and from inside: M, or its mean over the azimuth. */
    float glass_missing[2][ENERGY_NODES];
    energy_glass_stretch glass_stretch;            /* with SHADER_GLASS and SHADER_STRETCHED: M */
    float glass_part, glass_through[2];            /* the glass's weight; fraction of M that crosses: q */
    float glass_again[2], glass_again_cross[2][3]; /* factors of M(v) M(l) */
    float glass_sums[2][ENERGY_NODES];             /* of M, to sample it: see energy_sums() */
    float sheen_fit[6];                            /* of Λ; see kernels/sheen.h */
    float sheen_albedo[ENERGY_NODES];
    /* By channel: what the film reflects, and the fraction that does not reach the base; see layer_of(). */
    float film[3][FILM_STEPS + 1], film_kept[3][FILM_STEPS + 1];
    /* With SHADER_FILM and SHADER_EVEN: R of the layer, see film_under(); lift: 1 / the mean of 1 - R. */
    float film_low[3], film_high, film_again[3], film_lift[3], film_rest[3][FILM_STEPS + 1];
} shader;

enum {
    SHADER_DIFFUSE = 1u << 0,
    SHADER_HIGHLIGHT = 1u << 1, /* Phong's or Blinn's */
    SHADER_LAYER = 1u << 2,     /* a dielectric over the diffuse base */
    SHADER_GGX = 1u << 3,       /* rough reflection */
    SHADER_MIRROR = 1u << 4,    /* the same with an alpha below SHADER_SMOOTH_ALPHA */
    SHADER_CLASSIC = 1u << 5,   /* k_r or k_t */
    SHADER_THIN = 1u << 6,      /* rough transmission through a thin wall */
    SHADER_REFRACT = 1u << 7,   /* rough refraction */
    SHADER_PASS = 1u << 8,      /* smooth transmission of either kind */
    SHADER_SOLID = 1u << 9,     /* inside and outside have different indices */
    SHADER_EVEN = 1u << 10,     /* multiple scattering between facets is compensated */
    SHADER_BEHIND = 1u << 11,   /* classic: lit from behind */
    SHADER_STRAIGHT = 1u << 12, /* an opacity below 1 */
    SHADER_COATED = 1u << 13,   /* there is a clear coat, which attenuates all other lobes */
    SHADER_COAT = 1u << 14,     /* a rough clear coat; a smooth one is part of SHADER_MIRROR */
    SHADER_SHEEN = 1u << 15,
    SHADER_STRETCHED = 1u << 16,   /* GGX has two alphas */
    SHADER_FILM = 1u << 17,        /* reflectances include a thin film */
    SHADER_LEAF = 1u << 18,        /* diffuse transmission */
    SHADER_DISPERSIVE = 1u << 19,  /* refraction depends on the channel */
    SHADER_TURNED = 1u << 20,      /* the clear coat has a normal of its own */
    SHADER_INNER_METAL = 1u << 21, /* the surface of a solid is partly metal */
    SHADER_GLASS =
        1u << 22, /* multiple scattering by rough glass is compensated: see kernels/rough_glass.h */
    SHADER_RARE = SHADER_FILM | SHADER_STRETCHED | SHADER_INNER_METAL, /* reflection needs more constants */
};

/* shader_under: the fraction 1 - R(mu) that the layer transmits to the base, from its facets' albedos at
 * mu. shader_below_coat: the fraction that the clear coat transmits at node k of the curves, 1 without a
 * coat. */

static inline float shader_under(const shader *m, float all, float edge) {
    return 1 - (m->layer0 * (all - edge) + m->layer90 * edge + m->layer_again * (1 - all));
}
static inline float shader_below_coat(const shader *m, int k) {
    const float all = energy_all(&m->coat_facets, k), edge = energy_edge(&m->coat_facets, k);
    return 1 - m->coat_strength * (0.04f * (all - edge) + edge);
}

/* True for a clear coat over a normal map, or with its own normal map. */
bool shader_coat_has_normal(const fathom_material *material);
void shader_prepare(const fathom_material *material, shader *out);
/* A fully transparent surface: rays pass straight through. */
void shader_prepare_hole(shader *out);
/* The index of the volume that the material bounds, for a channel of its light, 1 to 3. */
float shader_index(const shader *m, uint32_t channel);
/* shader.emission alone. */
void shader_emission(const fathom_material *material, float out[3]);

/* Lobes that sample() chooses from. */
enum {
    SHADER_TAKE_DIFFUSE, /* proportional to the cosine */
    SHADER_TAKE_BEHIND,  /* as DIFFUSE, on the other side */
    SHADER_TAKE_HIGHLIGHT,
    SHADER_TAKE_GGX,
    SHADER_TAKE_CROSS, /* rough transmission */
    SHADER_TAKE_COAT,
    SHADER_TAKE_SHEEN,
    SHADER_TAKE_MIRROR,
    SHADER_TAKE_PASS,     /* smooth transmission */
    SHADER_TAKE_STRAIGHT, /* straight through the surface */
    SHADER_TAKES
};

/* The BSDFs of a block of points: the data of materials and viewer that evaluate() and sample() need. */
typedef struct shader_block {
    _Alignas(64) lanes3 t; /* t, b and n are a right-handed frame */
    lanes3 b, n;
    lanes3 v;                        /* towards the viewer, in that frame; v[2] > 0 */
    float take[SHADER_TAKES][LANES]; /* probabilities of the lobes */
    const shader *at[LANES];         /* the materials */
    /* Constants of the materials; constants that no lane's lobes read are not set. */
    lanes3 diffuse, highlight, f0, cross, again, again_cross;
    lanes3 mirror_share, pass_share; /* weights of the smooth lobes */
    lanes3 mirror, pass;             /* their directions, in world space */
    float shininess[LANES], alpha[LANES], f90[LANES], layer0[LANES], layer90[LANES];
    float eta[LANES]; /* index of the side away from the viewer divided by that of the viewer's side */
    float missing[LANES], under[LANES], below_coat[LANES]; /* at the viewer's cosine */
    float coat[LANES], coat_alpha[LANES];
    float below_sheen[LANES], sheen_part[LANES], sheen_lambda[LANES]; /* at the viewer's cosine */
    uint32_t blinn[LANES], from_behind[LANES], even[LANES];
    uint32_t inside[LANES];  /* all ones: the viewer is inside a solid, whose base has no layer; else 0 */
    lanes3 coat_axes[3];     /* with SHADER_TURNED: the coat's frame in the block's frame; [2] is the coat's
                                normal */
    lanes3 coat_v;           /* v in the coat's frame */
    lanes3 film_under;       /* with SHADER_FILM: `under` by channel, where `under` is only an estimate */
    uint32_t lobes;          /* of all lanes */
    uint32_t channel[LANES]; /* of the path, 1 to 3, or 0 for all; read if some material is dispersive */
} shader_block;

/* One direction per lane that continues a path. */
typedef struct shader_sample {
    _Alignas(64) lanes3 direction; /* unit */
    lanes3 weight; /* f |cosine| / density: factor of the radiance along the ray; 0: the path ends (absorbed,
                      or the direction is not on the side of its lobe) */
    float density[LANES];     /* INFINITY for a smooth lobe */
    uint32_t through[LANES];  /* all ones: the ray leaves on the side away from the viewer; else 0 */
    uint32_t straight[LANES]; /* all ones: straight through, as if the surface were absent; `through` is set,
                                 too */
    uint32_t pane[LANES];     /* if straight: all ones: through a clear thin wall; 0: through a hole */
} shader_sample;

typedef struct shader_kernels {
    /* The caller sets out->at, and out->channel if it is read. */
    void (*make)(const surface_block *s, shader_block *out);

    /* For light from unit directions l: f |cosine|, and the density with which sample() chooses l. */
    void (*evaluate)(const surface_block *s, const shader_block *b, const lanes3 l, float (*f)[LANES],
                     float density[LANES]);

    /* u: three numbers in [0,1) per lane; the third chooses the lobe. */
    void (*sample)(const surface_block *s, const shader_block *b, const lanes3 u, shader_sample *out);
} shader_kernels;

const shader_kernels *shader_kernels_best(void);
