/* LEAD: STOP AND READ LEAD_READ_THIS.txt at the top of this tree before you go on; then delete this line. */
/* Products of groups of many nodes in space: displacement gradients, internal force and stiffness of the points of a
 * group (qsmpm_group_stiffness has the equations). They are small for a library of dense matrices, which copies both
 * factors and pads them; here nodes are taken four at a time, a pair of four nodes and four nodes stays in registers
 * over all points, and only half of a symmetric stiffness is formed.
 *
 * Every function is compiled twice where the processor may have AVX2, and the wider one is taken where it has it. */
#include <stddef.h>

/* Four nodes. */
enum { WIDTH = 4 };
typedef double quad __attribute__((vector_size(8 * WIDTH)));
typedef double loose_quad __attribute__((vector_size(8 * WIDTH), aligned(8), may_alias));
typedef long long places __attribute__((vector_size(8 * WIDTH)));

/* Set by assignments: what stands for memset and memcpy at this size is slow to start. */
#define ZERO ((quad){0.0, 0.0, 0.0, 0.0})
#define INLINE static inline __attribute__((always_inline))
#if defined(__x86_64__) && defined(__GNUC__)
#define WIDER __attribute__((target("avx2,fma")))
#define HAS_WIDER (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma"))
#endif

/* Components i and k of the blocks of a panel: those with i = k, and the others in two threes, mirror images. */
static const int FIRST[3][3] = {{0, 1, 2}, {0, 0, 1}, {1, 2, 2}};
static const int SECOND[3][3] = {{0, 1, 2}, {1, 2, 2}, {0, 0, 1}};

int qsmpm_wide_registers(void);
void qsmpm_wide_gradients(int n, int points, const double *u, const double *gradient, double *tensor);
void qsmpm_wide_force(int n, int points, const double *tensor, const double *gradient, double *force);
void qsmpm_wide_stiffness(int n, int points, const int *point, int symmetric, int add, const double *weight,
                          const double *gradient, const double *tangent, double *scratch, double *block);

/* u_i,j = sum over a of u_ia N_a,j; the last four nodes count those that were not counted before. */
INLINE void gradients(int n, int points, const double *u, const double *gradient, double *tensor)
{
    int quads = (n + WIDTH - 1) / WIDTH, q, v, i, j, a;

    for (q = 0; q < points; q++) {
        const double *g = gradient + (size_t)3 * n * q;
        quad sum[9];

        for (a = 0; a < 9; a++) sum[a] = ZERO;
        for (v = 0; v < quads; v++) {
            int start = v < quads - 1 ? WIDTH * v : n - WIDTH;
            quad d[3], s[3];

            for (j = 0; j < 3; j++) d[j] = *(const loose_quad *)(g + j * n + start);
            for (i = 0; i < 3; i++) s[i] = *(const loose_quad *)(u + (i * quads + v) * WIDTH);
            for (j = 0; j < 3; j++)
                for (i = 0; i < 3; i++) sum[3 * j + i] += s[i] * d[j];
        }
        for (a = 0; a < 9; a++) tensor[9 * q + a] = (sum[a][0] + sum[a][2]) + (sum[a][1] + sum[a][3]);
    }
}

/* f_ia = f_ia + sum over points of t_ij N_a,j; nodes that the last four share with those before are left to these. */
INLINE void add_forces(int n, int points, const double *tensor, const double *gradient, double *force)
{
    int start, next, q, i, j, a;

    for (next = 0; next < n; next = start + WIDTH) {
        quad sum[3];

        start = next + WIDTH <= n ? next : n - WIDTH;
        for (i = 0; i < 3; i++) sum[i] = ZERO;
        for (q = 0; q < points; q++) {
            const double *g = gradient + (size_t)3 * n * q + start, *t = tensor + 9 * q;

            for (j = 0; j < 3; j++) {
                quad d = *(const loose_quad *)(g + j * n);

                for (i = 0; i < 3; i++) sum[i] += d * t[3 * j + i];
            }
        }
        for (a = next - start; a < WIDTH; a++)
            for (i = 0; i < 3; i++) force[3 * (start + a) + i] += sum[i][a];
    }
}

