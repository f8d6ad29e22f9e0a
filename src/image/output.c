#include "image/output.h"

#include "base/file.h"
#include "base/text.h"
#include "image/helper/helper.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

static bool known_format(const char *extension, image_format *out) {
    static const image_format formats[] = {IMAGE_EXR,  IMAGE_PNG,  IMAGE_JPEG,
                                           IMAGE_JPEG, IMAGE_TIFF, IMAGE_TIFF};
    int found = words_find("exr|png|jpg|jpeg|tif|tiff", extension, strlen(extension));
    if (found >= 0) *out = formats[found];
    return found >= 0;
}

fathom_status output_format(fathom_context *context, const char *path, image_format *out) {
    char extension[16];
    file_extension(path, extension);
    if (known_format(extension, out)) return FATHOM_OK;
    return fail_file(context, FATHOM_BAD_USAGE, path,
                     "unknown image extension \"%s\"; expected .exr, .png, .jpg, .jpeg, .tif or .tiff",
                     extension);
}

fathom_status output_check_exposure(fathom_context *context, const fathom_write_options *options) {
    if (isfinite(exp2f(options->exposure)) && isfinite(options->exposure)) return FATHOM_OK;
    return fail_field(context, FATHOM_BAD_USAGE, "exposure", "%g; expected stops below 128",
                      (double)options->exposure);
}

/* libjpeg ends the process for larger images. */
#define JPEG_LARGEST_SIDE 65500u

fathom_status output_check_size(fathom_context *context, const char *path, image_format format,
                                uint32_t width, uint32_t height) {
    if (format != IMAGE_JPEG || (width <= JPEG_LARGEST_SIDE && height <= JPEG_LARGEST_SIDE)) return FATHOM_OK;
    return fail_file(context, FATHOM_BAD_USAGE, path, "%u x %u pixels; JPEG holds at most %u x %u", width,
                     height, JPEG_LARGEST_SIDE, JPEG_LARGEST_SIDE);
}

fathom_status image_check_size(fathom_context *context, const char *path, uint32_t width, uint32_t height) {
    image_format format = IMAGE_EXR;
    fathom_status status = output_format(context, path, &format);
    return status == FATHOM_OK ? output_check_size(context, path, format, width, height) : status;
}

/* ---- the date ---- */

static const char *given(void) {
    const char *text = getenv("SOURCE_DATE_EPOCH");
    return text && text[0] ? text : NULL;
}

bool image_date_is_given(void) { return given(); }

/* Digits only, up to the year 9999, the last one with four digits. */
static bool read_seconds(const char *text, time_t *out) {
    const long long last = 253402300799;
    char *end;
    errno = 0;
    long long seconds = strtoll(text, &end, 10);
    *out = (time_t)seconds;
    return text[0] >= '0' && text[0] <= '9' && !*end && !errno && seconds <= last;
}

fathom_status date_read(fathom_context *context, image_date *out) {
    const char *text = given();
    struct tm utc;
    time_t seconds;
    *out = (image_date){""};
    if (!text) return FATHOM_OK;
    if (!read_seconds(text, &seconds) || !gmtime_r(&seconds, &utc) ||
        !strftime(out->text, sizeof out->text, "%Y:%m:%d %H:%M:%S", &utc)) {
        return fail_field(context, FATHOM_BAD_USAGE, "SOURCE_DATE_EPOCH",
                          "expected seconds since 1970, such as 1700000000, found \"%.40s\"", text);
    }
    return FATHOM_OK;
}

/* ---- the view ---- */

static const char *config_of(const fathom_write_options *options) {
    if (options->ocio) return options->ocio;
    const char *named = getenv("OCIO");
    return named && named[0] ? named : NULL;
}

bool image_view_is_srgb(const fathom_write_options *options) {
    return !config_of(options) && (!options->display || strcasecmp(options->display, "sRGB") == 0) &&
           (!options->view || strcasecmp(options->view, "sRGB") == 0);
}

static bool output_needs_module(image_format format, const fathom_write_options *options) {
    if (format == IMAGE_EXR) return false;
    return format != IMAGE_PNG || !image_view_is_srgb(options);
}

bool image_needs_module(const char *path, const fathom_write_options *options) {
    char extension[16];
    image_format format;
    file_extension(path, extension);
    return known_format(extension, &format) && output_needs_module(format, options);
}

fathom_status output_open_view(fathom_context *context, const fathom_write_options *options, image_view **out,
                               bool *srgb) {
    image_message message = {""};
    image_view_request request = {config_of(options), options->display, options->view};
    fathom_status status = image_calls.view_open(&request, out, srgb, &message);
    if (status == FATHOM_OK) return status;
    if (!request.config) return fail(context, status, "OpenColorIO: %s", message.text);
    return fail(context, status, "OpenColorIO config %s%s: %s", options->ocio ? "" : "($OCIO) ",
                request.config, message.text);
}

uint64_t image_config_files(const fathom_write_options *options) {
    image_message why = {""};
    image_view_request request = {config_of(options), options->display, options->view};
    uint64_t files = 0;
    if (request.config) image_calls.view_files(&request, NULL, &files, &why);
    return files;
}

static fathom_status check_view(fathom_context *context, const fathom_write_options *options) {
    image_view *view;
    bool srgb;
    fathom_status status = output_open_view(context, options, &view, &srgb);
    if (status == FATHOM_OK) image_calls.view_close(view);
    return status;
}

fathom_status image_check(fathom_context *context, const char *path, const fathom_write_options *options) {
    image_format format = IMAGE_EXR;
    fathom_status status = output_format(context, path, &format);
    if (status == FATHOM_OK) status = output_check_exposure(context, options);
    image_date date;
    if (status == FATHOM_OK) status = date_read(context, &date);
    if (status == FATHOM_OK) status = fathom_file_check(context, path);
    if (status != FATHOM_OK || !output_needs_module(format, options)) return status;
    status = helper_find(context);
    if (status != FATHOM_OK || image_view_is_srgb(options)) return status;
    return check_view(context, options);
}
