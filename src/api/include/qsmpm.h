/* QSMPM from C and from whatever calls C: a handle for an analysis, functions that return a status, text on request.
 *
 * Status: 0 done; 1 wrong call or other failure, 2 deck, 3 not converged, 4 a point left the mesh, 5 singular
 * equations, 6 user material, 7 the handle is null, 128 stopped. After a status the sentence is had by qsmpm_error and
 * the state is that of the last accepted step. A null handle is legal everywhere. Functions that put a text into a
 * buffer return its length, cut it off where the buffer is too short, and may be asked for the length with NULL, 0.
 * Any number of handles may live at once; calls come one after the other, whatever thread they come from. See
 * docs/embedding.md. */
#ifndef QSMPM_H
#define QSMPM_H

#define QSMPM_API_VERSION 201 /* 10000 major + 100 minor + patch, as qsmpm_api_version() of the library linked */

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
/* Name, version and make. */
int qsmpm_version(char *buffer, int size);
/* 1 where "suitesparse", "openmp", ... is there, else 0. */
int qsmpm_has(const char *feature);

/* ---- handles, errors, messages ------------------------------------------------------------------------------- */

int qsmpm_create(qsmpm_handle *handle);
/* Gives everything back and sets the handle to NULL. */
int qsmpm_destroy(qsmpm_handle *handle);
/* Sentence of the last call that failed, empty after one that did not. */
int qsmpm_error(qsmpm_handle handle, char *buffer, int size);
/* What the reader of the deck has to say: its errors and warnings, one a line. */
int qsmpm_messages(qsmpm_handle handle, char *buffer, int size);
typedef void (*qsmpm_logger)(void *user, const char *text);
int qsmpm_set_logger(qsmpm_handle handle, qsmpm_logger logger, void *user);
/* 0 nothing, 1 sentences, 2 sentences and a line for every step (as it is at first). */
int qsmpm_set_verbosity(qsmpm_handle handle, int level);
int qsmpm_set_threads(qsmpm_handle handle, int threads);

/* ---- what is to be analysed ---------------------------------------------------------------------------------- */

int qsmpm_read_deck(qsmpm_handle handle, const char *path);
int qsmpm_parse_deck(qsmpm_handle handle, const char *text, const char *job);

/* ---- a material of the program's own: one point, six components 11,22,33,12,13,23, shear gamma = 2 eps, tension
 * positive; 3x3 tensors column by column ------------------------------------------------------------------------- */

typedef struct qsmpm_model_options {
    int state_count;     /* state variables of a point */
    int symmetric;       /* the tangent is symmetric for every state */
    int thread_safe;     /* may be called from several threads at once */
    int reads_strain;    /* reads strain_start; points then carry 6 numbers more */
    int reads_gradient;  /* reads the gradients; points then carry 9 numbers more */
    double stiffness_scale, shear_scale; /* Young's modulus and shear modulus, for stabilisation */
} qsmpm_model_options;

typedef struct qsmpm_increment {
    double strain[6], strain_start[6]; /* increment of the step; sum of those before, turned with the material */
    double rotation[9];                /* of the step; the stress has been turned by it */
    double gradient_start[9], gradient_end[9];
    int phase, step;                   /* from 1 */
    double start, duration;            /* share of the phase at the start, and of the step */
    int point, cell;
    double place[3], cell_size;
    int wants_tangent, elastic_tangent; /* whether the tangent is read, and may be the elastic one */
    double time, time_increment;        /* at the start of the step; of the step, 1e-6 of the stage at held load */
} qsmpm_increment;

typedef struct qsmpm_response {
    int plastic;        /* whether the point yields */
    double share;       /* with QSMPM_CUT: share of the step to be tried next, 0 for no opinion */
    double tangent[36]; /* [i + 6*j] = d stress[i] / d strain[j] */
    char message[256];  /* why, with any status but QSMPM_UPDATED */
} qsmpm_response;

enum qsmpm_update_status { QSMPM_UPDATED = 0, QSMPM_CUT = 1, QSMPM_FAILED = 2, QSMPM_UNRECOVERABLE = 3 };

