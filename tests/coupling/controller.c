/* A small controller FMU 2.0 of five agents: spring forces towards where each agent is sent, from the poses it
 * is told, after a delay. Beside that one input and one output of each type: real.out = real.in + 1,
 * integer.out = integer.in + 1, boolean.out = !boolean.in, string.out = string.in + "x".
 * With real.in = 7 each step returns fmi2Warning. */
#include <stdlib.h>
#include <string.h>

#define API __attribute__((visibility("default")))
#define AGENTS 5
enum { POSES = 0, FORCES = 3 * AGENTS, DELAY = 6 * AGENTS, STIFFNESS, REAL_IN, REAL_OUT, REALS };
enum { OK = 0, WARNING = 1, ERROR = 3 };
enum { LONGEST = 200 };

typedef unsigned Reference;
typedef struct {
    double reals[REALS];
    int integers[2], booleans[2];
    char strings[2][LONGEST + 2];
} Controller;

API const char *fmi2GetTypesPlatform(void) { return "default"; }
API const char *fmi2GetVersion(void) { return "2.0"; }
API int fmi2SetDebugLogging(void *c, int on, size_t n, const char *const names[]) { return OK; }

static void decide(Controller *c, double time) {
    for (int i = 0; i < AGENTS; i++) {
        const double *pose = c->reals + POSES + 3 * i;
        double *force = c->reals + FORCES + 3 * i, stiffness = time < c->reals[DELAY] ? 0 : c->reals[STIFFNESS];
        force[0] = stiffness * (1.0 + 0.1 * i - pose[0]);
        force[1] = stiffness * (0.05 * i - pose[1]);
        force[2] = 0.1 * stiffness * (0.3 - pose[2]);
    }
    c->reals[REAL_OUT] = c->reals[REAL_IN] + 1;
    c->integers[1] = c->integers[0] + 1;
    c->booleans[1] = !c->booleans[0];
    strcat(strcpy(c->strings[1], c->strings[0]), "x");
}

API void *fmi2Instantiate(const char *name, int type, const char *guid, const char *resources, const void *functions,
                          int visible, int logging) {
    Controller *c = type == 1 && strcmp(guid, "{controller}") == 0 ? calloc(1, sizeof *c) : NULL;
    if (c) c->reals[STIFFNESS] = 400;
    return c;
}
API void fmi2FreeInstance(void *c) { free(c); }
API int fmi2SetupExperiment(void *c, int tolerance, double t, double start, int stops, double stop) { return OK; }
API int fmi2EnterInitializationMode(void *c) { return OK; }
API int fmi2ExitInitializationMode(void *c) { return OK; }
API int fmi2Terminate(void *c) { return OK; }
API int fmi2Reset(void *c) { return ERROR; }

API int fmi2GetReal(Controller *c, const Reference r[], size_t n, double v[]) {
    for (size_t i = 0; i < n; i++) v[i] = c->reals[r[i]];
    return OK;
}
API int fmi2SetReal(Controller *c, const Reference r[], size_t n, const double v[]) {
    for (size_t i = 0; i < n; i++) c->reals[r[i]] = v[i];
    return OK;
}
API int fmi2GetInteger(Controller *c, const Reference r[], size_t n, int v[]) {
    for (size_t i = 0; i < n; i++) v[i] = c->integers[r[i]];
    return OK;
}
API int fmi2SetInteger(Controller *c, const Reference r[], size_t n, const int v[]) {
    for (size_t i = 0; i < n; i++) c->integers[r[i]] = v[i];
    return OK;
}
API int fmi2GetBoolean(Controller *c, const Reference r[], size_t n, int v[]) {
    for (size_t i = 0; i < n; i++) v[i] = c->booleans[r[i]];
    return OK;
}
API int fmi2SetBoolean(Controller *c, const Reference r[], size_t n, const int v[]) {
    for (size_t i = 0; i < n; i++) c->booleans[r[i]] = v[i];
    return OK;
}
API int fmi2GetString(Controller *c, const Reference r[], size_t n, const char *v[]) {
    for (size_t i = 0; i < n; i++) v[i] = c->strings[r[i]];
    return OK;
}
API int fmi2SetString(Controller *c, const Reference r[], size_t n, const char *const v[]) {
    for (size_t i = 0; i < n; i++) {
        if (strlen(v[i]) > LONGEST) return ERROR;
        strcpy(c->strings[r[i]], v[i]);
    }
    return OK;
}
API int fmi2DoStep(Controller *c, double time, double step, int final) {
    decide(c, time + step);
    return c->reals[REAL_IN] == 7 ? WARNING : OK;
}

/* Not there, but importers want them exported. */
#define NONE(name) API int name(void) { return ERROR; }
NONE(fmi2GetFMUstate) NONE(fmi2SetFMUstate) NONE(fmi2FreeFMUstate) NONE(fmi2SerializedFMUstateSize)
NONE(fmi2SerializeFMUstate) NONE(fmi2DeSerializeFMUstate) NONE(fmi2GetDirectionalDerivative)
NONE(fmi2SetRealInputDerivatives) NONE(fmi2GetRealOutputDerivatives) NONE(fmi2CancelStep) NONE(fmi2GetStatus)
NONE(fmi2GetRealStatus) NONE(fmi2GetIntegerStatus) NONE(fmi2GetBooleanStatus) NONE(fmi2GetStringStatus)
