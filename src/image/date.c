#include "image/date.h"

#include <errno.h>
#include <stdlib.h>
#include <time.h>

static const char *given(void) {
    const char *text = getenv("SOURCE_DATE_EPOCH");
    return text && text[0] ? text : NULL;
}

bool date_is_given(void) { return given(); }

/* Digits alone, to the end of the year 9999, the last that a file's date has room for. */
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