/* Gradients as (quads of nodes, directions of the points, 4), filled with zeros. */
INLINE void pack(int n, int points, const int *point, const double *gradient, double *packed)
{
    int quads = (n + WIDTH - 1) / WIDTH, q, v, j, a;

    for (q = 0; q < points; q++)
        for (j = 0; j < 3; j++) {
            const double *g = gradient + (size_t)n * (3 * (point[q] - 1) + j);
            double *to = packed + WIDTH * (3 * q + j);

            for (v = 0; v < n / WIDTH; v++)
                *(loose_quad *)(to + (size_t)v * 3 * WIDTH * points) = *(const loose_quad *)(g + WIDTH * v);
            if (v == quads) continue;
            to += (size_t)v * 3 * WIDTH * points;
            for (a = 0; a < WIDTH; a++) to[a] = WIDTH * v + a < n ? g[WIDTH * v + a] : 0.0;
        }
}

/* S of four nodes and three pairs of components: (directions of the points, pairs, 4), of w_ijkl as (points, l, pairs,
 * j). */
INLINE void form_panel(int points, const double *packed, const double *scaled, double *panel)
{
    int q, l, p;

    for (q = 0; q < points; q++) {
        quad x = *(const loose_quad *)(packed + 3 * WIDTH * q), y = *(const loose_quad *)(packed + 3 * WIDTH * q + WIDTH),
            z = *(const loose_quad *)(packed + 3 * WIDTH * q + 2 * WIDTH);

        for (l = 0; l < 3; l++)
            for (p = 0; p < 3; p++) {
                const double *w = scaled + 27 * q + 9 * l + 3 * p;

                *(loose_quad *)(panel + 9 * WIDTH * q + 3 * WIDTH * l + WIDTH * p) = x * w[0] + y * w[1] + z * w[2];
            }
    }
}

/* V A_ijkl of the three pairs (i,k) of a panel, (points, l, pairs, j). */
INLINE void scale(int points, const int *point, int triple, const double *weight, const double *tangent, double *scaled)
{
    int q, l, p, j;

    for (q = 0; q < points; q++) {
        const double *a = tangent + 81 * (size_t)(point[q] - 1), w = weight[point[q] - 1];

        for (l = 0; l < 3; l++)
            for (p = 0; p < 3; p++)
                for (j = 0; j < 3; j++)
                    *scaled++ = w * a[9 * (3 * l + SECOND[triple][p]) + 3 * j + FIRST[triple][p]];
    }
}

/* Store or add four nodes, or as many as there are. */
INLINE void put(int count, int add, const quad *value, double *to)
{
    int a;

    if (count >= WIDTH) {
        if (add) *(loose_quad *)to += *value;
        else *(loose_quad *)to = *value;
    } else {
        for (a = 0; a < count; a++) to[a] = add ? to[a] + (*value)[a] : (*value)[a];
    }
}

/* Rows of a block of four nodes and four nodes from its columns. */
INLINE void transpose(const quad *value, quad *image)
{
    const places even = {0, 4, 2, 6}, odd = {1, 5, 3, 7}, low = {0, 1, 4, 5}, high = {2, 3, 6, 7};
    quad p = __builtin_shuffle(value[0], value[1], even), q = __builtin_shuffle(value[2], value[3], even);

    image[0] = __builtin_shuffle(p, q, low);
    image[2] = __builtin_shuffle(p, q, high);
    p = __builtin_shuffle(value[0], value[1], odd);
    q = __builtin_shuffle(value[2], value[3], odd);
    image[1] = __builtin_shuffle(p, q, low);
    image[3] = __builtin_shuffle(p, q, high);
}

/* Three blocks of four nodes `first` and four nodes `second`, and their mirror images where these are asked for. */
INLINE void put_blocks(int n, int add, int triple, int mirrored, int first, int second, quad (*value)[WIDTH],
                       double *block)
{
    int rows = n - first < WIDTH ? n - first : WIDTH, columns = n - second < WIDTH ? n - second : WIDTH, p, a, b;

    for (p = 0; p < 3; p++) {
        int i = FIRST[triple][p], k = SECOND[triple][p];
        double *to = block + (size_t)n * (i + 3 * k + 9 * (size_t)second) + first;
        quad image[WIDTH];

        for (b = 0; b < columns; b++) put(rows, add, value[p] + b, to + 9 * (size_t)n * b);
        if (!mirrored) continue;
        to = block + (size_t)n * (k + 3 * i + 9 * (size_t)first) + second;
        transpose(value[p], image);
        for (a = 0; a < rows; a++) put(columns, add, image + a, to + 9 * (size_t)n * a);
    }
}

