/* Settings and material parameters by name. One table lists all settings, and one the parameters of each
 * material model. All code that reads, checks, prints or saves them follows these tables. */
#ifndef FATHOM_PARAMETER_H
#define FATHOM_PARAMETER_H

#include <fathom/render.h>

#ifdef __cplusplus
extern "C" {
#endif

/* The type of the member. */
typedef enum fathom_parameter_type {
    FATHOM_PARAMETER_BOOL,
    FATHOM_PARAMETER_U32,
    FATHOM_PARAMETER_U64,
    FATHOM_PARAMETER_F32,
    FATHOM_PARAMETER_F64,
    FATHOM_PARAMETER_WORD,  /* an enum: the index of its word in `words` */
    FATHOM_PARAMETER_WORDS, /* unsigned: a bit for each word of `words` */
    FATHOM_PARAMETER_TEXT   /* const char *, or NULL */
} fathom_parameter_type;

enum {
    FATHOM_PARAMETER_PIXELS = 1u << 0,    /* pixels depend on it: part of checkpoint keys and image headers */
    FATHOM_PARAMETER_SWITCH = 1u << 1,    /* pixels depend only on whether it is 0 */
    FATHOM_PARAMETER_FILE = 1u << 2,      /* scene JSON may have it */
    FATHOM_PARAMETER_COMMAND = 1u << 3,   /* `fathom render` has an option of its name */
    FATHOM_PARAMETER_OPEN_LOW = 1u << 4,  /* `low` itself is out of range */
    FATHOM_PARAMETER_OPEN_HIGH = 1u << 5, /* so is `high` */
    FATHOM_PARAMETER_SOFT = 1u << 6 /* only scene JSON enforces the range; other callers may give any finite
                                       number: > 0 if `low` is, and >= 0 if `low` is 0 */
};

typedef struct fathom_parameter {
    const char *name; /* of the member: "max_depth"; "specular" of specular_factor */
    fathom_parameter_type type;
    size_t offset;     /* of the member in its struct */
    unsigned flags;    /* FATHOM_PARAMETER_ bits */
    double low, high;  /* of each number; `high` may be infinite; for words, `high` is what "all" means */
    double fallback;   /* the default: a number, 0 or 1, a word's place, bits; texts are NULL */
    const char *unit;  /* what a value is, for help: "SECONDS", "X0,Y0,X1,Y1" */
    const char *group; /* heading under which help lists it */
    const char *help;  /* sentences; names of other keys stand between `backquotes` */
    unsigned count;    /* numbers in the member; 0: one */
    unsigned step;     /* the number is a multiple of it; 0: any */
    const char *words; /* "grid|stratified|sobol"; of numbers, the only ones allowed: "1|4|8|16"; or NULL */
    const char *zero;  /* the word for 0, such as "off" or "auto"; the number 0 is then allowed outside of the
                          range, too, but not its text "0". Or NULL */
} fathom_parameter;

/* All members of fathom_settings, and those of fathom_material that a model has. Returns the first; *count
 * says how many. */
FATHOM_API const fathom_parameter *fathom_settings_parameters(size_t *count);
FATHOM_API const fathom_parameter *fathom_material_parameters(fathom_model model, size_t *count);

/* Settings by name, as text: "16", "0,0,640,360", "sobol", "Z,N", "true", "auto". FATHOM_BAD_USAGE when there
 * is no such setting, FATHOM_BAD_INPUT when the value is wrong; then nothing has changed. The text of a
 * setting of type text is not copied. */
FATHOM_API fathom_status fathom_settings_set_text(fathom_context *context, fathom_settings *settings,
                                                  const char *name, const char *value);
/* FATHOM_BAD_USAGE when `size` is too small; 128 is enough for all but texts. */
FATHOM_API fathom_status fathom_settings_get_text(fathom_context *context, const fathom_settings *settings,
                                                  const char *name, char *out, size_t size);
#ifdef __cplusplus
}
#endif
#endif
