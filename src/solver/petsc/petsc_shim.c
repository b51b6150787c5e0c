/* PETSc behind one opaque handle: a matrix in rows spread over the ranks of a communicator, and a Krylov method with a
 * preconditioner for it. Rows and columns count from 0 through all ranks.
 *
 * PETSc is started when it is first wanted and ends as MPI does. It installs no signal handler, reads neither .petscrc
 * nor PETSC_OPTIONS (settings are those of this file), and reports errors by what its functions return, never on the
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

/* What the solver is made of; reasons and measurements stand in docs/distributed.md. */
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
/* On many ranks: the product of the coarse levels that adds in one order and is fast. The library knows it by no prefix. */
static const char *product[] = {"-matptap_via", "backend"};

/* Called by MPI_Finalize, which deletes what hangs on the communicator of the process alone before it ends anything. */
static int finish(MPI_Comm comm, int key, void *value, void *extra)
{
    (void)comm;
    (void)key;
    (void)value;
    (void)extra;
    PetscFinalize();
    return MPI_SUCCESS;
}

/* Start PETSc; 0 when it runs. */
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

/* A solver without a past: to reset one leaves more of it than a run can know that is continued from a file. */
static PetscErrorCode renew(qsmpm_petsc *self)
{
    PetscCall(KSPDestroy(&self->solver));
    PetscCall(KSPCreate(PetscObjectComm((PetscObject)self->matrix), &self->solver));
    PetscCall(KSPSetOptionsPrefix(self->solver, "qsmpm_"));
    PetscCall(KSPSetFromOptions(self->solver));
    return 0;
}

/* Number of the first row of this rank, which has so many; negative when PETSc does not start. */
int qsmpm_petsc_first(int communicator, int rows)
{
    int rank, first = 0;

    if (start()) return -1;
    MPI_Comm_rank(MPI_Comm_f2c(communicator), &rank);
    MPI_Exscan(&rows, &first, 1, MPI_INT, MPI_SUM, MPI_Comm_f2c(communicator));
    return rank == 0 ? 0 : first;
}

/* A matrix without values and its solver. Each row of this rank gives the numbers of its columns that belong to rows of
 * this rank and of others. NULL when that fails. */
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

/* Values of a row of this rank. */
int qsmpm_petsc_row(qsmpm_petsc *self, int row, int count, const int *columns, const double *values)
{
    return MatSetValues(self->matrix, 1, &row, count, columns, values, INSERT_VALUES);
}

/* The motions that multigrid must be able to represent, from the places of the nodes: one a block of rows. */
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

/* Take the values that were set. Afresh: nothing is kept of an earlier matrix; keep: its multigrid stays. */
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

/* Numbers stored in the matrix of this rank and its coarse levels. */
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

/* Size of b - K x relative to that of b: what the method carries along may have left it. */
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

/* Solve to a residual relative to the right-hand side; what was reached is told, whether it is enough or not. */
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

/* Give the multigrid back; the next values are to be taken afresh. */
void qsmpm_petsc_forget(qsmpm_petsc *self)
{
    KSPDestroy(&self->solver);
}

/* Give everything back. */
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
