/* PETSc with an opaque handle: a matrix with rows distributed over the ranks of a communicator, and a preconditioned
 * Krylov method. Rows and columns are numbered globally from 0.
 *
 * PETSc is started at its first use and finalised with MPI. It installs no signal handler, reads neither .petscrc
 * nor PETSC_OPTIONS (settings are those of this file), and reports errors by return values, never on the
 * screen. */
#define _DEFAULT_SOURCE
#include <stdlib.h>
#include <petscksp.h>

typedef struct {
    Mat matrix;
    KSP solver;
    Vec rhs, solution, work;
    /* Rows of this rank. */
    PetscInt rows;
} qsmpm_petsc;

qsmpm_petsc *qsmpm_petsc_make(int communicator, int block, int rows, const int *own, const int *foreign, int symmetric);
int qsmpm_petsc_first(int communicator, int rows);
int qsmpm_petsc_row(qsmpm_petsc *self, int row, int count, const int *columns, const double *values);
int qsmpm_petsc_rigid_motions(qsmpm_petsc *self, const double *places);
int qsmpm_petsc_take(qsmpm_petsc *self, int afresh, int keep);
double qsmpm_petsc_size(qsmpm_petsc *self);
int qsmpm_petsc_solve(qsmpm_petsc *self, const double *rhs, double tolerance, int most_sweeps, double *x, int *sweeps,
                      double *residual);
void qsmpm_petsc_forget(qsmpm_petsc *self);
void qsmpm_petsc_free(qsmpm_petsc *self);

/* Settings of the solver; docs/distributed.md has the reasons and measurements. */
static const char *settings[][2] = {
    {"-qsmpm_ksp_type", "fgmres"},
    {"-qsmpm_ksp_gmres_restart", "60"},
    {"-qsmpm_pc_type", "gamg"},
    {"-qsmpm_pc_gamg_threshold", "-1"},
    {"-qsmpm_mg_levels_ksp_type", "gmres"},
    {"-qsmpm_mg_levels_ksp_max_it", "4"},
    {"-qsmpm_mg_levels_pc_type", "jacobi"},
    {"-qsmpm_mg_coarse_sub_pc_factor_shift_type", "nonzero"},
};
/* On many ranks: the product of the coarse levels that sums in a fixed order and is fast. The option has no prefix. */
static const char *product[] = {"-matptap_via", "backend"};

/* Called by MPI_Finalize, which first deletes the attributes of MPI_COMM_SELF. */
static int finish(MPI_Comm comm, int key, void *value, void *extra)
{
    (void)comm;
    (void)key;
    (void)value;
    (void)extra;
    PetscFinalize();
    return MPI_SUCCESS;
}

/* Starts PETSc; returns 0 on success. */
static PetscErrorCode start(void)
{
    char name[] = "qsmpm", *words[] = {name, "-skip_petscrc", "-no_signal_handler", "-options_left", "no", NULL};
    char **argv = words;
    int argc = 5, key, started, ended;
    PetscBool running, over;

    PetscCall(PetscInitialized(&running));
    if (running) return 0;
    PetscCall(PetscFinalized(&over));
    MPI_Initialized(&started);
    MPI_Finalized(&ended);
    if (over || !started || ended) return PETSC_ERR_ORDER;
    unsetenv("PETSC_OPTIONS");
    unsetenv("PETSC_OPTIONS_YAML");
    PetscCall(PetscInitialize(&argc, &argv, NULL, NULL));
    PetscCall(PetscPushErrorHandler(PetscReturnErrorHandler, NULL));
    for (size_t i = 0; i < sizeof settings / sizeof *settings; i++)
        PetscCall(PetscOptionsSetValue(NULL, settings[i][0], settings[i][1]));
    MPI_Comm_create_keyval(MPI_COMM_NULL_COPY_FN, finish, &key, NULL);
    MPI_Comm_set_attr(MPI_COMM_SELF, key, NULL);
    return 0;
}

