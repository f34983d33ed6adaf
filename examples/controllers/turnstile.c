/* A turnstile that limits squeeze: an FMU of FMI 3.0 for co-simulation, between Decision and the crowd.
 *
 *   python examples/controllers/pack_controller.py turnstile --agents 80 -o turnstile.fmu      # for 80 people
 *
 * People walk to greater x and pass a line at x = Line [m]. The squeeze of each person goes through a low pass with a time
 * constant of 1 s. Squeeze [N] is the greatest of these means among the people beyond the line. The turnstile closes when
 * it is above Limit [N]. It opens when it is below (1 - Hysteresis) Limit.
 *
 * While it is closed, who is before the line and at most Distance [m] away gets no force towards greater x; the force to
 * the sides and back stays as it was wanted. All others get what they want. The people behind stop by themselves, if their
 * model of walking keeps a distance. Nothing holds people back whom others push over the line.
 *
 * Order: a step from t to t + H takes the inputs at t, of which MeanNormalForce is the mean from t - H to t. The outputs
 * hold from the end of the step on. Before the first step Fp is 0 and the turnstile open.
 * Gauss-Seidel, with the order Decision, turnstile, crowd: these outputs act in the crowd's step from t to t + H.
 * Jacobi: they act in its step from t + H to t + 2 H, and Wanted follows from where people were at t - H.
 *
 * FMI 3.0 has many functions that a turnstile does not need. They are at the end, and refuse each call. The states of FMI
 * (a master that goes back) are among them. The order of calls is the master's task: it is not checked.
 */
#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#ifndef AGENTS
#define AGENTS 1 /* the start value of the number of people */
#endif
#define TIME_CONSTANT 1.0 /* [s] of the low pass */
#define TOKEN "{4c8ad5b1-6a2e-4d0b-9a53-7f7c2a6d1e90}"

/* Of FMI 3.0: statuses, and the value references of modelDescription.xml. */
enum { OK = 0, ERROR = 3 };
enum { TIME, NUMBER, LINE, LIMIT, HYSTERESIS, DISTANCE, POSITION, MEAN_NORMAL_FORCE, WANTED, FP, SQUEEZE, OPEN };
typedef uint32_t Reference;

typedef struct {
    uint64_t agents;
    double time, line, limit, hysteresis, distance, squeeze;
    double *position, *wanted, *fp;   /* [m], [N], [N]: x and y of each person */
    double *force, *mean;             /* [N] of each person: MeanNormalForce, and its low pass */
    bool open;
} Turnstile;

/* For so many people, none of them squeezed. Parameters stay. */
static int resize(Turnstile *t, uint64_t agents) {
    double *all = agents > 0 ? calloc(agents, 8 * sizeof *all) : NULL;
    if (!all) return ERROR;
    free(t->position);
    t->agents = agents, t->open = true, t->squeeze = 0.0;
    t->position = all, t->wanted = all + 2 * agents, t->fp = all + 4 * agents;
    t->force = all + 6 * agents, t->mean = all + 7 * agents;
    return OK;
}

/* Everything as at the start. */
static int start(Turnstile *t, uint64_t agents) {
    t->time = t->line = 0.0, t->limit = 500.0, t->hysteresis = 0.2, t->distance = 0.5;
    return resize(t, agents);
}

void *fmi3InstantiateCoSimulation(const char *name, const char *token, const char *resources, bool visible, bool logging,
                                  bool events, bool early, const Reference intermediate[], size_t count, void *environment,
                                  void *log, void *update) {
    Turnstile *t = strcmp(token, TOKEN) == 0 ? calloc(1, sizeof *t) : NULL;
    if (t && start(t, AGENTS) != OK) free(t), t = NULL;
    return t;
}
void fmi3FreeInstance(Turnstile *t) {
    if (t) free(t->position);
    free(t);
}
const char *fmi3GetVersion(void) { return "3.0"; }
int fmi3SetDebugLogging(Turnstile *t, bool on, size_t count, const char *const categories[]) { return OK; }
int fmi3EnterConfigurationMode(Turnstile *t) { return OK; }
int fmi3ExitConfigurationMode(Turnstile *t) { return OK; }
int fmi3EnterInitializationMode(Turnstile *t, bool tolerance, double limit, double begin, bool stops, double stop) {
    t->time = begin;
    return OK;
}
int fmi3ExitInitializationMode(Turnstile *t) { return OK; }
int fmi3Terminate(Turnstile *t) { return OK; }
int fmi3Reset(Turnstile *t) { return start(t, t->agents); }

