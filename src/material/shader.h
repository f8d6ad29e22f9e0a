/* Materials under path tracing: BSDFs that are evaluated and sampled, sixteen points at a time.
 *
 * The density of a direction is counted per solid angle, over all lobes. A direction that a smooth lobe
 * (mirror, clear glass) chooses has no density: it is marked by an infinite one, and evaluate() leaves such
 * lobes out. Directions l and v point away from the surface.
 *
 * Sides. n is the shading normal, or the geometric one where the viewer is below the shading normal's
 * horizon. Light is reflected where l·n > 0 and l·ng > 0, and crosses the surface where both are < 0; any
 * other direction carries nothing, in evaluate() and in sample(). Where a normal map has turned n, light has
 * to be on the same side of the normal without the map as well (`base` in surface/surface.h). Smooth lobes
 * follow MODEL.md, which scatters them about the geometric normal where the shading normal would send them
 * through the surface.
 *
 * metallicRoughness. With m = metallic, c = baseColor, s = specular, T = transmission, F0 = s min(1, ((ior -
 * 1) / (ior + 1))^2 specularColor), h the half vector, S(f0, f90) = f0 + (f90 - f0) (1 - v·h)^5, L = S of the
 * largest channel of F0 and of s, D GGX, G2 height-correlated Smith:
 *
 *   f = (m S(c, 1) + (1 - m) S(F0, s)) D G2 / (4 n·v n·l) + (1 - m) (1 - L) c ((1 - T) / pi + T t)
 *
 * t transmits. thickness 0 is a thin wall: t is the reflecting D G2 / (4 n·v n·l) of l mirrored to the
 * viewer's side. thickness > 0 bounds a solid: t is Walter et al.'s (2007) refraction. Radiance counts
 * over the squared index of the medium that it is in, so that refraction does not scale it, and emission
 * inside glass is what a viewer outside sees. In the denser medium, the dielectric's S takes the angle of the
 * other side, and total reflection has S = f90; the metal's S keeps its own. Lobes whose facets turn
 * transmitted light by less than 2^-13 radians (alpha |ior - 1|) transmit smoothly.
 *
 * `multiscatter` gives back what leaves the facets after more scatterings (Kulla & Conty 2017), reciprocally.
 * With E(mu) the albedo of D G2 / (4…) and <> the mean over the cosine: metal and dielectric get
 * Q (1 - E(n·v)) (1 - E(n·l)) / (pi <1 - E>), Q = <S>^2 <E> / (1 - <S> (1 - <E>)) and <S> = f0 + (f90 - f0) /
 * 21; thin walls transmit (1 - m) T c (1 - Q) of the same. The base below gets, in place of 1 - L, (1 -
 * R(n·v)) (1 - R(n·l)) / <1 - R>, R the dielectric's albedo with all its scatterings. So white materials that
 * are no rough solids reflect and transmit everything. Refraction through rough solids gets nothing back, and
 * the base is as without `multiscatter` for a viewer inside.
 *
 * A clear coat of strength k = clearcoat, index 1.5 and its own roughness lies over all of this: k S(0.04, 1)
 * D G2 / (4 n·v n·l) is added, and all else counts by C(n·v) C(n·l), C(mu) being 1 - k times the coat's
 * albedo. With `multiscatter`, Lambert's part is over <(1 - R) C> instead of <1 - R>; the others lose what
 * goes round under the coat.
 *
 * A coat over a normal map, or with one, has a normal of its own (KHR_materials_clearcoat): its cosines are
 * those, and it is no mirror but a lobe of SHADER_SMOOTH_ALPHA at least. Where that normal would mirror the
 * viewer to behind the surface, the coat takes the normal of the surface without a map, or the geometric one
 * where that would, too. It reflects light that is above its own horizon, the surface's without a map and the
 * geometric one; the mapped normal of what it covers does not count.
 *
 * Fibres (KHR_materials_sheen) lie between these and the coat: sheenColor D / (4 n·v n·l (1 + Λ(v) + Λ(l)))
 * with α = max(sheenRoughness, 0.07)², see kernels/sheen.h. All below counts by min(s(n·v), s(n·l)), s(mu) =
 * 1 - max(sheenColor) E(mu), E the fibres' albedo: light between fibres and base is lost, none is gained.
 * Where E > 1 the fibres count by the smaller 1 / E of both directions.
 *
 * anisotropy: GGX's alpha is mix(α, 1, anisotropy²) along the tangent, turned by anisotropyRotation, and α
 * across it; surfaces without texture coordinates take any tangent. iridescence: S is mixed with the
 * reflectance of a thin film on it (film.c), whose largest channel does not reach the base; where the base
 * gets 1 - R, R is that of a layer that reflects at least as much as the film at every angle.
 *
 * diffuseTransmission moves that part of Lambert's lobe to the other side, with its own colour: the same
 * both ways, for a thin wall as for a solid.
 *
 * dispersion: refraction of the three channels by ior - d, ior and ior + d, d = 0.025 (ior - 1) dispersion,
 * but no less than 1.0001. A path that crosses such a surface carries one of them from then on, three times
 * (integrate/path.c). F0 is that of ior; angles, and with them total reflection, are the channel's own.
 *
 * opacity is coverage: a smooth lobe takes light straight past the surface, and all else counts by opacity.
 */
