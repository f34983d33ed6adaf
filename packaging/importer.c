/* A small importer of FMI 2.0, for Windows and Linux: loads a library, and prints the bits of outputs after each step.
 *
 *   importer LIBRARY RESOURCES GUID STEPS STEP INPUT VALUE OUTPUT…
 *
 * RESOURCES is the URI as an importer gives it. INPUT and OUTPUT are value references of Reals; the input has the value
 * during all steps. It knows nothing of the project but the standard.
 */
#include <stdio.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#ifdef _WIN32
#include <windows.h>
static void *open_library(const char *path) {
    wchar_t wide[4096];
    MultiByteToWideChar(CP_UTF8, 0, path, -1, wide, 4096);
    return LoadLibraryW(wide);
}
static void *function(void *library, const char *name) { return (void *)GetProcAddress(library, name); }
#else
#include <dlfcn.h>
static void *open_library(const char *path) { return dlopen(path, RTLD_NOW | RTLD_LOCAL); }
static void *function(void *library, const char *name) { return dlsym(library, name); }
#endif

typedef void *Component;
typedef void (*Logger)(void *, const char *, int, const char *, const char *, ...);
struct callbacks {
    Logger logger;
    void *(*allocate)(size_t, size_t);
    void (*release)(void *);
    void *finished, *environment;
};

static void logger(void *environment, const char *name, int status, const char *category, const char *message, ...) {
    (void)environment, (void)name, (void)category;
    fprintf(stderr, "status %d: %s\n", status, message);
}

#define CALL(name, type, ...) \
    do { \
        int (*call) type = (int(*) type)function(library, name); \
        int status = call ? call(__VA_ARGS__) : -1; \
        if (status) return fprintf(stderr, "%s: %d\n", name, status), 1; \
    } while (0)

static int run(int count, char **words) {
    struct callbacks callbacks = {logger, calloc, free, NULL, NULL};
    void *library = open_library(words[1]);
    Component (*instantiate)(const char *, int, const char *, const char *, const struct callbacks *, int, int);
    void (*release)(Component);
    Component component;
    int steps = atoi(words[4]), outputs = count - 8;
    double step = atof(words[5]), value = atof(words[7]), values[64];
    unsigned input = (unsigned)atoi(words[6]), references[64];

    if (!library) return fprintf(stderr, "%s: cannot be loaded\n", words[1]), 1;
    for (int k = 0; k < outputs; k++) references[k] = (unsigned)atoi(words[8 + k]);
    *(void **)&instantiate = function(library, "fmi2Instantiate");
    *(void **)&release = function(library, "fmi2FreeInstance");
    component = instantiate("x", 1, words[3], words[2], &callbacks, 0, 0);
    if (!component) return fprintf(stderr, "fmi2Instantiate: NULL\n"), 1;
    CALL("fmi2SetupExperiment", (Component, int, double, double, int, double), component, 0, 0.0, 0.0, 0, 0.0);
    CALL("fmi2EnterInitializationMode", (Component), component);
    CALL("fmi2ExitInitializationMode", (Component), component);
    CALL("fmi2SetReal", (Component, const unsigned *, size_t, const double *), component, &input, 1, &value);
    for (int k = 0; k < steps; k++) {
        CALL("fmi2DoStep", (Component, double, double, int), component, k * step, step, 1);
        CALL("fmi2GetReal", (Component, const unsigned *, size_t, double *), component, references, (size_t)outputs,
             values);
        for (int i = 0; i < outputs; i++) {
            uint64_t bits;
            memcpy(&bits, &values[i], sizeof bits);
            printf("%08lx%08lx ", (unsigned long)(bits >> 32), (unsigned long)(bits & 0xffffffff));
        }
        printf("\n");
    }
    CALL("fmi2Terminate", (Component), component);
    release(component);
    return 0;
}

#ifdef _WIN32
/* Arguments in UTF-8, whatever the code page. */
int main(void) {
    int count;
    wchar_t **wide = CommandLineToArgvW(GetCommandLineW(), &count);
    char **words = calloc((size_t)count + 1, sizeof *words);
    for (int k = 0; k < count; k++) {
        words[k] = calloc(4096, 1);
        WideCharToMultiByte(CP_UTF8, 0, wide[k], -1, words[k], 4096, NULL, NULL);
    }
#else
int main(int count, char **words) {
#endif
    if (count < 9 || count > 8 + 64)
        return fprintf(stderr, "importer LIBRARY RESOURCES GUID STEPS STEP INPUT VALUE OUTPUT...\n"), 2;
    return run(count, words);
}