/* Where the numbers of a variable are, and how many. */
static double *numbers(Turnstile *t, Reference of, size_t *count) {
    *count = of == POSITION || of == WANTED || of == FP ? 2 * t->agents : of == MEAN_NORMAL_FORCE ? t->agents : 1;
    double *all[] = {[TIME] = &t->time, [LINE] = &t->line, [LIMIT] = &t->limit, [HYSTERESIS] = &t->hysteresis,
                     [DISTANCE] = &t->distance, [POSITION] = t->position, [MEAN_NORMAL_FORCE] = t->force,
                     [WANTED] = t->wanted, [FP] = t->fp, [SQUEEZE] = &t->squeeze};
    return of < sizeof all / sizeof *all ? all[of] : NULL;
}
int fmi3GetFloat64(Turnstile *t, const Reference of[], size_t variables, double values[], size_t left) {
    for (size_t k = 0, count; k < variables; k++, values += count, left -= count) {
        double *from = numbers(t, of[k], &count);
        if (!from || count > left) return ERROR;
        memcpy(values, from, count * sizeof *from);
    }
    return left == 0 ? OK : ERROR;
}
int fmi3SetFloat64(Turnstile *t, const Reference of[], size_t variables, const double values[], size_t left) {
    for (size_t k = 0, count; k < variables; k++, values += count, left -= count) {
        double *to = of[k] >= LINE && of[k] <= WANTED ? numbers(t, of[k], &count) : NULL;
        if (!to || count > left) return ERROR;
        for (size_t i = 0; i < count; i++)
            if (!isfinite(values[i])) return ERROR;
        memcpy(to, values, count * sizeof *to);
    }
    return left == 0 ? OK : ERROR;
}
int fmi3GetBoolean(Turnstile *t, const Reference of[], size_t variables, bool values[], size_t count) {
    for (size_t k = 0; k < variables; k++) {
        if (of[k] != OPEN || k >= count) return ERROR;
        values[k] = t->open;
    }
    return OK;
}
int fmi3GetUInt64(Turnstile *t, const Reference of[], size_t variables, uint64_t values[], size_t count) {
    for (size_t k = 0; k < variables; k++) {
        if (of[k] != NUMBER || k >= count) return ERROR;
        values[k] = t->agents;
    }
    return OK;
}
int fmi3SetUInt64(Turnstile *t, const Reference of[], size_t variables, const uint64_t values[], size_t count) {
    return variables == 1 && count == 1 && of[0] == NUMBER ? resize(t, values[0]) : ERROR;
}

int fmi3DoStep(Turnstile *t, double time, double step, bool never_back, bool *event, bool *end, bool *early, double *last) {
    double part = -expm1(-step / TIME_CONSTANT);
    t->squeeze = 0.0;
    for (size_t i = 0; i < t->agents; i++) {
        t->mean[i] += part * (t->force[i] - t->mean[i]);
        if (t->position[2 * i] > t->line && t->mean[i] > t->squeeze) t->squeeze = t->mean[i];
    }
    if (t->squeeze > t->limit) t->open = false;
    if (t->squeeze < (1.0 - t->hysteresis) * t->limit) t->open = true;
    for (size_t i = 0; i < t->agents; i++) {
        double *wanted = t->wanted + 2 * i, before = t->line - t->position[2 * i];
        bool held = !t->open && before >= 0.0 && before <= t->distance && wanted[0] > 0.0;
        t->fp[2 * i] = held ? 0.0 : wanted[0];
        t->fp[2 * i + 1] = wanted[1];
    }
    t->time = time + step;
    *event = *end = *early = false, *last = t->time;
    return OK;
}

/* All that is refused, whatever its arguments. */
#define NONE(TYPE) int fmi3Get##TYPE(void) { return ERROR; } int fmi3Set##TYPE(void) { return ERROR; }
#define REFUSED(NAME) int fmi3##NAME(void) { return ERROR; }
void *fmi3InstantiateModelExchange(void) { return NULL; }
void *fmi3InstantiateScheduledExecution(void) { return NULL; }
int fmi3SetBoolean(void) { return ERROR; }
NONE(Float32) NONE(Int8) NONE(UInt8) NONE(Int16) NONE(UInt16) NONE(Int32) NONE(UInt32) NONE(Int64) NONE(String) NONE(Binary)
NONE(Clock) NONE(FMUState) NONE(IntervalDecimal) NONE(IntervalFraction) NONE(ShiftDecimal) NONE(ShiftFraction)
NONE(ContinuousStates) REFUSED(SetTime) REFUSED(FreeFMUState) REFUSED(SerializedFMUStateSize) REFUSED(SerializeFMUState)
REFUSED(DeserializeFMUState) REFUSED(GetNumberOfVariableDependencies) REFUSED(GetVariableDependencies)
REFUSED(GetDirectionalDerivative) REFUSED(GetAdjointDerivative) REFUSED(GetOutputDerivatives) REFUSED(EnterEventMode)
REFUSED(EnterStepMode) REFUSED(EnterContinuousTimeMode) REFUSED(CompletedIntegratorStep) REFUSED(EvaluateDiscreteStates)
REFUSED(UpdateDiscreteStates) REFUSED(GetContinuousStateDerivatives) REFUSED(GetEventIndicators)
REFUSED(GetNominalsOfContinuousStates) REFUSED(GetNumberOfEventIndicators) REFUSED(GetNumberOfContinuousStates)
REFUSED(ActivateModelPartition)
