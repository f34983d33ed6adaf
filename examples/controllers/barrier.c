/* A barrier that gives way: an FMU of FMI 2.0 for co-simulation, beside the crowd that presses on it.
 *
 *   python examples/controllers/pack_controller.py barrier -o barrier.fmu
 *
 * Per metre of its length it is a mass on a spring with a damper: Mass x'' + Damping x' + Force = Load. The Force of the
 * spring is Stiffness (x - Plastic), and no more than Strength: beyond it the barrier yields, and Plastic [m] is what stays.
 * When Deflection x passes Travel, it has fallen: the door of the crowd, which is this barrier, opens for good.
 *
 * A step from t to t + H takes the Load [N/m] at t, which is the crowd's mean from t - H to t. The crowd does not see the
 * deflection: its wall stands until it has fallen. So Travel must be small beside a person. */
#include <math.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#define GUID "{8d9c2c86-52f4-4b8e-9a2f-6f1f5d0f7c11}"
enum { OK = 0, ERROR = 3 };
/* Value references of modelDescription.xml; numbers before LOAD are parameters. */
enum { MASS, STIFFNESS, DAMPING, STRENGTH, TRAVEL, LOAD, DEFLECTION, PLASTIC, FORCE, NUMBERS };
static const double START[NUMBERS] = {20.0, 5e5, 300.0, 3000.0, 0.05};
typedef struct { double of[NUMBERS], speed; int open; } Barrier;
typedef unsigned Reference;

static int start(Barrier *b) {
    memcpy(b->of, START, sizeof START), b->speed = 0.0, b->open = 0;
    return OK;
}
void *fmi2Instantiate(const char *name, int type, const char *guid, const char *resources, const void *callbacks, int visible,
                      int logging) {
    Barrier *b = type == 1 && strcmp(guid, GUID) == 0 ? calloc(1, sizeof *b) : NULL;
    if (b) start(b);
    return b;
}
void fmi2FreeInstance(Barrier *b) { free(b); }
const char *fmi2GetVersion(void) { return "2.0"; }
const char *fmi2GetTypesPlatform(void) { return "default"; }
int fmi2SetDebugLogging(Barrier *b, int on, size_t count, const char *const categories[]) { return OK; }
int fmi2SetupExperiment(Barrier *b, int tolerance, double limit, double begin, int stops, double stop) { return OK; }
int fmi2EnterInitializationMode(Barrier *b) { return OK; }
int fmi2ExitInitializationMode(Barrier *b) { return OK; }
int fmi2Terminate(Barrier *b) { return OK; }
int fmi2Reset(Barrier *b) { return start(b); }

int fmi2GetReal(Barrier *b, const Reference of[], size_t count, double values[]) {
    for (size_t k = 0; k < count; k++) {
        if (of[k] >= NUMBERS) return ERROR;
        values[k] = b->of[of[k]];
    }
    return OK;
}
int fmi2SetReal(Barrier *b, const Reference of[], size_t count, const double values[]) {
    for (size_t k = 0; k < count; k++) {
        int possible = isfinite(values[k]) && (of[k] == LOAD || values[k] > 0.0 || (of[k] == DAMPING && values[k] == 0.0));
        if (of[k] > LOAD || !possible) return ERROR;
        b->of[of[k]] = values[k];
    }
    return OK;
}
int fmi2GetBoolean(Barrier *b, const Reference of[], size_t count, int values[]) {
    for (size_t k = 0; k < count; k++) {
        if (of[k] != 0) return ERROR;
        values[k] = b->open;
    }
    return OK;
}

/* Symplectic Euler in a hundred steps or more for each oscillation, and for each decay time. */
int fmi2DoStep(Barrier *b, double time, double step, int never_back) {
    double *of = b->of, period = 6.283 * sqrt(of[MASS] / of[STIFFNESS]), decay = of[MASS] / (of[DAMPING] + 1e-9);
    double count = ceil(step / (0.01 * fmin(period, decay)));
    if (!(count >= 1.0 && count < 1e7)) return ERROR;
    for (double k = 0.0, h = step / count; k < count && !b->open; k++) {
        b->speed += h * (of[LOAD] - of[DAMPING] * b->speed - of[FORCE]) / of[MASS];
        of[DEFLECTION] += h * b->speed;
        of[FORCE] = of[STIFFNESS] * (of[DEFLECTION] - of[PLASTIC]);
        if (fabs(of[FORCE]) > of[STRENGTH]) {
            of[FORCE] = copysign(of[STRENGTH], of[FORCE]);
            of[PLASTIC] = of[DEFLECTION] - of[FORCE] / of[STIFFNESS];
        }
        b->open = fabs(of[DEFLECTION]) > of[TRAVEL];
    }
    return OK;
}

/* All that is refused, whatever its arguments. */
#define REFUSED(NAME) int fmi2##NAME(void) { return ERROR; }
REFUSED(GetInteger) REFUSED(GetString) REFUSED(SetInteger) REFUSED(SetBoolean) REFUSED(SetString) REFUSED(GetFMUstate)
REFUSED(SetFMUstate) REFUSED(FreeFMUstate) REFUSED(SerializedFMUstateSize) REFUSED(SerializeFMUstate)
REFUSED(DeSerializeFMUstate) REFUSED(GetDirectionalDerivative) REFUSED(SetRealInputDerivatives)
REFUSED(GetRealOutputDerivatives) REFUSED(CancelStep) REFUSED(GetStatus) REFUSED(GetRealStatus) REFUSED(GetIntegerStatus)
REFUSED(GetBooleanStatus) REFUSED(GetStringStatus)
