/* What text from strangers may not do to a terminal. */
#include "base/text.h"

#include "unit.h"

static void becomes(const char *text, const char *expected) {
    char room[64];
    snprintf(room, sizeof room, "%s", text);
    text_disarm(room);
    assert_string_equal(room, expected);
}

UNIT_TEST(valid_text_is_kept) {
    becomes("", "");
    becomes("a b~", "a b~");
    becomes("\u00e4\u00a0\u20ac\u202f\U0001f41f", "\u00e4\u00a0\u20ac\u202f\U0001f41f");
}

UNIT_TEST(control_characters_are_replaced) {
    becomes("a\nb\t\x1b[31m\x7f", "a?b??[31m?");
    becomes("\xc2\x80\xc2\x9b"
            "31m\xc2\x9f",
            "????31m??");
    becomes("\u061c\u200e\u200f\u2028\u2029\u202a\u202e\u2066\u2069", "??????????????????????????");
}

UNIT_TEST(invalid_utf8_is_replaced) {
    becomes("\x9b"
            "31m",
            "?31m");
    becomes("\xe4x", "?x");
    becomes("\xe2\x82", "??");
    becomes("\xc0\x9b\xe0\x80\x9b", "?????"); /* too long for what they are */
    becomes("\xed\xa0\x80", "???");           /* half of a pair */
    becomes("\xf4\x90\x80\x80\xff", "?????"); /* behind the last */
    becomes("\xf0\x9f\x90\x9f\xf0", "\U0001f41f?");
}

int main(void) { return unit_main(NULL, NULL); }
