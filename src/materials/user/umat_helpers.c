/* Utility procedures that Abaqus provides to a UMAT: ROTSIG, SINV, SPRINC, SPRIND, XIT, STDB_ABQERR, GETOUTDIR,
 * GETJOBNAME, GETNUMCPUS, GETRANK, MUTEXINIT, MUTEXLOCK, MUTEXUNLOCK.
 *
 * They are independent of other files: the program exports them to models that were linked without them, and
 * tools/build-umat links them into the model, which any program can then load. Symmetric tensors are NDI normal
 * components followed by NSHR shear components 12, 13, 23; the shear of a strain (LSTR = 2) is gamma. Matrices are in
 * Fortran's column order. The symbols are weak: a model's own procedure of the same name takes precedence. */
#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define LENT __attribute__((weak))

enum { axes = 3, is_strain = 2, most_sweeps = 50, fatal = -3 };

static const int shear_row[axes] = {0, 0, 1}, shear_column[axes] = {1, 2, 2};

/* Full tensor of packed components. */
static void unpack(const double *s, int lstr, int ndi, int nshr, double a[axes][axes])
{
    const double factor = lstr == is_strain ? 0.5 : 1.0;
    int i;

    memset(a, 0, sizeof(double) * axes * axes);
    for (i = 0; i < ndi; i++) a[i][i] = s[i];
    for (i = 0; i < nshr; i++)
        a[shear_row[i]][shear_column[i]] = a[shear_column[i]][shear_row[i]] = factor * s[ndi + i];
}

/* sprime = r s r' of a stress (lstr = 1) or strain (lstr = 2). */
LENT void rotsig_(const double *s, const double *r, double *sprime, const int *lstr, const int *ndi, const int *nshr)
{
    const double factor = *lstr == is_strain ? 2.0 : 1.0;
    double a[axes][axes], b[axes][axes];
    int i, j, k, l;

    unpack(s, *lstr, *ndi, *nshr, a);
    for (i = 0; i < axes; i++)
        for (j = 0; j < axes; j++) {
            b[i][j] = 0.0;
            for (k = 0; k < axes; k++)
                for (l = 0; l < axes; l++) b[i][j] += r[i + axes * k] * a[k][l] * r[j + axes * l];
        }
    for (i = 0; i < *ndi; i++) sprime[i] = b[i][i];
    for (i = 0; i < *nshr; i++) sprime[*ndi + i] = factor * b[shear_row[i]][shear_column[i]];
}

/* Mean stress and Mises stress. */
LENT void sinv_(const double *stress, double *sinv1, double *sinv2, const int *ndi, const int *nshr)
{
    double a[axes][axes], sum = 0.0;
    int i, j;

    unpack(stress, 1, *ndi, *nshr, a);
    *sinv1 = (a[0][0] + a[1][1] + a[2][2]) / axes;
    for (i = 0; i < axes; i++)
        for (j = 0; j < axes; j++) {
            const double deviator = a[i][j] - (i == j ? *sinv1 : 0.0);
            sum += deviator * deviator;
        }
    *sinv2 = sqrt(1.5 * sum);
}

/* Rotates rows and columns p, q of a symmetric tensor so that its component pq vanishes, and the directions. */
static void annihilate(double a[axes][axes], double n[axes][axes], int p, int q)
{
    const double ratio = (a[q][q] - a[p][p]) / (2.0 * a[p][q]);
    const double t = (ratio >= 0.0 ? 1.0 : -1.0) / (fabs(ratio) + sqrt(1.0 + ratio * ratio));
    const double c = 1.0 / sqrt(1.0 + t * t), s = t * c;
    int k;

    for (k = 0; k < axes; k++) {
        const double akp = a[k][p], akq = a[k][q];
        a[k][p] = c * akp - s * akq;
        a[k][q] = s * akp + c * akq;
    }
    for (k = 0; k < axes; k++) {
        const double apk = a[p][k], aqk = a[q][k], nkp = n[k][p], nkq = n[k][q];
        a[p][k] = c * apk - s * aqk;
        a[q][k] = s * apk + c * aqk;
        n[k][p] = c * nkp - s * nkq;
        n[k][q] = s * nkp + c * nkq;
    }
}