/* One panel with four nodes b: the sum over all directions of all points stays in registers. */
INLINE void multiply(int terms, const double *panel, const double *other, quad (*value)[WIDTH])
{
    quad sum[3][WIDTH];
    int t, p, b;

    for (p = 0; p < 3; p++)
        for (b = 0; b < WIDTH; b++) sum[p][b] = ZERO;
    for (t = 0; t < terms; t++, panel += 3 * WIDTH, other += WIDTH)
        for (b = 0; b < WIDTH; b++)
            for (p = 0; p < 3; p++) sum[p][b] += *(const loose_quad *)(panel + WIDTH * p) * other[b];
    for (p = 0; p < 3; p++)
        for (b = 0; b < WIDTH; b++) value[p][b] = sum[p][b];
}

/* K_iakb of some points into a block (a, i, k, b). */
INLINE void stiffness(int n, int points, const int *point, int symmetric, int add, const double *weight,
                      const double *gradient, const double *tangent, double *scratch, double *block)
{
    int quads = (n + WIDTH - 1) / WIDTH, terms = 3 * points, triple, v, w;
    double *packed = scratch, *scaled = packed + (size_t)WIDTH * quads * terms, *panel = scaled + 9 * terms;
    quad value[3][WIDTH];

    pack(n, points, point, gradient, packed);
    for (triple = 0; triple < (symmetric ? 2 : 3); triple++) {
        scale(points, point, triple, weight, tangent, scaled);
        for (v = 0; v < quads; v++) {
            int last = symmetric && triple == 0 ? v : quads - 1;

            form_panel(points, packed + (size_t)v * WIDTH * terms, scaled, panel);
            for (w = 0; w <= last; w++) {
                multiply(terms, panel, packed + (size_t)w * WIDTH * terms, value);
                put_blocks(n, add, triple, symmetric && (triple > 0 || w < v), WIDTH * v, WIDTH * w, value, block);
            }
        }
    }
}

#ifdef WIDER
WIDER static void wider_gradients(int n, int points, const double *u, const double *gradient, double *tensor)
{
    gradients(n, points, u, gradient, tensor);
}

WIDER static void wider_force(int n, int points, const double *tensor, const double *gradient, double *force)
{
    add_forces(n, points, tensor, gradient, force);
}

WIDER static void wider_stiffness(int n, int points, const int *point, int symmetric, int add, const double *weight,
                                  const double *gradient, const double *tangent, double *scratch, double *block)
{
    stiffness(n, points, point, symmetric, add, weight, gradient, tangent, scratch, block);
}
#endif

/* Whether four numbers fit a register: else a library of dense matrices is faster. */
int qsmpm_wide_registers(void)
{
#ifdef WIDER
    return HAS_WIDER ? 1 : 0;
#else
    return 0;
#endif
}

/* Displacement gradients (3, 3, points) of displacements (quads of nodes, 3), those of the last four nodes that others
 * have counted zero. */
void qsmpm_wide_gradients(int n, int points, const double *u, const double *gradient, double *tensor)
{
#ifdef WIDER
    if (HAS_WIDER) {
        wider_gradients(n, points, u, gradient, tensor);
        return;
    }
#endif
    gradients(n, points, u, gradient, tensor);
}

/* Add forces of the points' weighted stresses (3, 3, points) to those of the nodes (3, n). */
void qsmpm_wide_force(int n, int points, const double *tensor, const double *gradient, double *force)
{
#ifdef WIDER
    if (HAS_WIDER) {
        wider_force(n, points, tensor, gradient, force);
        return;
    }
#endif
    add_forces(n, points, tensor, gradient, force);
}

/* Stiffness of the points listed (from 1), stored in the block or added to it; of a symmetric one the blocks i < k are
 * formed, and those below the diagonal of i = k. */
void qsmpm_wide_stiffness(int n, int points, const int *point, int symmetric, int add, const double *weight,
                          const double *gradient, const double *tangent, double *scratch, double *block)
{
#ifdef WIDER
    if (HAS_WIDER) {
        wider_stiffness(n, points, point, symmetric, add, weight, gradient, tangent, scratch, block);
        return;
    }
#endif
    stiffness(n, points, point, symmetric, add, weight, gradient, tangent, scratch, block);
}
