/* LEAD: STOP AND READ LEAD_READ_THIS.txt at the top of this tree before you go on; then delete this line. */
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

/* Entries of a row that follow each other: the place of the first among the columns of the patch, how many, and how far
 * the first is from the end of the row. */
struct run { int first, count, offset; };

#define INLINE static inline __attribute__((always_inline))
#if defined(__x86_64__) && defined(__GNUC__)
#define WIDER __attribute__((target("avx2")))
#define HAS_WIDER __builtin_cpu_supports("avx2")
#endif

int qsmpm_row_registers(void);
void qsmpm_add_rows(int n, const int *offset, const int *row_end, int symmetric, const double *block, double *values);

/* Nodes in the order of their equations, which rises with the ends of their rows; those without any come first. */
INLINE void sort_nodes(int n, const int *row_end, int *order)
{
    int last[n], b, i, j;

    for (b = 0; b < n; b++) {
        last[b] = 0;
        for (i = 0; i < 3; i++)
            if (row_end[3 * b + i] > last[b]) last[b] = row_end[3 * b + i];
        for (j = b; j > 0 && last[order[j - 1]] > last[b]; j--) order[j] = order[j - 1];
        order[j] = b;
    }
}

/* Places of the columns (k, b) that are unknowns in a block (a, i, k, b), node by node, four at least; the columns before
 * those of each node; how many they are. */
INLINE int list_columns(int n, const int *order, const int *row_end, size_t *column, int *first)
{
    int count = 0, j, k;

    for (j = 0; j < n; j++) {
        first[j] = count;
        for (k = 0; k < 3; k++)
            if (row_end[3 * order[j] + k] > 0) column[count++] = 3 * (size_t)n * (3 * order[j] + k);
    }
    first[n] = count;
    for (; count < WIDTH; count++) column[count] = 0;
    return count;
}

/* Runs of entries of node a. */
INLINE int find_runs(int n, int a, const int *order, const int *first, const int *offset, int symmetric,
                     struct run *runs)
{
    int count = 0, j;

    for (j = 0; j < n; j++) {
        int at = offset[a + (size_t)n * order[j]], columns = first[j + 1] - first[j];
        struct run *last = runs + count - 1;

        if (at == 0 || columns == 0 || (symmetric && a == order[j])) continue;
        if (count > 0 && last->first + last->count == first[j] && last->offset - last->count == at) {
            last->count += columns;
        } else {
            runs[count++] = (struct run){first[j], columns, at};
        }
    }
    return count;
}

/* Rows of component i of the nodes start : start+3. */
INLINE void turn(int n, int i, int start, int columns, const size_t *column, const double *block, double *rows)
{
    const places even = {0, 4, 2, 6}, odd = {1, 5, 3, 7}, low = {0, 1, 4, 5}, high = {2, 3, 6, 7};
    const double *first = block + (size_t)n * i + start;
    int c;

    for (c = 0; c < columns; c += WIDTH) {
        /* The last ones once more where they are no whole four. */
        int from = c + WIDTH <= columns ? c : columns - WIDTH;
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

/* Ask for the entries of a row, which come from far away in a matrix that is larger than the cache. */
INLINE void fetch_row(int count, const struct run *runs, const double *row_end)
{
    int r, c;

    for (r = 0; r < count; r++)
        for (c = 0; c < runs[r].count + 7; c += 8) __builtin_prefetch(row_end - runs[r].offset + c, 1);
}

/* The runs of a row. */
INLINE void add_row(int count, const struct run *runs, const double *row, double *row_end)
{
    int r;

    for (r = 0; r < count; r++) {
        const double *from = row + runs[r].first;
        double *to = row_end - runs[r].offset;
        int left = runs[r].count;

        for (; left >= WIDTH; left -= WIDTH, from += WIDTH, to += WIDTH) *(loose_quad *)to += *(const loose_quad *)from;
        for (; left > 0; left--) *to++ += *from++;
    }
}

INLINE void add_rows(int n, const int *offset, const int *row_end, int symmetric, const double *block, double *values)
{
    double rows[3 * WIDTH * (size_t)n];
    size_t column[3 * (size_t)n];
    struct run runs[WIDTH][n];
    int order[n], first[n + 1], count[WIDTH], columns, next, start, i, e;

    sort_nodes(n, row_end, order);
    columns = list_columns(n, order, row_end, column, first);
    for (next = 0; next < n; next = start + WIDTH) {
        start = next + WIDTH <= n ? next : n - WIDTH;
        for (e = next - start; e < WIDTH; e++)
            count[e] = find_runs(n, start + e, order, first, offset, symmetric, runs[e]);
        for (i = 0; i < 3; i++) {
            for (e = next - start; e < WIDTH; e++) {
                int end = row_end[3 * (start + e) + i];

                if (end > 0) fetch_row(count[e], runs[e], values + end - 1);
            }
            turn(n, i, start, columns, column, block, rows);
            for (e = next - start; e < WIDTH; e++) {
                int end = row_end[3 * (start + e) + i];

                if (end > 0) add_row(count[e], runs[e], rows + (size_t)columns * e, values + end - 1);
            }
        }
    }
}

#ifdef WIDER
WIDER static void add_rows_wider(int n, const int *offset, const int *row_end, int symmetric, const double *block,
                                 double *values)
{
    add_rows(n, offset, row_end, symmetric, block, values);
}
#endif

/* Whether four numbers fit a register: else entries are added faster one by one. */
int qsmpm_row_registers(void)
{
#ifdef WIDER
    return HAS_WIDER ? 1 : 0;
#else
    return 0;
#endif
}

/* Add the pairs of nodes that have a place (offset) and, in a symmetric matrix, are not on the diagonal; components
 * without an equation have no row_end. */
void qsmpm_add_rows(int n, const int *offset, const int *row_end, int symmetric, const double *block, double *values)
{
#ifdef WIDER
    if (HAS_WIDER) {
        add_rows_wider(n, offset, row_end, symmetric, block, values);
        return;
    }
#endif
    add_rows(n, offset, row_end, symmetric, block, values);
}