/* Computes principal values, the largest first, and directions, as columns, by Jacobi's method. */
static void principal(double a[axes][axes], double value[axes], double n[axes][axes])
{
    int sweep, i, j, k;

    for (i = 0; i < axes; i++)
        for (j = 0; j < axes; j++) n[i][j] = i == j;
    for (sweep = 0; sweep < most_sweeps; sweep++) {
        if (a[0][1] == 0.0 && a[0][2] == 0.0 && a[1][2] == 0.0) break;
        for (i = 0; i < axes; i++)
            if (a[shear_row[i]][shear_column[i]] != 0.0) annihilate(a, n, shear_row[i], shear_column[i]);
    }
    for (i = 0; i < axes; i++) value[i] = a[i][i];
    for (i = 0; i < axes - 1; i++)
        for (j = i + 1; j < axes; j++) {
            const double swap = value[i];
            if (value[j] <= value[i]) continue;
            value[i] = value[j];
            value[j] = swap;
            for (k = 0; k < axes; k++) {
                const double component = n[k][i];
                n[k][i] = n[k][j];
                n[k][j] = component;
            }
        }
}

/* Principal values of a stress (lstr = 1) or strain (lstr = 2). */
LENT void sprinc_(const double *s, double *ps, const int *lstr, const int *ndi, const int *nshr)
{
    double a[axes][axes], n[axes][axes];

    unpack(s, *lstr, *ndi, *nshr, a);
    principal(a, ps, n);
}

/* Principal values and directions: an(k,:) are the cosines of the k-th one. */
LENT void sprind_(const double *s, double *ps, double *an, const int *lstr, const int *ndi, const int *nshr)
{
    double a[axes][axes], n[axes][axes];
    int i, k;

    unpack(s, *lstr, *ndi, *nshr, a);
    principal(a, ps, n);
    for (k = 0; k < axes; k++)
        for (i = 0; i < axes; i++) an[k + axes * i] = n[i][k];
}

/* Ends the run. */
LENT void xit_(void)
{
    fputs("the model calls XIT\n", stderr);
    exit(1);
}

/* Copies a text as a Fortran string, padded with blanks. */
static void give_text(const char *text, char *to, size_t length)
{
    size_t n = strlen(text);

    memset(to, ' ', length);
    memcpy(to, text, n < length ? n : length);
}

/* Directory of the model's own files, without a slash: the working directory. */
LENT void getoutdir_(char *directory, int *used, size_t length)
{
    give_text(".", directory, length);
    *used = 1;
}

/* Name of the run for the model's own files. */
LENT void getjobname_(char *name, int *used, size_t length)
{
    give_text("qsmpm", name, length);
    *used = 5;
}

/* Number of processes, and rank of this one. */
LENT void getnumcpus_(int *count)
{
    *count = 1;
}

LENT void getrank_(int *rank)
{
    *rank = 0;
}

/* Locks without effect: models are called one at a time unless they are declared thread safe. */
LENT void mutexinit_(const int *number)
{
    (void)number;
}

LENT void mutexlock_(const int *number)
{
    (void)number;
}

LENT void mutexunlock_(const int *number)
{
    (void)number;
}

/* Replaces CALL ABORT of gfortran, which would remove the signal handler first. */
LENT void _gfortran_abort(void)
{
    abort();
}

/* Prints a message; %I, %R and %S in its text are the next integer, real number and word of 8 characters. lop = 1 is
 * information, -1 a warning, -2 an error, and -3 ends the run. */
LENT void stdb_abqerr_(const int *lop, const char *string, const int *intv, const double *realv, const char *charv,
                  size_t length, size_t word)
{
    size_t i;

    while (length > 0 && string[length - 1] == ' ') length--;
    fprintf(stderr, "the model says: ");
    for (i = 0; i < length; i++) {
        const char kind = string[i] == '%' && i + 1 < length ? string[i + 1] : ' ';
        if (kind == 'I' || kind == 'i') {
            fprintf(stderr, "%d", *intv++);
        } else if (kind == 'R' || kind == 'r') {
            fprintf(stderr, "%g", *realv++);
        } else if (kind == 'S' || kind == 's') {
            fprintf(stderr, "%.*s", (int)word, charv);
            charv += word;
        } else {
            fputc(string[i], stderr);
            continue;
        }
        i++;
    }
    fputc('\n', stderr);
    if (*lop == fatal) xit_();
}
