/* Text from strangers, made fit for a terminal. */
#ifndef BASE_TEXT_H
#define BASE_TEXT_H

/* Puts '?' for each byte that could steer a terminal or pass for other text: control characters, those of C1
 * (U+0080 to U+009F) among them, line ends and marks of direction of Unicode, and what is no UTF-8. */
void text_disarm(char *text);

#endif