static PetscErrorCode make(qsmpm_petsc *self, MPI_Comm comm, PetscInt block, const PetscInt *own,
                           const PetscInt *foreign, PetscBool symmetric)
{
    int ranks;

    MPI_Comm_size(comm, &ranks);
    if (ranks > 1)
        PetscCall(PetscOptionsSetValue(NULL, product[0], product[1]));
    else
        PetscCall(PetscOptionsClearValue(NULL, product[0]));
    PetscCall(MatCreate(comm, &self->matrix));
    PetscCall(MatSetSizes(self->matrix, self->rows, self->rows, PETSC_DETERMINE, PETSC_DETERMINE));
    PetscCall(MatSetOptionsPrefix(self->matrix, "qsmpm_"));
    PetscCall(MatSetType(self->matrix, MATAIJ));
    PetscCall(MatSetBlockSize(self->matrix, block));
    PetscCall(MatSeqAIJSetPreallocation(self->matrix, 0, own));
    PetscCall(MatMPIAIJSetPreallocation(self->matrix, 0, own, 0, foreign));
    PetscCall(MatSetOption(self->matrix, MAT_SYMMETRIC, symmetric));
    PetscCall(MatSetOption(self->matrix, MAT_SYMMETRY_ETERNAL, symmetric));
    PetscCall(MatCreateVecs(self->matrix, &self->solution, &self->rhs));
    PetscCall(VecDuplicate(self->rhs, &self->work));
    return 0;
}

/* Creates a new solver: a reset would retain data that a run continued from a file does not have. */
static PetscErrorCode renew(qsmpm_petsc *self)
{
    PetscCall(KSPDestroy(&self->solver));
    PetscCall(KSPCreate(PetscObjectComm((PetscObject)self->matrix), &self->solver));
    PetscCall(KSPSetOptionsPrefix(self->solver, "qsmpm_"));
    PetscCall(KSPSetFromOptions(self->solver));
    return 0;
}

/* Returns the number of the first row of this rank from its number of rows; negative if PETSc does not start. */
int qsmpm_petsc_first(int communicator, int rows)
{
    int rank, first = 0;

    if (start()) return -1;
    MPI_Comm_rank(MPI_Comm_f2c(communicator), &rank);
    MPI_Exscan(&rows, &first, 1, MPI_INT, MPI_SUM, MPI_Comm_f2c(communicator));
    return rank == 0 ? 0 : first;
}

/* Creates a matrix without values and its solver. For each row of this rank, own and foreign are the numbers of columns
 * that belong to rows of this rank and of others. Returns NULL on failure. */
qsmpm_petsc *qsmpm_petsc_make(int communicator, int block, int rows, const int *own, const int *foreign, int symmetric)
{
    qsmpm_petsc *self;

    if (start()) return NULL;
    self = calloc(1, sizeof *self);
    if (!self) return NULL;
    self->rows = rows;
    if (!make(self, MPI_Comm_f2c(communicator), block, own, foreign, symmetric ? PETSC_TRUE : PETSC_FALSE)) return self;
    qsmpm_petsc_free(self);
    return NULL;
}

/* Sets the values of a row of this rank. */
int qsmpm_petsc_row(qsmpm_petsc *self, int row, int count, const int *columns, const double *values)
{
    return MatSetValues(self->matrix, 1, &row, count, columns, values, INSERT_VALUES);
}

/* Sets the rigid body motions, which multigrid must represent, from the locations of the nodes: one per row block. */
int qsmpm_petsc_rigid_motions(qsmpm_petsc *self, const double *places)
{
    PetscScalar *values;
    MatNullSpace motions;
    PetscInt block;
    Vec vector;

    PetscCall(MatGetBlockSize(self->matrix, &block));
    PetscCall(VecDuplicate(self->rhs, &vector));
    PetscCall(VecSetBlockSize(vector, block));
    PetscCall(VecGetArray(vector, &values));
    for (PetscInt i = 0; i < self->rows; i++) values[i] = places[i];
    PetscCall(VecRestoreArray(vector, &values));
    PetscCall(MatNullSpaceCreateRigidBody(vector, &motions));
    PetscCall(MatSetNearNullSpace(self->matrix, motions));
    PetscCall(MatNullSpaceDestroy(&motions));
    PetscCall(VecDestroy(&vector));
    return 0;
}