#ifndef MATERIAL_SHADER_H
#define MATERIAL_SHADER_H

#include "material/energy.h"
#include "scene/scene.h"
#include "surface/surface.h"

/* GGX lobes of a smaller alpha are mirrors. Unit vectors of floats give the slope of a half vector to 2^-23,
 * so at this alpha the distribution is known to 2 * 2^-23 / 2^-13 = 0.2 %. The lobe is then 2^-13 radians
 * wide: less than a pixel, where 8,000 of them see a right angle. */
#define SHADER_SMOOTH_ALPHA 0x1p-13f

/* Curves of films are given at cosines (k / FILM_STEPS)^2, and cubic in its root between. */
enum { FILM_STEPS = 64 };

/* A material's constants, made once before rendering. */
typedef struct shader {
    fathom_model model;
    float emission[3];   /* radiance of both sides, times the part of the surface that is there */
    float albedo[3];     /* for the AOV: what it reflects or lets through of white light, about */
    float absorption[3]; /* per unit of length, of the volume that the surface encloses: -ln c / d; else 0 */
    bool transmits;      /* some lobe sends light to the other side */
    bool encloses;       /* what it transmits enters or leaves a volume; a thin wall has none */
    /* The members below are the kernels' own. */
    uint32_t lobes;                 /* SHADER_ bits */
    float diffuse[3];               /* Lambert's reflectance; with SHADER_EVEN over the mean of `under` */
    float highlight[3], shininess;  /* classic */
    float k_r[3], k_t[3], ior;      /* classic; ior: of either model */
    uint32_t blinn, fresnel;        /* all ones or 0; highlights are Phong's or Blinn's */
    uint32_t from_behind, even;     /* the same; even: with SHADER_EVEN */
    float alpha, f0[3], f90;        /* of the GGX lobe, dielectric and metal mixed */
    float mirror0[3], mirror90;     /* the same where the lobe is a mirror */
    float layer0, layer90;          /* of the dielectric alone: what it reflects does not reach the base */
    float cross[3];                 /* transmittance of the base */
    float eta;                      /* inside over outside; 1: a thin wall */
    float again[3], again_cross[3]; /* factors of light that scatters more than once between facets */
    float coat, coat_alpha;         /* strength of the clear coat; its GGX lobe's alpha */
    float hole;                     /* 1 - opacity; the other factors are times opacity */
    float missing_share;            /* of `missing`, what is reflected */
    energy_curve facets;            /* albedos of the GGX lobe, unless stretched */
    energy_curve coat_facets;       /* of the clear coat */
    float coat_strength;            /* as `coat`, but not times opacity */
    float leaf[3];                  /* Lambert's reflectance of light from the other side; as `diffuse` */
    float along;                    /* alpha along the tangent; `alpha` is across it */
    float layer_again;              /* what the layer reflects of light that scatters more than once */
    float mean_under;  /* with SHADER_EVEN: the mean of `under` that diffuse and leaf are over; else 1 */
    uint32_t priority; /* of the volume; 0: it takes no part */
    float eta_spread;  /* of dispersion, between neighbouring channels */
    float sheen[3], sheen_most, sheen_alpha;
    float metal_rise[3]; /* with SHADER_INNER_METAL: m (1 - c), the metal's part of f90 - f0 */
    /* From here on set only where the lobes have a use for it. */
    energy_stretch stretch;
    float sheen_fit[6]; /* of Λ; see kernels/sheen.h */
    float sheen_albedo[ENERGY_NODES];
    float film[4][FILM_STEPS + 1]; /* reflectances by channel, and what does not reach the base */
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
    SHADER_EVEN = 1u << 10,     /* scattering between facets is given back */
    SHADER_BEHIND = 1u << 11,   /* classic: lit from behind */
    SHADER_STRAIGHT = 1u << 12, /* an opacity below 1 */
    SHADER_COATED = 1u << 13,   /* all but the clear coat passes through it */
    SHADER_COAT = 1u << 14,     /* a rough clear coat; a smooth one is part of SHADER_MIRROR */
    SHADER_SHEEN = 1u << 15,
    SHADER_STRETCHED = 1u << 16,   /* GGX has two alphas */
    SHADER_FILM = 1u << 17,        /* reflectances are those of a thin film */
    SHADER_LEAF = 1u << 18,        /* diffuse transmission */
    SHADER_DISPERSIVE = 1u << 19,  /* refraction depends on the channel */
    SHADER_TURNED = 1u << 20,      /* the clear coat has a normal of its own */
    SHADER_INNER_METAL = 1u << 21, /* metal is a part of a solid's surface */
    SHADER_RARE = SHADER_FILM | SHADER_STRETCHED | SHADER_INNER_METAL, /* reflection takes more constants */
};

