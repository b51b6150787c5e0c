/* Blocks of many nodes in space added to the matrix row by row (qsmpm_matrix_blocks).
 *
 * Products over nodes leave a block as (a, i, k, b), rows of the matrix have it as (k, b) for each (i, a): four nodes a
 * at a time are turned round, their columns in the order of the matrix. Where the entries of nodes b that follow each
 * other do so in a row, they are added together; a row is gone through from one end to the other.
 * Every entry is added once, so that the sums are those of any other order. */
#include <stddef.h>

/* Nodes that are taken together. */
enum { WIDTH = 4 };
typedef double quad __attribute__((vector_size(8 * WIDTH)));
typedef double loose_quad __attribute__((vector_size(8 * WIDTH), aligned(8), may_alias));
typedef long long places __attribute__((vector_size(8 * WIDTH)));

/* Nodes whose entries follow each other: the place of the first, how many, and the offset of the first from the end of
 * a row. */
struct run { int first, count, offset; };

#define INLINE static inline __attribute__((always_inline))
#if defined(__x86_64__) && defined(__GNUC__)
#define WIDER __attribute__((target("avx2")))
#define HAS_WIDER __builtin_cpu_supports("avx2")
#endif

void qsmpm_add_rows(int n, const int *offset, const int *free, const int *row_end, int symmetric, const double *block,
                    double *values);

/* Nodes in the order of their columns, by the ends of their rows. */
INLINE void sort_nodes(int n, const int *row_end, int *order)
{
    int b, j;

    for (b = 0; b < n; b++) {
        for (j = b; j > 0 && row_end[3 * order[j - 1]] > row_end[3 * b]; j--) order[j] = order[j - 1];
        order[j] = b;
    }
}

/* Runs of the pairs of node a that can be added without a question. */
INLINE int find_runs(int n, int a, const int *order, const int *offset, const int *free, int symmetric,
                     struct run *runs)
{
    int count = 0, next = 0, j;

    if (!free[a]) return 0;
    for (j = 0; j < n; j++) {
        int b = order[j], at = offset[a + (size_t)n * b];

        if (at == 0 || !free[b] || (symmetric && a == b)) continue;
        if (count > 0 && next == j && runs[count - 1].offset - 3 * runs[count - 1].count == at) {
            runs[count - 1].count++;
        } else {
            runs[count++] = (struct run){j, 1, at};
        }
        next = j + 1;
    }
    return count;
}

/* Rows (3n) of component i of the nodes start : start+3, of a block (a, i, k, b) whose columns (k, b) begin at `column`. */
INLINE void turn(int n, int i, int start, const size_t *column, const double *block, double *rows)
{
    const places even = {0, 4, 2, 6}, odd = {1, 5, 3, 7}, low = {0, 1, 4, 5}, high = {2, 3, 6, 7};
    const size_t columns = 3 * (size_t)n;
    const double *first = block + (size_t)n * i + start;
    size_t c;

    for (c = 0; c < columns; c += WIDTH) {
        /* The last ones once more where they are no whole four. */
        size_t from = c + WIDTH <= columns ? c : columns - WIDTH;
        quad p = *(const loose_quad *)(first + column[from]), q = *(const loose_quad *)(first + column[from + 1]),
            r = *(const loose_quad *)(first + column[from + 2]), s = *(const loose_quad *)(first + column[from + 3]);
        quad pq = __builtin_shuffle(p, q, even), rs = __builtin_shuffle(r, s, even);

        *(loose_quad *)(rows + from) = __builtin_shuffle(pq, rs, low);
        *(loose_quad *)(rows + 2 * columns + from) = __builtin_shuffle(pq, rs, high);
        pq = __builtin_shuffle(p, q, odd);
        rs = __builtin_shuffle(r, s, odd);
        *(loose_quad *)(rows + columns + from) = __builtin_shuffle(pq, rs, low);
        *(loose_quad *)(rows + 3 * columns + from) = __builtin_shuffle(pq, rs, high);
    }
}

/* The runs of a row. */
INLINE void add_row(int count, const struct run *runs, const double *row, double *row_end)
{
    int r;

    for (r = 0; r < count; r++) {
        const double *from = row + 3 * runs[r].first;
        double *to = row_end - runs[r].offset;
        int left = 3 * runs[r].count;

        for (; left >= WIDTH; left -= WIDTH, from += WIDTH, to += WIDTH) *(loose_quad *)to += *(const loose_quad *)from;
        for (; left > 0; left--) *to++ += *from++;
    }
}

INLINE void add_rows(int n, const int *offset, const int *free, const int *row_end, int symmetric, const double *block,
                     double *values)
{
    double rows[3 * WIDTH * (size_t)n];
    size_t column[3 * (size_t)n];
    struct run runs[WIDTH][n];
    int order[n], count[WIDTH], next, start, i, e;

    sort_nodes(n, row_end, order);
    for (i = 0; i < 3 * n; i++) column[i] = 3 * (size_t)n * (3 * order[i / 3] + i % 3);
    for (next = 0; next < n; next = start + WIDTH) {
        start = next + WIDTH <= n ? next : n - WIDTH;
        for (e = next - start; e < WIDTH; e++)
            count[e] = find_runs(n, start + e, order, offset, free, symmetric, runs[e]);
        for (i = 0; i < 3; i++) {
            turn(n, i, start, column, block, rows);
            for (e = next - start; e < WIDTH; e++)
                add_row(count[e], runs[e], rows + 3 * (size_t)n * e, values + row_end[3 * (start + e) + i] - 1);
        }
    }
}

#ifdef WIDER
WIDER static void add_rows_wider(int n, const int *offset, const int *free, const int *row_end, int symmetric,
                                 const double *block, double *values)
{
    add_rows(n, offset, free, row_end, symmetric, block, values);
}
#endif

/* Add the pairs of nodes that are free, have a place (offset) and, in a symmetric matrix, are not on the diagonal. */
void qsmpm_add_rows(int n, const int *offset, const int *free, const int *row_end, int symmetric, const double *block,
                    double *values)
{
#ifdef WIDER
    if (HAS_WIDER) {
        add_rows_wider(n, offset, free, row_end, symmetric, block, values);
        return;
    }
#endif
    add_rows(n, offset, free, row_end, symmetric, block, values);
}
