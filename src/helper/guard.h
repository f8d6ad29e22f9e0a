/* Turns C++ exceptions into a status and a message. */
#pragma once

#include "image/helper/module.h"

#include <cstdio>
#include <memory>
#include <new>
#include <stdexcept>
#include <string>

struct failure : std::runtime_error {
    failure(fathom_status s, const std::string &text) : std::runtime_error(text), status(s) {}
    fathom_status status;
};

/* A file that a reader refuses. Some readers give no reason, and some give several, a line each. */
inline failure unreadable(std::string reason) {
    for (size_t at; (at = reason.find('\n')) != std::string::npos;)
        reason.replace(at, 1, at + 1 < reason.size() ? "; " : "");
    return failure(FATHOM_BAD_INPUT, reason.empty() ? "the file is broken or ends early" : reason);
}

/* Runs body(). Exceptions of the libraries return `status`. */
template <class Body>
fathom_status guarded(image_message *message, fathom_status status, Body body) noexcept {
    try {
        body();
        return FATHOM_OK;
    } catch (const failure &e) {
        status = e.status;
        std::snprintf(message->text, sizeof message->text, "%s", e.what());
    } catch (const std::bad_alloc &) {
        status = FATHOM_OUT_OF_RESOURCES;
        std::snprintf(message->text, sizeof message->text, "out of memory");
    } catch (const std::exception &e) {
        std::snprintf(message->text, sizeof message->text, "%s", e.what());
    } catch (...) {
        std::snprintf(message->text, sizeof message->text, "unknown exception");
    }
    return status;
}

/* Converts pixels of R, G, B and optionally A from a colour space to linear Rec.709, in place. */
struct image_space {
    virtual ~image_space() = default;
    virtual void apply(float *pixels, size_t count, unsigned channels) const = 0;
};
/* Throws `failure` if the config lacks this space or linear Rec.709. config may be NULL: the built-in one. */
std::unique_ptr<image_space> space_open(const char *config, const char *name);