/* What the layer lets through to the base, 1 - R(mu), of its facets' albedos there; and what the clear coat
 * lets through at node k of the curves, 1 without one. */

static inline float shader_under(const shader *m, float all, float edge) {
    return 1 - (m->layer0 * (all - edge) + m->layer90 * edge + m->layer_again * (1 - all));
}
static inline float shader_below_coat(const shader *m, int k) {
    const float all = energy_all(&m->coat_facets, k), edge = energy_edge(&m->coat_facets, k);
    return 1 - m->coat_strength * (0.04f * (all - edge) + edge);
}

/* A clear coat over a normal map, or with one. */
bool shader_coat_has_normal(const fathom_material *material);
void shader_prepare(const fathom_material *material, shader *out);
/* The part of it that is the same for all materials: emission, and no lobes. */
void shader_begin(const fathom_material *material, shader *out);
/* A surface that is not there: rays pass straight. */
void shader_prepare_hole(shader *out);
/* shader.emission alone. */
void shader_emission(const fathom_material *material, float out[3]);

/* Lobes that sample() chooses from. */
enum {
    SHADER_TAKE_DIFFUSE, /* by the cosine */
    SHADER_TAKE_BEHIND,  /* the same on the other side */
    SHADER_TAKE_HIGHLIGHT,
    SHADER_TAKE_GGX,
    SHADER_TAKE_CROSS, /* rough transmission */
    SHADER_TAKE_COAT,
    SHADER_TAKE_SHEEN,
    SHADER_TAKE_MIRROR,
    SHADER_TAKE_PASS,     /* smooth transmission */
    SHADER_TAKE_STRAIGHT, /* past the surface */
    SHADER_TAKES
};

/* The BSDFs of a block of points: what evaluate() and sample() need of the materials and the viewer. */
typedef struct shader_block {
    _Alignas(64) lanes3 t; /* with b and n a right-handed frame */
    lanes3 b, n;
    lanes3 v;                        /* towards the viewer, in that frame; v[2] > 0 */
    float take[SHADER_TAKES][LANES]; /* chances of the lobes */
    const shader *at[LANES];         /* the materials */
    /* Constants of the materials; those that no lane's lobes read are not set. */
    lanes3 diffuse, highlight, f0, cross, again, again_cross;
    lanes3 mirror_share, pass_share; /* of the smooth lobes */
    lanes3 mirror, pass;             /* their directions, in the world */
    float shininess[LANES], alpha[LANES], f90[LANES], layer0[LANES], layer90[LANES];
    float eta[LANES]; /* of the side that the viewer is not on over that of the viewer */
    float missing[LANES], under[LANES], below_coat[LANES]; /* at the viewer's cosine */
    float coat[LANES], coat_alpha[LANES];
    float below_sheen[LANES], sheen_part[LANES], sheen_lambda[LANES]; /* at the viewer's cosine */
    uint32_t blinn[LANES], from_behind[LANES], even[LANES];
    lanes3 coat_axes[3];     /* with SHADER_TURNED: the coat's frame, z its normal, in that of the block */
    lanes3 coat_v;           /* v in it */
    uint32_t lobes;          /* of all lanes */
    uint32_t channel[LANES]; /* of the path, 1 to 3, or 0; read where some material is dispersive */
} shader_block;

/* One direction a lane that continues a path. */
typedef struct shader_sample {
    _Alignas(64) lanes3 direction; /* unit */
    lanes3 weight; /* f |cosine| / density: what radiance along the ray counts at the point; 0: the path
                      ends (absorbed, or the direction left the side it was meant for) */
    float density[LANES];     /* INFINITY: a smooth lobe's */
    uint32_t through[LANES];  /* all ones: the ray leaves on the side that the viewer is not on; else 0 */
    uint32_t straight[LANES]; /* all ones: past the surface, as if it were not there; through is set, too */
} shader_sample;

typedef struct shader_kernels {
    /* out->at is set, and out->channel where it is read. */
    void (*make)(const surface_block *s, shader_block *out);

    /* For light from unit directions l: f |cosine|, and the density with which sample() takes l. */
    void (*evaluate)(const surface_block *s, const shader_block *b, const lanes3 l, float (*f)[LANES],
                     float density[LANES]);

    /* u: three numbers in [0,1) a lane; the third chooses the lobe. */
    void (*sample)(const surface_block *s, const shader_block *b, const lanes3 u, shader_sample *out);
} shader_kernels;

const shader_kernels *shader_kernels_best(void);
/* Those that this processor can run, from the plainest to the best; NULL past the last. */
const shader_kernels *shader_kernels_at(unsigned index);

#endif