/* Takes the values that were set. afresh: no data of an earlier matrix are used; keep: its multigrid is retained. */
int qsmpm_petsc_take(qsmpm_petsc *self, int afresh, int keep)
{
    PetscCall(MatAssemblyBegin(self->matrix, MAT_FINAL_ASSEMBLY));
    PetscCall(MatAssemblyEnd(self->matrix, MAT_FINAL_ASSEMBLY));
    if (afresh) PetscCall(renew(self));
    PetscCall(KSPSetOperators(self->solver, self->matrix, self->matrix));
    PetscCall(KSPSetReusePreconditioner(self->solver, keep ? PETSC_TRUE : PETSC_FALSE));
    PetscCall(KSPSetUp(self->solver));
    return 0;
}

/* Returns the number of values stored in the matrix of this rank and its coarse levels. */
double qsmpm_petsc_size(qsmpm_petsc *self)
{
    PetscReal nodes, numbers;
    MatInfo info;
    PC multigrid;

    if (KSPGetPC(self->solver, &multigrid) || PCMGGetGridComplexity(multigrid, &nodes, &numbers) ||
        MatGetInfo(self->matrix, MAT_LOCAL, &info))
        return 0.0;
    return numbers * info.nz_used;
}

/* Computes the norm of b - K x relative to that of b, from which the recursive residual may deviate. */
static PetscErrorCode true_residual(qsmpm_petsc *self, double *residual)
{
    PetscReal size, rest;

    PetscCall(MatMult(self->matrix, self->solution, self->work));
    PetscCall(VecAYPX(self->work, -1.0, self->rhs));
    PetscCall(VecNorm(self->work, NORM_2, &rest));
    PetscCall(VecNorm(self->rhs, NORM_2, &size));
    *residual = size > 0.0 ? rest / size : rest;
    return 0;
}

static PetscErrorCode solve(qsmpm_petsc *self, const double *rhs, double tolerance, int most_sweeps, double *x,
                            int *sweeps, double *residual)
{
    PetscInt count;

    PetscCall(KSPSetTolerances(self->solver, tolerance, 1e-300, 1e10, most_sweeps));
    PetscCall(VecPlaceArray(self->rhs, rhs));
    PetscCall(VecPlaceArray(self->solution, x));
    PetscCall(KSPSolve(self->solver, self->rhs, self->solution));
    PetscCall(KSPGetIterationNumber(self->solver, &count));
    *sweeps = (int)count;
    return true_residual(self, residual);
}

/* Solves to a residual relative to the right-hand side; returns the residual reached, sufficient or not. */
int qsmpm_petsc_solve(qsmpm_petsc *self, const double *rhs, double tolerance, int most_sweeps, double *x, int *sweeps,
                      double *residual)
{
    int status;

    *sweeps = 0;
    *residual = 1.0;
    status = solve(self, rhs, tolerance, most_sweeps, x, sweeps, residual);
    VecResetArray(self->rhs);
    VecResetArray(self->solution);
    return status;
}

/* Frees the multigrid; the next values must be taken afresh. */
void qsmpm_petsc_forget(qsmpm_petsc *self)
{
    KSPDestroy(&self->solver);
}

/* Frees all data. */
void qsmpm_petsc_free(qsmpm_petsc *self)
{
    PetscBool over;

    PetscFinalized(&over);
    if (!over) {
        KSPDestroy(&self->solver);
        VecDestroy(&self->rhs);
        VecDestroy(&self->solution);
        VecDestroy(&self->work);
        MatDestroy(&self->matrix);
    }
    free(self);
}
