/* fmi2CallbackLogger: formats what an FMU says, and hands it to the listener that is the environment. */

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>

/* As `Listener` in calls.rs; what follows is known there alone. */
struct listener {
    void (*hear)(const struct listener *, int status, const char *text);
};

/* Of a message; the rest is cut off. */
#define LONGEST 1000000

void lemons_logger(void *environment, const char *instance, int status, const char *category,
                   const char *message, ...) {
    const struct listener *listener = environment;
    va_list arguments;
    int length;
    size_t size;
    char *text;

    (void)instance;
    (void)category;
    if (!listener || !message) return;

    va_start(arguments, message);
    length = vsnprintf(NULL, 0, message, arguments);
    va_end(arguments);
    if (length < 0) return;

    size = (size_t)(length < LONGEST ? length : LONGEST) + 1;
    text = malloc(size);
    if (!text) return;
    va_start(arguments, message);
    length = vsnprintf(text, size, message, arguments);
    va_end(arguments);
    if (length >= 0) listener->hear(listener, status, text);
    free(text);
}
