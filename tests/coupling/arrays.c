/* A small FMU 3.0 of another hand: arrays of most types, of n elements by a structural parameter. Outputs are inputs + 1,
 * !b, and texts with an x. The input "mode" says how a step ends: 1 returns early, 2 ends the simulation, 3 wants an event,
 * 4 is discarded and says why, 5 warns, 6 answers a status that FMI 3.0 has not. */
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define API __attribute__((visibility("default")))
enum { OK = 0, WARNING = 1, DISCARD = 2, ERROR = 3, PENDING = 5 };
enum { MOST = 8, LONGEST = 60 };
/* Value references. */
enum { N = 1, F64_IN, F64_OUT, F32_IN, F32_OUT, I8_IN, I8_OUT, U64_IN, U64_OUT, B_IN, B_OUT, S_IN, S_OUT, MODE };

typedef unsigned Reference;
typedef void (*Log)(void *, int, const char *, const char *);
typedef struct {
    uint64_t n, u64;
    double f64[2 * MOST];
    float f32[MOST];
    int8_t i8;
    bool b[MOST], configuring;
    char s[2][LONGEST], told[2][LONGEST + 2];
    int mode;
    void *environment;
    Log log;
} Arrays;

API void *fmi3InstantiateCoSimulation(const char *name, const char *token, const char *resources, bool visible, bool logging,
                                      bool events, bool early, const Reference wanted[], size_t count, void *environment,
                                      Log log, void *update) {
    if (strcmp(token, "{arrays}") != 0 || resources || events || early || wanted || count || update) {
        log(environment, ERROR, "error", "100 % of this ## is a text");
        return NULL;
    }
    Arrays *a = calloc(1, sizeof *a);
    if (!a) return NULL;
    a->n = 2, a->environment = environment, a->log = log;
    return a;
}
API void fmi3FreeInstance(void *a) { free(a); }
API int fmi3EnterConfigurationMode(Arrays *a) { a->configuring = true; return OK; }
API int fmi3ExitConfigurationMode(Arrays *a) { a->configuring = false; return OK; }
API int fmi3EnterInitializationMode(Arrays *a, bool tolerance, double t, double start, bool stops, double stop) { return OK; }
API int fmi3ExitInitializationMode(Arrays *a) { return OK; }
API int fmi3Terminate(Arrays *a) { return OK; }
API int fmi3Reset(Arrays *a) {
    void *environment = a->environment;
    Log log = a->log;
    memset(a, 0, sizeof *a);
    a->n = 2, a->environment = environment, a->log = log;
    return OK;
}

/* The number of values must be exact. */
#define GET(NAME, TYPE, IN, OUT, FIELD, COUNT, PLUS)                                                              \
    API int fmi3Get##NAME(Arrays *a, const Reference r[], size_t n, TYPE v[], size_t values) {                      \
        size_t at = 0;                                                                                              \
        for (size_t k = 0; k < n; k++)                                                                              \
            for (size_t i = 0; i < (COUNT); i++, at++) {                                                            \
                if ((r[k] != IN && r[k] != OUT) || at >= values) return ERROR;                                      \
                v[at] = r[k] == OUT ? (TYPE)(PLUS) : (TYPE)(FIELD)[i];                                               \
            }                                                                                                       \
        return at == values ? OK : ERROR;                                                                           \
    }                                                                                                               \
    API int fmi3Set##NAME(Arrays *a, const Reference r[], size_t n, const TYPE v[], size_t values) {                \
        size_t at = 0;                                                                                              \
        for (size_t k = 0; k < n; k++)                                                                              \
            for (size_t i = 0; i < (COUNT); i++, at++) {                                                            \
                if (r[k] != IN || at >= values) return ERROR;                                                       \
                (FIELD)[i] = v[at];                                                                                 \
            }                                                                                                       \
        return at == values ? OK : ERROR;                                                                           \
    }
GET(Float64, double, F64_IN, F64_OUT, a->f64, 2 * a->n, a->f64[i] + 1)
GET(Float32, float, F32_IN, F32_OUT, a->f32, a->n, a->f32[i] + 1)
GET(Int8, int8_t, I8_IN, I8_OUT, &a->i8, 1, a->i8 + 1)
GET(Boolean, bool, B_IN, B_OUT, a->b, a->n, !a->b[i])

API int fmi3GetUInt64(Arrays *a, const Reference r[], size_t n, uint64_t v[], size_t values) {
    for (size_t k = 0; k < n; k++) v[k] = r[k] == N ? a->n : r[k] == U64_OUT ? a->u64 * a->u64 : a->u64;
    return n == values ? OK : ERROR;
}
API int fmi3SetUInt64(Arrays *a, const Reference r[], size_t n, const uint64_t v[], size_t values) {
    for (size_t k = 0; k < n; k++) {
        if (r[k] == N && (!a->configuring || v[k] > MOST)) return ERROR;
        *(r[k] == N ? &a->n : &a->u64) = v[k];
    }
    return n == values ? OK : ERROR;
}
API int fmi3SetInt32(Arrays *a, const Reference r[], size_t n, const int v[], size_t values) {
    if (n != 1 || values != 1 || r[0] != MODE) return ERROR;
    a->mode = v[0];
    return OK;
}
API int fmi3GetInt32(Arrays *a, const Reference r[], size_t n, int v[], size_t values) { v[0] = a->mode; return OK; }
API int fmi3SetString(Arrays *a, const Reference r[], size_t n, const char *const v[], size_t values) {
    if (n != 1 || values != 2 || r[0] != S_IN) return ERROR;
    for (int i = 0; i < 2; i++) snprintf(a->s[i], LONGEST, "%s", v[i]);
    return OK;
}
API int fmi3GetString(Arrays *a, const Reference r[], size_t n, const char *v[], size_t values) {
    if (n != 1 || values != 2) return ERROR;
    for (int i = 0; i < 2; i++) {
        snprintf(a->told[i], sizeof a->told[i], r[0] == S_OUT ? "%sx" : "%s", a->s[i]);
        v[i] = a->told[i];
    }
    return OK;
}

API int fmi3DoStep(Arrays *a, double t, double step, bool no_way_back, bool *event, bool *end, bool *early, double *last) {
    *event = a->mode == 3, *end = a->mode == 2, *early = a->mode == 1;
    *last = a->mode == 1 || a->mode == 2 ? t + step / 2 : t + step;
    if (a->mode == 4) {
        a->log(a->environment, DISCARD, "all", "50 % of the step ## is too long");
        return DISCARD;
    }
    return a->mode == 5 ? WARNING : a->mode == 6 ? PENDING : OK;
}
