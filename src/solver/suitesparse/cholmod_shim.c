/* CHOLMOD with an opaque handle, so that cholmod_solver.f90 need not declare its structs.
 *
 * The matrix is symmetric, in compressed columns with both triangles stored (the upper one is
 * ignored), indices from 0, in the order of elimination: CHOLMOD keeps it except for a postorder
 * of the elimination tree, which changes neither fill nor operations. The factor is always L L^T, so
 * that a matrix that is not positive definite is reported and not factorised. The int interface
 * supports factors of up to 2^31 entries; larger ones are reported as CHOLMOD_TOO_LARGE. */
#include <stddef.h>
#include <stdlib.h>
#include <cholmod.h>

typedef struct {
  cholmod_common common;
  cholmod_factor *factor;
  cholmod_dense *solution, *work_y, *work_e;
} qsmpm_cholmod;

void *qsmpm_cholmod_analyse(int n, int *first, int *row, int *status);
int qsmpm_cholmod_factorise(void *handle, int n, int *first, int *row, double *values, int *failed);
void qsmpm_cholmod_pivots(void *handle, double *pivots);
double qsmpm_cholmod_factor_size(void *handle);
double qsmpm_cholmod_operations(void *handle);
int qsmpm_cholmod_solve(void *handle, int n, double *rhs, double *x);
void qsmpm_cholmod_free(void *handle);

/* Returns a CHOLMOD matrix that refers to the caller's arrays. */
static cholmod_sparse view(int n, int *first, int *row, double *values)
{
  cholmod_sparse a = {0};
  a.nrow = a.ncol = (size_t)n;
  a.nzmax = (size_t)first[n];
  a.p = first;
  a.i = row;
  a.x = values;
  a.stype = -1;
  a.itype = CHOLMOD_INT;
  a.xtype = values ? CHOLMOD_REAL : CHOLMOD_PATTERN;
  a.dtype = CHOLMOD_DOUBLE;
  a.sorted = a.packed = 1;
  return a;
}

/* Analyses the pattern. Returns a handle, or NULL and a status below CHOLMOD_OK. */
void *qsmpm_cholmod_analyse(int n, int *first, int *row, int *status)
{
  qsmpm_cholmod *self = calloc(1, sizeof *self);
  if (!self) {
    *status = CHOLMOD_OUT_OF_MEMORY;
    return NULL;
  }
  cholmod_start(&self->common);
  self->common.print = 0;
  self->common.try_catch = 1;
  self->common.useGPU = 0;
  self->common.final_ll = 1;
  self->common.quick_return_if_not_posdef = 1;
  self->common.nmethods = 1;
  self->common.method[0].ordering = CHOLMOD_NATURAL;
  self->common.postorder = 1;
  cholmod_sparse a = view(n, first, row, NULL);
  self->factor = cholmod_analyze(&a, &self->common);
  *status = self->common.status;
  if (self->factor && *status == CHOLMOD_OK) return self;
  if (*status == CHOLMOD_OK) *status = CHOLMOD_INVALID;
  qsmpm_cholmod_free(self);
  return NULL;
}

/* Factorises. Returns CHOLMOD's status; with CHOLMOD_NOT_POSDEF `failed` is the equation (from 0). */
int qsmpm_cholmod_factorise(void *handle, int n, int *first, int *row, double *values, int *failed)
{
  qsmpm_cholmod *self = handle;
  cholmod_sparse a = view(n, first, row, values);
  *failed = -1;
  cholmod_factorize(&a, self->factor, &self->common);
  if (self->common.status == CHOLMOD_NOT_POSDEF && self->factor->minor < (size_t)n)
    *failed = ((int *)self->factor->Perm)[self->factor->minor];
  return self->common.status;
}

/* Returns the squares of the diagonal of L in the caller's numbering of the equations. */
void qsmpm_cholmod_pivots(void *handle, double *pivots)
{
  const cholmod_factor *l = ((qsmpm_cholmod *)handle)->factor;
  const int *order = l->Perm;
  const double *x = l->x;
  if (!l->is_super) {
    const int *p = l->p;
    for (size_t j = 0; j < l->n; j++) pivots[order[j]] = x[p[j]] * x[p[j]];
    return;
  }
  const int *super = l->super, *pi = l->pi, *px = l->px;
  for (size_t s = 0; s < l->nsuper; s++) {
    size_t rows = (size_t)(pi[s + 1] - pi[s]);
    for (int j = super[s]; j < super[s + 1]; j++) {
      double d = x[(size_t)px[s] + (size_t)(j - super[s]) * (rows + 1)];
      pivots[order[j]] = d * d;
    }
  }
}

/* Returns the number of values stored in the factor. */
double qsmpm_cholmod_factor_size(void *handle)
{
  const cholmod_factor *l = ((qsmpm_cholmod *)handle)->factor;
  return l->is_super ? (double)l->xsize : (double)l->nzmax;
}

/* Returns the floating-point operations of a factorisation with the analysed pattern. */
double qsmpm_cholmod_operations(void *handle)
{
  return ((qsmpm_cholmod *)handle)->common.fl;
}

/* Solves; the work arrays are retained for the next call. Returns 1 on success. */
int qsmpm_cholmod_solve(void *handle, int n, double *rhs, double *x)
{
  qsmpm_cholmod *self = handle;
  cholmod_dense b = {0};
  b.nrow = b.nzmax = b.d = (size_t)n;
  b.ncol = 1;
  b.x = rhs;
  b.xtype = CHOLMOD_REAL;
  b.dtype = CHOLMOD_DOUBLE;
  int ok = cholmod_solve2(CHOLMOD_A, self->factor, &b, NULL, &self->solution, NULL, &self->work_y,
                          &self->work_e, &self->common);
  if (!ok) return 0;
  const double *found = self->solution->x;
  for (int i = 0; i < n; i++) x[i] = found[i];
  return 1;
}

/* Frees all data. */
void qsmpm_cholmod_free(void *handle)
{
  qsmpm_cholmod *self = handle;
  cholmod_free_factor(&self->factor, &self->common);
  cholmod_free_dense(&self->solution, &self->common);
  cholmod_free_dense(&self->work_y, &self->common);
  cholmod_free_dense(&self->work_e, &self->common);
  cholmod_finish(&self->common);
  free(self);
}
