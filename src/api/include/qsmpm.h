/* C interface of QSMPM, also for languages that call C: a handle represents an analysis, functions return a status.
 *
 * Status: 0 success; 1 invalid call or other failure, 2 deck, 3 not converged, 4 a point left the mesh, 5 singular
 * equations, 6 user material, 7 the handle is null, 128 stopped. After a nonzero status, qsmpm_error returns the
 * message and the state is that of the last accepted step. A null handle is allowed in every call. Functions that copy
 * a text to a buffer return its length and truncate it if the buffer is too short; with NULL, 0 they return the length
 * only. Several handles may exist at the same time; calls must not overlap, but may come from any thread. See
 * docs/embedding.md. */
#ifndef QSMPM_H
#define QSMPM_H

#define QSMPM_API_VERSION 201 /* 10000 major + 100 minor + patch, equal to qsmpm_api_version() of the linked library */

#ifdef __cplusplus
extern "C" {
#endif

enum qsmpm_status {
    QSMPM_OK = 0,
    QSMPM_OTHER = 1,
    QSMPM_DECK = 2,
    QSMPM_NOT_CONVERGED = 3,
    QSMPM_LEFT_MESH = 4,
    QSMPM_SINGULAR = 5,
    QSMPM_USER_MATERIAL = 6,
    QSMPM_NO_HANDLE = 7,
    QSMPM_STOPPED = 128
};

typedef struct qsmpm_analysis *qsmpm_handle;

/* ---- the library --------------------------------------------------------------------------------------------- */

int qsmpm_api_version(void);
/* Name, version and build options. */
int qsmpm_version(char *buffer, int size);
/* Returns 1 if an optional feature ("suitesparse", "openmp", ...) is available, otherwise 0. */
int qsmpm_has(const char *feature);

/* ---- handles, errors, messages ------------------------------------------------------------------------------- */

int qsmpm_create(qsmpm_handle *handle);
/* Frees all data and sets the handle to NULL. */
int qsmpm_destroy(qsmpm_handle *handle);
/* Message of the last call if it failed, otherwise an empty text. */
int qsmpm_error(qsmpm_handle handle, char *buffer, int size);
/* Errors and warnings of the deck reader, one per line. */
int qsmpm_messages(qsmpm_handle handle, char *buffer, int size);
typedef void (*qsmpm_logger)(void *user, const char *text);
int qsmpm_set_logger(qsmpm_handle handle, qsmpm_logger logger, void *user);
/* 0 nothing, 1 messages, 2 messages and a line for every step (default). */
int qsmpm_set_verbosity(qsmpm_handle handle, int level);
int qsmpm_set_threads(qsmpm_handle handle, int threads);

/* ---- definition of the analysis ------------------------------------------------------------------------------ */

int qsmpm_read_deck(qsmpm_handle handle, const char *path);
int qsmpm_parse_deck(qsmpm_handle handle, const char *text, const char *job);

/* ---- user-defined soil model of one point: six components 11,22,33,12,13,23, shear gamma = 2 eps, tension positive;
 * 3x3 tensors column by column ------------------------------------------------------------------------------------ */

typedef struct qsmpm_model_options {
    int state_count;     /* number of state variables of a point */
    int symmetric;       /* nonzero if the tangent is symmetric for every state */
    int thread_safe;     /* nonzero if it may be called from several threads at once */
    int reads_strain;    /* nonzero if it reads strain_start; points then store 6 more values */
    int reads_gradient;  /* nonzero if it reads the gradients; points then store 9 more values */
    double stiffness_scale, shear_scale; /* Young's modulus and shear modulus, for stabilisation */
} qsmpm_model_options;

typedef struct qsmpm_increment {
    double strain[6], strain_start[6]; /* increment of the step; sum of the previous ones, rotated with the material */
    double rotation[9];                /* of the step; the stress has already been rotated by it */
    double gradient_start[9], gradient_end[9];
    int phase, step;                   /* from 1 */
    double start, duration;            /* load fraction of the phase at the start; its increment in the step */
    int point, cell;
    double place[3], cell_size;
    int wants_tangent, elastic_tangent; /* whether the tangent is used; whether it may be the elastic one */
    double time, time_increment;        /* at the start of the step; of the step, 1e-6 of the stage at constant load */
} qsmpm_increment;

typedef struct qsmpm_response {
    int plastic;        /* whether the point yields */
    double share;       /* with QSMPM_CUT: fraction of the step to try next, 0 for no proposal */
    double tangent[36]; /* [i + 6*j] = d stress[i] / d strain[j] */
    char message[256];  /* reason for any status other than QSMPM_UPDATED */
} qsmpm_response;

enum qsmpm_update_status { QSMPM_UPDATED = 0, QSMPM_CUT = 1, QSMPM_FAILED = 2, QSMPM_UNRECOVERABLE = 3 };

/* stress and state: values at the start of the step on entry, at its end on return. */
typedef int (*qsmpm_update)(void *user, const qsmpm_increment *increment, double *stress, double *state,
                            qsmpm_response *answer);
/* Sets the state variables of a point at a given stress; NULL for zeros. */
typedef void (*qsmpm_start)(void *user, const double *stress, double *state);
/* Assigns a soil model to a material of the deck, before qsmpm_initialise. */
int qsmpm_set_material(qsmpm_handle handle, const char *material, const qsmpm_model_options *options,
                       qsmpm_start start, qsmpm_update update, void *user);

/* ---- stepping ------------------------------------------------------------------------------------------------ */

int qsmpm_initialise(qsmpm_handle handle);
/* One accepted load step; to a load fraction of the current (between stages: next) stage; to the end. */
int qsmpm_advance(qsmpm_handle handle);
int qsmpm_advance_to(qsmpm_handle handle, double share);
int qsmpm_run(qsmpm_handle handle);
int qsmpm_finished(qsmpm_handle handle);
/* Start to write the result files of a run of the command line; close them. */
int qsmpm_record(qsmpm_handle handle, const char *directory);
int qsmpm_finish_record(qsmpm_handle handle);
/* Write and read the state, for an analysis with the same deck and stages. */
int qsmpm_save(qsmpm_handle handle, const char *path);
int qsmpm_load(qsmpm_handle handle, const char *path);
/* Store and restore one copy of state, loads and stages in memory. */
int qsmpm_checkpoint(qsmpm_handle handle);
int qsmpm_restore_checkpoint(qsmpm_handle handle);

/* ---- the load program: stages are the phases of the deck; loads are set for the next stage ------------------- */

int qsmpm_add_stage(qsmpm_handle handle, const char *name, int steps);
/* Adds lines to the end of the deck: *MATERIAL and *PHASE blocks (activation, deactivation and material changes of
 * bodies, water levels, *SAFETY, ...), checked as in a deck. */
int qsmpm_add_cards(qsmpm_handle handle, const char *cards);
int qsmpm_end_stage(qsmpm_handle handle);
int qsmpm_set_load_factor(qsmpm_handle handle, double factor);
int qsmpm_set_steps(qsmpm_handle handle, int steps);
/* For time-dependent models: duration of the stage, 1 by default; its start time, by default the end of the previous
 * stage. */
int qsmpm_set_time(qsmpm_handle handle, double duration);
int qsmpm_set_start_time(qsmpm_handle handle, double time);
int qsmpm_set_gravity(qsmpm_handle handle, const double *vector);
int qsmpm_set_traction(qsmpm_handle handle, const char *surface, const double *vector);
int qsmpm_set_pressure(qsmpm_handle handle, const char *surface, double pressure);
/* name: node set or surface of a row of *WATER LEVEL in consolidating soil; for hydrostatic water a body, or "" */
int qsmpm_set_water_level(qsmpm_handle handle, const char *name, double level);
/* component from 1 */
int qsmpm_set_displacement(qsmpm_handle handle, const char *set, int component, double value);
int qsmpm_set_fixity(qsmpm_handle handle, const char *set, const int *fixed);

/* ---- values by name: qsmpm_name(handle, "value", 1 ...) lists the names ---------------------------------------- */

/* Components per value and number of values; their product. */
int qsmpm_shape(qsmpm_handle handle, const char *name, int *rows, int *columns);
int qsmpm_count(qsmpm_handle handle, const char *name, int *number);
int qsmpm_get(qsmpm_handle handle, const char *name, double *values, int number);
/* Sets point_stress (with the state variables that belong to it), point_state or point_force. */
int qsmpm_set(qsmpm_handle handle, const char *name, const double *values, int number);
/* Address of the values, always those of the last step: valid until qsmpm_destroy or qsmpm_initialise, and until a
 * phase begins in which bodies are activated or deactivated. */
int qsmpm_view(qsmpm_handle handle, const char *name, const double **values, int *rows, int *columns);
/* Name of a "value", "history", "stage", "surface", "set", "material", "body", numbered from 1; -1 if there is none. */
int qsmpm_name(qsmpm_handle handle, const char *kind, int number, char *buffer, int size);

#ifdef __cplusplus
}
#endif
#endif