/* stress and state: of the start in, of the end out. */
typedef int (*qsmpm_update)(void *user, const qsmpm_increment *increment, double *stress, double *state,
                            qsmpm_response *answer);
/* State of a point with a given stress; NULL for zeros. */
typedef void (*qsmpm_start)(void *user, const double *stress, double *state);
/* Before qsmpm_initialise, for a material of the deck. */
int qsmpm_set_material(qsmpm_handle handle, const char *material, const qsmpm_model_options *options,
                       qsmpm_start start, qsmpm_update update, void *user);

/* ---- stepping ------------------------------------------------------------------------------------------------ */

int qsmpm_initialise(qsmpm_handle handle);
/* One accepted load step; to a share of the present stage (of the coming one between stages); to the end. */
int qsmpm_advance(qsmpm_handle handle);
int qsmpm_advance_to(qsmpm_handle handle, double share);
int qsmpm_run(qsmpm_handle handle);
int qsmpm_finished(qsmpm_handle handle);
/* From now on write the files of a run of the command line; close them. */
int qsmpm_record(qsmpm_handle handle, const char *directory);
int qsmpm_finish_record(qsmpm_handle handle);
/* State in a file, for an analysis with the same deck and stages. */
int qsmpm_save(qsmpm_handle handle, const char *path);
int qsmpm_load(qsmpm_handle handle, const char *path);
/* State, loads and stages in memory: one copy. */
int qsmpm_checkpoint(qsmpm_handle handle);
int qsmpm_restore_checkpoint(qsmpm_handle handle);

/* ---- the load program: stages are the phases of the deck; loads are set for the stage that begins next -------- */

int qsmpm_add_stage(qsmpm_handle handle, const char *name, int steps);
/* Lines of a deck behind the deck: *MATERIAL and *PHASE with what belongs to them (bodies that come, go or change their
 * material, water levels, *SAFETY, ...), checked as there. */
int qsmpm_add_cards(qsmpm_handle handle, const char *cards);
int qsmpm_end_stage(qsmpm_handle handle);
int qsmpm_set_load_factor(qsmpm_handle handle, double factor);
int qsmpm_set_steps(qsmpm_handle handle, int steps);
/* For models that depend on time: how long the stage lasts, 1 if not given; when it starts, at the end of the one
 * before if not given. */
int qsmpm_set_time(qsmpm_handle handle, double duration);
int qsmpm_set_start_time(qsmpm_handle handle, double time);
int qsmpm_set_gravity(qsmpm_handle handle, const double *vector);
int qsmpm_set_traction(qsmpm_handle handle, const char *surface, const double *vector);
int qsmpm_set_pressure(qsmpm_handle handle, const char *surface, double pressure);
/* name: node set or surface of a row of *WATER LEVEL in ground that consolidates; for water at rest a body, or "" */
int qsmpm_set_water_level(qsmpm_handle handle, const char *name, double level);
/* component from 1 */
int qsmpm_set_displacement(qsmpm_handle handle, const char *set, int component, double value);
int qsmpm_set_fixity(qsmpm_handle handle, const char *set, const int *fixed);

/* ---- values by name: qsmpm_name(handle, "value", 1 ...) lists the names ---------------------------------------- */

/* Components of one, and how many; their product. */
int qsmpm_shape(qsmpm_handle handle, const char *name, int *rows, int *columns);
int qsmpm_count(qsmpm_handle handle, const char *name, int *number);
int qsmpm_get(qsmpm_handle handle, const char *name, double *values, int number);
/* point_stress (with the state that belongs to it), point_state, point_force. */
int qsmpm_set(qsmpm_handle handle, const char *name, const double *values, int number);
/* Where the values lie, always those of the last step: good until qsmpm_destroy or qsmpm_initialise, and until a phase
 * begins in which bodies come or go. */
int qsmpm_view(qsmpm_handle handle, const char *name, const double **values, int *rows, int *columns);
/* Name of a "value", "history", "stage", "surface", "set", "material", "body", from 1; -1 when there is none. */
int qsmpm_name(qsmpm_handle handle, const char *kind, int number, char *buffer, int size);

#ifdef __cplusplus
}
#endif
#endif
