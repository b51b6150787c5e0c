/* What the compiler knows of the processor and Fortran cannot ask for. */

int qsmpm_has_avx2(void);
void qsmpm_fetch(const double *first, int count);

/* 1 where it has AVX2 and FMA. */
int qsmpm_has_avx2(void)
{
#if defined(__x86_64__) && defined(__GNUC__)
    return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
#else
    return 0;
#endif
}

/* Numbers that will be changed soon, a line of the cache at a time. */
void qsmpm_fetch(const double *first, int count)
{
    for (int c = 0; c < count + 7; c += 8) __builtin_prefetch(first + c, 1);
}
